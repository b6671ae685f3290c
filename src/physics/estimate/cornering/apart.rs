//! Do the stiffnesses of both axles move apart?
//!
//! A road changes under both axles. Where only one axle seems to become stiffer or softer while the car drives, a sensor has
//! changed, such as the scale of the steering angle, in which a front axle's stiffness shows first.

use crate::estimate::lasting::Lasting;
use crate::estimates::Estimate;

/// Tuned with the tests `one_channel` (a sound drive's ratio stays within 0.11) and `campaign`.
struct Tuning {
    /// The usual ratio is the mean of so many seconds, s, and known after so many.
    usual_s: f64,
    shows_s: f64,
    /// Logarithms may differ from it by so much.
    apart: f64,
    /// A doubt ends at this share of it.
    ends: f64,
    /// What gets in or out of a car that stands so long, s, may move them.
    stands_s: f64,
}

const TUNING: Tuning = Tuning { usual_s: 120.0, shows_s: 15.0, apart: 0.16, ends: 0.6, stands_s: 20.0 };

/// Follows the ratio of front and rear stiffness.
#[derive(Clone, Copy, Debug, Default)]
pub struct Apart {
    /// Logarithm of the ratio: its mean, and now.
    usual: f64,
    now: f64,
    seen_s: f64,
    stood_s: f64,
    doubt: Lasting,
}

impl Apart {
    /// Takes stiffnesses that are good enough to be given out, if there are any.
    pub fn step(&mut self, stiffness: &[Option<Estimate>; 2], are_good: bool, speed: f64, elapsed_s: f64) {
        self.stood_s = if speed > 1.0 { 0.0 } else { self.stood_s + elapsed_s };
        if self.stood_s > TUNING.stands_s {
            *self = Self { stood_s: self.stood_s, ..Self::default() };
        }
        let &[Some(front), Some(rear)] = stiffness else { return };
        if !are_good {
            return;
        }
        self.now = (front.value / rear.value).ln();
        if !self.doubt.is_there() {
            self.seen_s += elapsed_s;
            let weight = elapsed_s / self.seen_s.min(TUNING.usual_s);
            self.usual += weight.min(1.0) * (self.now - self.usual);
        }
        let limit = self.doubt.limit(TUNING.ends) * TUNING.apart;
        self.doubt.step(self.seen_s > TUNING.shows_s && self.by().abs() > limit, elapsed_s);
    }

    /// How far they have moved apart: logarithm of a factor, positive where the front axle seems stiffer; and for how long
    /// it has been too much, s.
    pub fn doubt(&self) -> Option<(f64, f64)> {
        Some((self.by(), self.doubt.lasts_s()?))
    }

    fn by(&self) -> f64 {
        self.now - self.usual
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn drive(apart: &mut Apart, stiffness: [f64; 2], seconds: u32) {
        for _ in 0..100 * seconds {
            let known = stiffness.map(|value| Some(Estimate { value, std: 1.0, age_s: 0.0 }));
            apart.step(&known, true, 20.0, 0.01);
        }
    }

    #[test]
    fn a_road_changes_under_both_axles_and_a_sensor_under_one() {
        let mut apart = Apart::default();
        drive(&mut apart, [12.0, 14.0], 60);
        drive(&mut apart, [6.5, 7.0], 60);
        assert_eq!(apart.doubt(), None);
        drive(&mut apart, [9.0, 7.0], 60);
        assert!(apart.doubt().is_some_and(|(by, lasts_s)| by > 0.2 && lasts_s > 59.0));
        drive(&mut apart, [12.0, 13.5], 1);
        assert_eq!(apart.doubt(), None);
    }

    #[test]
    fn who_stands_may_load() {
        let mut apart = Apart::default();
        drive(&mut apart, [12.0, 14.0], 60);
        (0..3000).for_each(|_| apart.step(&[None; 2], false, 0.0, 0.01));
        drive(&mut apart, [12.0, 10.0], 60);
        assert_eq!(apart.doubt(), None);
    }
}
