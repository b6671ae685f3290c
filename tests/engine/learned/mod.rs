//! What outlives a drive: taken up by the next one, refused where it is not wholly right, and never in the
//! service's way.

mod poison;
mod service;

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;
use std::process::Output;
use std::sync::OnceLock;

use gripd::can::Frame;
use gripd::can::candump::Reader;
use gripd::service::saved::Refusal;
use gripd::service::{Engine, SavedState, Sink};
use gripd::{Config, Estimates, Sample};
use tempfile::TempDir;
use testing::program;
use testing::program::project;
use testing::results::Section;

fn gripd(arguments: &[&str], folder: &Path) -> Output {
    program::gripd().env_remove("STATE_DIRECTORY").current_dir(folder).args(arguments).output().unwrap()
}

/// The demo car's first 44 s, on asphalt, with sensors a good deal off.
fn scenario() -> String {
    let demo = fs::read_to_string(project("config/scenarios/demo.toml")).unwrap();
    let worse = [
        ("duration_s = 120.0", "duration_s = 44.0"),
        ("offset = 0.002\n", "offset = 0.012\n"),
        ("offset = 0.04\n", "offset = 0.12\n"),
        ("offset = 0.005\n", "offset = 0.12\n"),
    ];
    worse.iter().fold(demo, |text, (was, is)| {
        assert_eq!(text.matches(was).count(), 1, "{was}");
        text.replace(was, is)
    })
}

/// Such drives by their seeds, with their truths. The first is the one that is learned from.
const FIRST: &str = "1.log";
const SECOND: &str = "2.log";
const LATER: [u32; 7] = [2, 3, 4, 5, 6, 7, 8];

fn drives() -> &'static Path {
    static MADE: OnceLock<TempDir> = OnceLock::new();
    let folder = MADE.get_or_init(|| {
        let folder = TempDir::new().unwrap();
        fs::write(folder.path().join("drive.toml"), scenario()).unwrap();
        for seed in [1].into_iter().chain(LATER).map(|seed| seed.to_string()) {
            let (log, truth) = (format!("{seed}.log"), format!("{seed}.csv"));
            let arguments = ["simulate", "drive.toml", "-o", &log, "--truth", &truth, "--seed", &seed];
            let output = gripd(&arguments, folder.path());
            assert!(output.status.success(), "{}", complaint(&output));
        }
        folder
    });
    folder.path()
}

