//! `gripd setup`: from a DBC and recordings to a configuration that runs, without an editor.

use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};

use gripd::model::{DrivenAxle, Uncertain};
use gripd::{Config, Quantity};
use testing::program::{executable, gripd};

use crate::map::car::{Car, DRIVE};

/// The command in this folder, with nobody at a terminal.
fn setup(folder: &Path, arguments: &[&str]) -> Output {
    let mut command = gripd();
    command.current_dir(folder).args(["-q", "setup"]).args(arguments).stdin(Stdio::null());
    command.output().unwrap()
}

fn said(output: &Output) -> String {
    format!("{}{}", String::from_utf8_lossy(&output.stdout), String::from_utf8_lossy(&output.stderr))
}

/// What `check` says of a configuration and a recording.
fn checked(folder: &Path, config: &str, log: &str) -> String {
    let output = gripd().current_dir(folder).args(["-q", "check", "-c", config, log]).output().unwrap();
    assert_eq!(output.status.code(), Some(0), "{}", said(&output));
    said(&output)
}

/// A folder with a car's DBC and its drive.
fn recorded(car: &Car, scenario: &str) -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    car.record(folder.path(), scenario);
    folder
}

/// GIVEN a car's DBC and a drive, in whatever order, WHEN nothing is asked THEN the configuration has all signals, the
/// numbers that options told, where each comes from, and every command takes it.
#[test]
fn a_configuration_that_runs_comes_of_one_line() {
    let mut car = Car::german();
    car.of(Quantity::YawRate).gain = -1.0;
    let scratch = recorded(&car, DRIVE);
    let folder = scratch.path();
    let told = ["--mass", "1550+-40", "--wheelbase", "2.68", "--class", "compact"];
    let output = setup(folder, &[&["drive.log", "car.dbc", "-o", "my.toml", "--yes"][..], &told].concat());
    let text = String::from_utf8_lossy(&output.stdout).into_owned();
    assert_eq!(output.status.code(), Some(0), "{}", said(&output));
    for line in text.lines() {
        assert!(line.chars().count() <= 100, "{line}");
    }
    assert!(text.contains("gripd replay -c my.toml drive.log"), "{text}");
    assert!(text.contains("abs_active: ABS brakings"), "what is missing, and what it costs: {text}");
    let config = Config::load(&folder.join("my.toml")).unwrap();
    assert_eq!(config.signals.quantities.len(), car.lines.len());
    assert_eq!(config.signals.quantities[&Quantity::YawRate].gain, Some(-1.0));
    let vehicle = &config.vehicle;
    assert_eq!(vehicle.mass_kg, Uncertain { value: 1550.0, std: 40.0 });
    assert_eq!(vehicle.wheelbase_m, Uncertain::known(2.68));
    assert_eq!(vehicle.driven_axle, DrivenAxle::Front);
    // The true ratio is 15.5; the drive tells it.
    let ratio = vehicle.steering_ratio;
    assert!((ratio.value - 15.5).abs() < 2.0 * ratio.std && ratio.std < 1.6, "{ratio:?}");
    let written = std::fs::read_to_string(folder.join("my.toml")).unwrap();
    let line = |key: &str| written.lines().find(|line| line.starts_with(key)).unwrap().to_owned();
    assert!(line("mass_kg").contains("# told by you"), "{written}");
    assert!(line("steering_ratio").contains("# this recording"), "{written}");
    assert!(line("cg_to_front_m").contains("# class compact"), "{written}");
    assert!(written.contains("matter most"), "{written}");
    let checked = checked(folder, "my.toml", "drive.log");
    assert!(!checked.contains("CERTAIN"), "{checked}");
    for command in [
        "replay -c my.toml drive.log -o published.log --estimates estimates.csv",
        "plot -c my.toml drive.log --html drive.html",
        "explain -c my.toml drive.log --to 22 --json explained.json",
    ] {
        let mut program = gripd();
        let output = program.current_dir(folder).arg("-q").args(command.split(' ')).output().unwrap();
        assert_eq!(output.status.code(), Some(0), "{command}: {}", said(&output));
    }
}

