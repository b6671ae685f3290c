//! What becomes of results: complete under their name or not there at all, whatever ends the program, and what cannot be
//! written is said before the work.

use std::fs;
use std::os::unix::process::ExitStatusExt;
use std::path::Path;
use std::process::{Output, Stdio};
use std::time::{Duration, Instant};

use nix::sys::signal::{Signal, kill};
use nix::unistd::Pid;
use testing::program::{gripd, gripd_in, project};

fn complaint(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

/// The demo's drive, but an hour of it: nothing ends it before a signal does.
fn long_drive(folder: &Path) {
    let scenario = fs::read_to_string(project("config/scenarios/demo.toml")).unwrap();
    let long = scenario.replace("duration_s = 120.0", "duration_s = 3600.0");
    assert_ne!(long, scenario);
    fs::write(folder.join("drive.toml"), long).unwrap();
}

fn names(folder: &Path) -> Vec<String> {
    let mut names: Vec<String> = fs::read_dir(folder)
        .unwrap()
        .map(|entry| entry.unwrap().file_name().into_string().unwrap())
        .collect();
    names.sort();
    names
}

/// Does this process, and so what it starts, ignore a signal?
fn is_ignored(signal: Signal) -> bool {
    let status = fs::read_to_string("/proc/self/status").unwrap();
    let ignored = status.lines().find_map(|line| line.strip_prefix("SigIgn:")).unwrap();
    u64::from_str_radix(ignored.trim(), 16).unwrap() >> (signal as i32 - 1) & 1 == 1
}

#[test]
fn a_signal_leaves_the_old_results_and_nothing_half_written() {
    for signal in [Signal::SIGINT, Signal::SIGTERM] {
        if is_ignored(signal) {
            println!("skipped: {signal} is ignored here, as in the background of a shell");
            continue;
        }
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path();
        long_drive(path);
        fs::write(path.join("drive.log"), "old").unwrap();
        let mut command = gripd();
        command.args(["simulate", "drive.toml", "-o", "drive.log", "--truth", "truth.csv"]);
        let mut child = command.current_dir(path).stderr(Stdio::null()).spawn().unwrap();
        let began = Instant::now();
        while names(path).iter().filter(|name| name.ends_with(".part")).count() < 2 {
            assert!(began.elapsed() < Duration::from_secs(60) && child.try_wait().unwrap().is_none());
            std::thread::sleep(Duration::from_millis(5));
        }
        kill(Pid::from_raw(child.id().cast_signed()), signal).unwrap();
        let status = child.wait().unwrap();
        assert_eq!(status.signal(), Some(signal as i32), "{status}");
        assert_eq!(names(path), ["drive.log", "drive.toml"]);
        assert_eq!(fs::read_to_string(path.join("drive.log")).unwrap(), "old");
    }
}

#[test]
fn a_signal_that_is_to_be_ignored_is() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    long_drive(path);
    let mut command = std::process::Command::new("sh");
    command.args(["-c", "trap '' HUP; exec \"$0\" \"$@\"", env!("CARGO_BIN_EXE_gripd")]);
    command.args(["simulate", "drive.toml", "-o", "drive.log"]).current_dir(path).stderr(Stdio::null());
    let mut child = command.spawn().unwrap();
    let began = Instant::now();
    while !names(path).iter().any(|name| name.ends_with(".part")) {
        assert!(began.elapsed() < Duration::from_secs(60) && child.try_wait().unwrap().is_none());
        std::thread::sleep(Duration::from_millis(5));
    }
    let pid = Pid::from_raw(child.id().cast_signed());
    kill(pid, Signal::SIGHUP).unwrap();
    std::thread::sleep(Duration::from_millis(300));
    assert!(child.try_wait().unwrap().is_none(), "it goes on");
    kill(pid, Signal::SIGTERM).unwrap();
    assert_eq!(child.wait().unwrap().signal(), Some(Signal::SIGTERM as i32));
    assert_eq!(names(path), ["drive.toml"]);
}

#[test]
fn what_cannot_be_written_is_said_before_the_work() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    let short = fs::read_to_string(project("config/scenarios/demo.toml"))
        .unwrap()
        .replace("duration_s = 120.0", "duration_s = 10.0");
    fs::write(path.join("drive.toml"), short).unwrap();
    assert!(gripd_in(path, "simulate drive.toml -o drive.log").status.success());
    let car = project("config/demo.toml");
    for (command, option) in
        [("explain", "--json"), ("explain", "--html"), ("identify", "--html"), ("check", "--json")]
    {
        let output = gripd_in(path, &format!("{command} -c {} drive.log {option} no/x", car.display()));
        let said = complaint(&output);
        assert_eq!(output.status.code(), Some(1), "{command} {option}: {said}");
        assert!(said.contains("cannot write no/x") && said.contains("such a folder?"), "{said}");
        assert!(output.stdout.is_empty(), "{command} {option}: nothing was done");
    }
    assert_eq!(names(path), ["drive.log", "drive.toml"]);
}

#[test]
fn tables_are_not_what_their_name_does_not_say() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    fs::copy(project("config/scenarios/demo.toml"), path.join("drive.toml")).unwrap();
    fs::write(path.join("drive.log"), "(1.0) can0 123#00\n").unwrap();
    let car = project("config/demo.toml");
    for arguments in [
        format!("replay -c {} drive.log --estimates e.csv.gz", car.display()),
        format!("replay -c {} drive.log --samples s.parquet.zst", car.display()),
        "simulate drive.toml -o x.log --truth t.parquet".to_owned(),
        "simulate drive.toml -o x.log --truth t.csv.gz".to_owned(),
    ] {
        let output = gripd_in(path, &arguments);
        assert_eq!(output.status.code(), Some(2), "{arguments}: {}", complaint(&output));
        assert!(
            complaint(&output).contains(arguments.split(' ').next_back().unwrap()),
            "{}",
            complaint(&output)
        );
    }
    assert_eq!(names(path), ["drive.log", "drive.toml"]);
}

#[test]
fn a_reader_that_goes_away_ends_the_simulation() {
    let folder = tempfile::tempdir().unwrap();
    long_drive(folder.path());
    let mut command = gripd();
    command.args(["simulate", "drive.toml", "-o", "-"]).current_dir(folder.path());
    let mut child = command.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
    drop(child.stdout.take());
    let output = child.wait_with_output().unwrap();
    assert_eq!(output.status.code(), Some(0), "{}", complaint(&output));
    assert!(!complaint(&output).contains("pipe"), "{}", complaint(&output));
}

#[test]
fn a_full_disk_is_named() {
    let folder = tempfile::tempdir().unwrap();
    let car = project("config/demo.toml");
    let mut command = gripd();
    command.args(["check", "-c"]).arg(car).current_dir(folder.path());
    let full = fs::OpenOptions::new().write(true).open("/dev/full").unwrap();
    let output = command.stdout(full).output().unwrap();
    assert_eq!(output.status.code(), Some(1));
    assert!(complaint(&output).contains("cannot write to the standard output"), "{}", complaint(&output));
}
