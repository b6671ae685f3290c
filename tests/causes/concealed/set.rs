//! A set of recordings in a folder: which causes at which strengths, made once, and resumed where it was left.
//!
//! The folder holds `trial.dbc`, `trial_NNN.toml`, `trial_NNN.log.gz` and `truth.json`, like the practice set.

use std::path::{Path, PathBuf};
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};

use serde_json::{Map, Value};

use super::cause::{CAUSES, Cause, Sort};
use super::dice::Dice;
use super::recording::{Order, Recording};
use testing::setting::setting;

/// What is made of the same parts of a car.
const CLASHES: [[&str; 2]; 4] = [
    ["friction_change", "friction_split"],
    ["tire_saturation", "friction_change"],
    ["tire_saturation", "friction_split"],
    ["body_roll", "roll_steer"],
];

/// What a set is to consist of.
pub struct Wish {
    pub seed: u64,
    /// Recordings in all; a sixth of them controls.
    pub count: usize,
    /// Strengths, times the ordinary one, that the causes are dealt at in turn.
    pub factors: Vec<f64>,
    /// Only these causes, and no controls but where named.
    pub only: Option<Vec<String>>,
    /// Length of every drive; drawn from 90 to 120 s where `None`.
    pub seconds: Option<f64>,
    /// Noise and roads as cars have them.
    pub is_real: bool,
    /// How many causes act at once, dealt in turn; one each if there are none.
    pub together: Vec<usize>,
}

impl Wish {
    /// From the environment (main.rs lists it).
    pub fn from_environment() -> Self {
        let list = |name: &str| -> Option<Vec<String>> {
            let text = std::env::var(name).ok()?;
            Some(text.split(',').map(|part| part.trim().to_owned()).collect())
        };
        let factors =
            list("CONCEALED_FACTOR").unwrap_or_else(|| vec!["1".into(), "0.3".into(), "0.1".into()]);
        Wish {
            seed: setting("CONCEALED_SEED", 1),
            count: setting("CONCEALED_COUNT", 210),
            factors: factors
                .iter()
                .map(|f| f.parse().unwrap_or_else(|_| panic!("CONCEALED_FACTOR: {f}: not a number")))
                .collect(),
            only: list("CONCEALED_ONLY"),
            seconds: std::env::var("CONCEALED_LENGTH").is_ok().then(|| setting("CONCEALED_LENGTH", 0.0)),
            is_real: setting("CONCEALED_REAL", 0) != 0,
            together: list("CONCEALED_TOGETHER")
                .unwrap_or_default()
                .iter()
                .map(|n| n.parse().unwrap())
                .collect(),
        }
    }

    /// The orders, in an order that does not tell the causes.
    pub fn orders(&self) -> Vec<Order> {
        if !self.together.is_empty() {
            return self.orders_together();
        }
        let mut dice = Dice::new(self.seed, 0);
        let mut asked: Vec<(&'static Cause, f64)> = Vec::new();
        let causes: Vec<&'static Cause> = match &self.only {
            Some(names) => names.iter().map(|name| Cause::find(name)).collect(),
            None => {
                asked.resize(self.count / 6, (Cause::find("control"), 1.0));
                CAUSES.iter().filter(|c| c.sort != Sort::Control).collect()
            }
        };
        for round in 0.. {
            let turn = round % self.factors.len();
            let mut dealt: Vec<_> = causes
                .iter()
                .filter(|c| turn == 0 || c.has_strength())
                .map(|c| (*c, if c.has_strength() { self.factors[turn] } else { 1.0 }))
                .collect();
            shuffle(&mut dealt, &mut dice);
            let room = self.count.saturating_sub(asked.len());
            asked.extend(dealt.into_iter().take(room));
            if asked.len() >= self.count {
                break;
            }
        }
        let mut orders: Vec<Order> = (1..)
            .zip(asked)
            .map(|(number, (cause, factor))| Order { factor, number, ..self.order(cause) })
            .collect();
        shuffle(&mut orders, &mut dice);
        orders
    }

    fn order(&self, cause: &'static Cause) -> Order {
        Order { seconds: self.seconds, is_real: self.is_real, ..Order::of(cause, self.seed) }
    }

    /// Several causes at once, drawn from all that have a strength.
    fn orders_together(&self) -> Vec<Order> {
        let mut dice = Dice::new(self.seed, 0);
        let strong: Vec<_> = CAUSES.iter().filter(|c| c.sort == Sort::Library && c.has_strength()).collect();
        let mut orders = Vec::new();
        while orders.len() < self.count {
            let several = self.together[orders.len() % self.together.len()];
            let factor = self.factors[orders.len() % self.factors.len()];
            let mut draw = |wanted: bool| wanted.then(|| *dice.pick(&strong));
            let beside = [draw(several > 1), draw(several > 2)];
            let number = orders.len() as u64 + 1;
            let cause = *dice.pick::<&Cause>(&strong);
            let order = Order { beside, factor, number, ..self.order(cause) };
            let causes: Vec<_> = order.causes().map(Cause::effect).collect();
            let clash = |one: &str, other: &str| {
                let both = |pair: [&str; 2]| pair.contains(&one) && pair.contains(&other);
                one == other || CLASHES.into_iter().any(both)
            };
            let is_clash = (1..causes.len()).any(|k| causes[..k].iter().any(|one| clash(one, causes[k])));
            if order.is_possible() && !is_clash {
                orders.push(order);
            }
        }
        orders
    }
}

