//! Does the zero of the drive torque jump?
//!
//! Torque over radius is what pushes the car, and an accelerometer feels the same, hills included. Their difference is an
//! offset that moves slowly. When it jumps, slips against forces tell nothing for as long as it takes to see whether it
//! stays; then the forces are corrected by it. Without an accelerometer a hill looks the same, and nothing is said.

use crate::estimate::cornering::Doubt;

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
    lasts_s: 20.0,
    steady: 0.15,
};

/// Compares torque and accelerometer.
#[derive(Clone, Copy, Debug, Default)]
pub struct TorqueZero {
    /// Mean differences, m/s², and the first one.
    usual: f64,
    now: f64,
    first: Option<f64>,
    /// Variance of the difference around its mean of now, and mean square of what the accelerometer feels, (m/s²)².
    variance: f64,
    square: f64,
    seen_s: f64,
    doubted_s: Option<f64>,
    calm_s: f64,
}

impl TorqueZero {
    /// Takes what the torque tells more than the accelerometer feels, and that, m/s².
    pub fn step(&mut self, difference: f64, felt: f64, elapsed_s: f64) {
        self.seen_s += elapsed_s;
        let within = |seconds: f64| (elapsed_s / self.seen_s.min(seconds)).min(1.0);
        self.now += within(TUNING.now_s) * (difference - self.now);
        self.variance += within(TUNING.lasts_s / 2.0) * ((difference - self.now).powi(2) - self.variance);
        self.square += within(TUNING.usual_s) * (felt * felt - self.square);
        if self.doubted_s.is_none() {
            self.usual += within(TUNING.usual_s) * (difference - self.usual);
        }
        if self.seen_s < TUNING.shows_s {
            return;
        }
        self.first.get_or_insert(self.usual);
        let off = (self.now - self.usual).abs();
        self.calm_s = if off > TUNING.ends * TUNING.jump { 0.0 } else { self.calm_s + elapsed_s };
        self.doubted_s = match self.doubted_s {
            Some(since) if self.calm_s < TUNING.calm_s => Some(since + elapsed_s),
            None if off > TUNING.jump => Some(0.0),
            _ => None,
        };
        let lasts = self.doubted_s.is_some_and(|since| since > TUNING.lasts_s);
        if lasts && self.variance < TUNING.steady * TUNING.steady {
            (self.usual, self.doubted_s) = (self.now, None);
        }
    }

    /// The forces cannot be told at the moment.
    pub fn doubt(&self) -> Option<Doubt> {
        let lasts_s = self.doubted_s?;
        Some(Doubt::Disagreement {
            sensors: ["drive_torque", "longitudinal_acceleration", "m/s²"],
            off: (self.now - self.usual).abs(),
            of: self.square.sqrt(),
            lasts_s,
            left_out: None,
        })
    }

    /// By so much the torque tells more now than in the beginning, m/s²; what is less than a jump is the tires' business.
    pub fn moved(&self) -> f64 {
        let moved = self.first.map_or(0.0, |first| self.usual - first);
        if moved.abs() > TUNING.ends * TUNING.jump { moved } else { 0.0 }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Accelerates and coasts with a torque that is 5 % wrong; what is told at each quarter of a second.
    fn drive(zero: impl Fn(f64) -> f64) -> Vec<TorqueZero> {
        let mut torque = TorqueZero::default();
        let at = |i: u32| {
            let t = 0.25 * f64::from(i);
            let felt = 1.5 * (0.8 * t).sin();
            torque.step(0.05 * felt + 0.1 + zero(t), felt, 0.25);
            torque
        };
        (0..480).map(at).collect()
    }

    #[test]
    fn a_wrong_scale_and_a_slow_drift_are_no_jump() {
        let seen = drive(|t| 0.003 * t);
        assert!(seen.iter().all(|it| it.doubt().is_none()));
    }

    #[test]
    fn a_jump_is_told_and_what_stays_is_the_new_zero() {
        let seen = drive(|t| if t > 60.0 { 0.44 } else { 0.0 });
        let told: Vec<usize> = (0..seen.len()).filter(|i| seen[*i].doubt().is_some()).collect();
        let (first, last) = (0.25 * told[0] as f64, 0.25 * told[told.len() - 1] as f64);
        assert!((60.0..64.0).contains(&first) && (78.0..86.0).contains(&last), "{first} to {last}");
        assert!((seen[479].moved() - 0.44).abs() < 0.05, "{}", seen[479].moved());
    }

    #[test]
    fn a_frozen_torque_has_no_zero() {
        let felt = |t: f64| 1.5 * (0.8 * t).sin();
        let seen = drive(|t| if t > 60.0 { -1.05 * felt(t) + 0.3 } else { 0.0 });
        assert!(seen[260..].iter().all(|it| it.doubt().is_some() && it.moved() == 0.0));
    }

    #[test]
    fn a_jump_that_ends_leaves_nothing() {
        let seen = drive(|t| if (60.0..70.0).contains(&t) { -0.44 } else { 0.0 });
        assert!(seen[275].doubt().is_some());
        assert!(seen[310].doubt().is_none() && seen[479].moved() == 0.0);
    }
}
