//! Where on a recording's clock a simulation of the same drive lies.

use physics::Quantity;

use super::ordinary::{Incomparable, resampled_every};
use predict::Recording;

/// Seconds between the points that are compared. Numerical.
const STEP_S: f64 = 0.05;

/// So much of both must lie beside each other, s: what a fit needs.
const LEAST_OVERLAP_S: f64 = 12.0;

/// Squared correlation below which two records are not of the same drive. Statistical: the steering of another drive of the
/// same course shares less (laps dry1 and wet2 of the real recordings: 10 %).
const LEAST_SHARED: f64 = 0.5;

/// Squared correlation of two records of the same steering, one of them perhaps filtered or rounded.
const SAME_STEERING: f64 = 0.97;

/// A driver is late by less than this, s: reaction and preview of driver models are tenths of a second.
const DRIVER_S: f64 = 0.5;

/// How they lie.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Alignment {
    /// What is added to the simulation's times, s.
    pub offset_s: f64,
    /// Was it steered as the recorded car was? None where it does not tell.
    pub steered_alike: Option<bool>,
}

/// Lays a simulation beside a recording by what both have: the steering, else the yaw rate.
///
/// # Errors
/// If they do not overlap, or are of different drives.
pub fn align(recording: &Recording, simulation: &Recording) -> Result<Alignment, Incomparable> {
    let steering = Quantity::SteeringWheelAngle;
    if simulation.has(steering) && recording.has(steering) {
        let (offset_s, shared) = best(recording, simulation, steering)?;
        let steered_alike = shared >= SAME_STEERING;
        if shared >= LEAST_SHARED {
            // A driver model is late itself: that is not its clock.
            let is_same_clock = !steered_alike && offset_s.abs() < DRIVER_S;
            let offset_s = if is_same_clock { 0.0 } else { offset_s };
            return Ok(Alignment { offset_s, steered_alike: Some(steered_alike) });
        }
    }
    let of = Quantity::YawRate;
    let (offset_s, shared) = best(recording, simulation, of)?;
    if shared < LEAST_SHARED {
        return Err(Incomparable::AnotherDrive { of, percent: 100.0 * shared });
    }
    Ok(Alignment { offset_s, steered_alike: simulation.has(steering).then_some(false) })
}

/// The offset at which two records of a quantity share most, and how much: their squared correlation, of equal sign.
fn best(recording: &Recording, simulation: &Recording, of: Quantity) -> Result<(f64, f64), Incomparable> {
    let [there, here] = [recording, simulation].map(|record| {
        let track = &record.tracks[of as usize];
        let begin = track.first().map_or(0.0, |(t, _)| *t);
        let end = track.last().map_or(0.0, |(t, _)| *t);
        (begin, resampled_every(STEP_S, track, begin, ((end - begin) / STEP_S) as usize))
    });
    let (longer, shorter) = (there.1.len().max(here.1.len()), there.1.len().min(here.1.len()));
    let least = (LEAST_OVERLAP_S / STEP_S) as usize;
    if shorter < least {
        return Err(Incomparable::NoOverlap(shorter as f64 * STEP_S));
    }
    // A part of either is enough, but most of the shorter one must lie beside the other.
    let least = least.max(shorter / 2) as i64;
    let lags = least - here.1.len() as i64..=there.1.len() as i64 - least;
    let at = lags.map(|lag| (shared(&there.1, &here.1, lag), lag));
    let Some((_, lag)) = at.max_by(|a, b| a.0.total_cmp(&b.0)) else {
        return Err(Incomparable::NoOverlap(longer as f64 * STEP_S));
    };
    let coarse = there.0 - here.0 + lag as f64 * STEP_S;
    // Finer than the points, by the same measure.
    let there = &recording.tracks[of as usize];
    let shared_at = |offset: f64| {
        let from = there[0].0.max(simulation.tracks[of as usize][0].0 + offset);
        let points = longer.min((least as usize).max(shorter));
        let a = resampled_every(STEP_S, there, from, points);
        let b = resampled_every(STEP_S, &simulation.tracks[of as usize], from - offset, points);
        shared(&a, &b, 0)
    };
    let (mut offset, mut step) = (coarse, 0.5 * STEP_S);
    let mut most = shared_at(offset);
    while step > 1e-3 {
        let better = [offset - step, offset + step].map(|offset| (shared_at(offset), offset));
        match better.into_iter().max_by(|a, b| a.0.total_cmp(&b.0)) {
            Some((shared, there)) if shared > most => (most, offset) = (shared, there),
            _ => step *= 0.5,
        }
    }
    // Clocks that are the same to a hundredth of a second are the same.
    let same = shared_at(0.0);
    Ok(if offset.abs() < 0.02 && same > most - 1e-3 { (0.0, same) } else { (offset, most) })
}

