//! The EKF of thesis (5.21) over a drive, and what became of it.

use std::fmt;

use super::course::{HALVED, LateralDrive, MINIMUM_SPEED, STIFFNESS, WHOLE, mean};
use physics::estimate::Kinematics;
use physics::estimate::thesis::{JointEkf, JointEkfConfig};

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
    course: &LateralDrive,
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
        rear_angle: 0.0,
        ..point.now
    }
}

/// What a filter did in Sim2.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Behaviour {
    /// Right within [`SOON_S`] of each change and at the end of every phase, seldom far off between.
    Follows,
    /// The same, but slower.
    Late,
    /// Right at first; did not move.
    Blind,
    /// Anything else.
    Wrong,
}

/// Right: within this share of the truth.
const RIGHT: f64 = 0.2;
/// Within seconds, s.
const SOON_S: f64 = 10.0;
/// Share of the seconds, changes left out, that may be outside what C_y ever is.
const SELDOM: f64 = 0.1;
/// The truth halves; a filter that moves by less than this factor did not move.
const MOVED: f64 = 1.25;
/// So far from the truth before anything changes (share): not blind, but wrong.
const OFF: f64 = 0.3;

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
    /// Of stiffnesses over time, in order; those that are not numbers do not count.
    pub(super) fn new(points: impl Iterator<Item = (f64, f64)>) -> Self {
        let truth = [STIFFNESS, 0.5 * STIFFNESS, STIFFNESS];
        let phases = seconds(points);
        let right = |phase: usize, value: f64| (value / truth[phase] - 1.0).abs() < RIGHT;
        let ends = phases.each_ref().map(|means| {
            let last = means.iter().rev().take(10);
            mean(last.copied().filter(|value| value.is_finite()))
        });
        let delays_s = [1, 2].map(|phase| {
            let first = phases[phase].iter().position(|value| right(phase, *value));
            first.map_or(f64::INFINITY, |second| second as f64)
        });
        let (low, high) = ((1.0 - RIGHT) * truth[1], (1.0 + RIGHT) * truth[0]);
        let settled = phases.iter().flat_map(|means| means.iter().skip(SOON_S as usize));
        let astray = mean(settled.map(|value| f64::from(u8::from(!(low..=high).contains(value))))) > SELDOM;
        let ends_right = ends.iter().enumerate().all(|(phase, end)| right(phase, *end));
        let moved = (ends[0] / ends[1]).max(ends[1] / ends[0]) > MOVED;
        let behaviour = if ends_right && !astray {
            let soon = delays_s.iter().all(|delay| *delay <= SOON_S);
            if soon { Behaviour::Follows } else { Behaviour::Late }
        } else if !moved && (ends[0] / truth[0] - 1.0).abs() < OFF {
            Behaviour::Blind
        } else {
            Behaviour::Wrong
        };
        let least = phases[1].iter().copied().fold(f64::INFINITY, f64::min);
        Self { ends, least, delays_s, behaviour }
    }
}

impl fmt::Display for Track {
    /// The ends of the phases.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (i, end) in self.ends.iter().enumerate() {
            let comma = if i > 0 { ", " } else { "" };
            if end.is_finite() { write!(f, "{comma}{end:.1}")? } else { write!(f, "{comma}none")? }
        }
        Ok(())
    }
}

/// Means over each second of the three phases of Sim2; the first phase from [`WHOLE`] on.
fn seconds(points: impl Iterator<Item = (f64, f64)>) -> [Vec<f64>; 3] {
    let starts = [WHOLE.start, HALVED.start, HALVED.end, 200.0];
    let mut sums = [0, 1, 2].map(|i| vec![(0.0, 0.0); (starts[i + 1] - starts[i]).round() as usize]);
    for (t, value) in points.filter(|point| point.1.is_finite()) {
        let phase = starts.iter().take_while(|start| **start <= t).count();
        let Some(sums) = phase.checked_sub(1).and_then(|phase| sums.get_mut(phase)) else { continue };
        if let Some((count, sum)) = sums.get_mut((t - starts[phase - 1]) as usize) {
            *count += 1.0;
            *sum += value;
        }
    }
    sums.map(|sums| sums.into_iter().map(|(count, sum)| sum / count).collect())
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
        assert_eq!(track(|_| 5.0), Behaviour::Wrong);
        let astray = |t: f64| if (110.0..130.0).contains(&t) { 1.0 } else { truth(t) };
        assert_eq!(track(astray), Behaviour::Wrong, "right at the ends is not enough");
        assert_eq!(track(|t| if HALVED.contains(&t) { 2.0 } else { 11.5 }), Behaviour::Wrong);
    }
}
