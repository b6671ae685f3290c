//! The thesis's findings on lateral velocity and stiffness on line (5.2.2, 5.3.1), and their reasons.

use std::ops::Range;

use gripd::estimate::thesis::{
    JointEkf, JointEkfConfig, KinematicObserver, LateralSlopeEstimator, LateralVelocityEstimator, SlipAngles,
    SpeedDerivative,
};
use gripd::estimate::{Car, Cornering, Kinematics};
use gripd::estimates::LateralVelocities;
use gripd::model::scenario::Piece;
use gripd::model::scenario::thesis::{SIM1, SIM2};
use gripd::model::simulate::SimulatedDrive;
use gripd::model::{Scenario, Truth};

const SLOWEST: f64 = 4.0;
const WHOLE: Range<f64> = 20.0..100.0;
const HALVED: Range<f64> = 105.0..150.0;

fn scenario(text: &str, frequency_hz: f64, amplitude: f64) -> Scenario {
    let mut scenario = Scenario::parse(text).unwrap();
    let (phase_rad, offset, from_s, to_s) = (0.0, 0.0, 0.0, f64::INFINITY);
    scenario.steering_wheel_angle =
        vec![Piece::Sine { amplitude, frequency_hz, phase_rad, offset, from_s, to_s }];
    scenario
}

fn drive(text: &str, frequency_hz: f64, amplitude: f64) -> SimulatedDrive {
    let scenario = scenario(text, frequency_hz, amplitude);
    SimulatedDrive::simulate(&scenario, scenario.seed).unwrap()
}

/// Runs `estimate` over a drive; gives time, truth and what it returned.
fn over<T>(
    drive: &SimulatedDrive,
    mut estimate: impl FnMut(&Kinematics, &Truth) -> T,
) -> Vec<(f64, Truth, T)> {
    let car = Car::new(&drive.vehicle);
    let samples = drive.samples.iter().zip(&drive.truth);
    samples
        .map(|(sample, truth)| {
            (truth.time.seconds(), *truth, estimate(&Kinematics::new(sample, &car), truth))
        })
        .collect()
}

fn rms(values: impl Iterator<Item = f64>) -> f64 {
    let (count, sum) = values.fold((0.0, 0.0), |(count, sum), value| (count + 1.0, sum + value * value));
    assert!(count > 100.0);
    (sum / count).sqrt()
}

/// Error of a lateral velocity / true lateral velocity, rms.
fn relative_error(rows: &[(f64, Truth, f64)], time: Range<f64>) -> f64 {
    let during = || rows.iter().filter(|row| time.contains(&row.0));
    rms(during().map(|row| row.2 - row.1.lateral_velocity)) / rms(during().map(|row| row.1.lateral_velocity))
}

fn mean(rows: &[(f64, Truth, f64)], time: Range<f64>) -> f64 {
    let values: Vec<_> = rows.iter().filter(|row| time.contains(&row.0)).map(|row| row.2).collect();
    values.iter().sum::<f64>() / values.len() as f64
}

fn velocities(drive: &SimulatedDrive, of: fn(&LateralVelocities) -> Option<f64>) -> Vec<(f64, Truth, f64)> {
    let mut estimator = LateralVelocityEstimator::new(&Car::new(&drive.vehicle), &drive.sensors, SLOWEST);
    over(drive, |now, _| of(&estimator.step(now)).unwrap())
}

/// Method 2 with an a_x of our choice.
fn observer(drive: &SimulatedDrive, mut ax: impl FnMut(&Cornering, &Truth) -> f64) -> Vec<(f64, Truth, f64)> {
    let mut observer = KinematicObserver::new(&drive.sensors);
    over(drive, |now, truth| {
        let cornering = now.cornering(SLOWEST).unwrap();
        let acceleration = [ax(&cornering, truth), cornering.lateral_acceleration];
        observer.step(cornering.speed, cornering.yaw_rate, acceleration, now.elapsed_s)
    })
}

