//! `gripd conceal`: what it changes in a recording, what it leaves, what it says, and what it refuses.

use std::path::Path;
use std::process::Output;

use gripd::can::Frame;
use gripd::can::recording::Reader;
use gripd::dbc::Database;
use serde_json::Value;
use tempfile::TempDir;
use testing::program::{gripd, project};

/// Curves and braking of the demo's car for half a minute, as a recording.
fn drive() -> TempDir {
    let folder = tempfile::tempdir().unwrap();
    let demo = std::fs::read_to_string(project("config/scenarios/demo.toml")).unwrap();
    let scenario = demo.replace("duration_s = 120.0", "duration_s = 30.0");
    std::fs::write(folder.path().join("scenario.toml"), scenario).unwrap();
    let output = run(folder.path(), &["simulate", "scenario.toml", "-o", "drive.log"]);
    assert!(output.status.success(), "{}", told(&output));
    folder
}

fn run(folder: &Path, arguments: &[&str]) -> Output {
    gripd().current_dir(folder).args(arguments).output().unwrap()
}

fn conceal(folder: &Path, arguments: &[&str]) -> Output {
    let config = project("config/demo.toml");
    let fixed = ["-q", "conceal", "-c", config.to_str().unwrap(), "drive.log", "--truth", "truth.json"];
    run(folder, &[&fixed[..], arguments].concat())
}

