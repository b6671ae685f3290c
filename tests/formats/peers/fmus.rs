//! FMUs as FMPy reads and runs them.

use std::fs;
use std::process::Command;

use gripd::Config;
use gripd::model::Scenario;
use testing::program::{gripd_in, project};

use super::succeed;

const EFFECTS: &str = "[[effect]]\nkind = 'load_transfer'\ncg_height_m = 0.55\n\
    [[effect]]\nkind = 'relaxation_length'\nlength_m = 0.5\n\
    [[effect]]\nkind = 'sensor_delay'\nchannel = 'yaw_rate'\ndelay_s = 0.03\n";

/// As `tests/peers/fmus.py` has the inputs.
const DRIVE: &str = "duration_s = 3.0\ninitial_speed_mps = 22.0\ntruth_period_ms = 1\n\
    steering_wheel_angle = [{ kind = 'ramp', from_s = 0.3, to_s = 0.8, value = 0.8 }, \
    { kind = 'ramp', from_s = 1.2, to_s = 1.8, value = -1.3 }]\n\
    drive_torque = [{ kind = 'ramp', from_s = 0.2, to_s = 0.6, value = 500.0 }]\n\
    brake_torque = [{ kind = 'ramp', from_s = 2.0, to_s = 2.4, value = 1500.0 }]\n\
    [vehicle]\nmass_kg = 1\nwheelbase_m = 2\ncg_to_front_m = 1\nwheel_radius_m = 0.3\nsteering_ratio = 15\n\
    driven_axle = 'front'\n";

/// GIVEN a car with effects WHEN FMPy validates its FMUs and runs them THEN it finds nothing, and drives as `gripd simulate`
/// drives it. The table of the truth has nine decimals.
#[test]
#[ignore = "long: fetches FMPy"]
fn fmpy_drives_as_simulate_does() {
    let Some(python) = testing::fmpy() else { return };
    let folder = tempfile::tempdir().unwrap();
    let demo = fs::read_to_string(project("config/demo.toml")).unwrap();
    let demo = demo.replace("../dbc", project("dbc").to_str().unwrap());
    let path = folder.path().join("car.toml");
    fs::write(&path, format!("{demo}\n{EFFECTS}")).unwrap();
    let config = Config::load(&path).unwrap();
    let mut scenario = Scenario::parse(DRIVE).unwrap();
    (scenario.vehicle, scenario.effect) = (config.vehicle, config.effect);
    fs::write(folder.path().join("drive.toml"), toml::to_string(&scenario).unwrap()).unwrap();
    for arguments in [
        "simulate drive.toml -o drive.log --truth truth.csv",
        "export -c car.toml --fmu car2.fmu",
        "export -c car.toml --fmu car3.fmu --fmi 3",
        "export -c car.toml --fmu correction2.fmu --correction",
        "export -c car.toml --fmu correction3.fmu --correction --fmi 3",
    ] {
        let output = gripd_in(folder.path(), arguments);
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    }
    let output = succeed(Command::new(python).arg(project("tests/peers/fmus.py")).arg(folder.path()));
    let said = String::from_utf8_lossy(&output.stdout);
    println!("{said}");
    let apart: Vec<f64> =
        said.lines().map(|line| line.rsplit(',').next().unwrap().parse().unwrap()).collect();
    assert!(apart.len() == 2 && apart.iter().all(|apart| *apart < 1e-9), "{said}");
}
