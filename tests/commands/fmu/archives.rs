//! Archives and recordings for these tests.

use std::fs;
use std::io::{Cursor, Write};
use std::path::{Path, PathBuf};
use std::process::Command;

use testing::program::{gripd_in, project};
use zip::ZipWriter;
use zip::write::SimpleFileOptions;

/// An archive of these files.
pub fn archive(path: &Path, files: &[(&str, &[u8])]) {
    let mut zip = ZipWriter::new(Cursor::new(vec![]));
    for (name, bytes) in files {
        zip.start_file(*name, SimpleFileOptions::default()).unwrap();
        zip.write_all(bytes).unwrap();
    }
    fs::write(path, zip.finish().unwrap().into_inner()).unwrap();
}

/// Somebody else's library, compiled.
pub fn foreign_library(folder: &Path) -> Vec<u8> {
    let path = folder.join("foreign.so");
    let rustc = std::env::var_os("RUSTC").unwrap_or_else(|| "rustc".into());
    let output = Command::new(rustc)
        .args(["--edition", "2024", "--crate-type", "cdylib", "-A", "warnings", "-o"])
        .arg(&path)
        .arg(project("tests/data/foreign_fmu.rs"))
        .output()
        .unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    fs::read(path).unwrap()
}

/// Its description.
pub const FOREIGN: &str = "<?xml version=\"1.0\"?>\
    <fmiModelDescription fmiVersion=\"2.0\" modelName=\"somebody's\" guid=\"{x}\">\
    <CoSimulation modelIdentifier=\"somebody\"/><DefaultExperiment stepSize=\"0.01\"/><ModelVariables>\
    <ScalarVariable name=\"steering_wheel_angle\" valueReference=\"0\" causality=\"input\"><Real unit=\"deg\" start=\"0\"/>\
    </ScalarVariable>\
    <ScalarVariable name=\"psi_dot\" valueReference=\"1\" causality=\"output\"><Real unit=\"deg/s\"/></ScalarVariable>\
    <ScalarVariable name=\"gain\" valueReference=\"2\" causality=\"parameter\" variability=\"tunable\">\
    <Real min=\"0\" max=\"10\" start=\"1\"/></ScalarVariable>\
    <ScalarVariable name=\"lag\" valueReference=\"3\" causality=\"parameter\" variability=\"tunable\"><Real start=\"0.1\"/>\
    </ScalarVariable>\
    <ScalarVariable name=\"mood\" valueReference=\"4\" causality=\"parameter\" variability=\"fixed\"><Integer start=\"0\"/>\
    </ScalarVariable></ModelVariables></fmiModelDescription>";

/// The whole of it.
pub fn foreign(folder: &Path) -> PathBuf {
    let path = folder.join("foreign.fmu");
    let library = foreign_library(folder);
    archive(
        &path,
        &[("modelDescription.xml", FOREIGN.as_bytes()), ("binaries/linux64/somebody.so", &library)],
    );
    path
}

/// A drive of the demo's car, and its configuration with a table behind it.
pub fn drive(folder: &Path, seconds: u32) {
    let demo = fs::read_to_string(project("config/scenarios/demo.toml")).unwrap();
    let scenario = demo.replace("duration_s = 120.0", &format!("duration_s = {seconds}.0"));
    fs::write(folder.join("scenario.toml"), scenario).unwrap();
    let output = gripd_in(folder, "-q simulate scenario.toml -o drive.log");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    configure(folder, "");
}

/// The demo's configuration with a table behind it.
pub fn configure(folder: &Path, table: &str) {
    let demo = fs::read_to_string(project("config/demo.toml")).unwrap();
    let demo = demo.replace("../dbc", project("dbc").to_str().unwrap());
    fs::write(folder.join("car.toml"), format!("{demo}\n{table}\n")).unwrap();
}
