//! `--from` and `--to` of all commands on recordings.

use std::path::Path;
use std::process::Output;

use gripd::Micros;
use gripd::can::recording::Reader;
use gripd::time::Clock;
use testing::program::{gripd, project};

use super::changed::plain_demo;

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
    assert!(String::from_utf8_lossy(&output.stderr).contains("drive.log is of 0.0 to 20.0 s"), "{output:?}");
}

/// GIVEN a part that is beyond the end, or one in which the car is hardly driven THEN check tells the recording's span and nothing
/// of signals, and `explain --apply` writes nothing and says why.
#[test]
fn of_a_part_that_tells_nothing_nothing_is_made() {
    let scratch = tempfile::tempdir().unwrap();
    let folder = scratch.path();
    let demo = std::fs::read_to_string(project("config/scenarios/demo.toml")).unwrap();
    std::fs::write(folder.join("scenario.toml"), demo.replace("duration_s = 120.0", "duration_s = 20.0"))
        .unwrap();
    assert!(run(folder, &["-q", "simulate", "scenario.toml", "-o", "drive.log"]).status.success());
    let config = project("config/demo.toml");
    let config = config.to_str().unwrap();

    let output = run(folder, &["check", "-c", config, "drive.log", "--from", "1000"]);
    let said = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(1), "{said}");
    assert!(said.contains("drive.log is of 0.0 to 20.0 s") && !said.contains("signals."), "{said}");

    let explain =
        ["explain", "-c", config, "drive.log", "--to", "4", "--json", "a.json", "--apply", "new.toml"];
    let output = run(folder, &explain);
    let said = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(1), "{said}");
    assert!(said.contains("--apply has nothing to write to new.toml"), "{said}");
    assert!(said.contains("insufficient_excitation"), "{said}");
    assert!(!folder.join("new.toml").exists() && folder.join("a.json").exists());
}

/// GIVEN a recording whose stamps are dates WHEN a part is asked for by the date THEN it is the part that seconds give; what
/// is no moment, and what is on another day, is told with the recording's span; and every answer has both clocks.
#[test]
fn either_clock_tells_a_part_and_a_moment() {
    let scratch = tempfile::tempdir().unwrap();
    let folder = scratch.path();
    std::fs::write(folder.join("scenario.toml"), plain_demo(20.0)).unwrap();
    assert!(run(folder, &["-q", "simulate", "scenario.toml", "-o", "undated.log"]).status.success());
    let undated = std::fs::read_to_string(folder.join("undated.log")).unwrap();
    let dated = |line: &str| {
        let (time, frame) = line[1..].split_once(')').unwrap();
        format!("({:.6}){frame}\n", 1.76e9 + time.parse::<f64>().unwrap())
    };
    std::fs::write(folder.join("drive.log"), undated.lines().map(dated).collect::<String>()).unwrap();
    let [start, _] = ends(&folder.join("drive.log"));
    let utc = |seconds: f64| Clock::of(Micros::from_seconds(start)).utc(seconds).unwrap();
    let (from, to) = (utc(4.0), utc(9.5));
    for (name, ends) in [("seconds.log", ["4", "9.5"]), ("dates.log", [from.as_str(), to.as_str()])] {
        let part = ["convert", "drive.log", "-o", name, "--from", ends[0], "--to", ends[1]];
        assert!(run(folder, &part).status.success());
    }
    let frames = |name: &str| std::fs::read_to_string(folder.join(name)).unwrap();
    assert_eq!(frames("seconds.log").lines().count(), frames("dates.log").lines().count());

    let config = project("config/demo.toml");
    let config = config.to_str().unwrap();
    let span = format!("drive.log is of 0.0 to 20.0 s ({}", utc(0.0));
    let refused = |command: &[&str], code: i32, words: &str| {
        let output = run(folder, command);
        let told = String::from_utf8_lossy(&output.stderr).into_owned();
        assert_eq!(output.status.code(), Some(code), "{told}");
        assert!(told.contains(words) && told.contains(&span), "{told}");
    };
    refused(&["check", "-c", config, "drive.log", "--from", "soon"], 2, "--from soon: is neither seconds");
    refused(
        &["plot", "-c", config, "drive.log", "--html", "x.html", "--to", "2025-13-01T00:00Z"],
        2,
        "--to 2025-13",
    );
    refused(
        &["replay", "-c", config, "drive.log", "--from", &to, "--to", &from],
        2,
        "must be more than --from",
    );
    refused(&["explain", "-c", config, "drive.log", "--to", "2001-01-01T00:00:00Z"], 1, "nothing is between");

    let json = |command: &[&str]| -> serde_json::Value {
        let output = run(folder, &[command, &["-q", "-c", config, "drive.log", "--json", "-"]].concat());
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        serde_json::from_slice(&output.stdout).unwrap()
    };
    let checked = json(&["check"]);
    assert_eq!(checked["recordings"]["files"][0]["begins_utc"], utc(0.0));
    let yaw_rate = checked["recordings"]["quantities"].as_array().unwrap();
    let gap = yaw_rate.iter().find(|it| it["quantity"] == "yaw_rate").unwrap();
    assert_eq!(gap["longest_gap_at_utc"], utc(gap["longest_gap_at_s"].as_f64().unwrap()));
    let explained = json(&["explain", "--from", &utc(1.0)]);
    assert_eq!(explained["begins_utc"]["drive.log"], utc(0.0), "counted from the recording's start");
    let block = &explained["split"][0];
    assert_eq!(block["t_utc"][0], utc(block["t"][0].as_f64().unwrap()));
    let identified = json(&["identify", "--starts", "1", "--parameters", "steering_ratio"]);
    assert_eq!(identified["recordings"][0]["begins_utc"], utc(0.0));
}
