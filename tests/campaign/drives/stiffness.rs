//! How well each peer knows the cornering stiffness.

use std::fmt;

use gripd::Estimates;
use gripd::estimate::Car;
use gripd::estimates::Estimate;
use gripd::model::Truth;

use super::judge::{TRANSITION, counts, share};
use super::learner::Said;
use super::peers::{Driven, Row};

/// A change of surface counts as one of the stiffness from this share on.
const CHANGE: f64 = 0.2;
/// It is noticed when the estimate is this near the new truth.
const NEAR: f64 = 0.15;
/// One surface is still going over into the next: who is right at the end of it was so by chance, s.
const TOO_EARLY_S: f64 = 0.01 * TRANSITION as f64;
/// Who has had less driving than this after a change has had no chance, s.
const CHANCE_S: f64 = 1.0;

/// A name in the table, and how it speaks, given the data sheet's stiffnesses front and rear.
pub type Peer = (&'static str, fn(&Row, [f64; 2]) -> Stiffness);

/// The peers, in the order of the table.
pub const PEERS: [Peer; 6] = [
    ("gripd", |row, _| Stiffness::of_axles(&row.ours.cornering)),
    ("gripd, where valid", valid),
    ("thesis (5.20), v_y by method 2", |row, _| Stiffness::of_axles(&row.thesis.thesis.cornering_regression)),
    ("thesis (5.20), v_y by gripd", |row, _| Stiffness::of_axles(&row.ours.thesis.cornering_regression)),
    ("thesis (5.21), one stiffness", |row, _| Stiffness::OfBoth(row.ours.thesis.cornering_ekf.map(said))),
    ("learner, factor × data sheet", learned),
];

/// Normalized by load, 1/rad.
#[derive(Clone, Copy, Debug)]
pub enum Stiffness {
    /// Front and rear.
    OfAxles([Option<Said>; 2]),
    /// One for both axles.
    OfBoth(Option<Said>),
}

fn said(estimate: Estimate) -> Said {
    Said { value: estimate.value, std: estimate.std }
}

fn valid(row: &Row, _: [f64; 2]) -> Stiffness {
    let Estimates { cornering, cornering_valid, .. } = &row.ours;
    Stiffness::of_axles(&cornering.map(|axle| axle.filter(|_| *cornering_valid)))
}

fn learned(row: &Row, sheet: [f64; 2]) -> Stiffness {
    let axle =
        |sheet: f64| row.factor.map(|factor| Said { value: factor.value * sheet, std: factor.std * sheet });
    Stiffness::OfAxles(sheet.map(axle))
}

impl Stiffness {
    fn of_axles(axles: &[Option<Estimate>; 2]) -> Self {
        Self::OfAxles(axles.map(|axle| axle.map(said)))
    }

    /// Both axles' mean by load.
    fn mean(self, front_share: f64) -> Option<f64> {
        match self {
            Self::OfAxles(axles) => {
                let [front, rear] = axles.map(|axle| axle.map(|axle| axle.value));
                Some(front_share * front? + (1.0 - front_share) * rear?)
            }
            Self::OfBoth(both) => both.map(|both| both.value),
        }
    }
}

/// Relative errors.
#[derive(Clone, Debug, Default)]
struct Errors(Vec<f32>);

impl Errors {
    fn add(&mut self, estimate: Option<f64>, truth: f64) {
        self.0.extend(estimate.map(|estimate| (estimate / truth - 1.0) as f32));
    }
}

impl fmt::Display for Errors {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.0.is_empty() {
            return write!(f, "–");
        }
        let square: f64 = self.0.iter().map(|error| f64::from(*error).powi(2)).sum();
        let sizes = self.0.iter().map(|error| f64::from(error.abs())).collect();
        let rms = (square / self.0.len() as f64).sqrt();
        write!(f, "{:.1} / {:.1} %", 100.0 * rms, 100.0 * median(sizes))
    }
}

fn median(mut values: Vec<f64>) -> f64 {
    let middle = values.len() / 2;
    *values.select_nth_unstable_by(middle, f64::total_cmp).1
}

/// What one peer achieved.
#[derive(Clone, Debug, Default)]
pub struct Score {
    samples: u64,
    with_value: u64,
    /// Front, rear and their mean.
    errors: [Errors; 3],
    /// Numbers with a standard deviation, and how many of them hold the truth within two.
    held: [u64; 2],
    /// Seconds of driving from each change of surface until it was noticed.
    noticed_s: Vec<f64>,
    unnoticed: u64,
    /// Changes to a stiffness that an estimate was at already, by chance.
    there_before: u64,
}

