//! GIVEN published frames WHEN others' implementations read them THEN cantools sees the same numbers and
//! texts, and the AUTOSAR E2E package accepts every checksum.

use std::io::Write;
use std::path::Path;
use std::process::{Command, Stdio};

use gripd::can::Frame;
use gripd::estimates::{Estimate, Friction, Motion, MuSource, State};
use gripd::signals::publish::{PublishConfig, Publisher, built_in_database};
use gripd::{Estimates, Faults, Micros};
use rand::{RngExt, SeedableRng};
use serde_json::Value;

/// Lines "ID PAYLOAD" in, lines out.
fn ask(command: &mut Command, frames: &[Frame]) -> Vec<String> {
    let mut child = command.stdin(Stdio::piped()).stdout(Stdio::piped()).spawn().unwrap();
    let text: String = frames
        .iter()
        .map(|f| format!("{} {}\n", f.id, f.data().iter().map(|b| format!("{b:02X}")).collect::<String>()))
        .collect();
    let mut input = child.stdin.take().unwrap();
    let writer = std::thread::spawn(move || input.write_all(text.as_bytes()));
    let output = child.wait_with_output().unwrap();
    writer.join().unwrap().unwrap();
    assert!(output.status.success());
    String::from_utf8(output.stdout).unwrap().lines().map(str::to_owned).collect()
}

/// Estimates with values in and around what can be published, some of them missing.
fn random(rng: &mut impl RngExt) -> Estimates {
    let mut some = |low: f64, high: f64| {
        let value = rng.random_range(low..high);
        rng.random_bool(0.8).then_some(value)
    };
    let friction = Friction {
        max: some(-0.1, 2.2),
        low: some(0.0, 1.0),
        high: some(0.0, 2.5),
        used: some(0.0, 1.2),
        age_s: some(0.0, 40.0),
        source: MuSource::Joint,
        valid: true,
        ..Friction::default()
    };
    let motion = Motion {
        speed: some(-1.0, 110.0),
        lateral_velocity: some(-12.0, 12.0),
        sideslip: some(-0.3, 0.3),
        slip_angle_front: some(-0.3, 0.3),
        slip_angle_rear: some(-0.3, 0.3),
        valid: true,
    };
    let mut estimate = |value: f64, std: f64| {
        Some(Estimate { value: some(0.0, value)?, std: some(0.0, std)?, age_s: some(0.0, 150.0)? })
    };
    Estimates {
        state: State::Running,
        friction,
        motion,
        slope: std::array::from_fn(|_| estimate(300.0, 40.0)),
        slip_offset: std::array::from_fn(|_| estimate(0.06, 0.004)),
        cornering: std::array::from_fn(|_| estimate(50.0, 12.0)),
        slope_valid: true,
        cornering_valid: true,
        excitation_long: rng.random_range(0.0..1.0),
        excitation_lat: rng.random_range(0.0..1.0),
        surface_changes: rng.random_range(0..300),
        faults: Faults::from_bits_truncate(rng.random()),
        dropped_frames: rng.random_range(0..400),
        ..Estimates::default()
    }
}

fn published(rounds: usize) -> Vec<Frame> {
    let mut rng = rand_chacha::ChaCha8Rng::seed_from_u64(7);
    let mut publisher = Publisher::new(&built_in_database().unwrap(), &PublishConfig::default()).unwrap();
    let mut frames = Vec::new();
    publisher.publish(Micros(0), &Estimates::default(), &mut |frame| frames.push(*frame));
    for _ in 1..rounds {
        publisher.publish(Micros(0), &random(&mut rng), &mut |frame| frames.push(*frame));
    }
    frames
}

#[test]
fn cantools_takes_the_file_strictly_and_sees_the_same_numbers() {
    let Some(python) = testing::python() else { return };
    let dbc = Path::new(env!("CARGO_MANIFEST_DIR")).join("dbc/gripd.dbc");
    let frames = published(500);
    let answers = ask(testing::reference(&python).arg("strict").arg(dbc), &frames);
    assert_eq!(answers.len(), frames.len());
    let database = built_in_database().unwrap();
    let mut not_available = 0;
    for (frame, answer) in frames.iter().zip(answers) {
        let answer: Value = serde_json::from_str(&answer).unwrap();
        let message = database.message_with_id(frame.id).unwrap();
        assert_eq!(answer["message"], message.name.as_str());
        assert_eq!(answer["cycle_time"], 20);
        assert!(
            answer["comments"].as_array().unwrap().iter().all(|c| c.as_str().is_some_and(|c| !c.is_empty()))
        );
        for signal in &message.signals {
            let theirs = answer["values"][&signal.name].as_str().unwrap();
            let theirs = f64::from_bits(u64::from_str_radix(theirs, 16).unwrap());
            assert_eq!(signal.decode(frame.data()), Some(theirs), "{}.{}", message.name, signal.name);
            let bits = signal.bits(frame.data()).unwrap();
            if let Some(name) = signal.value_name(bits) {
                assert_eq!(answer["texts"][&signal.name], name);
                not_available += usize::from(name == "not_available");
            }
        }
    }
    assert!(not_available > 1000, "{not_available}");
}

#[test]
fn the_e2e_package_accepts_every_frame_and_no_damaged_one() {
    let Some(python) = testing::python() else { return };
    let mut frames = published(200);
    let good = frames.len();
    let damaged: Vec<Frame> = frames
        .iter()
        .enumerate()
        .map(|(n, frame)| {
            let mut data = frame.data().to_vec();
            data[n % 8] ^= 1 << (n / 8 % 8);
            Frame::data_frame(frame.time, frame.id, &data).unwrap()
        })
        .collect();
    frames.extend(damaged);
    let answers = ask(testing::reference(&python).arg("e2e"), &frames);
    assert_eq!(answers.len(), frames.len());
    assert!(answers[..good].iter().all(|answer| answer == "True"));
    assert!(answers[good..].iter().all(|answer| answer == "False"));
}
