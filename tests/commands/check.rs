//! `gripd check` as a command; the trials' controls and real recordings are left alone.

use std::path::{Path, PathBuf};
use std::process::Output;

use testing::program;

fn check(arguments: &[&Path]) -> Output {
    program::gripd().args(["-q", "check", "-c"]).args(arguments).output().unwrap()
}

/// Runs it and reads its JSON.
fn chain(config: &Path, logs: &[PathBuf]) -> serde_json::Value {
    let folder = tempfile::tempdir().unwrap();
    let json = folder.path().join("report.json");
    let mut arguments = vec![config];
    arguments.extend(logs.iter().map(PathBuf::as_path));
    arguments.extend([Path::new("--json"), &json]);
    let output = check(&arguments);
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    serde_json::from_slice(&std::fs::read(json).unwrap()).unwrap()
}

fn certain(report: &serde_json::Value) -> Vec<String> {
    let findings = report["chain"]["findings"].as_array().unwrap();
    findings
        .iter()
        .filter(|f| f["confidence"] == "certain")
        .map(|f| format!("{}:{}", f["effect"].as_str().unwrap(), f["channel"].as_str().unwrap()))
        .collect()
}

#[test]
fn the_trials_get_no_certain_finding_but_their_own() {
    let Some(shared) = testing::shared(".") else { return };
    let folder = shared.join("trials/practice");
    let truth: serde_json::Value =
        serde_json::from_slice(&std::fs::read(folder.join("truth.json")).unwrap()).unwrap();
    for (name, trial) in truth.as_object().unwrap() {
        let log = folder.join(format!("{name}.log.gz"));
        let found = certain(&chain(&folder.join(format!("{name}.toml")), &[log]));
        let cause = trial["cause"].as_str().unwrap_or("none").to_owned();
        let own = |finding: &String| finding.starts_with(&cause);
        assert!(found.iter().all(own), "{name} ({cause}): {found:?}");
        // What kinematics alone can tell must be told.
        if cause == "tire_radius" || cause == "sensor_delay:yaw_rate" {
            assert_eq!(found.len(), 1, "{name} ({cause}): {found:?}");
        }
    }
}

/// A configuration for recording.dbc.
fn recorded_car(folder: &Path, shared: &Path, signals: &str, vehicle: &str) -> PathBuf {
    let dbc = shared.join("recordings/recording.dbc");
    let text = format!(
        r#"
        [dbc]
        input = ["{}"]
        [signals]
        wheel_speed_fl = "WHEEL_SPEEDS.WheelSpeedFL"
        wheel_speed_fr = "WHEEL_SPEEDS.WheelSpeedFR"
        wheel_speed_rl = "WHEEL_SPEEDS.WheelSpeedRL"
        wheel_speed_rr = "WHEEL_SPEEDS.WheelSpeedRR"
        yaw_rate = {{ signal = "INERTIAL.YawRate", not_available = [32768] }}
        lateral_acceleration = {{ signal = "INERTIAL.LateralAcceleration", not_available = [32768] }}
        steering_wheel_angle = {{ signal = "STEERING.SteeringWheelAngle", not_available = [32768] }}
        {signals}
        [vehicle]
        driven_axle = "front"
        {vehicle}
        "#,
        dbc.canonicalize().unwrap().display()
    );
    let path = folder.join("car.toml");
    std::fs::write(&path, text).unwrap();
    path
}

#[test]
fn the_real_recordings_tell_what_is_wrong_with_them() {
    let Some(shared) = testing::shared(".") else { return };
    let folder = tempfile::tempdir().unwrap();
    let recordings = shared.join("recordings");
    let car = Path::new(env!("CARGO_MANIFEST_DIR")).join("config/rav4.toml");
    let report = chain(&car, &[recordings.join("rav4/bus0.log.gz")]);
    assert!(certain(&report).is_empty(), "{:?}", certain(&report));
    assert_eq!(report["recordings"]["frames"], 53_800);
    assert_eq!(report["recordings"]["unneeded_ids"], 87);

    let revsted = recorded_car(
        folder.path(),
        &shared,
        "",
        "mass_kg = { value = 1600.0, std = 200.0 }\nwheelbase_m = { value = 2.7, std = 0.1 }\n\
         cg_to_front_m = { value = 1.2, std = 0.1 }\nwheel_radius_m = { value = 0.33, std = 0.01 }\n\
         steering_ratio = { value = 15.0, std = 2.0 }",
    );
    let report = chain(&revsted, &[recordings.join("revsted/obd.log.gz")]);
    assert_eq!(certain(&report), ["sensor_sign:lateral_acceleration"]);

    let zoe = recorded_car(
        folder.path(),
        &shared,
        "longitudinal_acceleration = { signal = \"INERTIAL.LongitudinalAcceleration\", not_available = [32768] }\n\
         drive_torque = { signal = \"POWERTRAIN.DriveTorque\", not_available = [32768] }",
        "mass_kg = { value = 1550.0, std = 60.0 }\nwheelbase_m = 2.588\ncg_to_front_m = { value = 1.15, std = 0.08 }\n\
         wheel_radius_m = { value = 0.31, std = 0.006 }\nsteering_ratio = { value = 16.0, std = 2.0 }\n\
         drive_torque_ratio = 9.3",
    );
    let mut scenes: Vec<PathBuf> =
        std::fs::read_dir(recordings.join("zoe")).unwrap().map(|entry| entry.unwrap().path()).collect();
    scenes.retain(|path| path.extension().is_some_and(|extension| extension == "gz"));
    scenes.sort();
    let report = chain(&zoe, &scenes);
    // It reads −5 m/s² going straight on level roads.
    assert_eq!(certain(&report), ["sensor_bias:lateral_acceleration"]);

    // Before and after a run they stand, and no zero has moved.
    let mut drives: Vec<PathBuf> =
        std::fs::read_dir(recordings.join("gti")).unwrap().map(|entry| entry.unwrap().path()).collect();
    drives.retain(|path| path.extension().is_some_and(|extension| extension == "gz"));
    let report = chain(&recordings.join("gti/drives.toml"), &drives);
    assert!(drives.len() > 14 && certain(&report).iter().all(|found| !found.starts_with("sensor_drift")));
}

