//! The list of what can go wrong between a sensor and the service, each fault for itself.

use gripd::{Config, Faults};

use super::case;
use testing::fault::content::changed;
use testing::fault::frame::instead;
use testing::fault::{Case, Fault, content, frame, sensor, timing};
use testing::{demo_car as car, program};

#[test]
fn faults_of_frames() {
    case::check(&car::config(), car::readings(), &frame::cases());
}

#[test]
fn faults_of_content() {
    case::check(&car::config(), car::readings(), &content::cases());
}

#[test]
fn faults_of_sensors() {
    case::check(&car::config(), car::readings(), &sensor::cases());
}

/// In a car that all but stops.
#[test]
fn faults_of_slow_wheels() {
    case::check(&car::config(), car::stopping(), &sensor::slow_wheels());
}

#[test]
fn faults_of_timing() {
    case::check(&car::config(), car::readings(), &timing::cases());
}

/// The demo's car with a steering angle in floating point and a brake pressure on a page of its own.
fn other_car() -> (Config, tempfile::TempDir) {
    let folder = tempfile::tempdir().unwrap();
    let dbc = std::fs::read_to_string(program::project("dbc/demo.dbc")).unwrap();
    let edits = [
        ("STEERING: 4 EPS", "STEERING: 8 EPS"),
        ("Angle : 0|16@1- (0.1,0) [-1000|1000] \"deg\"", "Angle : 0|32@1- (1,0) [0|0] \"deg\""),
        ("AngleValid : 16|1", "AngleValid : 32|1"),
        (" SG_ BrakePressure :", " SG_ Page M : 40|4@1+ (1,0) [0|15] \"\" GATEWAY\n SG_ BrakePressure m1 :"),
    ];
    let dbc = edits.iter().fold(dbc, |dbc, (was, is)| {
        assert_eq!(dbc.matches(was).count(), 1, "{was}");
        dbc.replace(was, is)
    });
    let file = folder.path().join("car.dbc");
    std::fs::write(&file, dbc + "\nSIG_VALTYPE_ 448 Angle : 1;\n").unwrap();
    (car::with(&[("../dbc/demo.dbc", file.to_str().unwrap())]), folder)
}

#[test]
fn faults_of_floating_point_and_multiplexed_content() {
    let cases = [
        Case {
            name: "not a number in a floating-point signal",
            fault: Fault::Frames(|frames| {
                instead(frames, 0x1C0, |f| {
                    changed(f, false, |d| d[..4].copy_from_slice(&f32::NAN.to_le_bytes()))
                })
            }),
            told: Faults::NOT_AVAILABLE,
            ..Case::PLAIN
        },
        Case {
            name: "a page that does not come (multiplexed brake pressure)",
            fault: Fault::Frames(|frames| instead(frames, 0x1D0, |f| changed(f, false, |d| d[5] = 0))),
            told: Faults::TIMEOUT,
            within: (0.3, 0.1),
            ..Case::PLAIN
        },
    ];
    let (config, _folder) = other_car();
    case::check(&config, car::readings(), &cases);
}