fn ekf(
    drive: &SimulatedDrive,
    walk: f64,
    input: fn(&Kinematics, &Truth) -> Kinematics,
) -> Vec<(f64, Truth, f64)> {
    let config = JointEkfConfig { stiffness_walk: walk, ..JointEkfConfig::default() };
    let mut filter = JointEkf::new(&Car::new(&drive.vehicle), &drive.sensors, &config, SLOWEST);
    over(drive, |now, truth| {
        filter.step(&input(now, truth));
        filter.stiffness().map_or(f64::NAN, |estimate| estimate.value)
    })
}

fn measured(now: &Kinematics, _: &Truth) -> Kinematics {
    *now
}

fn noise_free(now: &Kinematics, truth: &Truth) -> Kinematics {
    Kinematics {
        speed: Some(truth.longitudinal_velocity),
        yaw_rate: Some(truth.yaw_rate),
        lateral_acceleration: Some(truth.lateral_acceleration),
        road_angle: Some(truth.steer),
        rear_angle: 0.0,
        ..*now
    }
}

/// Harmonic mean of both axles' slopes on a lateral velocity.
fn slope(
    drive: &SimulatedDrive,
    mut velocity: impl FnMut(&Kinematics, &Truth) -> Option<f64>,
) -> Vec<(f64, Truth, f64)> {
    let mut estimator = LateralSlopeEstimator::new(&Car::new(&drive.vehicle), SLOWEST);
    over(drive, |now, truth| {
        let vy = velocity(now, truth);
        estimator.step(now, vy);
        let [front, rear] = estimator.slopes();
        front.zip(rear).map_or(f64::NAN, |(f, r)| 2.0 / (1.0 / f.value + 1.0 / r.value))
    })
}

#[test]
fn integration_drifts_by_the_sensors_offsets_and_by_nothing_else() {
    let mut offsets = scenario(SIM1, 0.5, 0.03);
    offsets.sensors.by_name.get_mut("lateral_acceleration").unwrap().offset = -0.02;
    let with = SimulatedDrive::simulate(&offsets, 1).unwrap();
    let without = drive(SIM1, 0.5, 0.03);
    let end = |drive: &SimulatedDrive| {
        let rows = velocities(drive, |v| v.integration);
        let (_, truth, estimate) = rows.last().unwrap();
        estimate - truth.lateral_velocity
    };
    assert!((end(&with) + 0.02 * 200.0).abs() < 0.6, "{}", end(&with));
    assert!(end(&without).abs() < 0.6, "{}", end(&without));
}

#[test]
fn the_kinematic_observer_fails_by_5_13_and_not_by_kinematics() {
    let drive = drive(SIM1, 0.5, 0.1);
    let derived = relative_error(&velocities(&drive, |v| v.kinematic), 20.0..200.0);
    let told = relative_error(&observer(&drive, |_, truth| truth.longitudinal_acceleration), 20.0..200.0);
    assert!(derived > 0.4, "of the order of v_y itself: {derived}");
    assert!(told < 0.03, "{told}");
    // (5.13) is what the estimator uses, and what makes the difference is −v_y r alone.
    let mut derivative = SpeedDerivative::default();
    let again = observer(&drive, |now, _| derivative.step(now.speed, 0.01));
    assert!((relative_error(&again, 20.0..200.0) - derived).abs() < 1e-12);
    let without = observer(&drive, |_, truth| {
        truth.longitudinal_acceleration + truth.lateral_velocity * truth.yaw_rate
    });
    assert!(relative_error(&without, 20.0..200.0) > 0.4, "true, but −v_y r dropped");
}