/// GIVEN a lateral acceleration that reads half as much again and is turned, and a yaw rate that comes a quarter of a
/// second late and is off THEN all of it is put right, and nothing certain is left.
#[test]
fn what_check_is_certain_of_is_put_right() {
    let mut car = Car::german();
    car.of(Quantity::LateralAcceleration).gain = -1.0;
    let late = DRIVE.replace("offset = 0.002, delay_ms = 3.0", "offset = 0.1, delay_ms = 253.0");
    let scratch = recorded(&car, &late);
    let folder = scratch.path();
    let dbc = std::fs::read_to_string(folder.join("car.dbc")).unwrap();
    let wrong = dbc.replace("@1- (0.001,0) [0|0] \"g\"", "@1- (0.00145,0) [0|0] \"g\"");
    assert_ne!(dbc, wrong);
    std::fs::write(folder.join("car.dbc"), wrong).unwrap();
    let output = setup(folder, &["car.dbc", "drive.log", "-o", "my.toml", "--yes"]);
    let text = said(&output);
    println!("{text}");
    assert_eq!(output.status.code(), Some(0), "{text}");
    assert!(text.contains("put right") && text.contains("ms late"), "{text}");
    let config = Config::load(&folder.join("my.toml")).unwrap();
    let of = |quantity| &config.signals.quantities[&quantity];
    let lateral = of(Quantity::LateralAcceleration).gain.unwrap();
    assert!((lateral + 1.0 / 1.45).abs() < 0.08, "{lateral}");
    let yaw = of(Quantity::YawRate);
    assert!((yaw.delay_ms - 253.0).abs() < 30.0, "{}", yaw.delay_ms);
    assert!((yaw.offset + 0.1).abs() < 0.02, "{}", yaw.offset);
    let checked = checked(folder, "my.toml", "drive.log");
    assert!(!checked.contains("CERTAIN"), "{checked}");
}

/// GIVEN a signal that says "not available" in a part of the drive THEN it is taken, with its code.
#[test]
fn a_signal_that_is_there_half_of_the_time_has_its_code() {
    let scratch = recorded(&Car::german(), DRIVE);
    let folder = scratch.path();
    let log = std::fs::read_to_string(folder.join("drive.log")).unwrap();
    let mut lines = 0;
    let half: Vec<String> = log
        .lines()
        .map(|line| match line.split_once(" 140#") {
            // Bytes 2 and 3 are the brake pressure.
            Some((head, data)) if data.len() >= 8 && lines < 6000 => {
                lines += 1;
                format!("{head} 140#{}0080{}", &data[..4], &data[8..])
            }
            _ => line.to_owned(),
        })
        .collect();
    assert!(lines > 1000, "the brake's message was found");
    std::fs::write(folder.join("drive.log"), half.join("\n")).unwrap();
    let output = setup(folder, &["car.dbc", "drive.log", "-o", "my.toml", "--yes"]);
    assert_eq!(output.status.code(), Some(0), "{}", said(&output));
    let config = Config::load(&folder.join("my.toml")).unwrap();
    assert_eq!(config.signals.quantities[&Quantity::BrakePressure].not_available, [-32768]);
}

/// GIVEN no lateral acceleration THEN it says what that costs; GIVEN no yaw rate by name THEN nothing is written, until
/// its signal is named.
#[test]
fn what_is_missing_is_told_and_may_be_named() {
    let car = Car::german();
    let scratch = recorded(&car, DRIVE);
    let folder = scratch.path();
    let dbc = std::fs::read_to_string(folder.join("car.dbc")).unwrap();
    // By its name it is asked for, and not measured.
    let other = dbc.replace("Giergeschwindigkeit", "Soll_Kennfeld");
    let other = other.lines().filter(|line| !line.contains("Querbeschl")).collect::<Vec<_>>().join("\n");
    std::fs::write(folder.join("car.dbc"), other).unwrap();
    let output = setup(folder, &["car.dbc", "drive.log", "-o", "my.toml", "--yes"]);
    assert_eq!(output.status.code(), Some(1), "{}", said(&output));
    assert!(said(&output).contains("needed, so nothing is written"), "{}", said(&output));
    assert!(!folder.join("my.toml").exists());
    let named =
        ["car.dbc", "drive.log", "-o", "my.toml", "--yes", "--signal", "yaw_rate=Sensor_2.Soll_Kennfeld"];
    let output = setup(folder, &[&named[..], &["--signal", "drive_torque=none"]].concat());
    let text = said(&output);
    assert!(text.contains("lateral_acceleration: sideslip less surely"), "{text}");
    let config = Config::load(&folder.join("my.toml")).unwrap();
    assert!(config.signals.quantities.contains_key(&Quantity::YawRate));
    assert!(!config.signals.quantities.contains_key(&Quantity::DriveTorque));
    // A temperature is no pressure, whoever says so.
    let wrong = ["--force", "--signal", "brake_pressure=Antrieb_1.Temperatur"];
    let output = setup(folder, &[&named[..], &wrong].concat());
    assert_eq!(output.status.code(), Some(2), "{}", said(&output));
    assert!(said(&output).contains("brake_pressure: cannot be taken"), "{}", said(&output));
}

