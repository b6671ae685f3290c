//! The command: what it writes, and how it ends.

use gripd::{Config, Quantity};

use super::car::{Car, DRIVE};
use super::gripd;
use testing::program;

#[test]
fn the_command_writes_what_check_accepts_and_overwrites_nothing() {
    let mut car = Car::german();
    car.of(Quantity::YawRate).gain = -1.0;
    let folder = tempfile::tempdir().unwrap();
    let (dbc, log) = car.record(folder.path(), DRIVE);
    let out = folder.path().join("proposed.toml");
    let json = folder.path().join("proposed.json");
    let mapped = gripd(&[&"map", &dbc, &log, &"-o", &out, &"--json", &json]);
    assert_eq!(mapped.status.code(), Some(0), "{}", String::from_utf8_lossy(&mapped.stderr));
    assert!(mapped.stdout.is_empty());
    let text = std::fs::read_to_string(&out).unwrap();
    println!("{text}");
    assert!(text.contains("input = [\"car.dbc\"]"), "relative to the file");
    assert!(text.contains("# yaw_rate: sure: ") && text.contains("gain = -1.0"));
    let config = Config::load(&out).unwrap();
    assert_eq!(config.signals.quantities.len(), car.lines.len());
    let checked = gripd(&[&"check", &"-c", &out, &log]);
    let said = String::from_utf8_lossy(&checked.stdout).into_owned();
    assert!(checked.status.success() && !said.contains("CERTAIN"), "{said}");
    let answer: serde_json::Value = serde_json::from_slice(&std::fs::read(&json).unwrap()).unwrap();
    let yaw_rate = &answer["quantities"][4];
    assert_eq!(
        (yaw_rate["quantity"].as_str(), yaw_rate["confidence"].as_str()),
        (Some("yaw_rate"), Some("sure"))
    );
    assert!(yaw_rate["data"]["correlation"].as_f64().unwrap() < -0.95);
    // A second time there is something there.
    let again = gripd(&[&"map", &dbc, &"-o", &out]);
    assert_eq!(again.status.code(), Some(2));
    assert!(String::from_utf8_lossy(&again.stderr).contains("is not overwritten"));
    assert_eq!(std::fs::read_to_string(&out).unwrap(), text);
    // Without it, on the standard output; with JSON there, nothing else.
    let printed = gripd(&[&"map", &dbc, &log]);
    assert!(String::from_utf8_lossy(&printed.stdout).contains("[signals]"));
    let printed = gripd(&[&"map", &dbc, &log, &"--json", &"-"]);
    assert!(serde_json::from_slice::<serde_json::Value>(&printed.stdout).is_ok());
}

#[test]
fn what_is_missing_or_foreign_ends_with_its_code() {
    let mut car = Car::german();
    car.lines.retain(|line| line.quantity != Quantity::YawRate);
    let folder = tempfile::tempdir().unwrap();
    let dbc = folder.path().join("car.dbc");
    std::fs::write(&dbc, car.dbc()).unwrap();
    let mapped = gripd(&[&"map", &dbc]);
    assert_eq!(mapped.status.code(), Some(1));
    assert!(String::from_utf8_lossy(&mapped.stderr).contains("not found, and needed: yaw_rate"));
    assert!(
        String::from_utf8_lossy(&mapped.stdout).contains("lateral_acceleration = \"Sensor_2.Querbeschl\"")
    );
    let log = folder.path().join("other.log");
    std::fs::write(&log, "(1.000000) can0 7FF#00\n").unwrap();
    let mapped = gripd(&[&"map", &dbc, &log]);
    assert_eq!(mapped.status.code(), Some(1));
    assert!(String::from_utf8_lossy(&mapped.stderr).contains("is it the right bus"));
    assert_eq!(gripd(&[&"map", &folder.path().join("none.dbc")]).status.code(), Some(2));
}

#[test]
fn the_demo_cars_own_file_is_mapped_by_its_names() {
    let mapped = gripd(&[&"map", &program::project("dbc/demo.dbc")]);
    assert_eq!(mapped.status.code(), Some(0), "{}", String::from_utf8_lossy(&mapped.stderr));
    let text = String::from_utf8_lossy(&mapped.stdout);
    let config = Config::parse(&text, std::path::Path::new("car.toml")).unwrap();
    let signal =
        |quantity| config.signals.quantities.get(&quantity).and_then(|mapped| mapped.signal.as_deref());
    assert_eq!(signal(Quantity::SteeringWheelAngle), Some("STEERING.Angle"));
    assert_eq!(signal(Quantity::DriveTorque), Some("DRIVE.AxleTorque"));
    // Its comment says that brakes are not in it; and nothing measures two things.
    assert_eq!(signal(Quantity::BrakeTorque), None);
    assert_eq!(config.bus.interface, "can0");
}
