//! `gripd export --fmu`: the car that drives in it is the one that `gripd simulate` drives.

use std::fs;
use std::path::Path;
use std::time::Duration;

use gripd::fmu::foreign::{Course, Job, Line, Program, Role, Rows, Run, Unpacked, Value};
use gripd::model::{Scenario, Simulation, Truth};
use testing::program::{executable, gripd_in};

use super::archives::configure;

const EFFECTS: &str = "[[effect]]\nkind = 'load_transfer'\ncg_height_m = { value = 0.55, std = 0.05 }\n\
    [[effect]]\nkind = 'relaxation_length'\nlength_m = 0.5\n\
    [[effect]]\nkind = 'roll_steer'\nroll_steer_rad_per_rad = 0.1\n\
    [[effect]]\nkind = 'sensor_delay'\nchannel = 'yaw_rate'\ndelay_s = 0.03\n\
    [[effect]]\nkind = 'sensor_bias'\nchannel = 'lateral_acceleration'\nbias = 0.2\n";

/// The configured car over a curve and a braking, as `gripd simulate` drives it: truth and readings at each millisecond.
fn simulated(folder: &Path) -> (Vec<Truth>, Vec<[f64; 2]>) {
    let config = gripd::Config::load(&folder.join("car.toml")).unwrap();
    let mut scenario = Scenario::parse(
        "duration_s = 3.0\ninitial_speed_mps = 22.0\ntruth_period_ms = 1\n\
         steering_wheel_angle = [{ kind = 'sine', amplitude = 0.9, frequency_hz = 0.6 }]\n\
         drive_torque = [{ kind = 'ramp', from_s = 0.2, to_s = 0.6, value = 500.0 }]\n\
         brake_torque = [{ kind = 'ramp', from_s = 1.5, to_s = 1.9, value = 1500.0 }]\n\
         [sensors.yaw_rate]\nperiod_ms = 1.0\n[sensors.lateral_acceleration]\nperiod_ms = 1.0\n\
         [vehicle]\nmass_kg = 1\nwheelbase_m = 2\ncg_to_front_m = 1\nwheel_radius_m = 0.3\nsteering_ratio = 15\n\
         driven_axle = 'front'\n[[road]]",
    )
    .unwrap();
    scenario.vehicle = config.vehicle;
    scenario.effect = config.effect;
    let mut simulation = Simulation::new(&scenario, 1).unwrap();
    let (mut truth, mut said) = (vec![], vec![]);
    while let Some(tick) = simulation.next_tick() {
        truth.push(*tick.truth);
        said.push(std::array::from_fn(|i| tick.readings[i].value));
    }
    (truth, said)
}

/// A run of an FMU with the inputs of a drive, in communication steps of so many milliseconds.
fn driven(fmu: &Unpacked, folder: &Path, truth: &[Truth], every: usize, outputs: &[&str]) -> Rows {
    let variable = |name: &str| fmu.description.named(name).unwrap_or_else(|| panic!("{name}"));
    let set = |name: &str, value| {
        let of = variable(name);
        Value { kind: of.kind, reference: of.reference, value }
    };
    let line = |name: &str, value: fn(&Truth) -> f64| {
        let of = variable(name);
        Line {
            kind: of.kind,
            reference: of.reference,
            values: truth.iter().step_by(every).map(value).collect(),
        }
    };
    let is_three = fmu.description.version == gripd::fmu::Version::Three;
    let mut run = Run { set: vec![set("initial_speed", 22.0)] };
    if is_three {
        run.set.push(set("inputs_are_of_the_end", 1.0));
    }
    let job = Job {
        is_three,
        library: fmu.library.clone(),
        resources: fmu.resources.clone(),
        token: fmu.description.token.clone(),
        name: "a drive".into(),
        step_s: every as f64 * 1e-3,
        steps: (truth.len() - 1) / every,
        course: if is_three { Course::ToTheEnd } else { Course::Rates },
        inputs: vec![
            line("steering_wheel_angle", |truth| truth.steering_wheel_angle),
            line("drive_torque", |truth| truth.drive_torque),
            line("brake_torque", |truth| truth.brake_torque),
        ],
        outputs: outputs.iter().map(|name| (variable(name).kind, variable(name).reference)).collect(),
        runs: vec![run.clone(), run],
    };
    let program =
        Program { executable: executable(), folder: folder.to_owned(), limit: Duration::from_secs(60) };
    let mut rows = program.work(&job).unwrap();
    assert_eq!(rows[0], rows[1], "two instances are two cars");
    rows.remove(0)
}

