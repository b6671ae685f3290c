//! The program under test, and the files of the project.

#![allow(dead_code, reason = "each test binary uses a part of it")]

use std::path::{Path, PathBuf};
use std::process::{Command, Output};

/// A file of the project.
pub fn project(path: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join(path)
}

/// `gripd`, which logs as it does without being told otherwise.
pub fn gripd() -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_gripd"));
    command.env_remove("RUST_LOG");
    command
}

/// `gripd` in a folder, until it ends.
pub fn gripd_in(folder: &Path, arguments: &str) -> Output {
    gripd().current_dir(folder).args(arguments.split_whitespace()).output().unwrap()
}
