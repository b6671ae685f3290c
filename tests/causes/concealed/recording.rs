//! One recording: a car, a drive, a hidden cause, what the program under test is given, and the sealed truth.

use std::io::Write;
use std::path::Path;

use serde_json::{Value, json};

use super::bus;
use super::car::{CURVATURE, Car, SHAPE};
use super::cause::{Cause, Sort, Tires};
use super::dice::Dice;
use super::drive::{self, Plan};
use super::hidden::Hidden;
use super::physics::Moment;
use super::recipe::{self, Made};
use super::road::{self, Road};
use super::sensors::Chain;
use super::visible::{self, DETECTABLE, Visibility};

/// What is asked for.
#[derive(Clone, Copy)]
pub struct Order {
    pub cause: &'static Cause,
    /// What acts at the same time.
    pub beside: [Option<&'static Cause>; 2],
    /// Noise and road as cars have them, which is nothing to be found.
    pub is_real: bool,
    /// Times its ordinary strength.
    pub factor: f64,
    pub seed: u64,
    pub number: u64,
    /// Length of the drive; drawn where `None`.
    pub seconds: Option<f64>,
}

impl Order {
    /// A cause at its ordinary strength.
    pub fn of(cause: &'static Cause, seed: u64) -> Self {
        Self { cause, beside: [None; 2], is_real: false, factor: 1.0, seed, number: 1, seconds: None }
    }

    /// All that act.
    pub fn causes(&self) -> impl Iterator<Item = &'static Cause> + use<> {
        std::iter::once(self.cause).chain(self.beside.into_iter().flatten())
    }

    fn is_several(&self) -> bool {
        self.causes().count() > 1
    }

    /// Kinds of drive that show all of them.
    fn drives(&self) -> Vec<drive::Kind> {
        let shown = |kind: &&drive::Kind| self.causes().all(|cause| cause.drives.contains(kind));
        self.cause.drives.iter().filter(shown).copied().collect()
    }

    /// Could they be in one car on one drive?
    pub fn is_possible(&self) -> bool {
        let of = |tires: Tires| self.causes().any(|cause| cause.tires == tires);
        let fit = !of(Tires::Linear) || !of(Tires::Magic);
        fit && !self.drives().is_empty()
    }

    /// What tells one order of a set from another.
    pub fn made(&self) -> Value {
        let mut made = json!({
            "seed": self.seed, "number": self.number, "cause": self.cause.key, "factor": self.factor,
        });
        if let Some(seconds) = self.seconds {
            made["seconds"] = json!(seconds);
        }
        if self.is_real {
            made["real"] = json!(true);
        }
        if self.is_several() {
            made["beside"] = self.beside.iter().flatten().map(|cause| cause.key).collect();
        }
        made
    }
}

pub struct Recording {
    pub order: Order,
    pub car: Car,
    pub plan: Plan,
    /// The first cause; all that is hidden stands there.
    pub made: Made,
    /// The others.
    pub beside: Vec<Made>,
    pub chain: Chain,
    pub moments: Vec<Moment>,
    /// The user's car file and the log.
    pub toml: String,
    pub log: String,
    pub visibility: Option<Visibility>,
}

impl Recording {
    /// Makes what is ordered; drives that end in a spin are drawn again;
    /// `None` when all do.
    pub fn make(order: Order) -> Option<Self> {
        let mut dice = Dice::new(order.seed, order.number);
        let magic_wanted = dice.chance(0.35);
        for _ in 0..40 {
            let kind = *dice.pick(&order.drives());
            let of = |tires: Tires| order.causes().any(|cause| cause.tires == tires);
            let magic = !of(Tires::Linear) && (of(Tires::Magic) || kind == drive::Kind::Hard || magic_wanted);
            let car = Car::random(&mut dice, magic);
            let drawn = dice.between(9.0, 12.0).round() * 10.0;
            let seconds = order.seconds.unwrap_or(drawn);
            let grip = if kind == drive::Kind::Hard { car.friction.unwrap_or(0.9) } else { 1.0 };
            let plan = Plan::random(kind, seconds, 0.78 * 9.81 * grip, &mut dice);
            let mut real = order.is_real.then(|| Dice::new(!order.seed, order.number));
            let road = real.as_mut().map(|dice| Road::random(seconds, dice));
            let mut hide =
                |cause, hidden| recipe::make((cause, order.factor), &plan, &car, hidden, &mut dice);
            let mut made = hide(order.cause, Hidden { road, ..Hidden::default() });
            let mut beside: Vec<Made> = Vec::new();
            for cause in order.beside.into_iter().flatten() {
                let next = hide(cause, made.hidden);
                made.hidden = next.hidden.clone();
                beside.push(next);
            }
            let mut chain = Chain::random(&mut dice);
            let moments = drive::drive(&plan, &car, &made.hidden);
            if !drive::plausible(&moments) {
                continue;
            }
            if let Some(dice) = &mut real {
                chain.colour = road::colour(&moments, seconds, dice);
                chain.timing = road::timing(dice);
            }
            let toml = car.user_toml(&mut dice);
            let log = bus::candump(&moments, seconds, &made.hidden, &chain, &mut dice);
            let visibility = None;
            return Some(Recording { order, car, plan, made, beside, chain, moments, toml, log, visibility });
        }
        None
    }

    /// Finds out how visible its cause is.
    pub fn look(&mut self) {
        if self.order.cause.sort != Sort::Control && !self.order.is_several() {
            let compare = matches!(self.order.cause.sort, Sort::Library | Sort::Unknown)
                && !matches!(self.order.cause.effect(), "sensor_sign" | "channel_swap");
            self.visibility = Some(visible::visibility(
                &self.car,
                &self.moments,
                &self.made,
                compare.then_some(self.order.cause.key),
            ));
        }
    }

