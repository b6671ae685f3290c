//! What of the filter outlives a drive: the stiffnesses and the errors of the sensors; motion and bank do not.

use super::model::Model;
use super::state::{
    ANGLE_OFFSET, ANGLE_SCALE, AY_OFFSET, FRONT, REAR, SPEED_SCALE, State, YAW_OFFSET, prior,
};
use crate::estimate::learned::{ERRORS, Known, Learned};

/// Between two drives an error of a sensor moves by this share of what it may be at all: temperature, a steering
/// sensor that was reset, load, tires. Tuned with the test `learned`.
const BETWEEN_DRIVES: f64 = 0.25;
/// Beyond this many times what it may be at all, an error is not known. Tuned with the test `learned`.
const FORGOTTEN: f64 = 1.5;
/// Restored stiffnesses and errors are independent of each other. Multiplied by these factors their variances bound
/// the covariance they had, however they were correlated: P ≤ diag((1 + c) P₁, (1 + 1/c) P₂), here for c = 4.
const APART: (f64, f64) = (5.0, 1.25);
/// Readings (two for each window) for which an earlier drive's numbers are on trial. Tuned with the test `learned`.
pub const TRIAL: u32 = 80;
/// The errors of the sensors, in the order of [`Learned::errors`].
const PLACES: [usize; ERRORS] = [ANGLE_OFFSET, AY_OFFSET, YAW_OFFSET, SPEED_SCALE, ANGLE_SCALE];

/// The state before the first sample, by what an earlier drive learned, less sure of it.
pub fn restored(learned: &Learned, model: &Model) -> State {
    let fresh = prior(&model.car, &model.config);
    let mut state = fresh;
    for (i, stiffness) in [FRONT, REAR].into_iter().zip(learned.cornering) {
        let Some(stiffness) = stiffness else { continue };
        // Half of what makes a stiffness valid has to be news.
        let systematic = model.systematic_std[i - FRONT];
        let valid = model.config.valid_relative_std.powi(2) - systematic * systematic;
        let least = (2.0 * valid).max(0.0).sqrt();
        let relative = least.max(APART.0.sqrt() * stiffness.std / stiffness.value);
        if relative < fresh.std(i) / fresh.mean[i] {
            state.mean[i] = 1.0 / stiffness.value;
            state.covariance[(i, i)] = (relative / stiffness.value).powi(2);
        }
    }
    let correlation = learned.correlation();
    let errors = learned.errors().map(|error| error.map(|e| (e.value, APART.1.sqrt() * e.std)));
    for (place, i) in PLACES.into_iter().enumerate() {
        // An error known much worse than by its data sheet counts as unknown.
        let known = |place: usize| {
            let std = errors[place]?.1;
            (std < FORGOTTEN * fresh.std(PLACES[place])).then_some(std)
        };
        let (Some((value, _)), Some(std)) = (errors[place], known(place)) else { continue };
        for (other, &j) in PLACES[..place].iter().enumerate() {
            let shared = known(other).map_or(0.0, |other_std| std * other_std);
            state.covariance[(i, j)] = correlation[(place, other)] * shared;
            state.covariance[(j, i)] = state.covariance[(i, j)];
        }
        state.mean[i] = value;
        state.covariance[(i, i)] = std * std + (BETWEEN_DRIVES * fresh.std(i)).powi(2);
    }
    state
}

/// Puts the sensors' errors into `learned`.
pub fn learn_errors(state: &State, learned: &mut Learned) {
    let known = |i: usize| {
        let std = state.std(i);
        (std > 0.0).then(|| Known { value: state.mean[i], std })
    };
    learned.road_angle_offset = known(ANGLE_OFFSET);
    learned.lateral_acceleration_offset = known(AY_OFFSET);
    learned.yaw_rate_offset = known(YAW_OFFSET);
    learned.speed_scale = known(SPEED_SCALE);
    learned.road_angle_scale = known(ANGLE_SCALE);
    let mut triangle = learned.error_correlations.iter_mut();
    for (place, &i) in PLACES.iter().enumerate() {
        for (&j, correlation) in PLACES[place + 1..].iter().zip(&mut triangle) {
            let scale = state.std(i) * state.std(j);
            *correlation = if scale > 0.0 { state.covariance[(i, j)] / scale } else { 0.0 };
        }
    }
}

/// Keeps the stiffnesses that are known well, `valid` or better (relative).
pub fn settle(state: &State, valid: f64, settled: &mut [Option<Known>; 2]) {
    for (i, settled) in [FRONT, REAR].into_iter().zip(settled) {
        let compliance = state.mean[i];
        let relative = state.alone_std(i, &[FRONT, REAR]) / compliance;
        if relative <= valid {
            *settled = Some(Known { value: 1.0 / compliance, std: relative / compliance });
        }
    }
}