fn complaint(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

fn demo_car() -> Config {
    Config::load(&project("config/demo.toml")).unwrap()
}

fn frames(log: &str) -> Vec<Frame> {
    let mut reader = Reader::open(&drives().join(log)).unwrap();
    std::iter::from_fn(|| reader.next_frame().unwrap()).collect()
}

/// `gripd replay` of the demo car, of a log of [`drives`].
fn replay(log: &str, arguments: &[&str], folder: &Path) -> Output {
    replay_of(&project("config/demo.toml"), log, arguments, folder)
}

/// The same with another configuration.
fn replay_of(car: &Path, log: &str, arguments: &[&str], folder: &Path) -> Output {
    let log = drives().join(log);
    let begin = ["replay", "-c", car.to_str().unwrap(), log.to_str().unwrap()];
    gripd(&[&begin, arguments].concat(), folder)
}

/// A folder with the state that the first drive left.
fn after_the_first_drive() -> TempDir {
    static TEXT: OnceLock<Vec<u8>> = OnceLock::new();
    let folder = TempDir::new().unwrap();
    let path = folder.path().join("learned.toml");
    let text = TEXT.get_or_init(|| {
        let output = replay(FIRST, &["--state", path.to_str().unwrap()], folder.path());
        assert!(output.status.success(), "{}", complaint(&output));
        fs::read(&path).unwrap()
    });
    fs::write(&path, text).unwrap();
    folder
}

/// A column of a CSV, with the time.
fn column(csv: &str, name: &str) -> Vec<(f64, Option<f64>)> {
    let mut reader = csv::Reader::from_reader(csv.as_bytes());
    let place = reader.headers().unwrap().iter().position(|header| header == name).unwrap();
    let rows = reader.records().map(Result::unwrap);
    rows.map(|row| (row[0].parse().unwrap(), row[place].parse().ok())).collect()
}

/// Seconds until a column is 1.
fn until(csv: &str, name: &str) -> f64 {
    let rows = column(csv, name);
    let (when, _) = rows.iter().find(|(_, value)| *value == Some(1.0)).unwrap();
    when - rows[0].0
}

/// Rms difference of a column to the truth, from second to second of the drive.
fn error(csv: &str, truth: &str, name: &str, from: f64, to: f64) -> f64 {
    let truth = column(truth, name);
    let rows = column(csv, name);
    let begun = rows[0].0;
    let mut errors = Vec::new();
    for (t, value) in rows.iter().filter(|(t, _)| (from..to).contains(&(t - begun))) {
        let place = truth.partition_point(|(of_truth, _)| of_truth < t).min(truth.len() - 1);
        if let (Some(value), Some(truth)) = (value, truth[place].1) {
            errors.push((value - truth).powi(2));
        }
    }
    assert!(!errors.is_empty(), "{name} has no values");
    (errors.iter().sum::<f64>() / errors.len() as f64).sqrt()
}

/// GIVEN seven drives of a car whose sensors are off WHEN they start from what another drive learned THEN
/// they know sooner, and better from the start on.
#[test]
fn the_next_drive_knows_sooner() {
    compare(
        "learned",
        &project("config/demo.toml"),
        &[
            ("slope_valid", 0.95),
            // Where the data sheet is good, stiffnesses are valid as soon as curves were driven, learned or not.
            ("cornering_valid", 1.001),
            ("cornering_front 0 s", 0.98),
            ("cornering_rear 0 s", 1.0),
            ("slip_offset_fl 0 s", 0.8),
            // The bank of filters begins where a good data sheet has it: a twentieth of a degree either way.
            ("sideslip 0 s", 1.35),
            ("sideslip 5 s", 1.15),
        ],
    );
}

/// The same WHEN the data sheet says little of the tires, and that wrongly THEN most of all.
#[test]
fn the_worse_the_data_sheet_the_more_was_learned() {
    let folder = TempDir::new().unwrap();
    let car = folder.path().join("car.toml");
    let vague = [
        ("\"../dbc/demo.dbc\"", format!("{:?}", project("dbc/demo.dbc"))),
        ("{ value = 104.0, std = 30.0 }", "{ value = 50.0, std = 30.0 }".into()),
        (
            "lateral_stiffness_front = { value = 12.0, std = 3.0 }",
            "lateral_stiffness_front = { value = 20.0, std = 9.0 }".into(),
        ),
        (
            "lateral_stiffness_rear = { value = 14.0, std = 3.0 }",
            "lateral_stiffness_rear = { value = 22.0, std = 10.0 }".into(),
        ),
    ];
    let demo = fs::read_to_string(project("config/demo.toml")).unwrap();
    let text = vague.iter().fold(demo, |text, (was, is)| {
        assert_eq!(text.matches(was).count(), 1, "{was}");
        text.replace(was, is)
    });
    fs::write(&car, text).unwrap();
    compare(
        "learned_vague",
        &car,
        &[
            ("slope_valid", 0.95),
            ("cornering_valid", 0.9),
            ("cornering_front 0 s", 0.75),
            ("cornering_rear 0 s", 0.6),
            ("slip_offset_fl 0 s", 0.5),
            ("sideslip 5 s", 0.5),
        ],
    );
}

/// Drives without and with what the first one learned; the means of times and errors with it are at most
/// these shares of those without.
fn compare(name: &str, car: &Path, at_most: &[(&str, f64)]) {
    let run = |log: &str, arguments: &[&str], folder: &Path| {
        let output = replay_of(car, log, arguments, folder);
        assert!(output.status.success(), "{}", complaint(&output));
    };
    let folder = TempDir::new().unwrap();
    let folder = folder.path();
    run(FIRST, &["--state", "first.toml"], folder);
    let mut sums = BTreeMap::<String, [f64; 2]>::new();
    for seed in LATER {
        let log = format!("{seed}.log");
        run(&log, &["--estimates", "fresh.csv"], folder);
        fs::copy(folder.join("first.toml"), folder.join("learned.toml")).unwrap();
        run(&log, &["--estimates", "later.csv", "--state", "learned.toml"], folder);
        let both = ["fresh.csv", "later.csv"].map(|name| fs::read_to_string(folder.join(name)).unwrap());
        let truth = fs::read_to_string(drives().join(format!("{seed}.csv"))).unwrap();
        let mut add = |what: String, of: [f64; 2]| {
            let sum = sums.entry(what).or_default();
            *sum = [sum[0] + of[0], sum[1] + of[1]];
        };
        for name in ["slope_valid", "cornering_valid"] {
            let [fresh, later] = both.each_ref().map(|csv| until(csv, name));
            // Which window of 0.4 s is the first is chance.
            assert!(later < fresh + 0.5, "seed {seed}: {name} after {later} s, fresh {fresh} s");
            add(name.into(), [fresh, later]);
        }
        for (name, from, to) in ERRORS {
            add(format!("{name} {from} s"), both.each_ref().map(|csv| error(csv, &truth, name, from, to)));
        }
    }
    let mean = |of: f64| if of < 0.7 { format!("{:.5}", of / 7.0) } else { format!("{:.2}", of / 7.0) };
    let row = |(what, [fresh, later]): (&String, &[f64; 2])| {
        format!("{what} | {} | {}", mean(*fresh), mean(*later))
    };
    let section = Section {
        name,
        seed: "seeds 2 to 8",
        tolerance: 0.02,
        header: "first s until valid, or error (SI) from this second on | nothing learned before | after another drive",
    };
    section.check(&sums.iter().map(row).collect::<Vec<_>>());
    for (what, at_most) in at_most {
        let [fresh, later] = sums[*what];
        assert!(later < at_most * fresh, "{what}: {later}, fresh {fresh}");
    }
}

/// Columns, and seconds of the drive in which they are compared with the truth.
const ERRORS: [(&str, f64, f64); 5] = [
    ("sideslip", 0.0, 5.0),
    ("sideslip", 5.0, 20.0),
    ("slip_offset_fl", 0.0, 5.0),
    ("cornering_front", 0.0, 20.0),
    ("cornering_rear", 0.0, 20.0),
];

/// GIVEN a file WHEN a replay is not told of it THEN it neither reads nor writes it, and is what it always
/// was; AND told of it twice, from the same file, it is the same twice.
#[test]
fn a_replay_stays_the_same() {
    let folder = after_the_first_drive();
    let (path, saved) = (folder.path().join("learned.toml"), folder.path().join("saved.toml"));
    fs::copy(&path, &saved).unwrap();
    let estimates = |arguments: &[&str]| {
        let all = [&["-o", "-"], arguments].concat();
        let output = replay(SECOND, &all, folder.path());
        assert!(output.status.success(), "{}", complaint(&output));
        (output.stdout, fs::read(&path).unwrap())
    };
    let without = estimates(&[]);
    assert!(without == estimates(&[]) && without.1 == fs::read(&saved).unwrap());
    let with = estimates(&["--state", "learned.toml"]);
    assert!(with.0 != without.0 && with.1 != without.1);
    fs::copy(&saved, &path).unwrap();
    assert!(with == estimates(&["--state", "learned.toml"]));
}

/// GIVEN a drive WHEN what it learned is saved THEN the file says what it is, in SI with its units, and has
/// no word of friction.
#[test]
fn friction_is_not_in_the_file() {
    let folder = after_the_first_drive();
    let text = fs::read_to_string(folder.path().join("learned.toml")).unwrap();
    println!("{text}");
    let numbers: toml::Table = toml::from_str(&text).unwrap();
    assert_eq!(numbers["version"].as_integer(), Some(1));
    assert!((30.0..44.1).contains(&numbers["driving_s"].as_float().unwrap()));
    let offset = numbers["slip_offset"]["fl"]["value"].as_float().unwrap();
    assert!((offset + 0.0138).abs() < 1e-3 || (offset - 0.0138).abs() < 1e-3, "{offset}");
    let keys = text.lines().filter(|line| !line.starts_with('#')).collect::<String>();
    assert!(!keys.contains("friction") && !keys.contains("mu"), "{keys}");
}

/// GIVEN nothing but what an earlier drive learned WHEN the car stands, or only rolls straight on THEN
/// nothing of it is called valid.
#[test]
fn nothing_restored_is_valid_before_it_is_driven() {
    struct Never;
    impl Sink for Never {
        fn estimates(&mut self, _: &Sample, estimates: &Estimates) {
            assert!(!estimates.slope_valid && !estimates.cornering_valid && !estimates.friction.valid);
            assert_eq!((estimates.cornering, estimates.friction.max), ([None; 2], None));
        }
        fn publish(&mut self, _: &Frame) {}
    }
    let folder = after_the_first_drive();
    let car = demo_car();
    let saved = SavedState::new(&folder.path().join("learned.toml"), &car);
    let mut engine = Engine::new(&car).unwrap();
    engine.restore(&saved.load().unwrap().unwrap());
    for frame in calm_frames(folder.path()) {
        engine.frame(&frame, &mut Never);
    }
    assert!(engine.driving_s() > 70.0);
}

/// 30 s straight on at 8 m/s.
fn calm_frames(folder: &Path) -> Vec<Frame> {
    let text = scenario().replace("initial_speed_mps = 15.0", "initial_speed_mps = 8.0");
    let (before, rest) = text.split_once("[driver]").unwrap();
    let (_, sensors) = rest.split_once("# The ordinary measuring chain").unwrap();
    let driver = "[driver]\n[[driver.speed_mps]]\nkind = \"points\"\npoints = [[0, 8], [44, 8]]\n";
    fs::write(folder.join("calm.toml"), format!("{before}{driver}#{sensors}")).unwrap();
    let output = gripd(&["simulate", "calm.toml", "-o", "calm.log"], folder);
    assert!(output.status.success(), "{}", complaint(&output));
    let mut reader = Reader::open(&folder.join("calm.log")).unwrap();
    std::iter::from_fn(|| reader.next_frame().unwrap()).collect()
}

/// What is refused stays as it is when a user names it, AND the command says what and why.
#[test]
fn a_replay_refuses_and_leaves_the_file_alone() {
    let folder = after_the_first_drive();
    let path = folder.path().join("learned.toml");
    let good = fs::read_to_string(&path).unwrap();
    let cases = [
        (good.replace("value = ", "value = 1"), "checksum"),
        (good[..good.len() / 2].to_owned(), "checksum"),
        (String::new(), "no state of gripd"),
        (fs::read_to_string(project("config/demo.toml")).unwrap(), "no state of gripd"),
    ];
    for (text, reason) in cases {
        fs::write(&path, &text).unwrap();
        let output = replay(SECOND, &["--state", "learned.toml"], folder.path());
        let said = complaint(&output);
        assert_eq!(output.status.code(), Some(2), "{said}");
        assert!(said.contains("learned.toml") && said.contains(reason), "{said}");
        assert!(fs::read_to_string(&path).unwrap() == text);
    }
    assert_eq!(replay(SECOND, &["--state", "."], folder.path()).status.code(), Some(2));
}

/// GIVEN a file learned on one car WHEN the configuration is another's THEN it is refused; AND it is not
/// when only what does not matter changed.
#[test]
fn another_vehicle_or_mapping_refuses_it() {
    let folder = after_the_first_drive();
    let path = folder.path().join("learned.toml");
    let text = fs::read_to_string(project("config/demo.toml")).unwrap();
    let load = |was: &str, is: &str| {
        assert!(text.contains(was), "{was}");
        let config = Config::parse(&text.replace(was, is), &project("config/demo.toml")).unwrap();
        SavedState::new(&path, &config).load()
    };
    assert!(load("fd = false", "fd = true").unwrap().is_some());
    assert!(load("valid_when = 1", "valid_when = [1, 2]").unwrap().is_some());
    let others = [
        ("value = 1450.0", "value = 1650.0"),
        ("driven_axle = \"front\"", "driven_axle = \"rear\""),
        ("\"INERTIAL.AccelerationY\"", "{ signal = \"INERTIAL.AccelerationY\", gain = -1.0 }"),
        ("\"INERTIAL.AccelerationY\"", "{ signal = \"INERTIAL.AccelerationY\", offset = 0.01 }"),
        ("\"WHEELS.SpeedFL\"", "\"WHEELS.SpeedFR\""),
        ("drive_torque = \"DRIVE.AxleTorque\"", ""),
    ];
    for (was, is) in others {
        assert!(matches!(load(was, is), Err(Refusal::OtherVehicle)), "{is}");
    }
}
