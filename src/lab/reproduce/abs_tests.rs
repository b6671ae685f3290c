//! Drives for calibrating: on each of several surfaces some normal driving, then an ABS braking.

use super::SimulatedDrive;
use physics::Micros;
use physics::estimate::mapping::{Braking, PairFinder};
use physics::estimate::{EstimatorsConfig, Pipeline};
use physics::model::scenario::{DriverConfig, Piece, Stretch};
use physics::model::{GRAVITY, Scenario, TireKind, Truth, Uncertain, Vehicle};
use serde::Deserialize;

const BASE: &str = include_str!("../../../config/scenarios/demo.toml");

const CAR: &str = include_str!("../../../config/demo.toml");

/// Of the demo car's configuration what its owner knows of the car.
#[derive(Deserialize)]
struct DataSheet {
    vehicle: Vehicle,
}

/// One surface, and how long it is driven on before the braking.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AbsTest {
    /// Friction.
    pub friction: f64,
    /// Slope.
    pub slope: f64,
    /// Normal driving before the braking, s. The slope of a new surface needs some 10 to 20 s.
    pub settle_s: f64,
    /// Driving on the same surface after the braking, s.
    pub after_s: f64,
}

impl AbsTest {
    /// Long enough for the slope to settle before and to be confirmed after.
    pub const fn settled(friction: f64, slope: f64) -> Self {
        Self { friction, slope, settle_s: 27.0, after_s: 10.0 }
    }

    /// Braked as soon as the surface has begun, before its slope can be noticed.
    pub const fn too_soon(friction: f64, slope: f64) -> Self {
        Self { friction, slope, settle_s: 0.4, after_s: 13.0 }
    }
}

/// How long the pedal is pressed, s.
pub const PRESSED_S: f64 = 1.3;
/// Within which the pressure builds up, s.
const BUILD_UP_S: f64 = 0.15;
/// More than any surface needs, bar.
const PRESSURE_BAR: f64 = 110.0;
/// Speed between the brakings, m/s.
const SPEED: f64 = 22.0;

/// The drive as a scenario of the demo car, with the measuring chain of the demo.
///
/// # Errors
/// What is wrong with the tests' numbers.
pub fn scenario(tests: &[AbsTest], tire: TireKind) -> Result<Scenario, String> {
    let mut scenario = Scenario::parse(BASE).map_err(|e| e.to_string())?;
    scenario.description = "ABS tests on several surfaces".into();
    scenario.vehicle.tire = tire;
    scenario.initial_speed_mps = SPEED;
    scenario.steering_wheel_angle =
        vec![Piece::Random { rms: 0.05, correlation_time_s: 1.5, from_s: 0.0, to_s: f64::INFINITY }];
    scenario.road.clear();
    let (mut speeds, mut pressures, mut pieces) = (vec![[0.0, SPEED]], Vec::new(), Vec::new());
    let mut now = 0.0;
    for test in tests {
        scenario.road.push(Stretch {
            from_s: now,
            transition_s: if now > 0.0 { 0.1 } else { 0.0 },
            friction: Some(test.friction),
            slope: Some(test.slope),
            ..Stretch::default()
        });
        let brake = now + test.settle_s;
        let released = brake + PRESSED_S;
        let end = released + test.after_s;
        // The driver does not use more than the road gives.
        let acceleration = (0.12 * test.friction * GRAVITY).min(0.5);
        let correlation_time_s = 3.0;
        for (from_s, to_s) in [(now, brake), (released, end)] {
            pieces.push(Piece::Random {
                rms: acceleration * correlation_time_s,
                correlation_time_s,
                from_s,
                to_s,
            });
        }
        pressures.extend([
            [brake, 0.0],
            [brake + BUILD_UP_S, PRESSURE_BAR],
            [released - 0.02, PRESSURE_BAR],
            [released, 0.0],
        ]);
        let slowed = SPEED - test.friction * GRAVITY * (PRESSED_S - 0.5 * BUILD_UP_S);
        let again = released + (SPEED - slowed) / (0.12 * test.friction * GRAVITY).min(1.6);
        speeds.extend([
            [brake, SPEED],
            [released, slowed],
            [again.min(end), {
                // The next surface is reached at the speed there is by then.
                slowed + (SPEED - slowed) * ((end - released) / (again - released)).min(1.0)
            }],
        ]);
        now = end;
    }
    // Where the speed was not reached, the next stretch goes on from it.
    speeds.dedup_by(|later, earlier| later[0] <= earlier[0]);
    pieces.insert(0, Piece::Points { points: speeds });
    scenario.driver = scenario.driver.map(|driver| DriverConfig { speed_mps: pieces, ..driver });
    scenario.brake_pressure = vec![Piece::Points { points: pressures }];
    scenario.duration_s = now;
    scenario.validate().map_err(|e| e.to_string())?;
    Ok(scenario)
}

