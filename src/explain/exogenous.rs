//! Is a course the road's and the weather's, or does it follow what the driver does? What follows the
//! car's own motion is no wind and no bank: it is a term that is missing in the equations.

use nalgebra::{DMatrix, DVector};

use super::predict::Drive;
use super::predict::drive::{STEP_S, points};
use super::smooth::Smoothed;

/// Distance of the points that are compared, grid points.
const EVERY: usize = points(0.1);

/// The speed changes by differences over so many to each side.
const NEAR: usize = points(0.1);

/// Share of a course's variance that follows from the driver's inputs and the speed, the number of
/// regressors counted against the course's independent pieces: 0 none, 1 all. Of the road the drive torque is
/// no witness: the driver answers a grade with it.
pub fn follows_motion(drive: &Drive, course: &Smoothed, length_s: f64, is_of_the_road: bool) -> f64 {
    let compared: Vec<(usize, f64)> = course
        .t
        .iter()
        .zip(&course.value)
        .map(|(t, value)| ((t / STEP_S).round() as usize, *value))
        .filter(|(k, _)| k % EVERY == 0 && *k >= NEAR && k + NEAR < drive.inputs.len())
        .collect();
    if compared.len() < 50 {
        return 0.0;
    }
    let strongest = drive.inputs.iter().map(|input| input.drive_torque.abs()).fold(1e-9, f64::max);
    let torque = |k: usize| if is_of_the_road { 0.0 } else { drive.inputs[k].drive_torque / strongest };
    let played = PLAYS.map(|width| play(drive, width));
    let demand = |k: usize| drive.inputs[k].steering_wheel * drive.speed[k] * drive.speed[k] * 0.0025;
    let row = |k: usize| {
        let input = &drive.inputs[k];
        let speed = drive.speed[k];
        let steering = input.steering_wheel;
        let faster = (drive.speed[k + NEAR] - drive.speed[k - NEAR]) / (2.0 * NEAR as f64 * STEP_S);
        let mut row = [0.0; REGRESSORS];
        let motion = [
            1.0,
            steering,
            steering * speed * 0.05,
            steering.abs(),
            demand(k) * demand(k),
            speed * 0.05,
            speed * speed * 0.0025,
            faster,
            faster * steering,
            input.brake_pressure * 0.1,
            torque(k),
            torque(k) * torque(k).abs(),
        ];
        row[..motion.len()].copy_from_slice(&motion);
        // The car answers within tenths of a second; what swings or settles in it, within seconds.
        for (place, lag) in LAGS.into_iter().enumerate() {
            row[motion.len() + place] = demand(k.saturating_sub(lag));
        }
        for (place, played) in played.iter().enumerate() {
            row[motion.len() + LAGS.len() + place] = played[k];
        }
        row
    };
    let rows: Vec<[f64; REGRESSORS]> = compared.iter().map(|(k, _)| row(*k)).collect();
    let x = DMatrix::from_fn(rows.len(), REGRESSORS, |i, j| rows[i][j]);
    let y = DVector::from_iterator(compared.len(), compared.iter().map(|(_, value)| *value));
    if x.iter().any(|value| !value.is_finite()) {
        return 0.0;
    }
    let mean = y.mean();
    let total: f64 = y.iter().map(|value| (value - mean).powi(2)).sum();
    let normal = x.tr_mul(&x) + DMatrix::identity(REGRESSORS, REGRESSORS) * 1e-6;
    let Some(fit) = normal.cholesky().map(|c| c.solve(&x.tr_mul(&y))) else { return 0.0 };
    let left = (&y - &x * fit).norm_squared();
    if total <= 0.0 {
        return 0.0;
    }
    // Independent pieces: two for each correlation length.
    let seconds = compared.len() as f64 * EVERY as f64 * STEP_S;
    let pieces = (2.0 * seconds / length_s.max(0.5)).max(2.0 * REGRESSORS as f64);
    let adjusted = 1.0 - left / total * (pieces - 1.0) / (pieces - REGRESSORS as f64);
    adjusted.clamp(0.0, 1.0)
}

const REGRESSORS: usize = 12 + LAGS.len() + PLAYS.len();

/// Lags, grid points.
const LAGS: [usize; 6] = [0, points(0.15), points(0.3), points(0.6), points(1.0), points(1.5)];

/// Widths of a play between steering wheel and road wheels, rad at the steering wheel.
const PLAYS: [f64; 3] = [0.01, 0.03, 0.1];

/// What a play of this width takes away, as a share of it: the sign of the last steering, softened.
fn play(drive: &Drive, width: f64) -> Vec<f64> {
    let mut behind = f64::NAN;
    let step = |input: &crate::model::effect::Recorded| {
        let angle = input.steering_wheel;
        if !angle.is_finite() {
            return 0.0;
        }
        behind = if behind.is_nan() { angle } else { behind.clamp(angle - 0.5 * width, angle + 0.5 * width) };
        (angle - behind) / (0.5 * width)
    };
    drive.inputs.iter().map(step).collect()
}
