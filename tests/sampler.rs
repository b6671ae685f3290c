//! From frames to samples: time, order, gaps, time-outs, plausibility.

mod signals_support;

use gripd::dbc::Database;
use gripd::signals::{Inputs, Sampler};
use signals_support as car;

fn explore(name: &str, config: &str, dbc: &std::path::Path, log: &std::path::Path) {
    let config = car::config(config);
    let database = Database::load(dbc).unwrap();
    let inputs = Inputs::compile(&config, &database, 0.33).unwrap_or_else(|e| panic!("{e}"));
    let mut sampler = Sampler::new(inputs, &config.sampling);
    let frames = car::recording(log);
    let start = std::time::Instant::now();
    let samples = car::run(&mut sampler, &frames, true);
    let took = start.elapsed();
    let mut first = std::collections::BTreeMap::new();
    for s in &samples {
        for name in s.faults.names() {
            let e = first.entry(name).or_insert((s.time, 0));
            e.1 += 1;
        }
    }
    println!(
        "{name}: {} frames, {} samples, counts {}; {:?}; {} ns/frame",
        frames.len(),
        samples.len(),
        sampler.counts(),
        first,
        took.as_nanos() / frames.len() as u128
    );
}

#[test]
fn explore_all() {
    let real = r#"
    wheel_speed_fl = "WHEEL_SPEEDS.WheelSpeedFL"
    wheel_speed_fr = "WHEEL_SPEEDS.WheelSpeedFR"
    wheel_speed_rl = "WHEEL_SPEEDS.WheelSpeedRL"
    wheel_speed_rr = "WHEEL_SPEEDS.WheelSpeedRR"
    yaw_rate = { signal = "INERTIAL.YawRate", not_available = [32768] }
    lateral_acceleration = { signal = "INERTIAL.LateralAcceleration", not_available = [32768] }
    longitudinal_acceleration = { signal = "INERTIAL.LongitudinalAcceleration", not_available = [32768] }
    steering_wheel_angle = { signal = "STEERING.SteeringWheelAngle", not_available = [32768] }
    drive_torque = { signal = "POWERTRAIN.DriveTorque", not_available = [32768] }
    brake_pressure = { signal = "POWERTRAIN.BrakePressure", not_available = [32768] }
    "#;
    let root = car::shared("recordings").unwrap();
    let mut logs: Vec<_> = std::fs::read_dir(root.join("zoe")).unwrap().map(|e| e.unwrap().path()).collect();
    logs.push(root.join("revsted/obd.log.gz"));
    logs.sort();
    for log in logs.iter().filter(|l| l.extension().is_some_and(|e| e == "gz")) {
        explore(&log.display().to_string(), real, &root.join("recording.dbc"), log);
    }
    let rav4 = r#"
    wheel_speed_fl = "WHEEL_SPEEDS.WHEEL_SPEED_FL"
    wheel_speed_fr = "WHEEL_SPEEDS.WHEEL_SPEED_FR"
    wheel_speed_rl = "WHEEL_SPEEDS.WHEEL_SPEED_RL"
    wheel_speed_rr = "WHEEL_SPEEDS.WHEEL_SPEED_RR"
    yaw_rate = "KINEMATICS.YAW_RATE"
    lateral_acceleration = { signal = "KINEMATICS.ACCEL_Y", gain = -1 }
    longitudinal_acceleration = { signal = "KINEMATICS.ACCEL_X", gain = -1 }
    steering_wheel_angle = { sum = ["STEER_ANGLE_SENSOR.STEER_ANGLE", "STEER_ANGLE_SENSOR.STEER_FRACTION"] }
    "#;
    explore("rav4", rav4, &root.join("rav4/_toyota_2017.dbc"), &root.join("rav4/bus0.log.gz"));
    let trials = car::shared("trials/practice").unwrap();
    let mut logs: Vec<_> = std::fs::read_dir(&trials).unwrap().map(|e| e.unwrap().path()).collect();
    logs.sort();
    for log in logs.iter().filter(|l| l.extension().is_some_and(|e| e == "gz")) {
        let toml = std::fs::read_to_string(log.display().to_string().replace(".log.gz", ".toml")).unwrap();
        let table: toml::Table = toml::from_str(&toml).unwrap();
        let signals = toml::to_string(&table["signals"]).unwrap();
        explore(&log.file_name().unwrap().to_string_lossy(), &signals, &trials.join("trial.dbc"), log);
    }
}
