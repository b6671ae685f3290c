//! What several tests and benchmarks need: the program, the shared data, drives as frames, faults to put into them, and a
//! Python with the reference implementations.

#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, reason = "a test fails by panicking")]
#![allow(missing_docs, reason = "read by those who read the tests")]

pub mod allocator;
pub mod bus;
pub mod cells;
pub mod demo_car;
pub mod dice;
pub mod driven;
pub mod fault;
pub mod frames;
pub mod golden;
pub mod heard;
pub mod hostile;
pub mod package;
pub mod program;
pub mod results;
pub mod setting;
pub mod small_car;
pub mod sound;
pub mod surface;
pub mod town;
pub mod vcan;

use std::fs::{self, File};
use std::path::{Path, PathBuf};
use std::process::Command;

use program::{project, target};

/// The implementations to compare with, pinned.
const REQUIREMENTS: [&str; 3] = ["cantools==45.1.0", "autosar-e2e==1.0.0", "py-expression-eval==0.3.14"];
/// Those that write recordings and read tables.
const PEERS: [&str; 5] =
    ["python-can==4.6.1", "asammdf==8.8.28", "polars==2.1.0", "mcap==1.6.0", "mcap-protobuf-support==0.6.0"];

/// Those that decode.
const DECODERS: [&str; 2] = ["cantools==45.1.0", "opendbc==0.3.1"];

/// A file or folder of the shared data; `None`, with a printed message, where it is not there.
pub fn shared(path: &str) -> Option<PathBuf> {
    let root = std::env::var_os("GRIPD_SHARED").map_or_else(|| project("../shared"), PathBuf::from);
    let found = root.join(path);
    if found.exists() {
        return Some(found);
    }
    eprintln!("skipped: no {} (set GRIPD_SHARED)", found.display());
    None
}

/// The recordings in a folder, by name.
pub fn recordings_in(folder: &Path) -> Vec<PathBuf> {
    let mut logs: Vec<PathBuf> =
        std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()).collect();
    logs.retain(|log| log.to_string_lossy().ends_with(".log.gz"));
    logs.sort();
    logs
}

/// A file of `tests/data`.
pub fn data(name: &str) -> PathBuf {
    project("tests/data").join(name)
}

/// A Python that has the reference implementations, in a virtual environment below `target`;
/// `None`, with a printed message, where it cannot be had.
pub fn python() -> Option<PathBuf> {
    environment("reference-venv", &REQUIREMENTS)
}

/// Another one that has python-can with MF4, and polars.
pub fn peers() -> Option<PathBuf> {
    environment("peers-venv", &PEERS)
}

/// Another one that runs FMUs.
pub fn fmpy() -> Option<PathBuf> {
    environment("fmpy-venv", &["fmpy==0.3.32"])
}

/// Another one for comparing speeds.
pub fn decoders() -> Option<PathBuf> {
    environment("decoders-venv", &DECODERS)
}

fn environment(name: &str, requirements: &[&str]) -> Option<PathBuf> {
    let folder = target("tmp").join(name);
    let python = folder.join("bin/python");
    // Several tests may come here at once.
    let lock = File::create(folder.with_extension("lock")).unwrap();
    lock.lock().unwrap();
    let ready = folder.join(format!("ready-{}", requirements.join("-")));
    if ready.exists() {
        return Some(python);
    }
    // A guest of the tests on vcan0 does not see the lock, and has no network: it must not clear what others make. So it
    // is made aside, and gets its name when it is complete.
    let aside = folder.with_extension(format!("made-by-{}", std::process::id()));
    let made = run(Command::new("python3").args(["-m", "venv", "--clear"]).arg(&aside))
        && run(Command::new(aside.join("bin/python"))
            .args(["-m", "pip", "install", "--quiet"])
            .args(requirements))
        && File::create(aside.join(ready.file_name()?)).is_ok();
    let is_there = made && {
        let _ = fs::remove_dir_all(&folder);
        fs::rename(&aside, &folder).is_ok()
    };
    if !is_there {
        let _ = fs::remove_dir_all(&aside);
        eprintln!("skipped: no Python with {}", requirements.join(" and "));
        return None;
    }
    Some(python)
}

/// The reference script, run by that Python.
pub fn reference(python: &Path) -> Command {
    let mut command = Command::new(python);
    command.arg(project("tests/peers/cantools_reference.py"));
    command
}

fn run(command: &mut Command) -> bool {
    match command.output() {
        Ok(output) if output.status.success() => true,
        Ok(output) => {
            eprintln!("{command:?} failed: {}", String::from_utf8_lossy(&output.stderr));
            false
        }
        Err(error) => {
            eprintln!("{command:?} cannot be run: {error}");
            false
        }
    }
}
