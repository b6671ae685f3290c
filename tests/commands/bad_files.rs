//! Files that are none, names that steer a terminal, and what a state file is to forget.

use std::fs;
use std::os::unix::fs::PermissionsExt;
use std::path::Path;
use std::process::{Command, Output};
use std::time::{Duration, Instant};

use testing::program::{gripd, project};

/// The demo car in a folder of its own, with an edit of its configuration and one of its DBC.
fn car(
    folder: &Path,
    config: impl FnOnce(String) -> String,
    dbc: impl FnOnce(String) -> String,
) -> std::path::PathBuf {
    let text = fs::read_to_string(project("config/demo.toml")).unwrap();
    let path = folder.join("car.toml");
    fs::write(&path, config(text.replace("../dbc/demo.dbc", "car.dbc"))).unwrap();
    fs::write(folder.join("car.dbc"), dbc(fs::read_to_string(project("dbc/demo.dbc")).unwrap())).unwrap();
    path
}

fn check(config: &Path) -> Output {
    gripd().arg("check").arg("-c").arg(config).output().unwrap()
}

#[test]
fn a_pipe_is_no_configuration_and_no_dbc() {
    let folder = tempfile::tempdir().unwrap();
    let pipe = folder.path().join("pipe");
    assert!(Command::new("mkfifo").arg(&pipe).status().unwrap().success());
    let begun = Instant::now();
    let refused = check(&pipe);
    let said = String::from_utf8_lossy(&refused.stderr).into_owned();
    assert_eq!(refused.status.code(), Some(2), "{said}");
    assert!(said.contains("not an ordinary file"), "{said}");
    let config = car(folder.path(), |text| text.replace("car.dbc", "pipe"), |dbc| dbc);
    let refused = check(&config);
    let said = String::from_utf8_lossy(&refused.stderr).into_owned();
    assert!(!refused.status.success() && said.contains("not an ordinary file"), "{said}");
    assert!(begun.elapsed() < Duration::from_secs(10), "{:?}", begun.elapsed());
}

#[test]
fn what_others_have_named_does_not_steer_the_terminal() {
    let folder = tempfile::tempdir().unwrap();
    let steers = |text: &[u8]| text.iter().any(|byte| (*byte < b' ' && *byte != b'\n') || *byte == 0x7F);
    // In the DBC's units and names of values, in the interface's name, in a file's name.
    let folder = folder.path().join("a\u{1b}[2Jcar");
    fs::create_dir(&folder).unwrap();
    let config = car(
        &folder,
        |text| text.replace("\"vcan0\"", "\"v\\u001b[31m0\""),
        |dbc| dbc.replace("\"deg/s\"", "\"\u{1b}[31mdeg/s\"").replace("\"m/s2\"", "\"\u{1b}]0;x\u{7}m/s2\""),
    );
    let output = check(&config);
    assert!(!steers(&output.stdout), "{}", String::from_utf8_lossy(&output.stdout));
    assert!(!steers(&output.stderr), "{}", String::from_utf8_lossy(&output.stderr));
    let all = [output.stdout, output.stderr].concat();
    assert!(String::from_utf8_lossy(&all).contains("\\u{1b}["), "{}", String::from_utf8_lossy(&all));
    // Where the configuration is usable, too.
    let config = car(&folder, |text| text.replace("\"vcan0\"", "\"v\\u001b[31m0\""), |dbc| dbc);
    let output = check(&config);
    assert!(!steers(&output.stdout) && !steers(&output.stderr));
}

/// A drive's state, and what is in it.
fn learned(folder: &Path) -> std::path::PathBuf {
    let (drive, state) = (folder.join("drive.log"), folder.join("learned.toml"));
    let scenario = project("config/scenarios/demo.toml");
    assert!(gripd().args(["-q", "simulate"]).arg(scenario).arg("-o").arg(&drive).status().unwrap().success());
    let mut replay = gripd();
    replay
        .args(["-q", "replay", "-c"])
        .arg(project("config/demo.toml"))
        .arg(&drive)
        .arg("--state")
        .arg(&state);
    assert!(replay.status().unwrap().success());
    state
}

fn forget(state: &Path, parts: &[&str]) -> Output {
    let mut forget = gripd();
    forget.arg("forget").arg(state);
    for part in parts {
        forget.args(["--part", part]);
    }
    forget.output().unwrap()
}

#[test]
fn a_state_file_forgets_wholly_or_a_part() {
    let folder = tempfile::tempdir().unwrap();
    let state = learned(folder.path());
    assert_eq!(fs::metadata(&state).unwrap().permissions().mode() & 0o777, 0o600);
    let text = || fs::read_to_string(&state).unwrap();
    let has = |what: &str| text().contains(what);
    let (slopes, offsets) = ("[slip_slope.", "[yaw_rate_offset_rad_per_s]");
    assert!(has(slopes) && has("[slip_offset.") && has(offsets), "{}", text());
    let driving = text().lines().find(|line| line.starts_with("driving_s")).unwrap().to_owned();
    assert!(forget(&state, &["tires"]).status.success());
    assert!(!has(slopes) && !has("[cornering_stiffness_per_rad.f") && has("[slip_offset.") && has(offsets));
    assert!(forget(&state, &["radii"]).status.success());
    assert!(!has("[slip_offset.") && has(offsets) && has(&driving), "{}", text());
    // What is left is still a state, and of this car.
    let mut replay = gripd();
    replay.args(["-q", "replay", "-c"]).arg(project("config/demo.toml"));
    replay.arg(folder.path().join("drive.log")).arg("--state").arg(&state);
    assert!(replay.status().unwrap().success());
    assert!(has(slopes));
    assert!(forget(&state, &[]).status.success());
    assert!(!has(slopes) && !has("[slip_offset.") && !has(offsets));
    fs::write(&state, "something else").unwrap();
    let refused = forget(&state, &[]);
    assert_eq!(refused.status.code(), Some(2), "{}", String::from_utf8_lossy(&refused.stderr));
    assert_eq!(text(), "something else");
}

/// States of the versions that were released: read, or refused with the reason. One file for each release.
#[test]
fn states_of_every_release() {
    let folder = tempfile::tempdir().unwrap();
    let kept = project("tests/data/state/0.1.0.toml");
    let state = folder.path().join("learned.toml");
    fs::copy(&kept, &state).unwrap();
    let output = forget(&state, &["offsets"]);
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let (before, after) = (fs::read_to_string(kept).unwrap(), fs::read_to_string(&state).unwrap());
    for line in
        before.lines().filter(|line| ["version", "vehicle", "driving_s"].iter().any(|k| line.starts_with(k)))
    {
        assert!(after.contains(line), "{line}");
    }
    // A later version's: that is what is said, whatever else is in it.
    let (_, contents) = before.split_once('\n').unwrap();
    let contents = contents.replace("version = 1", "version = 2");
    let mut crc = flate2::Crc::new();
    crc.update(contents.as_bytes());
    fs::write(&state, format!("checksum = \"{:08x}\"\n{contents}", crc.sum())).unwrap();
    let refused = forget(&state, &[]);
    let said = String::from_utf8_lossy(&refused.stderr).into_owned();
    assert!(refused.status.code() == Some(2) && said.contains("has version 2"), "{said}");
}
