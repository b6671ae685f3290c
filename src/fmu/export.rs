//! The archive of a car's FMU, and the library that goes into it.

use std::io::{self, Seek, Write};
use std::path::{Path, PathBuf};

use thiserror::Error;
use zip::write::SimpleFileOptions;
use zip::{CompressionMethod, DateTime, ZipWriter};

use crate::Version;
use crate::car::{CAR_FILE, Car, CarError};
use crate::description::{LIBRARY, description};
use crate::instance::{Instance, Refused};

/// Name of the library where programs are.
pub const LIBRARY_FILE: &str = "libgripd_fmu.so";

/// An FMU that cannot be written.
#[derive(Debug, Error)]
pub enum ExportError {
    /// The car.
    #[error(transparent)]
    Car(#[from] CarError),
    /// It cannot drive at all.
    #[error(transparent)]
    Drive(#[from] Refused),
    /// The library is nowhere.
    #[error(
        "the library that goes into FMUs, {LIBRARY_FILE}, is not there; looked for: {}. Packages of gripd bring it, \
         `cargo build --release -p gripd-fmu` makes it (`cargo install` does not copy it); put it beside the program",
        list(.0)
    )]
    NoLibrary(Vec<PathBuf>),
    /// It cannot be read.
    #[error("cannot read {0}: {1}")]
    Library(PathBuf, io::Error),
    /// Of another version than the program.
    #[error("{0} is not of this version of gripd ({version}); put the one beside the program that was built with it",
            version = env!("CARGO_PKG_VERSION"))]
    OtherVersion(PathBuf),
    /// FMI has no name for this machine.
    #[error("FMI {0} has no FMUs for {1}; {2}")]
    Machine(Version, &'static str, &'static str),
    /// It cannot be written.
    #[error("cannot write the archive: {0}")]
    Archive(#[from] zip::result::ZipError),
    /// It cannot be written.
    #[error(transparent)]
    Write(#[from] io::Error),
}

fn list(paths: &[PathBuf]) -> String {
    paths.iter().map(|path| path.display().to_string()).collect::<Vec<_>>().join(", ")
}

/// The folder for this machine's libraries in an archive.
///
/// # Errors
/// If FMI has no name for it.
pub fn machine(version: Version) -> Result<&'static str, ExportError> {
    let refused = |hint| Err(ExportError::Machine(version, MACHINE, hint));
    match (version, MACHINE) {
        (Version::Two, "x86_64-linux") => Ok("linux64"),
        (Version::Two, _) => refused("use FMI 3.0"),
        (Version::Three, "x86_64-linux" | "aarch64-linux") => Ok(MACHINE),
        (Version::Three, _) => refused("export on Linux on x86-64 or aarch64"),
    }
}

/// Processor and system, as FMI 3.0 names them.
pub const MACHINE: &str = if cfg!(all(target_os = "linux", target_arch = "x86_64")) {
    "x86_64-linux"
} else if cfg!(all(target_os = "linux", target_arch = "aarch64")) {
    "aarch64-linux"
} else {
    "this machine"
};

/// Finds and reads the library of a program: beside it, where Cargo puts the libraries of what it builds, and where packages
/// put it.
///
/// # Errors
/// Where it was looked for, or why it cannot be read or used.
pub fn library(program: &Path) -> Result<Vec<u8>, ExportError> {
    let folder = program.parent().unwrap_or(Path::new(""));
    // Cargo keeps the one in `deps` up to date, and the one beside the program only where it was asked for the library.
    let places = ["deps", ".", "../lib/gripd", "../deps"].map(|place| folder.join(place).join(LIBRARY_FILE));
    let Some(found) = places.iter().find(|path| path.is_file()) else {
        return Err(ExportError::NoLibrary(places.to_vec()));
    };
    let bytes = std::fs::read(found).map_err(|error| ExportError::Library(found.clone(), error))?;
    let mark = crate::MARK.as_bytes();
    if !bytes.windows(mark.len()).any(|window| window == mark) {
        return Err(ExportError::OtherVersion(found.clone()));
    }
    Ok(bytes)
}

/// Writes the archive: the same car gives the same bytes.
///
/// # Errors
/// A car that cannot be driven, or what the writer reports.
pub fn write<W: Write + Seek>(
    car: &Car,
    version: Version,
    library: &[u8],
    writer: W,
) -> Result<W, ExportError> {
    let folder = machine(version)?;
    // What is wrong with the car is better told here than by every program that opens the FMU.
    Instance::new(car.clone()).initialize()?;
    let mut archive = ZipWriter::new(writer);
    let options = SimpleFileOptions::default()
        .compression_method(CompressionMethod::Deflated)
        .last_modified_time(DateTime::default());
    let files = [
        ("modelDescription.xml".to_owned(), description(car, version)?.into_bytes()),
        (format!("resources/{CAR_FILE}"), car.text()?.into_bytes()),
    ];
    for (name, bytes) in &files {
        archive.start_file(name.as_str(), options)?;
        archive.write_all(bytes)?;
    }
    archive.start_file(format!("binaries/{folder}/{LIBRARY}.so"), options.unix_permissions(0o755))?;
    archive.write_all(library)?;
    Ok(archive.finish()?)
}
