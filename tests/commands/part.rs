//! `--from` and `--to` of all commands on recordings.

use std::path::Path;
use std::process::Output;

use gripd::can::recording::Reader;
use testing::program::{gripd, project};

/// A command in this folder.
fn run(folder: &Path, arguments: &[&str]) -> Output {
    gripd().current_dir(folder).args(arguments).output().unwrap()
}

/// Times of a recording's first and last frame, s.
fn ends(path: &Path) -> [f64; 2] {
    let mut reader = Reader::open(path).unwrap();
    let times: Vec<f64> =
        std::iter::from_fn(|| reader.next_frame().unwrap()).map(|frame| frame.time.seconds()).collect();
    [times[0], times[times.len() - 1]]
}

/// GIVEN a recording WHEN a part is asked for THEN every command takes that part and no more, counted from the recording's
/// first frame; nonsense is refused, and a part beyond the end is told.
#[test]
fn a_part_is_all_that_is_taken() {
    let scratch = tempfile::tempdir().unwrap();
    let folder = scratch.path();
    let demo = std::fs::read_to_string(project("config/scenarios/demo.toml")).unwrap();
    std::fs::write(folder.join("scenario.toml"), demo.replace("duration_s = 120.0", "duration_s = 20.0"))
        .unwrap();
    assert!(run(folder, &["-q", "simulate", "scenario.toml", "-o", "drive.log"]).status.success());
    let [start, end] = ends(&folder.join("drive.log"));
    let part = ["convert", "drive.log", "-o", "part.log", "--from", "4", "--to", "9.5"];
    assert!(run(folder, &part).status.success());
    let [first, last] = ends(&folder.join("part.log"));
    assert!((first - start - 4.0).abs() < 0.02 && (last - start - 9.5).abs() < 0.02, "{first} to {last}");

    let config = project("config/demo.toml");
    let config = config.to_str().unwrap();
    let replay = ["-q", "replay", "-c", config, "drive.log", "--from", "15", "--samples", "samples.csv"];
    assert!(run(folder, &replay).status.success());
    let samples = std::fs::read_to_string(folder.join("samples.csv")).unwrap();
    let time = |line: &str| line.split(',').next().unwrap().parse::<f64>().unwrap();
    let times: Vec<f64> = samples.lines().skip(1).map(time).collect();
    assert!(times[0] - start > 14.9 && end - times[times.len() - 1] < 0.2, "{} of {start}", times[0]);

    let output = run(folder, &["check", "-c", config, "drive.log", "--from", "5", "--to", "2"]);
    assert_eq!(output.status.code(), Some(2));
    assert!(String::from_utf8_lossy(&output.stderr).contains("--to 2"), "{output:?}");
    let output = run(folder, &["identify", "-c", config, "drive.log", "--from", "50"]);
    assert_eq!(output.status.code(), Some(1));
    assert!(String::from_utf8_lossy(&output.stderr).contains("it ends after 20.0 s"), "{output:?}");
}