/// GIVEN a car with effects WHEN it is exported THEN it drives as `gripd simulate` drives it, to 1e-9, in both versions of
/// FMI, and its sensors say what is said there.
#[test]
fn it_drives_as_simulate_does() {
    let folder = tempfile::tempdir().unwrap();
    configure(folder.path(), EFFECTS);
    let (truth, said) = simulated(folder.path());
    let columns = Truth::columns();
    for version in ["2", "3"] {
        let name = format!("car{version}.fmu");
        let output = gripd_in(folder.path(), &format!("export -c car.toml --fmu {name} --fmi {version}"));
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        let unpacked = tempfile::tempdir().unwrap();
        let fmu = Unpacked::new(&folder.path().join(&name), unpacked.path()).unwrap();
        let outputs: Vec<&str> = fmu
            .description
            .variables
            .iter()
            .filter(|variable| variable.role == Role::Output && columns.contains(&variable.name))
            .map(|variable| variable.name.as_str())
            .collect();
        assert!(outputs.len() > 35, "{outputs:?}");
        let with_sensors = [&outputs[..], &["measured.yaw_rate", "measured.lateral_acceleration"]].concat();
        let rows = driven(&fmu, unpacked.path(), &truth, 1, &with_sensors);
        assert_eq!(rows.len(), truth.len());
        let mut most: f64 = 0.0;
        for ((row, truth), said) in rows.iter().zip(&truth).zip(&said) {
            let values = truth.values();
            for (name, value) in outputs.iter().zip(row) {
                let column = columns.iter().position(|column| column == name).unwrap();
                // Forces are thousands of newtons: relative to them.
                let apart = (value - values[column]).abs() / values[column].abs().max(1.0);
                assert!(apart < 1e-9, "{version}, {name} at {:?}: {value} {}", truth.time, values[column]);
                most = most.max(apart);
            }
            for (value, said) in row[outputs.len()..].iter().zip(said) {
                assert!((value - said).abs() < 1e-9, "{version} at {:?}: {value} {said}", truth.time);
            }
        }
        println!("FMI {version}: {most:.1e} apart at most");
        // In longer steps it is the same drive, its inputs taken as straight over each.
        let rows = driven(&fmu, unpacked.path(), &truth, 10, &["yaw_rate"]);
        let apart = rows.iter().zip(truth.iter().step_by(10)).map(|(row, truth)| row[0] - truth.yaw_rate);
        let most = apart.map(f64::abs).fold(0.0, f64::max);
        assert!(most < 1e-4, "{most}");
    }
}

/// GIVEN what cannot be exported, or a library that is not there THEN that is said, and nothing is written.
#[test]
fn what_cannot_be_exported_is_said() {
    let folder = tempfile::tempdir().unwrap();
    configure(folder.path(), "");
    let alone = folder.path().join("bin");
    fs::create_dir(&alone).unwrap();
    fs::copy(executable(), alone.join("gripd")).unwrap();
    let without = |library: Option<&[u8]>| {
        if let Some(bytes) = library {
            fs::write(alone.join("libgripd_fmu.so"), bytes).unwrap();
        }
        std::process::Command::new(alone.join("gripd"))
            .current_dir(folder.path())
            .args(["-q", "export", "-c", "car.toml", "--fmu", "car.fmu"])
            .output()
            .unwrap()
    };
    for (output, code, expected) in [
        (gripd_in(folder.path(), "export -c car.toml --fmu car.fmu --fmi 4"), 2, "possible values: 2, 3"),
        (gripd_in(folder.path(), "export -c car.toml --fmi 3"), 2, "--fmu"),
        (gripd_in(folder.path(), "export -c car.toml --fmu car.toml"), 2, "another name"),
        (gripd_in(folder.path(), "export -c car.toml --fmu car.fmu --tir car.tir"), 2, "cannot be used with"),
        (without(None), 1, "cargo build --release -p gripd-fmu"),
        (without(Some(b"\x7fELF of another version")), 1, "not of this version"),
    ] {
        let said = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(code), "{said}");
        assert!(said.contains(expected), "{expected}: {said}");
    }
    assert!(!folder.path().join("car.fmu").exists());
}