#[test]
fn what_is_there_is_not_overwritten_without_being_asked_to() {
    let scratch = recorded(&Car::german(), DRIVE);
    let folder = scratch.path();
    std::fs::write(folder.join("my.toml"), "# mine\n").unwrap();
    let line = ["car.dbc", "drive.log", "-o", "my.toml", "--yes"];
    let output = setup(folder, &line);
    assert_eq!(output.status.code(), Some(2));
    assert!(said(&output).contains("is not overwritten"), "{}", said(&output));
    assert_eq!(std::fs::read_to_string(folder.join("my.toml")).unwrap(), "# mine\n");
    let output = setup(folder, &[&line[..], &["--force"]].concat());
    assert_eq!(output.status.code(), Some(0), "{}", said(&output));
    assert!(Config::load(&folder.join("my.toml")).is_ok());
    // An input never is.
    let output = setup(folder, &["car.dbc", "drive.log", "-o", "drive.log", "--yes", "--force"]);
    assert_eq!(output.status.code(), Some(2), "{}", said(&output));
}

#[test]
fn what_cannot_work_is_refused_with_what_to_do() {
    let scratch = tempfile::tempdir().unwrap();
    let folder = scratch.path();
    std::fs::write(folder.join("car.dbc"), Car::german().dbc()).unwrap();
    std::fs::write(folder.join("broken.dbc"), "\u{0}\u{1}no DBC").unwrap();
    std::fs::write(folder.join("other.log"), "(1.000000) can0 7FF#00\n").unwrap();
    let refused = |arguments: &str, code: i32, words: &str| {
        let arguments: Vec<&str> = arguments.split_whitespace().collect();
        let output = setup(folder, &arguments);
        assert_eq!(output.status.code(), Some(code), "{arguments:?}: {}", said(&output));
        assert!(said(&output).contains(words), "{arguments:?}: {}", said(&output));
        assert!(!folder.join("my.toml").exists(), "{arguments:?}");
    };
    refused("car.dbc other.log -o my.toml", 2, "add --yes");
    refused("other.log -o my.toml --yes", 2, "no DBC");
    refused("car.dbc -o my.toml --yes", 2, "no recording");
    refused("car.dbc - -o my.toml --yes", 2, "cannot be read twice");
    refused("car.dbc other.log -o - --yes", 2, "file name");
    refused("car.dbc other.log -o none/my.toml --yes", 1, "is there such a folder?");
    refused("broken.dbc other.log -o my.toml --yes", 2, "broken.dbc");
    refused("none.dbc other.log -o my.toml --yes", 2, "none.dbc");
    refused("car.dbc none.log -o my.toml --yes", 1, "none.log");
    refused("car.dbc other.log -o my.toml --yes", 1, "is it the right bus");
    refused("car.dbc other.log -o my.toml --yes --mass heavy", 2, "1600+-50");
    refused("car.dbc other.log -o my.toml --yes --class lorry", 2, "compact");
    refused("car.dbc other.log -o my.toml --yes --signal yaw=A.b", 2, "there is no quantity `yaw`");
    refused("car.dbc other.log -o my.toml --yes --signal yaw_rate=A.b", 2, "A");
}

