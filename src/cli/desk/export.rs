//! `gripd export`: the car for other programs.

use std::io::{Cursor, Write};
use std::path::{Path, PathBuf};

use clap::{ArgGroup, Args};

use super::output::{Output, check_outputs};
use super::{Failure, configuration};
use bus::Config;
use bus::tire_file::{About, Axle, Written, of_vehicle};
use fmu::Version;
use fmu::car::{Car, Part};
use fmu::export::{ExportError, library, machine, write};

/// Writes what the configuration knows of the car (from a data sheet, or found by `gripd identify`) as other programs
/// for vehicle dynamics read it.
#[derive(Args)]
#[command(group = ArgGroup::new("format").required(true))]
pub struct Export {
    /// Configuration of the car.
    #[arg(short, long)]
    config: PathBuf,
    /// The tires as a tire property file: the magic formula of MF-Tyre 5.2 and 6.1 at pure slip (`-` is the standard
    /// output). Where no single tire has the stiffness of both axles, there are two files: x_front.tir and x_rear.tir
    /// of x.tir. `[vehicle] tire_file` reads them.
    #[arg(long, value_name = "FILE", group = "format")]
    tir: Option<PathBuf>,
    /// The whole car with its [[effect]] tables as an FMU for co-simulation (`-` is the standard output): steering wheel,
    /// torque and brakes in, motion, forces and what sensors say out, every number of the car a tunable parameter.
    #[arg(long, value_name = "FILE", group = "format")]
    fmu: Option<PathBuf>,
    /// With `--fmu`: the version of FMI, 2 (2.0) or 3 (3.0).
    #[arg(long, value_name = "VERSION", default_value = "2", requires = "fmu", value_parser = ["2", "3"])]
    fmi: String,
    /// With `--fmu`: only what the [[effect]] tables add to a plain simulation of the car, to be wired beside your own: its
    /// motion in; forces, moment, wheel torques and errors of sensors out.
    #[arg(long, requires = "fmu")]
    correction: bool,
}

impl Export {
    /// Runs it.
    pub fn run(self) -> Result<(), Failure> {
        let config = configuration::load(&self.config)?;
        match (&self.tir, &self.fmu) {
            (Some(path), _) => self.tires(&config, path),
            (None, Some(path)) => self.car(&config, path),
            // Clap asks for one of them.
            (None, None) => Ok(()),
        }
    }

    fn car(&self, config: &Config, path: &Path) -> Result<(), Failure> {
        check_outputs([&self.config].into_iter().chain(config.files()), [path.to_owned()].iter())?;
        let version = self.fmi.parse::<Version>().map_err(Failure::usage)?;
        let failed = |error: ExportError| match error {
            ExportError::Machine(..) => Failure::usage(error),
            ExportError::Car(_) | ExportError::Drive(_) => {
                Failure::usage(format_args!("{}: {error}", self.config.display()))
            }
            _ => Failure::work(error),
        };
        machine(version).map_err(failed)?;
        let name = self.config.file_stem().unwrap_or(self.config.as_os_str()).to_string_lossy().into_owned();
        let part = if self.correction { Part::Correction } else { Part::Car };
        let car = Car { name, part, vehicle: config.vehicle.clone(), effect: config.effect.clone() };
        let program = std::env::current_exe().map_err(Failure::work)?;
        let library = library(&program).map_err(failed)?;
        let archive =
            write(&car.with_every_number(), version, &library, Cursor::new(vec![])).map_err(failed)?;
        let mut output = Output::create(path)?;
        output.write_all(archive.get_ref())?;
        output.finish()
    }

    fn tires(&self, config: &Config, path: &Path) -> Result<(), Failure> {
        let name = self.config.file_name().unwrap_or(self.config.as_os_str()).to_string_lossy();
        let mut effects: Vec<_> = config.effect.iter().map(|effect| effect.kind().name).collect();
        effects.dedup();
        let about = About { source: &name, is_given: &|key| config.is_given(key), effects };
        let written = of_vehicle(&config.vehicle, &about)
            .map_err(|error| Failure::usage(format_args!("{}: [vehicle]: {error}", self.config.display())))?;
        let paths = paths(path, &written)?;
        check_outputs([&self.config].into_iter().chain(config.files()), &paths)?;
        // All of them complete, before the first has its name.
        let mut outputs = Vec::new();
        for (path, (_, text)) in paths.iter().zip(&written.files) {
            let mut output = Output::create(path)?;
            output.write_all(text.as_bytes())?;
            output.flush()?;
            outputs.push(output);
        }
        outputs.into_iter().try_for_each(Output::finish)?;
        for note in &written.notes {
            tracing::warn!("{}: {note}", self.config.display());
        }
        if let [front, rear] = paths.as_slice() {
            tracing::info!(
                "no single tire has both axles' stiffness: {} and {} written",
                front.display(),
                rear.display()
            );
        }
        Ok(())
    }
}

/// Each file's name.
fn paths(path: &Path, written: &Written) -> Result<Vec<PathBuf>, Failure> {
    let named = |axle: Axle| {
        let axle = match axle {
            Axle::Both => return Ok(path.to_owned()),
            Axle::Front => "_front",
            Axle::Rear => "_rear",
        };
        if path.as_os_str() == "-" {
            return Err(Failure::usage(
                "these tires are two files, which the standard output cannot hold; give --tir a file's name",
            ));
        }
        let mut name = path.file_stem().unwrap_or_default().to_owned();
        name.push(axle);
        if let Some(extension) = path.extension() {
            name.push(".");
            name.push(extension);
        }
        Ok(path.with_file_name(name))
    };
    written.files.iter().map(|(axle, _)| named(*axle)).collect()
}