fn told(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

fn frames(path: &Path) -> Vec<Frame> {
    let mut reader = Reader::open(path).unwrap();
    std::iter::from_fn(|| reader.next_frame().unwrap()).collect()
}

/// Time, s, and value of a signal in each of its frames.
fn series(path: &Path, signal: &str) -> Vec<(f64, f64)> {
    let text = std::fs::read(project("dbc/demo.dbc")).unwrap();
    let database = Database::parse(&text, "demo.dbc").unwrap();
    let (message, signal) = database.signal(signal).unwrap();
    let of = frames(path).into_iter().filter(|frame| frame.id == message.id);
    of.map(|frame| (frame.time.seconds(), signal.decode(frame.data()).unwrap())).collect()
}

fn truth(folder: &Path) -> Value {
    serde_json::from_slice(&std::fs::read(folder.join("truth.json")).unwrap()).unwrap()
}

/// GIVEN a simulated drive WHEN a wheel's radius, a jump and a delay are put in together THEN each reading is what they make
/// of it, to half a raw unit, and the frames that the service takes are as many as before.
#[test]
fn sensors_and_wheels_are_exact_on_the_frames() {
    let folder = drive();
    let (before, after) = (folder.path().join("drive.log"), folder.path().join("changed.log.gz"));
    let effects = "[[effect]]\nkind = \"sensor_bias\"\nchannel = \"yaw_rate\"\nbias = 0.03\nat_s = 12\n\
                   [[effect]]\nkind = \"sensor_delay\"\nchannel = \"lateral_acceleration\"\ndelay_s = 0.1\n";
    std::fs::write(folder.path().join("two.toml"), effects).unwrap();
    let wheel = "kind = 'tire_radius', relative_difference_rl = -0.015";
    let output = conceal(folder.path(), &["--effect", "two.toml", "--effect", wheel, "-o", "changed.log.gz"]);
    assert!(output.status.success(), "{}", told(&output));
    let pairs = |signal: &str| series(&before, signal).into_iter().zip(series(&after, signal));
    for ((t, was), (time, is)) in pairs("INERTIAL.YawRate") {
        assert_eq!(t, time);
        let bias = if t >= 12.0 { 0.03_f64.to_degrees() } else { 0.0 };
        assert!((is - was - bias).abs() <= 0.0051, "{t}: {was} to {is}");
    }
    for ((t, was), (_, is)) in pairs("WHEELS.SpeedRL") {
        assert!((is - was / 0.985).abs() <= 0.0051, "{t}: {was} to {is}");
    }
    assert!(pairs("WHEELS.SpeedRR").all(|(was, is)| was == is));
    let lateral = series(&before, "INERTIAL.AccelerationY");
    let earlier = |t: f64| {
        let after = lateral.partition_point(|(time, _)| *time < t);
        let ((t0, a), (t1, b)) = (lateral[after - 1], lateral[after]);
        a + (b - a) * (t - t0) / (t1 - t0)
    };
    for ((t, _), (_, is)) in pairs("INERTIAL.AccelerationY").skip(11) {
        assert!((is - earlier(t - 0.1)).abs() <= 0.00101, "{t}: {} to {is}", earlier(t - 0.1));
    }
    // Counters and checksums are right: a replay drops nothing that it did not drop before.
    let faults = ["drive.log", "changed.log.gz"].map(|log| {
        let config = project("config/demo.toml");
        let output =
            run(folder.path(), &["-q", "replay", "-c", config.to_str().unwrap(), log, "--stats", "-"]);
        serde_json::from_slice::<Value>(&output.stdout).unwrap()["faults"].clone()
    });
    assert_eq!(faults[0], faults[1]);
    let truth = truth(folder.path());
    assert_eq!(truth["recording"], "drive.log");
    assert_eq!(truth["effects"][0]["intervals"][0][0], 12.0);
    assert_eq!(truth["effects"][2]["parameters"]["relative_difference_rl"], -0.015);
    assert_eq!(truth["channels"]["yaw_rate"]["clipped"], 0);
    let strength = truth["channels"]["yaw_rate"]["strength"].as_f64().unwrap();
    assert!(strength > 1.0, "{truth}");
}

/// WHEN what is put in is nothing THEN the recording is the same to the byte, and that is told.
#[test]
fn nothing_leaves_the_recording_as_it_was() {
    let folder = drive();
    let output = conceal(folder.path(), &["--effect", "payload", "--set", "mass_kg=0", "-o", "changed.log"]);
    assert!(output.status.success(), "{}", told(&output));
    assert!(told(&output).contains("changes nothing"), "{}", told(&output));
    let [before, after] =
        ["drive.log", "changed.log"].map(|name| std::fs::read(folder.path().join(name)).unwrap());
    assert!(before == after);
}

/// WHEN something acts on the car THEN all that it changes is changed, no other line is, and the same seed gives the same.
#[test]
fn what_acts_on_the_car_changes_all_that_it_would() {
    let folder = drive();
    let wind = |seed: &str, out: &str| {
        let output = conceal(
            folder.path(),
            &["--effect", "crosswind", "--set", "force_rms_n=400", "--seed", seed, "-o", out],
        );
        assert!(output.status.success(), "{}", told(&output));
        std::fs::read_to_string(folder.path().join(out)).unwrap()
    };
    let (one, again, other) = (wind("1", "one.log"), wind("1", "again.log"), wind("2", "other.log"));
    assert!(one == again && one != other);
    let before = std::fs::read_to_string(folder.path().join("drive.log")).unwrap();
    assert_eq!(before.lines().count(), one.lines().count());
    let ids = before.lines().zip(one.lines()).filter(|(was, is)| was != is).map(|(_, is)| {
        let frame = is.split(' ').nth(2).unwrap();
        frame.split_once('#').unwrap().0
    });
    let ids: std::collections::BTreeSet<&str> = ids.collect();
    assert!(ids.contains("1B0") && ids.contains("1A0") && !ids.contains("1C0"), "{ids:?}");
    let truth = truth(folder.path());
    assert_eq!(truth["effects"][0]["parameters"]["force_rms_n"], 400.0);
    assert!(truth["car"]["yaw_rate_fit"].as_f64().unwrap() > 80.0, "{truth}");
    assert!(truth["channels"]["yaw_rate"]["kept"].as_f64().unwrap() > 0.9, "{truth}");
}

#[test]
fn another_format_is_written_by_its_name() {
    let folder = drive();
    let effect = ["--effect", "sensor_sign", "--set", "channel=yaw_rate", "-o", "changed.blf"];
    let output = conceal(folder.path(), &effect);
    assert!(output.status.success(), "{}", told(&output));
    let (before, after) =
        (frames(&folder.path().join("drive.log")), frames(&folder.path().join("changed.blf")));
    assert_eq!(before.len(), after.len());
    let log = folder.path().join("changed.blf");
    let (was, is) =
        (series(&folder.path().join("drive.log"), "INERTIAL.YawRate"), series(&log, "INERTIAL.YawRate"));
    assert!(was.iter().zip(&is).all(|((_, was), (_, is))| *is == -*was));
}

#[test]
fn the_list_names_every_kind_with_what_it_needs() {
    let folder = tempfile::tempdir().unwrap();
    let output = run(folder.path(), &["conceal", "--list"]);
    let text = String::from_utf8(output.stdout).unwrap();
    assert!(output.status.success());
    for kind in gripd::model::effect::KINDS {
        assert!(text.contains(&format!("{}: ", kind.name)), "{}", kind.name);
    }
    assert!(text.contains("force_rms_n, or value, or intervals, or series"), "{text}");
    assert!(text.contains("needs     its channel"), "{text}");
}

#[test]
fn what_cannot_be_is_refused_with_reason_and_exit_code() {
    let folder = drive();
    let refused = |arguments: &[&str]| {
        let output = conceal(folder.path(), &[arguments, &["-o", "out.log"]].concat());
        assert!(!folder.path().join("out.log").exists());
        (output.status.code(), told(&output))
    };
    for (arguments, code, words) in [
        (&["--effect", "payloads"][..], 2, "no such kind"),
        (&["--effect", "payload"], 2, "mass_kg"),
        (&["--effect", "payload", "--set", "mass=3"], 2, "mass"),
        (&["--effect", "payload", "--set", "mass_kg"], 2, "NAME=VALUE"),
        (&["--effect", "sensor_bias", "--set", "bias=0.1"], 2, "channel"),
        (&["--effect", "sensor_bias", "--set", "channel=brake_active", "--set", "bias=1"], 2, "channel"),
        (&["--effect", "kind = 'payload', mass_kg = 9e9"], 2, "mass_kg"),
        (&["--effect", "kind = 'road_bank', bank_rms_rad = 0.1, value = 0.1"], 2, "one of the two"),
        (&["--effect", "mass_kg = 3"], 2, "kind"),
        (
            &["--effect", "sensor_sign", "--set", "channel=drive_torque", "--effect", "payload"],
            2,
            "for one effect",
        ),
        (
            &["--effect", "kind = 'sensor_bias', channel = 'yaw_rate', bias = 0.1, at_s = 500"],
            1,
            "ends at 30.0 s",
        ),
        (
            &["--effect", "kind = 'friction_change', friction = 0.06, intervals = [[9, 20]]"],
            1,
            "take less of it",
        ),
    ] {
        let (found, text) = refused(arguments);
        assert!(found == Some(code) && text.contains(words), "{arguments:?}: {found:?} {text}");
        assert!(!text.contains("panicked"), "{text}");
    }
    let output = conceal(folder.path(), &["--effect", "payload", "--set", "mass_kg=9", "-o", "drive.log"]);
    assert_eq!(output.status.code(), Some(2), "{}", told(&output));
    let config = project("config/demo.toml");
    let arguments = ["conceal", "-c", config.to_str().unwrap(), "-", "--effect", "payload", "-o", "x.log"];
    let output = run(folder.path(), &arguments);
    assert!(output.status.code() == Some(2) && told(&output).contains("give a file"), "{}", told(&output));
}