#[test]
fn the_bicycle_is_right_with_the_right_stiffness_and_wrong_with_another() {
    for (frequency, amplitude) in [(0.25, 0.01), (0.5, 0.01), (1.0, 0.02)] {
        let rows = velocities(&drive(SIM2, frequency, amplitude), |v| v.bicycle);
        let (whole, halved) = (relative_error(&rows, WHOLE), relative_error(&rows, HALVED));
        assert!(whole < 0.06 && halved > 0.25, "{frequency} Hz {amplitude} rad: {whole} {halved}");
    }
}

#[test]
fn slip_angles_are_as_good_as_the_lateral_velocity_they_come_from() {
    let drive = drive(SIM2, 0.5, 0.01);
    let car = Car::new(&drive.vehicle);
    let mut estimator = LateralVelocityEstimator::new(&car, &drive.sensors, SLOWEST);
    let rows = over(&drive, |now, _| SlipAngles::new(&estimator.step(now), now, &car));
    let error = |of: fn(&SlipAngles) -> Option<[f64; 2]>, time: Range<f64>| {
        let during = || rows.iter().filter(|row| time.contains(&row.0));
        rms(during().map(|(_, truth, angles)| of(angles).unwrap()[1] - truth.slip_angle_rear))
            / rms(during().map(|row| row.1.slip_angle_rear))
    };
    assert!(error(|a| a.bicycle, WHOLE) < 0.1 && error(|a| a.bicycle, HALVED) > 0.3);
    assert!(error(|a| a.zero, WHOLE) > 0.5);
    assert!(rows.iter().all(|(_, _, angles)| angles.joint.is_none()), "no joint filter ran here");
}

#[test]
fn the_slope_follows_the_true_lateral_velocity_and_not_the_bicycles() {
    let drive = drive(SIM2, 0.5, 0.01);
    let told = slope(&drive, |_, truth| Some(truth.lateral_velocity));
    let mut estimator = LateralVelocityEstimator::new(&Car::new(&drive.vehicle), &drive.sensors, SLOWEST);
    let bicycle = slope(&drive, |now, _| estimator.step(now).bicycle);
    for (time, truth) in [(90.0..100.0, 11.5), (110.0..150.0, 5.75), (160.0..200.0, 11.5)] {
        let found = mean(&told, time.clone());
        assert!((found / truth - 1.0).abs() < 0.05, "{time:?}: {found}");
    }
    let handed_back = mean(&bicycle, 110.0..150.0);
    assert!(handed_back > 9.0, "the stiffness that method 3 was given, 11.5: {handed_back}");
}

#[test]
fn the_joint_ekf_is_blind_by_its_tuning() {
    let drive = drive(SIM2, 0.5, 0.01);
    let blind = ekf(&drive, 1e-4, measured);
    let moved = mean(&blind, 90.0..100.0) / mean(&blind, 140.0..150.0);
    assert!(moved < 1.25, "the truth moves by a factor of two: {moved}");
    let tuned = ekf(&drive, 1e-2, measured);
    let found = mean(&tuned, 110.0..150.0);
    assert!((found / 5.75 - 1.0).abs() < 0.1, "{found}");
    assert!(mean(&tuned, 160.0..200.0) > 10.0);
}

#[test]
fn the_joint_ekf_takes_sliding_for_a_soft_tire() {
    let rows = ekf(&drive(SIM2, 0.5, 0.1), 1e-2, measured);
    let low = rows.iter().filter(|row| HALVED.contains(&row.0) && row.2 < 0.6 * 5.75).count();
    assert!(low > 500, "more than five seconds far below the truth: {low} samples");
}

#[test]
fn where_transients_are_slow_the_joint_ekf_is_led_by_the_sensors_noise() {
    let drive = drive(SIM2, 0.05, 0.01);
    let noisy = mean(&ekf(&drive, 1e-2, measured), 50.0..100.0);
    let clean = mean(&ekf(&drive, 1e-2, noise_free), 50.0..100.0);
    assert!(noisy < 0.6 * 11.5, "{noisy}");
    assert!((clean / 11.5 - 1.0).abs() < 0.05, "{clean}");
}
