//! The program under test, and the files of the project.

use std::path::{Path, PathBuf};
use std::process::{Command, Output};

/// A file of the project.
pub fn project(path: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..").components().collect::<PathBuf>().join(path)
}

/// The program, built in the same profile as this test or benchmark, beside whose folder it lies.
pub fn executable() -> PathBuf {
    let myself = std::env::current_exe().unwrap();
    myself.parent().unwrap().with_file_name("gripd")
}

/// A folder of cargo's target folder, which is made where it is not there.
pub fn target(name: &str) -> PathBuf {
    let folder = executable().parent().unwrap().with_file_name(name);
    std::fs::create_dir_all(&folder).unwrap();
    folder
}

/// `gripd`, which logs as it does without being told otherwise.
pub fn gripd() -> Command {
    let mut command = Command::new(executable());
    command.env_remove("RUST_LOG");
    command
}

/// `gripd` in a folder, until it ends.
pub fn gripd_in(folder: &Path, arguments: &str) -> Output {
    gripd().current_dir(folder).args(arguments.split_whitespace()).output().unwrap()
}
