//! The Python package of `src/python`, as its users have it: built as a wheel, and installed beside what takes its tables.

use std::fs::{self, File};
use std::path::{Path, PathBuf};
use std::process::Command;

use super::program::{executable, project, target};

/// What builds it, what takes its tables, what runs its notebooks, and an engine and a store for a fleet.
const WITH: [&str; 10] = [
    "maturin==1.16.0",
    "pyarrow==26.0.1",
    "polars==2.1.0",
    "pandas==3.1.1",
    "nbclient==0.11.0",
    "ipykernel==7.4.0",
    "matplotlib==3.11.2",
    "dask[distributed]==2026.8.0",
    "s3fs==2026.9.0",
    "moto[server]==5.2.5",
];

/// A Python that has the package as it is now; `None`, with a printed message, where the others cannot be had.
pub fn python() -> Option<PathBuf> {
    let python = super::environment("package-venv", &WITH)?;
    // Several tests may come here at once.
    let lock = File::create(target("tmp").join("package.lock")).unwrap();
    lock.lock().unwrap();
    let wheels = target("tmp").join("wheels");
    let _ = fs::remove_dir_all(&wheels);
    // In the profile of who asks, so that little is compiled twice.
    let profile = if executable().parent().unwrap().ends_with("release") { "release" } else { "dev" };
    let mut build = Command::new(python.with_file_name("maturin"));
    build.args(["build", "--quiet", "--locked", "--profile", profile, "--manifest-path"]);
    build.arg(project("src/python/Cargo.toml")).arg("--interpreter").arg(&python).arg("--out").arg(&wheels);
    succeed(&mut build);
    let wheel = fs::read_dir(&wheels).unwrap().next().unwrap().unwrap().path();
    install(&python, &wheel);
    Some(python)
}

fn install(python: &Path, wheel: &Path) {
    let mut pip = Command::new(python);
    pip.args(["-m", "pip", "install", "--quiet", "--no-deps", "--no-index", "--force-reinstall"]);
    succeed(pip.arg(wheel));
}

/// What cannot be built is no reason to skip a test.
fn succeed(command: &mut Command) {
    let output = command.output().unwrap();
    assert!(output.status.success(), "{command:?}: {}", String::from_utf8_lossy(&output.stderr));
}