/// Watches one peer through one drive.
#[derive(Default)]
struct Watch {
    score: Score,
    /// Seconds of driving since a change that is not noticed yet.
    waiting: Option<f64>,
}

impl Watch {
    fn step(&mut self, stiffness: Stiffness, truth: &Truth, front_share: f64, changes: bool, elapsed_s: f64) {
        let axles = [truth.cornering_front, truth.cornering_rear];
        let both = front_share * axles[0] + (1.0 - front_share) * axles[1];
        let score = &mut self.score;
        let mean = stiffness.mean(front_share);
        score.samples += 1;
        score.with_value += u64::from(mean.is_some());
        score.errors[2].add(mean, both);
        let mut hold = |said: Option<Said>, truth: f64| {
            let Some(said) = said else { return };
            score.held[0] += 1;
            score.held[1] += u64::from((said.value - truth).abs() <= 2.0 * said.std);
        };
        match stiffness {
            Stiffness::OfAxles(said) => {
                for (i, said) in said.into_iter().enumerate() {
                    hold(said, axles[i]);
                    score.errors[i].add(said.map(|said| said.value), axles[i]);
                }
            }
            Stiffness::OfBoth(said) => hold(said, both),
        }
        if changes {
            self.give_up();
            self.waiting = Some(0.0);
        }
        let Some(waited) = &mut self.waiting else { return };
        *waited += elapsed_s;
        if *waited > TOO_EARLY_S && mean.is_some_and(|mean| (mean / both - 1.0).abs() <= NEAR) {
            if *waited < TOO_EARLY_S + 2.0 * elapsed_s {
                self.score.there_before += 1;
            } else {
                self.score.noticed_s.push(*waited);
            }
            self.waiting = None;
        }
    }

    fn give_up(&mut self) {
        self.score.unnoticed += u64::from(self.waiting.take().is_some_and(|waited| waited > CHANCE_S));
    }
}

/// How all of [`PEERS`] do on a drive.
pub fn scores(drive: &Driven) -> Vec<Score> {
    let car = Car::new(&drive.sheet);
    let sheet = car.cornering_prior.map(|(value, _)| value);
    let front_share = car.b / car.wheelbase();
    let stiffness = |place: usize| {
        let truth = &drive.rows[place].truth;
        front_share * truth.cornering_front + (1.0 - front_share) * truth.cornering_rear
    };
    let mut watches: Vec<Watch> = PEERS.iter().map(|_| Watch::default()).collect();
    let mut changed_before = false;
    for (place, row) in drive.rows.iter().enumerate() {
        let ratio = stiffness(place) / stiffness(place.saturating_sub(TRANSITION));
        let changed = (ratio - 1.0).abs() > CHANGE;
        let changes = changed && !std::mem::replace(&mut changed_before, changed);
        if !counts(&row.truth) {
            continue;
        }
        for ((_, of), watch) in PEERS.iter().zip(&mut watches) {
            watch.step(of(row, sheet), &row.truth, front_share, changes, drive.samples[place].elapsed_s);
        }
    }
    let finished = |mut watch: Watch| {
        watch.give_up();
        watch.score
    };
    watches.into_iter().map(finished).collect()
}

impl Score {
    pub fn and(mut self, other: Self) -> Self {
        self.samples += other.samples;
        self.with_value += other.with_value;
        for (mine, other) in self.errors.iter_mut().zip(other.errors) {
            mine.0.extend(other.0);
        }
        self.held = [self.held[0] + other.held[0], self.held[1] + other.held[1]];
        self.noticed_s.extend(other.noticed_s);
        self.unnoticed += other.unnoticed;
        self.there_before += other.there_before;
        self
    }

    pub const HEADER: &'static str = "\
| cornering stiffness | has a value | front: rms / median error | rear | both axles' mean | truth within ±2 std | \
changes by 20 %: within 15 % after (median) | never | by chance before |
|---|---|---|---|---|---|---|---|---|";

    /// Its line of the table.
    pub fn line(&self, name: &str) -> String {
        let changes = self.noticed_s.len() as u64 + self.unnoticed + self.there_before;
        let seconds = if self.noticed_s.is_empty() {
            "–".to_owned()
        } else {
            format!("{:.1} s", median(self.noticed_s.clone()))
        };
        let [front, rear, both] = &self.errors;
        format!(
            "| {name} | {:.1} % | {front} | {rear} | {both} | {:.1} % | {seconds} | {} of {changes} | {} |",
            share(self.with_value, self.samples),
            share(self.held[1], self.held[0]),
            self.unnoticed,
            self.there_before
        )
    }
}
