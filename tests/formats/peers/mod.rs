//! Beside the tools that people use: GIVEN files written by python-can and asammdf WHEN gripd reads them THEN they say what
//! their candump twin says, and they what gripd wrote; GIVEN tables written by gripd WHEN polars reads them THEN they say what the CSV twins say.
//! Skipped, with a message, where the Python packages cannot be had.

mod fmus;
mod package;
mod written;

use std::fs;
use std::path::Path;
use std::process::{Command, Output};

use gripd::Micros;
use gripd::can::candump::{self, Writer};
use gripd::can::recording::Reader;
use gripd::can::{CanId, Frame, FrameKind};
use testing::program::{gripd, project};

/// 9 October 2025, 08:53:20: on a whole millisecond, which is all that ASC and BLF have of a start.
const START: Micros = Micros(1_760_000_000_000_000);

#[track_caller]
fn succeed(command: &mut Command) -> Output {
    let output = command.output().unwrap();
    assert!(output.status.success(), "{command:?}: {}", String::from_utf8_lossy(&output.stderr));
    output
}

/// So many seconds of the demo drive, as frames from [`START`] on.
fn drive(folder: &Path, seconds: u32) -> Vec<Frame> {
    let scenario = fs::read_to_string(project("config/scenarios/demo.toml")).unwrap();
    let (path, log) = (folder.join("drive.toml"), folder.join("simulated.log"));
    fs::write(&path, scenario.replace("duration_s = 120.0", &format!("duration_s = {seconds}.0"))).unwrap();
    succeed(gripd().arg("simulate").arg(path).arg("-o").arg(&log));
    let mut reader = candump::Reader::open(&log).unwrap();
    let mut frames = Vec::new();
    while let Some(mut frame) = reader.next_frame().unwrap() {
        frame.time = frame.time + START;
        frames.push(frame);
    }
    // The first stamp is what those formats call the start.
    frames[0].time = START;
    frames
}

fn write(path: &Path, frames: &[(&str, Frame)]) {
    let mut writer = Writer::create(path, "can0").unwrap();
    frames.iter().for_each(|(interface, frame)| writer.write_as(interface, frame).unwrap());
    writer.finish().unwrap();
}

/// The files that python-can makes of a log.
fn twins(python: &Path, log: &Path, folder: &Path) -> Vec<String> {
    let output = succeed(Command::new(python).arg(project("tests/peers/recordings.py")).arg(log).arg(folder));
    let names: Vec<String> = String::from_utf8(output.stdout).unwrap().lines().map(str::to_owned).collect();
    assert_eq!(names.len(), 9, "{names:?}");
    names
}

fn samples(log: &Path) -> String {
    let table = log.with_extension("samples.csv");
    succeed(
        gripd()
            .args(["replay", "-q", "-c"])
            .arg(project("config/demo.toml"))
            .arg(log)
            .arg("--samples")
            .arg(&table),
    );
    fs::read_to_string(table).unwrap()
}

#[test]
#[ignore = "long: fetches python-can, asammdf and polars"]
fn every_format_gives_the_same_samples_as_its_candump_twin() {
    let Some(python) = testing::peers() else { return };
    let folder = tempfile::tempdir().unwrap();
    let frames: Vec<_> = drive(folder.path(), 20).into_iter().map(|frame| ("can0", frame)).collect();
    let log = folder.path().join("drive.log");
    write(&log, &frames);
    let expected = samples(&log);
    assert!(expected.lines().count() > 1990 && !expected.contains(",,,,,"), "{}", &expected[..500]);
    for name in twins(&python, &log, folder.path()) {
        let twin = samples(&folder.path().join(&name));
        assert!(twin == expected, "{name}: {:?}", twin.lines().zip(expected.lines()).find(|(a, b)| a != b));
        println!("{name}: the same {} samples", twin.lines().count() - 1);
    }
}

/// Frames of all kinds on three buses.
fn hard() -> Vec<(&'static str, Frame)> {
    let (standard, extended) = (CanId::standard(0x7FF).unwrap(), CanId::extended(0x123).unwrap());
    let fd = |bit_rate_switch, error_state| FrameKind::Fd { bit_rate_switch, error_state };
    let at = |us| START + Micros(us);
    let new = |us, id, kind, data: &[u8]| Frame::new(at(us), id, kind, data).unwrap();
    let mut frames = vec![("can0", new(0, standard, FrameKind::Data, &[]))];
    for n in 0..3000 {
        let interface = ["can0", "can1", "can2"][n % 3];
        let time = 1 + 977 * n as i64;
        let bytes = [n as u8; 64];
        frames.push((interface, new(time, standard, FrameKind::Data, &bytes[..n % 9])));
        frames.push((interface, new(time + 13, extended, FrameKind::Data, &bytes[..8])));
        let length = [12, 16, 20, 24, 32, 48, 64][n % 7];
        frames.push((interface, new(time + 101, extended, fd(n % 2 == 0, n % 3 == 0), &bytes[..length])));
        frames.push((interface, Frame::remote(at(time + 200), standard, n % 9).unwrap()));
    }
    frames.push(("can0", new(4_000_000, CanId::extended(0x80).unwrap(), FrameKind::Error, &[])));
    frames
}