#[test]
fn a_configuration_alone_is_described() {
    let car = Path::new(env!("CARGO_MANIFEST_DIR")).join("config/demo.toml");
    let output = check(&[&car]);
    let text = String::from_utf8(output.stdout).unwrap();
    assert!(output.status.success());
    for expected in ["usable", "WHEELS.", "yaw_rate", "6A0  GRIP_FRICTION", "brake_torque"] {
        assert!(text.contains(expected), "{expected}:\n{text}");
    }
    assert!(!text.contains("measurement chain"));
}

/// What is wrong with the demo's recording when a sign, a scale, a delay, a zero and a tire are put into it.
const WRONG: &str = r#"
[[effect]]
kind = "sensor_sign"
channel = "yaw_rate"
[[effect]]
kind = "sensor_scale"
channel = "lateral_acceleration"
relative_error = 0.15
[[effect]]
kind = "sensor_delay"
channel = "steering_wheel_angle"
delay_s = 0.12
[[effect]]
kind = "sensor_bias"
channel = "longitudinal_acceleration"
bias = 0.8
at_s = 60
[[effect]]
kind = "tire_radius"
relative_difference_rl = 0.02
"#;

/// The demo's configuration, for any folder.
fn demo_car(more: &str) -> String {
    let dbc = program::project("dbc/demo.dbc").canonicalize().unwrap();
    let text = std::fs::read_to_string(program::project("config/demo.toml")).unwrap();
    text.replace("../dbc/demo.dbc", dbc.to_str().unwrap()) + more
}

/// GIVEN a recording with wrong sensors, and a configuration whose effects say so WHEN it is checked THEN the audit says what it
/// says of the recording without either; the same configuration beside healthy sensors is told to be wrong; explain's audit, too.
#[test]
fn what_the_configurations_effects_say_is_not_found_again() {
    let scratch = tempfile::tempdir().unwrap();
    let folder = scratch.path();
    for (name, text) in [("car.toml", demo_car("")), ("told.toml", demo_car(WRONG)), ("e.toml", WRONG.into())]
    {
        std::fs::write(folder.join(name), text).unwrap();
    }
    let scenario = program::project("config/scenarios/demo.toml");
    let run = |arguments: &str| {
        let output = program::gripd_in(folder, arguments);
        assert!(output.status.success(), "{arguments}: {}", String::from_utf8_lossy(&output.stderr));
        String::from_utf8(output.stdout).unwrap()
    };
    run(&format!("-q simulate {} -o drive.log", scenario.display()));
    run("-q conceal -c car.toml drive.log -o wrong.log --effect e.toml");

    let of = |config: &str, log: &str| chain(&folder.join(config), &[folder.join(log)]);
    let found = |report: &serde_json::Value| -> Vec<String> {
        let findings = report["chain"]["findings"].as_array().unwrap().iter();
        findings.map(|f| format!("{}:{}", f["effect"], f["channel"])).collect()
    };
    let clean = of("car.toml", "drive.log");
    let told = of("told.toml", "wrong.log");
    assert!(certain(&of("car.toml", "wrong.log")).contains(&"sensor_sign:yaw_rate".to_owned()));
    assert_eq!(found(&told), found(&clean));
    assert_eq!(told["configuration"]["effects"].as_array().unwrap().len(), 5);
    assert!(told["configuration"]["effects"][0]["taken_out"].as_bool().unwrap());

    let twice = of("told.toml", "drive.log");
    let sign = &twice["chain"]["findings"][0];
    assert_eq!((&sign["effect"], &sign["channel"]), (&"sensor_sign".into(), &"yaw_rate".into()));
    assert!(sign["or"].to_string().contains("leave it away"), "{sign}");
    assert!(run("check -c told.toml").contains("sensor_sign of yaw_rate"));
}
