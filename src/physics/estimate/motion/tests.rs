//! Sensors as real cars have them: noisy, late and wrong.

use crate::estimate::{EstimatorsConfig, Pipeline};
use crate::model::{Scenario, Simulation, Uncertain};
use crate::{Faults, Micros, Quantity, Sample, Sensors};

/// A sensor's table, its key and the value there; `ABSENT` takes the sensor away.
type Change = (&'static str, &'static str, f64);

const SCENARIO: &str = include_str!("../../../../config/scenarios/asphalt_gravel.toml");

const ABSENT: &str = "absent";

/// A drive of one minute with this much steering (rad, rms; 0.4 makes curves of 2 m/s²) and these changes of the sensors' tables.
#[derive(Debug, Default)]
struct Outcome {
    /// Samples above 5 s, those with a valid motion, and those with a doubt.
    samples: f64,
    valid: f64,
    doubted: f64,
    /// Sum of squares of the valid sideslip's error, degrees².
    square: f64,
}

fn drive(changes: &[Change], steering: f64, told: bool) -> Outcome {
    let mut table: toml::Table = SCENARIO.parse().unwrap();
    table.insert("duration_s".into(), 60.0.into());
    table["steering_wheel_angle"][0].as_table_mut().unwrap().insert("rms".into(), steering.into());
    for (sensor, key, value) in changes {
        if *key == ABSENT {
            table["sensors"].as_table_mut().unwrap().remove(*sensor);
            continue;
        }
        table["sensors"][sensor].as_table_mut().unwrap().insert((*key).into(), (*value).into());
    }
    let scenario = Scenario::parse(&toml::to_string(&table).unwrap()).unwrap();
    let mut vehicle = scenario.vehicle.clone();
    vehicle.lateral_stiffness_front = Uncertain { value: 12.0, std: 3.0 };
    vehicle.lateral_stiffness_rear = Uncertain { value: 13.0, std: 3.0 };
    let mut sensors = Sensors::default();
    for quantity in Quantity::ALL {
        if let Some(sensor) = scenario.sensors.get(quantity) {
            sensors.add(quantity, told.then_some(sensor.noise_std).filter(|std| *std > 0.0));
        }
    }
    let mut pipeline = Pipeline::new(&vehicle, &sensors, &EstimatorsConfig::default());
    let mut simulation = Simulation::new(&scenario, 3).unwrap();
    let mut sample = Sample::empty(Micros(0), 0.01);
    let mut outcome = Outcome::default();
    while let Some(tick) = simulation.next_tick() {
        for reading in tick.readings {
            sample.set(reading.quantity, reading.value);
        }
        sample.time = tick.truth.time;
        let estimates = pipeline.step(&sample);
        if sample.time.seconds() < 5.0 {
            continue;
        }
        outcome.samples += 1.0;
        outcome.doubted += f64::from(u8::from(estimates.faults.contains(Faults::INCONSISTENT)));
        if let Some(sideslip) = estimates.motion.sideslip.filter(|_| estimates.motion.valid) {
            outcome.valid += 1.0;
            outcome.square += (sideslip - tick.truth.sideslip).to_degrees().powi(2);
        }
    }
    outcome
}

#[test]
fn noise_and_delays_leave_the_motion_valid_and_right() {
    let late = |sensors: &[&'static str], ms: f64| sensors.iter().map(|s| (*s, "delay_ms", ms)).collect();
    let inertial = ["yaw_rate", "lateral_acceleration", "longitudinal_acceleration"];
    let noisy = vec![("lateral_acceleration", "noise_std", 3.5), ("yaw_rate", "noise_std", 0.01)];
    let cases: [(&str, Vec<Change>); 6] = [
        ("as it is", vec![]),
        ("noisy", noisy),
        ("steering 100 ms late", late(&["steering_wheel_angle"], 100.0)),
        ("steering 300 ms late", late(&["steering_wheel_angle"], 300.0)),
        ("inertial unit 100 ms late", late(&inertial, 100.0)),
        ("wheels 200 ms late", late(&["wheel_speed"], 200.0)),
    ];
    for (name, changes) in cases {
        for told in [false, true] {
            let Outcome { samples, valid, doubted, square } = drive(&changes, 0.4, told);
            let rms = (square / valid).sqrt();
            println!("{name}, noise told: {told}: valid {:.3}, off by {rms:.3}°", valid / samples);
            assert!(valid > 0.9 * samples && rms < 0.5, "{name} {told}");
            // The motion lives with what is late; of 300 ms is told, because tires are learned wrong from it.
            let late = name.contains("late") && !name.starts_with("wheels");
            assert!(late || doubted == 0.0, "{name} {told}");
            assert!(doubted > 0.0 || !name.contains("300"), "{name} {told}");
        }
    }
}

/// Not driven wheels, yaw rate and steering are needed; nothing else is.
#[test]
fn what_a_car_does_not_have_is_not_needed() {
    for sensor in ["lateral_acceleration", "longitudinal_acceleration", "drive_torque", "brake_pressure"] {
        let Outcome { samples, valid, doubted, square } = drive(&[(sensor, ABSENT, 1.0)], 0.4, true);
        let rms = (square / valid).sqrt();
        println!("without {sensor}: valid {:.3}, off by {rms:.3}°", valid / samples);
        assert!(valid > 0.7 * samples && rms < 0.5 && doubted == 0.0, "{sensor}");
    }
    for sensor in ["yaw_rate", "steering_wheel_angle"] {
        assert_eq!(drive(&[(sensor, ABSENT, 1.0)], 0.4, true).valid, 0.0, "{sensor}");
    }
}

/// An accelerometer that contradicts yaw rate and steering is told of, and left out.
#[test]
fn an_accelerometer_that_nobody_believes_is_left_out() {
    for offset in [5.0, -2.0] {
        let changes = [("lateral_acceleration", "offset", offset)];
        let Outcome { samples, valid, doubted, square } = drive(&changes, 0.4, true);
        let rms = (square / valid).sqrt();
        let told = doubted / samples;
        println!("{offset} m/s² off: valid {:.3}, off by {rms:.3}°, told {told:.3}", valid / samples);
        assert!(valid > 0.65 * samples && rms < 0.6 && told > 0.9, "{offset}");
    }
}

/// Offsets of ordinary sensors are learned or lived with.
#[test]
fn ordinary_offsets_leave_the_motion_right() {
    for (sensor, offset) in [("lateral_acceleration", 0.3), ("yaw_rate", 0.01), ("steering_wheel_angle", 0.1)]
    {
        let Outcome { samples, valid, square, .. } = drive(&[(sensor, "offset", offset)], 0.4, true);
        let rms = (square / valid).sqrt();
        println!("{sensor} {offset} off: valid {:.3}, off by {rms:.3}°", valid / samples);
        assert!(valid > 0.9 * samples && rms < 0.6, "{sensor}");
    }
}

#[test]
fn a_wrong_scale_is_told() {
    for gain in [0.65, 1.4, -1.0] {
        let outcome = drive(&[("yaw_rate", "gain", gain)], 0.8, false);
        assert!(outcome.doubted > 0.5 * outcome.samples, "{gain}: {outcome:?}");
        assert!(outcome.valid < 0.3 * outcome.samples, "{gain}: {outcome:?}");
    }
}