    /// A cause that no test could find on this very drive counts as absorbable.
    pub fn sort(&self) -> Sort {
        match (&self.visibility, self.order.cause.sort) {
            (Some(v), Sort::Library | Sort::Unknown) if v.likelihood_ratio < DETECTABLE => Sort::Absorbable,
            (_, sort) => sort,
        }
    }

    /// Names that would be as good: given, or leaving no significant rest when fitted instead.
    pub fn fair(&self) -> Vec<String> {
        let mut fair = self.made.fair.clone();
        if let Some(v) = &self.visibility
            && matches!(self.order.cause.sort, Sort::Library | Sort::Unknown)
        {
            for (name, left, _) in &v.left_by {
                let name = if name.starts_with("tire_radius") { "tire_radius" } else { *name };
                let close = *left < 15.0 && *left < 0.2 * v.likelihood_ratio;
                if close && !self.made.accept.iter().any(|a| a == name) && !fair.iter().any(|f| f == name) {
                    fair.push(name.to_owned());
                }
            }
        }
        fair
    }

    /// Where the cause is visible: a local one where it acts, one that is always there where its signature is.
    pub fn intervals(&self) -> Vec<(f64, f64)> {
        if self.made.intervals.is_empty() {
            self.visibility.as_ref().map(|v| v.intervals.clone()).unwrap_or_default()
        } else {
            self.made.intervals.clone()
        }
    }

    /// The truth, in the form of the practice set's `truth.json`, with a few keys more.
    pub fn truth(&self) -> Value {
        let sort = self.sort();
        let nothing = sort == Sort::Control;
        let expected = match sort {
            Sort::Control | Sort::Absorbable => "adequate",
            Sort::Library | Sort::Everything => "missing_physics",
            Sort::Unknown => "unknown_physics",
        };
        let hidden_is_local = !self.made.intervals.is_empty();
        let round = |x: f64, digits: f64| (x * digits).round() / digits;
        let intervals: Vec<[f64; 2]> =
            self.intervals().iter().map(|&(a, b)| [round(a, 100.0), round(b, 100.0)]).collect();
        let (car, offset) = (&self.car, &self.chain.offset);
        let causes: Vec<&str> = self.order.causes().map(|cause| cause.key).collect();
        let all = std::iter::once(&self.made).chain(&self.beside).zip(&causes);
        let one = |(made, cause): (&Made, &&str)| {
            json!({
                "cause": cause, "accept": made.accept, "fair": made.fair, "intervals": made.intervals,
                "true_effect": made.parameters,
            })
        };
        let each: Vec<Value> = all.filter(|_| self.order.is_several()).map(one).collect();
        json!({
            "kind": if self.order.is_several() { "several" } else { sort.name() },
            "expected": expected,
            "cause": if nothing { Value::Null } else { json!(causes.join(" + ")) },
            "causes": each,
            "accept": self.made.accept,
            "fair": self.fair(),
            "intervals": intervals,
            "whole_recording": if nothing { Value::Null } else { json!(!hidden_is_local) },
            "seconds": self.plan.seconds,
            "source": "momentum",
            "made": self.order.made(),
            "scenario": self.plan.kind.name(),
            "factor": self.order.factor,
            "amplitude": if nothing { Value::Null } else { json!(self.made.amplitude) },
            "unit": if nothing { Value::Null } else { json!(self.made.unit) },
            "true_parameters": {
                "m": car.mass, "Iz": car.yaw_inertia, "a": car.a, "b": car.b, "tf": car.track[0],
                "tr": car.track[1], "Cf": car.cornering[0], "Cr": car.cornering[1], "Ck": car.slip_stiffness,
                "R": car.radius, "J": car.wheel_inertia, "ratio": car.steering_ratio, "mfC": SHAPE,
                "mfE": CURVATURE, "inv_mu": car.friction.map(|mu| 1.0 / mu), "kbf": car.brake_per_bar[0],
                "kbr": car.brake_per_bar[1], "fwd": if car.front_driven { 1.0 } else { 0.0 },
                "off_sw": offset[7], "off_r": offset[4], "off_ay": offset[5], "off_ax": offset[6],
            },
            "sensor_offsets": { "r": offset[4], "ay": offset[5], "ax": offset[6], "sw": offset[7] },
            "true_effect": self.made.parameters,
            "likelihood_ratio_of_truth": self.visibility.as_ref().map(|v| round(v.likelihood_ratio, 10.0)),
            "left_by": self.visibility.as_ref().map(|v| {
                v.left_by.iter().map(|(name, left, strength)| {
                        ((*name).to_owned(), json!([round(*left, 10.0), round(*strength, 1000.0)]))
                    })
                    .collect::<serde_json::Map<_, _>>()
            }),
        })
    }

    /// Writes what the program is given: `NAME.toml` and `NAME.log.gz` beside `trial.dbc`. Not the truth.
    pub fn write(&self, folder: &Path, name: &str) -> std::io::Result<()> {
        std::fs::write(folder.join("trial.dbc"), bus::DBC)?;
        std::fs::write(folder.join(format!("{name}.toml")), &self.toml)?;
        std::fs::write(folder.join(format!("{name}.log.gz")), self.log_gz())
    }

    /// The log, compressed.
    pub fn log_gz(&self) -> Vec<u8> {
        let mut gz = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::fast());
        gz.write_all(self.log.as_bytes()).unwrap();
        gz.finish().unwrap()
    }
}
