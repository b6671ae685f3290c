//! What the service says of the cornering stiffness, against what is true.

use gripd::Estimates;
use gripd::model::Truth;

use super::judge::{TRANSITION, share};

/// A value this near is right.
const NEAR: f64 = 0.07;

/// Lateral accelerations, m/s²: in curves, and in those that excite the stiffness much.
const IN_CURVES: f64 = 1.0;
const EXCITING: f64 = 3.0;

/// A change of surface counts as one of the stiffness from this share on, and is followed when both axles are this near.
const CHANGE: f64 = 0.2;
const FOLLOWED: f64 = 0.1;

/// Who has had less driving in curves than this after a change has had no chance, s.
const CHANCE_S: f64 = 1.0;

/// Samples where it is valid: all, both axles near, each axle's interval with the truth in it.
#[derive(Clone, Copy, Debug, Default)]
struct Valid {
    samples: u64,
    near: u64,
    held: [u64; 2],
}

impl Valid {
    fn add(&mut self, is_near: bool, held: [bool; 2]) {
        self.samples += 1;
        self.near += u64::from(is_near);
        self.held = [0, 1].map(|axle| self.held[axle] + u64::from(held[axle]));
    }

    fn and(self, other: Self) -> Self {
        Self {
            samples: self.samples + other.samples,
            near: self.near + other.near,
            held: [0, 1].map(|axle| self.held[axle] + other.held[axle]),
        }
    }
}

/// What is counted of a drive, or of many.
#[derive(Clone, Debug, Default)]
pub struct Cornering {
    in_curves: u64,
    valid_in_curves: u64,
    valid: Valid,
    valid_excited: Valid,
    /// Seconds of driving in curves from each change until both axles were near.
    followed_s: Vec<f64>,
    not_followed: u64,
}

/// Follows one drive.
#[derive(Default)]
pub struct Watch {
    sum: Cornering,
    /// Both axles' true stiffness, added, of all samples so far.
    before: Vec<f64>,
    is_changing: bool,
    /// Seconds of driving in curves since a change that is not followed yet.
    waiting: Option<f64>,
}

impl Watch {
    /// One sample, a hundredth of a second.
    pub fn step(&mut self, truth: &Truth, estimates: &Estimates) {
        let axles = [truth.cornering_front, truth.cornering_rear];
        self.notice_changes(axles[0] + axles[1]);
        let is_in_curve = truth.lateral_acceleration.abs() >= IN_CURVES;
        self.sum.in_curves += u64::from(is_in_curve);
        if let Some(waited) = self.waiting.as_mut().filter(|_| is_in_curve) {
            *waited += 0.01;
        }
        let [Some(front), Some(rear)] = estimates.cornering else { return };
        if !estimates.cornering_valid {
            return;
        }
        let off = [front.value / axles[0] - 1.0, rear.value / axles[1] - 1.0];
        let both = |near: f64| off.iter().all(|off| off.abs() <= near);
        let held = [(front, axles[0]), (rear, axles[1])]
            .map(|(estimate, truth)| (estimate.value - truth).abs() <= 1.96 * estimate.std);
        self.sum.valid_in_curves += u64::from(is_in_curve);
        self.sum.valid.add(both(NEAR), held);
        if truth.lateral_acceleration.abs() >= EXCITING {
            self.sum.valid_excited.add(both(NEAR), held);
        }
        if both(FOLLOWED) {
            self.sum.followed_s.extend(self.waiting.take());
        }
    }

    fn notice_changes(&mut self, both_axles: f64) {
        self.before.push(both_axles);
        let place = self.before.len().saturating_sub(TRANSITION + 1);
        let was_changing =
            std::mem::replace(&mut self.is_changing, (both_axles / self.before[place] - 1.0).abs() > CHANGE);
        if self.is_changing && !was_changing {
            self.give_up();
            self.waiting = Some(0.0);
        }
    }

    fn give_up(&mut self) {
        self.sum.not_followed += u64::from(self.waiting.take().is_some_and(|waited| waited > CHANCE_S));
    }

    pub fn finish(mut self) -> Cornering {
        self.give_up();
        self.sum
    }
}

impl Cornering {
    pub const HEADER: &str = "driving in curves, samples | cornering stiffness valid | both axles within 7 %, where \
                              valid | the same beyond 3 m/s² | in its 95 % interval, front and rear | after a change \
                              by 20 %: within 10 % after, in curves, median | most of 9 in 10 | not at all";

    pub fn and(mut self, other: Self) -> Self {
        self.in_curves += other.in_curves;
        self.valid_in_curves += other.valid_in_curves;
        self.valid = self.valid.and(other.valid);
        self.valid_excited = self.valid_excited.and(other.valid_excited);
        self.followed_s.extend(other.followed_s);
        self.not_followed += other.not_followed;
        self
    }

    /// Of all drives, a row of a table.
    pub fn row(&self) -> String {
        let changes = self.followed_s.len() as u64 + self.not_followed;
        let mut followed = self.followed_s.clone();
        followed.sort_by(f64::total_cmp);
        let within = |share: f64| {
            followed.get((share * changes as f64) as usize).map_or("–".into(), |s| format!("{s:.1} s"))
        };
        let Self { valid, valid_excited, .. } = self;
        let [front, rear] = valid.held.map(|held| share(held, valid.samples));
        format!(
            "{} | {:.1} % | {:.1} % | {:.1} % | {front:.1}, {rear:.1} % | {} | {} | {} of {changes}",
            self.in_curves,
            share(self.valid_in_curves, self.in_curves),
            share(valid.near, valid.samples),
            share(valid_excited.near, valid_excited.samples),
            within(0.5),
            within(0.9),
            self.not_followed,
        )
    }
}
