//! Is a course exogenous? Wind, bank and grade do not depend on what the driver does. A course that follows from
//! steering, speed and torque is a term that is missing in the equations.

use nalgebra::{DMatrix, DVector};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::StandardNormal;

use super::play::lost_in_play;
use super::smooth::Smoothed;
use predict::GriddedDrive;
use predict::grid::{STEP_S, points};

/// Distance of the points that are compared, grid points. Numerical: courses change more slowly.
const EVERY: usize = points(0.1);

/// The speed changes by differences over so many to each side.
const NEAR: usize = points(0.1);

/// What a course is of. What answers it is no witness of what it follows from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum CourseOf {
    /// The road: the driver answers a grade with torque.
    Road,
    /// The force along the car: its speed changes by that.
    Along,
    /// A sensor, or anything else.
    Other,
}

/// Share of a course's variance that follows from the driver's inputs and the speed, beyond what would by chance
/// of a course of its correlation length, s: 0 none, 1 all.
pub fn follows_motion(drive: &GriddedDrive, course: &Smoothed, length_s: f64, of: CourseOf) -> f64 {
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
    let torque = |k: usize| if of == CourseOf::Road { 0.0 } else { drive.inputs[k].drive_torque / strongest };
    let changes = f64::from(u8::from(of != CourseOf::Along));
    let played = PLAYS.map(|width| play(drive, width));
    let demand = |k: usize| drive.inputs[k].steering_wheel * drive.speed[k] * drive.speed[k] * 0.0025;
    let row = |k: usize| {
        let input = &drive.inputs[k];
        let speed = drive.speed[k];
        let steering = input.steering_wheel;
        let faster = changes * (drive.speed[k + NEAR] - drive.speed[k - NEAR]) / (2.0 * NEAR as f64 * STEP_S);
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
    if x.iter().any(|value| !value.is_finite()) || y.variance() <= 0.0 {
        return 0.0;
    }
    let normal = x.tr_mul(&x) + DMatrix::identity(REGRESSORS, REGRESSORS) * 1e-6;
    let Some(normal) = normal.cholesky() else { return 0.0 };
    let explained = |y: DVector<f64>| {
        // Centred, so that the mean explains nothing.
        let y = y.add_scalar(-y.mean());
        1.0 - (&y - &x * normal.solve(&x.tr_mul(&y))).norm_squared() / y.norm_squared()
    };
    // What is slow follows anything slow, by chance: so much as it does when it comes at other times, or, where
    // the drive repeats itself, as something that knows nothing of the drive does.
    let count = y.len();
    let moved = |part: usize| DVector::from_fn(count, |i, _| y[(i + part * count / SHIFTS) % count]);
    let at_other_times = nine_of_ten((2..SHIFTS - 1).map(|part| explained(moved(part))).collect());
    let mut random = ChaCha8Rng::seed_from_u64(1);
    let others = (0..OTHERS).map(|_| explained(of_its_own(count, length_s, &mut random)));
    let by_chance = at_other_times.min(nine_of_ten(others.collect()));
    ((explained(y) - by_chance) / (1.0 - by_chance).max(1e-3)).clamp(0.0, 1.0)
}

/// What nine of ten are below.
fn nine_of_ten(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    values.get(values.len() * 9 / 10).copied().unwrap_or(0.0)
}

/// Parts of the drive by which a course is moved round to come at other times; not by the first and the last
/// two, where it is still much the same. Statistical: enough for the level that nine of ten stay below.
const SHIFTS: usize = 24;

/// So many courses that know nothing of the drive. Statistical: as before.
const OTHERS: usize = 40;

/// A course that knows nothing of the drive: noise through two lags of a correlation length.
fn of_its_own(count: usize, length_s: f64, random: &mut ChaCha8Rng) -> DVector<f64> {
    let each_s = EVERY as f64 * STEP_S;
    let keeps = (-each_s / length_s).exp();
    let (mut once, mut twice) = (0.0, 0.0);
    let mut next = || {
        once = keeps * once + random.sample::<f64, _>(StandardNormal);
        twice = keeps * twice + (1.0 - keeps) * once;
        twice
    };
    let settling = (5.0 * length_s / each_s) as usize;
    (0..settling).for_each(|_| {
        next();
    });
    DVector::from_fn(count, |_, _| next())
}

const REGRESSORS: usize = 12 + LAGS.len() + PLAYS.len();

/// Lags, grid points. Physical: the car answers within tenths of a second, and settles within seconds.
const LAGS: [usize; 6] = [0, points(0.15), points(0.3), points(0.6), points(1.0), points(1.5)];

/// Widths of a play between steering wheel and road wheels, rad at the steering wheel.
/// Physical: half a degree to six.
const PLAYS: [f64; 3] = [0.01, 0.03, 0.1];

/// What a play of this width takes away, as a share of it: the sign of the last steering, softened.
fn play(drive: &GriddedDrive, width: f64) -> Vec<f64> {
    let mut lost = lost_in_play(drive.inputs.iter().map(|input| input.steering_wheel), width);
    lost.iter_mut().for_each(|lost| *lost /= 0.5 * width);
    lost
}

#[cfg(test)]
mod tests {
    use super::super::bench::recorded;
    use super::*;

    /// A course that is known everywhere.
    fn course(drive: &GriddedDrive, value: &dyn Fn(usize) -> f64) -> Smoothed {
        let points = 0..drive.inputs.len();
        let t: Vec<f64> = points.clone().map(|k| k as f64 * STEP_S).collect();
        Smoothed { value: points.map(value).collect(), std: vec![0.01; t.len()], t }
    }

    #[test]
    fn what_the_steering_tells_follows_and_what_is_only_slow_does_not() {
        let (vehicle, recording) = recorded("");
        let drive = GriddedDrive::new(&recording, &vehicle);
        let course = |value: &dyn Fn(usize) -> f64| course(&drive, value);
        let weave = |k: usize| drive.inputs[k].steering_wheel.signum() * drive.speed[k];
        assert!(follows_motion(&drive, &course(&weave), 1.0, CourseOf::Road) > 0.5);
        for phase in 0..6 {
            let slow = |k: usize| (0.21 * k as f64 * STEP_S + f64::from(phase)).sin();
            let share = follows_motion(&drive, &course(&slow), 15.0, CourseOf::Road);
            assert!(share < 0.35, "{phase}: {share}");
        }
    }

    /// GIVEN what is missing of a torque that ends at a limit, and a force that comes and goes on its own THEN the first follows from
    /// what the driver does, though both change the speed.
    #[test]
    fn a_torque_that_ends_at_a_limit_follows_and_a_force_of_its_own_does_not() {
        let (vehicle, recording) = recorded("");
        let drive = GriddedDrive::new(&recording, &vehicle);
        let course = |value: &dyn Fn(usize) -> f64| course(&drive, value);
        let most = drive.inputs.iter().map(|input| input.drive_torque).fold(0.0, f64::max);
        let limited = |k: usize| -(drive.inputs[k].drive_torque - 0.5 * most).max(0.0);
        assert!(follows_motion(&drive, &course(&limited), 1.0, CourseOf::Along) > 0.5);
        let own = of_its_own(drive.inputs.len(), 1.0, &mut ChaCha8Rng::seed_from_u64(5));
        let share = follows_motion(&drive, &course(&|k| own[k / EVERY]), 1.0, CourseOf::Along);
        assert!(share < 0.35, "{share}");
    }
}
