//! The EKF of thesis (5.21) over a drive, and what became of it.

use std::ops::Range;

use super::course::{Course, HALVED, MINIMUM_SPEED, STIFFNESS, WHOLE, mean};
use crate::estimate::{JointEkf, JointEkfConfig, Kinematics};

/// Parameter noises of C_y that are tried, relative, 1/√s: hardly any, moderate, much.
pub(super) const WALKS: [f64; 3] = [1e-4, 1e-2, 1e-1];

/// One sample of the filter.
#[derive(Clone, Copy, Debug)]
pub(super) struct EkfPoint {
    /// Time, s.
    pub(super) t: f64,
    /// Lateral velocity, m/s.
    pub(super) vy: f64,
    /// C_yN, 1/rad.
    pub(super) stiffness: f64,
}

/// Runs it with a parameter noise on what `input` makes of each point: the measurements, or the truth.
pub(super) fn over(
    course: &Course,
    walk: f64,
    input: impl Fn(&super::course::Point) -> Kinematics,
) -> Vec<EkfPoint> {
    let config = JointEkfConfig { stiffness_walk: walk, ..JointEkfConfig::default() };
    let mut filter = JointEkf::new(&course.car, &course.drive.sensors, &config, MINIMUM_SPEED);
    let step = |point: &super::course::Point| {
        filter.step(&input(point));
        EkfPoint {
            t: point.t,
            vy: filter.lateral_velocity().unwrap_or(f64::NAN),
            stiffness: filter.stiffness().map_or(f64::NAN, |estimate| estimate.value),
        }
    };
    course.points.iter().map(step).collect()
}

/// The true signals in the place of the measured ones.
pub(super) fn noise_free(point: &super::course::Point) -> Kinematics {
    Kinematics {
        speed: Some(point.truth.longitudinal_velocity),
        yaw_rate: Some(point.truth.yaw_rate),
        lateral_acceleration: Some(point.truth.lateral_acceleration),
        road_angle: Some(point.truth.steer),
        ..point.now
    }
}

/// What a filter did in Sim2.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Behaviour {
    /// Right at the end of every phase, and there within [`SOON_S`] of each change.
    Follows,
    /// Right at the end of every phase, but slower.
    Late,
    /// Did not move.
    Blind,
    /// Moved, but elsewhere.
    Wrong,
}

/// Right: within this share of the truth.
const RIGHT: f64 = 0.2;
/// Within seconds, s.
const SOON_S: f64 = 10.0;
/// The truth halves; a filter that moves by less than this factor did not move.
const MOVED: f64 = 1.25;

/// How a stiffness went through Sim2.
#[derive(Clone, Copy, Debug)]
pub(super) struct Track {
    /// Mean over the last ten seconds of each phase, 1/rad.
    pub(super) ends: [f64; 3],
    /// Least mean over a second while halved, 1/rad.
    pub(super) least: f64,
    /// From each change to the first second whose mean is right, s; infinite if there is none.
    pub(super) delays_s: [f64; 2],
    /// In one word.
    pub(super) behaviour: Behaviour,
}

impl Track {
    /// Of stiffnesses over time; those that are not numbers do not count.
    pub(super) fn new(points: impl Iterator<Item = (f64, f64)> + Clone) -> Self {
        let over = |time: Range<f64>| {
            mean(points.clone().filter(|p| time.contains(&p.0) && p.1.is_finite()).map(|p| p.1))
        };
        let phases = [WHOLE.start..HALVED.start, HALVED, HALVED.end..200.0];
        let ends = phases.clone().map(|phase| over(phase.end - 10.0..phase.end));
        let truth = [STIFFNESS, 0.5 * STIFFNESS, STIFFNESS];
        let right = |value: f64, truth: f64| (value / truth - 1.0).abs() < RIGHT;
        let seconds = |phase: &Range<f64>| -> Vec<f64> {
            let count = (phase.end - phase.start).round() as u32;
            (0..count).map(|i| phase.start + f64::from(i)).map(|from| over(from..from + 1.0)).collect()
        };
        let halved = seconds(&phases[1]);
        let delay = |means: &[f64], truth: f64| {
            means.iter().position(|value| right(*value, truth)).map_or(f64::INFINITY, |i| i as f64)
        };
        let delays_s = [delay(&halved, truth[1]), delay(&seconds(&phases[2]), truth[2])];
        let moved = (ends[0] / ends[1]).max(ends[1] / ends[0]);
        let behaviour = if ends.iter().zip(truth).all(|(end, truth)| right(*end, truth)) {
            if delays_s.iter().all(|delay| *delay <= SOON_S) { Behaviour::Follows } else { Behaviour::Late }
        } else if moved < MOVED {
            Behaviour::Blind
        } else {
            Behaviour::Wrong
        };
        let least = halved.iter().copied().fold(f64::INFINITY, f64::min);
        Self { ends, least, delays_s, behaviour }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn track(value: impl Fn(f64) -> f64) -> Behaviour {
        let points: Vec<_> = (0..2000).map(|i| f64::from(i) * 0.1).map(|t| (t, value(t))).collect();
        Track::new(points.into_iter()).behaviour
    }

    #[test]
    fn behaviours_are_told_apart() {
        let truth = |t: f64| if HALVED.contains(&t) { 5.75 } else { 11.5 };
        assert_eq!(track(truth), Behaviour::Follows);
        assert_eq!(track(|t| truth(t - 20.0)), Behaviour::Late);
        assert_eq!(track(|_| 11.0), Behaviour::Blind);
        assert_eq!(track(|t| if HALVED.contains(&t) { 2.0 } else { 11.5 }), Behaviour::Wrong);
    }
}