#[test]
#[ignore = "long: fetches python-can, asammdf and polars"]
fn frames_of_every_kind_survive_as_far_as_the_format_has_them() {
    let Some(python) = testing::peers() else { return };
    let folder = tempfile::tempdir().unwrap();
    let (log, hard) = (folder.path().join("hard.log"), hard());
    write(&log, &hard);
    for name in twins(&python, &log, folder.path()) {
        let mut expected: Vec<(String, Frame)> =
            hard.iter().map(|(i, frame)| ((*i).to_owned(), *frame)).collect();
        match name.as_str() {
            // One bus, no flags; what has more than 8 bytes is FD.
            "python.csv" => {
                for (interface, frame) in &mut expected {
                    *interface = "can0".into();
                    if let FrameKind::Fd { bit_rate_switch, error_state } = &mut frame.kind {
                        (*bit_rate_switch, *error_state) = (false, false);
                    }
                }
            }
            "python.trc" => expected.retain(|(_, frame)| frame.kind == FrameKind::Data),
            // It leaves the length of remote requests out, and gives errors to no bus of the log.
            "python.log" => {
                for (interface, frame) in &mut expected {
                    match frame.kind {
                        FrameKind::Remote => *frame = Frame::remote(frame.time, frame.id, 0).unwrap(),
                        FrameKind::Error => *interface = "vcan0".into(),
                        _ => {}
                    }
                }
            }
            _ => {}
        }
        let mut reader = Reader::open(&folder.path().join(&name)).unwrap();
        let mut read = Vec::new();
        while let Some(frame) = reader.next_frame().unwrap() {
            read.push((reader.interface().to_owned(), frame));
        }
        assert_eq!(reader.stats().skipped_lines, 0, "{name}: {:?}", reader.stats());
        assert_eq!(read.len(), expected.len(), "{name}");
        let different = read.iter().zip(&expected).find(|(read, expected)| read != expected);
        assert!(different.is_none(), "{name}: {different:?}");
        println!("{name}: {} frames", read.len());
    }
}

#[test]
#[ignore = "long: fetches python-can, asammdf, polars and mcap"]
fn tables_are_the_same_in_parquet_and_mcap_as_in_csv() {
    let Some(python) = testing::peers() else { return };
    let folder = tempfile::tempdir().unwrap();
    let frames: Vec<_> = drive(folder.path(), 60).into_iter().map(|frame| ("can0", frame)).collect();
    let log = folder.path().join("drive.log");
    write(&log, &frames);
    for extension in ["csv", "parquet", "mcap"] {
        let [estimates, samples] =
            ["estimates", "samples"].map(|name| folder.path().join(name).with_extension(extension));
        let mut replay = gripd();
        replay.args(["replay", "-q", "-c"]).arg(project("config/demo.toml")).arg(&log);
        succeed(replay.arg("--estimates").arg(estimates).arg("--samples").arg(samples));
    }
    let tables = ["estimates.parquet", "samples.parquet", "estimates.mcap", "samples.mcap"];
    let tables = tables.map(|name| folder.path().join(name));
    let told = succeed(Command::new(&python).arg(project("tests/peers/tables.py")).args(tables)).stdout;
    let told = String::from_utf8(told).unwrap();
    let version = env!("CARGO_PKG_VERSION");
    let lines: Vec<&str> = told.lines().collect();
    assert!(lines[0].starts_with("estimates 59") || lines[0].starts_with("estimates 60"), "{told}");
    assert!(lines[0].ends_with(&format!("{version} s Boolean Float64 Int64 String")), "{told}");
    assert!(lines[1].starts_with("samples ") && lines[1].ends_with(" Float64"), "{told}");
    let row = |line: &str| line.split(' ').take(2).map(str::to_owned).collect::<Vec<_>>();
    assert_eq!((row(lines[2]), row(lines[3])), (row(lines[0]), row(lines[1])), "{told}");
}

/// A hundredth of a fleet, as the guide's example has it.
#[test]
#[ignore = "long: fetches python-can, asammdf and polars"]
fn a_fleet_is_worked_through_by_polars() {
    let Some(python) = testing::peers() else { return };
    let folder = tempfile::tempdir().unwrap();
    let drives = folder.path().join("drives");
    fs::create_dir(&drives).unwrap();
    let script = project("tests/peers/fleet.sh");
    succeed(Command::new("sh").arg(script).arg(env!("CARGO_BIN_EXE_gripd")).arg("10").arg(&drives));
    let told = succeed(Command::new(&python).arg(project("tests/peers/fleet.py")).arg(&drives)).stdout;
    let told = String::from_utf8(told).unwrap();
    let mut lines = told.lines();
    assert_eq!(lines.next(), Some("rows,drives"), "{told}");
    let rows = lines.next().unwrap();
    assert!(
        rows.ends_with(",10") && rows.split(',').next().unwrap().parse::<u32>().unwrap() > 50_000,
        "{told}"
    );
    // Every drive has a slope that is valid, near what the scenario's tires have.
    let last: Vec<f64> = lines.last().unwrap().split(',').map(|number| number.parse().unwrap()).collect();
    assert!(last[0] == 10.0 && (15.0..60.0).contains(&last[2]), "{told}");
}