/// GIVEN a terminal WHEN the questions are answered, some of them with nothing, THEN the answers stand in the file.
#[test]
fn on_a_terminal_it_asks() {
    let scratch = recorded(&Car::german(), DRIVE);
    let folder = scratch.path();
    let line = format!("{} -q setup car.dbc drive.log -o my.toml --driven front", executable().display());
    let mut script = Command::new("script");
    script.args(["-qec", &line, "/dev/null"]).current_dir(folder).env_remove("RUST_LOG");
    let started = script.stdin(Stdio::piped()).stdout(Stdio::piped()).spawn();
    let Ok(mut started) = started else { return println!("skipped: there is no script(1) here") };
    // Class, mass, wheelbase, centre of gravity, tires.
    started.stdin.as_mut().unwrap().write_all(b"suv\n1710+-30\n\n1.2\n\n").unwrap();
    let output = started.wait_with_output().unwrap();
    let text = said(&output);
    assert_eq!(output.status.code(), Some(0), "{text}");
    assert!(text.contains("What kind of car is it") && !text.contains("Which axle"), "{text}");
    let vehicle = Config::load(&folder.join("my.toml")).unwrap().vehicle;
    assert_eq!(vehicle.mass_kg, Uncertain { value: 1710.0, std: 30.0 });
    assert_eq!(vehicle.cg_to_front_m, Uncertain::known(1.2));
    assert_eq!(vehicle.cg_height_m.value, 0.64, "that of a tall car");
}

/// The signals of a configuration: their names, and the signs that they are taken with.
fn signals(path: &Path) -> Vec<(Quantity, Option<String>, Vec<String>, bool)> {
    let config = Config::load(path).unwrap();
    let entries = config.signals.quantities.into_iter();
    entries
        .map(|(quantity, entry)| {
            let is_turned = entry.gain.is_some_and(|gain| gain < 0.0);
            (quantity, entry.signal, entry.sum.unwrap_or_default(), is_turned)
        })
        .collect()
}

/// GIVEN recordings of five real cars THEN the signals are those of the configuration that a user wrote for each, and
/// `check` is certain of nothing any more.
#[test]
fn real_cars_are_set_up_as_by_hand() {
    let Some(recordings) = testing::shared("recordings") else { return };
    let scratch = tempfile::tempdir().unwrap();
    let cars: [(&str, &str, &str, &[&str]); 8] = [
        ("tts/car.toml", "tts/aa.log.gz", "midsize", &["--wheelbase", "2.468"]),
        ("tts/car.toml", "tts/ad.log.gz", "midsize", &["--wheelbase", "2.468"]),
        ("av21/car.toml", "av21/putnam.log.gz", "race", &["--wheelbase", "2.981", "--mass", "790+-20"]),
        ("gti_payload/car.toml", "gti_payload/pid.log.gz", "compact", &[]),
        ("gti/laps.toml", "gti/dry4.log.gz", "compact", &[]),
        ("gti/drives.toml", "gti/group1controller.log.gz", "compact", &[]),
        ("gti/drives.toml", "gti/group10controller.log.gz", "compact", &[]),
        ("zoe/car.toml", "zoe/scene-0103.log.gz", "compact", &[]),
    ];
    for (number, (by_hand, log, class, options)) in cars.into_iter().enumerate() {
        let (dbc, log): (PathBuf, PathBuf) = (recordings.join("recording.dbc"), recordings.join(log));
        let (dbc, log) = (dbc.to_str().unwrap(), log.to_str().unwrap());
        let out = format!("{number}.toml");
        let line = [dbc, log, "-o", &out, "--yes", "--class", class];
        let output = setup(scratch.path(), &[&line[..], options].concat());
        assert_eq!(output.status.code(), Some(0), "{log}: {}", said(&output));
        let (own, by_hand) = (scratch.path().join(&out), recordings.join(by_hand));
        assert_eq!(signals(&own), signals(&by_hand), "{log}");
        let checked = checked(scratch.path(), &out, log);
        assert!(!checked.contains("CERTAIN"), "{log}: {checked}");
        let [own, by_hand] = [own, by_hand].map(|path| Config::load(&path).unwrap().vehicle);
        let (found, given) = (own.steering_ratio, by_hand.steering_ratio);
        let off = (found.value - given.value).abs();
        assert!(off < 2.0 * found.std.hypot(given.std), "{log}: {found:?}");
        if by_hand.driven_axle != DrivenAxle::All {
            assert_eq!(own.driven_axle, by_hand.driven_axle, "{log}");
        }
    }
}
