//! What of the filter outlives a drive: the stiffnesses and the errors of the sensors; motion and bank do not.

use super::config::CorneringConfig;
use super::model::Model;
use super::state::{
    ANGLE_OFFSET, ANGLE_SCALE, AY_OFFSET, FRONT, REAR, SPEED_SCALE, State, YAW_OFFSET, prior,
};
use crate::estimate::kinematics::Car;
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

/// What the errors of the sensors may be at all (one standard deviation), in the order of [`Learned::errors`].
pub fn expected_errors(car: &Car, config: &CorneringConfig) -> [f64; ERRORS] {
    let fresh = prior(car, config);
    PLACES.map(|i| fresh.std(i))
}

/// Errors of sensors that an earlier drive learned. A single reading says little of them; what a drive makes of them in
/// its first minutes does.
#[derive(Clone, Copy, Debug)]
pub struct Taken {
    errors: [Known; ERRORS],
    left_s: f64,
}

impl Taken {
    /// Until then every error was told from the others, if the car drives curves at all, s. Tuned with the test
    /// `learned`.
    const MINUTES_S: f64 = 180.0;
    /// Moved this many of the deviations that it had been taken up with, it contradicts. Statistical: by chance one
    /// drive in eighty.
    const CONTRADICTION: f64 = 3.0;

    /// As they are in the state before the first sample.
    pub fn new(state: &State) -> Self {
        Self {
            errors: PLACES.map(|i| Known { value: state.mean[i], std: state.std(i) }),
            left_s: Self::MINUTES_S,
        }
    }

    /// After a window of so many seconds: is one contradicted? `None`: they have stood the test.
    pub fn step(&mut self, state: &State, elapsed_s: f64) -> Option<bool> {
        self.left_s -= elapsed_s;
        let moved = |(i, taken): (usize, &Known)| {
            taken.std > 0.0 && (state.mean[i] - taken.value).abs() > Self::CONTRADICTION * taken.std
        };
        (self.left_s > 0.0).then(|| PLACES.into_iter().zip(&self.errors).any(moved))
    }
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::estimate::cornering::state::STATES;

    /// GIVEN errors from an earlier drive WHEN the first minutes move one far off THEN it is contradicted; AND not later,
    /// nor by what nothing was known of.
    #[test]
    fn the_first_minutes_may_contradict() {
        let mut std = [0.0; STATES];
        (std[YAW_OFFSET], std[SPEED_SCALE]) = (0.002, 0.01);
        let state = State::new([0.0; STATES], std);
        let mut taken = Taken::new(&state);
        let moved = |place: usize, to: f64| {
            let mut moved = state;
            moved.mean[place] = to;
            moved
        };
        assert_eq!(taken.step(&moved(YAW_OFFSET, 0.0059), 1.0), Some(false));
        assert_eq!(taken.step(&moved(YAW_OFFSET, -0.0061), 1.0), Some(true));
        assert_eq!(taken.step(&moved(SPEED_SCALE, 0.031), 1.0), Some(true));
        assert_eq!(taken.step(&moved(ANGLE_SCALE, 0.5), 1.0), Some(false));
        assert_eq!(taken.step(&moved(SPEED_SCALE, 0.031), Taken::MINUTES_S), None);
    }
}
