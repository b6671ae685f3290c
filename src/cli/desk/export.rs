//! `gripd export`: the car for other programs.

use std::io::Write;
use std::path::{Path, PathBuf};

use clap::{ArgGroup, Args};

use super::output::{Output, check_outputs};
use super::{Failure, configuration};
use bus::Config;
use bus::tire_file::{About, Axle, Written, of_vehicle};

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
}

impl Export {
    /// Runs it.
    pub fn run(self) -> Result<(), Failure> {
        let config = configuration::load(&self.config)?;
        match &self.tir {
            Some(path) => self.tires(&config, path),
            // Clap asks for one of them.
            None => Ok(()),
        }
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