/// Squared correlation where both are known; zero if they go against each other.
fn shared(there: &[f64], here: &[f64], lag: i64) -> f64 {
    let mut sums = [0.0; 6];
    for (i, here) in here.iter().enumerate() {
        let place = i as i64 + lag;
        let Some(there) = usize::try_from(place).ok().and_then(|place| there.get(place)) else { continue };
        if there.is_finite() && here.is_finite() {
            for (sum, term) in
                sums.iter_mut().zip([1.0, *there, *here, there * there, here * here, there * here])
            {
                *sum += term;
            }
        }
    }
    let [count, a, b, aa, bb, ab] = sums;
    let covariance = ab - a * b / count;
    let variances = (aa - a * a / count) * (bb - b * b / count);
    if covariance > 0.0 && variances > 0.0 { covariance * covariance / variances } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Steering and yaw rate of a drive, its clock begun so late, s.
    fn record(begin: f64, steered: impl Fn(f64) -> f64) -> Recording {
        let mut recording = Recording::default();
        let times = || (0..3000).map(|i| f64::from(i) * 0.01);
        let track = |of: &dyn Fn(f64) -> f64| times().map(|t| (t, of(t + begin))).collect();
        recording.tracks[Quantity::SteeringWheelAngle as usize] = track(&steered);
        recording.tracks[Quantity::YawRate as usize] = track(&|t| 0.3 * weave(t - 0.1));
        recording
    }

    fn weave(t: f64) -> f64 {
        (0.9 * t).sin() + 0.5 * (0.37 * t * t.sqrt()).sin()
    }

    #[test]
    fn a_clock_that_began_later_is_found() {
        let there = align(&record(0.0, weave), &record(4.237, weave)).unwrap();
        assert!((there.offset_s - 4.237).abs() < 0.005 && there.steered_alike == Some(true), "{there:?}");
        let same = align(&record(0.0, weave), &record(0.0, weave)).unwrap();
        assert_eq!(same, Alignment { offset_s: 0.0, steered_alike: Some(true) });
    }

    #[test]
    fn a_driver_model_is_told_from_the_recorded_steering() {
        let driver = |t: f64| weave(t - 0.15) + 0.3 * (2.3 * t).sin();
        let there = align(&record(0.0, weave), &record(0.0, driver)).unwrap();
        assert_eq!(there, Alignment { offset_s: 0.0, steered_alike: Some(false) });
    }

    #[test]
    fn another_drive_or_too_little_of_one_is_refused() {
        let mut other = record(0.0, |t| (1.7 * t).cos());
        other.tracks[Quantity::YawRate as usize].iter_mut().for_each(|(t, yaw)| *yaw = (2.9 * *t).sin());
        let refused = align(&record(0.0, weave), &other).unwrap_err();
        assert!(matches!(refused, Incomparable::AnotherDrive { .. }), "{refused}");
        let mut short = record(0.0, weave);
        short.tracks.iter_mut().for_each(|track| track.truncate(500));
        let refused = align(&record(0.0, weave), &short).unwrap_err();
        assert!(matches!(refused, Incomparable::NoOverlap(_)), "{refused}");
    }
}