fn shuffle<T>(list: &mut [T], dice: &mut Dice) {
    for i in (1..list.len()).rev() {
        list.swap(i, dice.below(i + 1));
    }
}

/// Does work 0, 1, … `count` − 1 on a few threads, whichever is next.
pub fn share(count: usize, work: impl Fn(usize) + Sync) {
    let next = AtomicUsize::new(0);
    std::thread::scope(|scope| {
        for _ in 0..setting("CONCEALED_JOBS", 2usize).max(1) {
            scope.spawn(|| {
                loop {
                    let i = next.fetch_add(1, Ordering::Relaxed);
                    if i >= count {
                        break;
                    }
                    work(i);
                }
            });
        }
    });
}

/// A set in its folder.
pub struct Set {
    pub folder: PathBuf,
    truths: Mutex<Map<String, Value>>,
}

impl Set {
    /// What is there already, or nothing yet.
    pub fn open(folder: &Path) -> Self {
        std::fs::create_dir_all(folder).unwrap();
        let truths = match std::fs::read_to_string(folder.join("truth.json")) {
            Ok(text) => serde_json::from_str(&text).unwrap(),
            Err(_) => Map::new(),
        };
        Set { folder: folder.to_owned(), truths: Mutex::new(truths) }
    }

    /// Names and truths.
    pub fn truths(&self) -> Map<String, Value> {
        self.truths.lock().unwrap().clone()
    }

    /// Whether the set came from elsewhere: nothing can be added to it, only scored.
    pub fn is_foreign(&self) -> bool {
        self.truths.lock().unwrap().values().any(|truth| truth["made"].is_null())
    }

    fn save(&self, name: &str, truth: Value) {
        let mut all = self.truths.lock().unwrap();
        all.insert(name.to_owned(), truth);
        let beside = self.folder.join("truth.json.new");
        std::fs::write(&beside, serde_json::to_string_pretty(&*all).unwrap()).unwrap();
        std::fs::rename(beside, self.folder.join("truth.json")).unwrap();
    }

    /// Makes what is not there yet: first all recordings, which takes a moment, then how visible each cause is,
    /// which takes minutes.
    pub fn complete(&self, orders: &[Order]) {
        let name = |i: usize| format!("trial_{:03}", i + 1);
        share(orders.len(), |i| {
            let (order, name) = (orders[i], name(i));
            let there = self.truths.lock().unwrap().get(&name).map(|truth| truth["made"] == order.made());
            if let Some(same) = there {
                assert!(same, "{}: holds another set ({name}); name an empty folder", self.folder.display());
                return;
            }
            match Recording::make(order) {
                None => {
                    println!("{name}: {} at {}: every drive ends in a spin", order.cause.key, order.factor)
                }
                Some(recording) => {
                    recording.write(&self.folder, &name).unwrap();
                    self.save(&name, recording.truth());
                }
            }
        });
        println!("{} recordings in {}", self.truths().len(), self.folder.display());
        if setting("CONCEALED_LOOK", 1) == 0 {
            return;
        }
        share(orders.len(), |i| {
            let (order, name) = (orders[i], name(i));
            let known = self.truths.lock().unwrap().get(&name).is_none_or(|t| {
                order.cause.sort == Sort::Control || !t["likelihood_ratio_of_truth"].is_null()
            });
            if known {
                return;
            }
            let Some(mut recording) = Recording::make(order) else { return };
            recording.look();
            let truth = recording.truth();
            println!(
                "{name} {:<10} {:<42} x {:<4} {:<8} {:<6} 2lnLR {:>12} fair {}",
                truth["kind"].as_str().unwrap(),
                order.cause.key,
                order.factor,
                truth["scenario"].as_str().unwrap(),
                if recording.car.friction.is_some() { "magic" } else { "linear" },
                truth["likelihood_ratio_of_truth"],
                truth["fair"],
            );
            self.save(&name, truth);
        });
    }
}

#[test]
fn a_set_has_the_count_the_controls_and_every_cause() {
    let wish = Wish {
        seed: 5,
        count: 210,
        factors: vec![1.0, 0.3, 0.1],
        only: None,
        seconds: None,
        is_real: false,
        together: Vec::new(),
    };
    let orders = wish.orders();
    assert_eq!(orders.len(), 210);
    assert_eq!(orders.iter().filter(|o| o.cause.sort == Sort::Control).count(), 35);
    for cause in CAUSES {
        let mut at: Vec<f64> = orders.iter().filter(|o| o.cause.key == cause.key).map(|o| o.factor).collect();
        at.sort_by(f64::total_cmp);
        at.dedup();
        assert_eq!(at, if cause.has_strength() { vec![0.1, 0.3, 1.0] } else { vec![1.0] }, "{}", cause.key);
    }
    let mut numbers: Vec<u64> = orders.iter().map(|o| o.number).collect();
    assert!(!numbers.is_sorted(), "the number tells the cause");
    numbers.sort_unstable();
    assert_eq!(numbers, (1..=210).collect::<Vec<_>>());
}
