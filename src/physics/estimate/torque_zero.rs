//! Does the zero of the drive torque jump?
//!
//! Torque over radius is what pushes the car, and an accelerometer feels the same, hills included. Their difference is an
//! offset that moves slowly. When it jumps, nobody knows which of both has a new zero, and slips against forces tell nothing
//! until the old one is there again. If it stays where it is, slopes are learned anew. Without an accelerometer a hill looks
//! the same, and nothing is said.

use crate::estimate::cornering::Doubt;
use crate::estimate::lasting::Lasting;

/// Tuned with the test `one_channel`.
struct Tuning {
    /// What is usual is the mean of so many seconds, what is now of so many, s.
    usual_s: f64,
    now_s: f64,
    /// Before so many seconds nothing is said.
    shows_s: f64,
    /// A jump is this much at least, m/s²: torques are some per cent wrong while the car accelerates.
    jump: f64,
    /// A doubt ends when it has been at this share of what it begins at for so long, s.
    ends: f64,
    calm_s: f64,
    /// What lasts so long, s, is the new zero, …
    lasts_s: f64,
    /// … if it varies by less than this, m/s² rms: a frozen torque has none.
    steady: f64,
}

const TUNING: Tuning = Tuning {
    usual_s: 40.0,
    now_s: 2.0,
    shows_s: 10.0,
    jump: 0.25,
    ends: 0.6,
    calm_s: 3.0,
    lasts_s: 60.0,
    steady: 0.15,
};

/// Compares torque and accelerometer.
#[derive(Clone, Copy, Debug, Default)]
pub struct TorqueZero {
    /// Mean differences, m/s².
    usual: f64,
    now: f64,
    /// Variance of the difference around its mean of now, and mean square of what the accelerometer feels, (m/s²)².
    variance: f64,
    square: f64,
    seen_s: f64,
    doubt: Lasting,
    calm_s: f64,
}

impl TorqueZero {
    /// Takes what the torque tells more than the accelerometer feels, and that, m/s². Returns whether the difference has moved
    /// and stayed there for long enough.
    pub fn step(&mut self, difference: f64, felt: f64, elapsed_s: f64) -> bool {
        self.seen_s += elapsed_s;
        let within = |seconds: f64| (elapsed_s / self.seen_s.min(seconds)).min(1.0);
        self.now += within(TUNING.now_s) * (difference - self.now);
        self.variance += within(TUNING.lasts_s / 6.0) * ((difference - self.now).powi(2) - self.variance);
        self.square += within(TUNING.usual_s) * (felt * felt - self.square);
        if !self.doubt.is_there() {
            self.usual += within(TUNING.usual_s) * (difference - self.usual);
        }
        if self.seen_s < TUNING.shows_s {
            return false;
        }
        let off = (self.now - self.usual).abs();
        self.calm_s = if off > TUNING.ends * TUNING.jump { 0.0 } else { self.calm_s + elapsed_s };
        let is_off = if self.doubt.is_there() { self.calm_s < TUNING.calm_s } else { off > TUNING.jump };
        self.doubt.step(is_off, elapsed_s);
        let lasts = self.doubt.lasts_s().is_some_and(|lasts| lasts > TUNING.lasts_s);
        if !lasts || self.variance > TUNING.steady * TUNING.steady {
            return false;
        }
        (self.usual, self.doubt) = (self.now, Lasting::default());
        true
    }

    /// The forces cannot be told at the moment.
    pub fn doubt(&self) -> Option<Doubt> {
        let lasts_s = self.doubt.lasts_s()?;
        Some(Doubt::Disagreement {
            sensors: ["drive_torque", "longitudinal_acceleration", "m/s²"],
            off: (self.now - self.usual).abs(),
            of: self.square.sqrt(),
            lasts_s,
            left_out: None,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Accelerates and coasts with a torque that is 5 % wrong; for each quarter of a second whether it is doubted, and
    /// whether its zero has moved.
    fn drive(zero: impl Fn(f64) -> f64) -> Vec<(bool, bool)> {
        let (mut torque, mut moved) = (TorqueZero::default(), false);
        let at = |i: u32| {
            let t = 0.25 * f64::from(i);
            let felt = 1.5 * (0.8 * t).sin();
            moved |= torque.step(0.05 * felt + 0.1 + zero(t), felt, 0.25);
            (torque.doubt().is_some(), moved)
        };
        (0..480).map(at).collect()
    }

    #[test]
    fn a_wrong_scale_and_a_slow_drift_are_no_jump() {
        assert!(drive(|t| 0.003 * t).iter().all(|is_doubted| *is_doubted == (false, false)));
    }

    #[test]
    fn a_jump_is_told_and_what_stays_is_the_new_zero() {
        let seen = drive(|t| if t > 56.0 { 0.44 } else { 0.0 });
        let told: Vec<usize> = (0..seen.len()).filter(|i| seen[*i].0).collect();
        let (first, last) = (0.25 * told[0] as f64, 0.25 * told[told.len() - 1] as f64);
        assert!((56.0..60.0).contains(&first) && (116.0..119.0).contains(&last), "{first} to {last}");
        assert!(!seen[last as usize * 4].1 && seen[479].1);
    }

    #[test]
    fn a_frozen_torque_has_no_zero() {
        let felt = |t: f64| 1.5 * (0.8 * t).sin();
        let seen = drive(|t| if t > 60.0 { -1.05 * felt(t) + 0.3 } else { 0.0 });
        assert!(seen[260..].iter().all(|is_doubted| *is_doubted == (true, false)));
    }

    #[test]
    fn a_jump_that_ends_leaves_nothing() {
        let seen = drive(|t| if (60.0..70.0).contains(&t) { -0.44 } else { 0.0 });
        assert!(seen[275].0 && seen[479] == (false, false));
    }
}