/// All sensors at once and undelayed, as a [`SimulatedDrive`] needs them.
pub fn in_step(mut scenario: Scenario) -> Scenario {
    for sensor in scenario.sensors.by_name.values_mut() {
        (sensor.period_ms, sensor.phase_ms, sensor.delay_ms) = (10.0, 0.0, 0.0);
    }
    scenario.clock = Default::default();
    scenario
}

/// A braking, and what was true.
#[derive(Clone, Debug)]
pub struct Found {
    /// As the pipeline and the pair finder saw it.
    pub braking: Braking,
    /// Slope of the surface that was braked on, mean of the front wheels.
    pub true_slope: f64,
    /// Its friction.
    pub true_mu: f64,
    /// Friction that the tires really used, mean over the braking.
    pub used_mu: f64,
}

/// Drives the tests through the pipeline and finds the brakings. The pipeline is told the demo car's data
/// sheet, and of the slopes what is usual for `usual_slope`.
///
/// # Errors
/// What is wrong with the tests' numbers.
pub fn drive(tests: &[AbsTest], tire: TireKind, usual_slope: f64, seed: u64) -> Result<Vec<Found>, String> {
    let drive = SimulatedDrive::simulate(&in_step(scenario(tests, tire)?), seed)?;
    let mut vehicle = toml::from_str::<DataSheet>(CAR).map_err(|error| error.to_string())?.vehicle;
    let scale = vehicle.static_wheel_load(true) / (0.25 * vehicle.mass() * GRAVITY);
    vehicle.longitudinal_stiffness = Uncertain { value: scale * usual_slope, std: 0.3 * scale * usual_slope };
    let mut pipeline = Pipeline::new(&vehicle, &drive.sensors, &EstimatorsConfig::default());
    let mut finder = PairFinder::new(&vehicle, &drive.sensors);
    for sample in &drive.samples {
        finder.step(sample, pipeline.step(sample));
    }
    let found = finder.finish().into_iter().filter_map(|braking| {
        let truth = drive.truth.iter().find(|truth| truth.time >= braking.time)?;
        let true_slope = 0.5 * (truth.slope[0] + truth.slope[1]);
        let end = braking.time + Micros::from_seconds(braking.duration_s);
        let during: Vec<_> =
            drive.truth.iter().filter(|truth| (braking.time..end).contains(&truth.time)).collect();
        let used = |truth: &Truth| -truth.fx.iter().sum::<f64>() / truth.fz.iter().sum::<f64>();
        let used_mu = during.iter().map(|truth| used(truth)).sum::<f64>() / during.len().max(1) as f64;
        Some(Found { true_slope, true_mu: truth.mu_max, used_mu, braking })
    });
    Ok(found.collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_test_is_one_braking_on_its_own_surface() {
        let tests = [AbsTest::settled(1.0, 95.0), AbsTest::too_soon(0.6, 50.0), AbsTest::settled(0.2, 30.0)];
        let found = drive(&tests, TireKind::Piecewise, 80.0, 3).unwrap();
        assert_eq!(found.len(), tests.len());
        for (found, test) in found.iter().zip(&tests) {
            assert!(
                (found.true_mu - test.friction).abs() < 1e-9 && (found.true_slope - test.slope).abs() < 1e-9
            );
        }
        // Whether a settled one makes a pair is the estimator's and the driver's luck; a hasty one never does.
        assert!(found.iter().all(|found| found.braking.mu.is_some()), "{found:?}");
        assert_eq!(found[1].braking.pair(), None);
    }
}
