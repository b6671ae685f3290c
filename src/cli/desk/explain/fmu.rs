//! A simulation that is an FMU: driven with the recorded inputs, in a process of its own, and tuned if that is asked for.

use std::collections::BTreeMap;
use std::path::Path;
use std::time::Duration;

use bus::Config;
use bus::signals::to_si;
use fmu::foreign::{FmuConfig, ForeignError, Program, Tuned, Unpacked, Wiring, tune};
use lab::explain::{Recording, Work, speed_of};
use physics::Quantity;

use crate::cli::Failure;

/// Somebody's simulation of a recording.
pub struct Simulation {
    /// What it says.
    pub recording: Recording,
    /// Parameters that were tuned before, by its names and in its units.
    pub tuned: BTreeMap<String, f64>,
}

/// Drives it as the car of a recording was driven.
///
/// # Errors
/// What is wrong with the FMU or the `[fmu]` table, or how it failed.
pub fn run(
    path: &Path,
    table: &FmuConfig,
    config: &Config,
    recording: &Recording,
) -> Result<Simulation, Failure> {
    let failed = |error: ForeignError| match error {
        ForeignError::Wiring { .. } => Failure::usage(format_args!("{}: {error}", path.display())),
        _ => Failure::work(error),
    };
    let folder = tempfile::tempdir().map_err(|error| {
        Failure::work(format_args!("cannot make a folder to unpack {} into: {error}", path.display()))
    })?;
    let fmu = Unpacked::new(path, folder.path()).map_err(failed)?;
    let mut recorded = recording.tracks.clone();
    // A driver holds the speed of the car, not that of a single wheel.
    recorded[Quantity::VehicleSpeed as usize] = speed_of(recording, &config.vehicle);
    let radius = config.vehicle.wheel_radius_m.value;
    let to_si = |quantity, unit: &str| to_si(quantity, unit, radius).map_err(|error| error.to_string());
    let wiring = Wiring::new(&fmu, table, &recorded, &to_si).map_err(failed)?;
    for words in &wiring.words {
        tracing::info!("{}: {words}", path.display());
    }
    let program = Program {
        executable: std::env::current_exe().map_err(Failure::work)?,
        folder: folder.path().to_owned(),
        limit: Duration::from_secs_f64(table.time_limit_s),
    };
    let Tuned { values, left, rows } = tune(&wiring, &recorded, &program, path).map_err(failed)?;
    for (name, before, after, is_at_end) in &values {
        let end = if *is_at_end { ", an end of its range" } else { "" };
        tracing::info!("{}: {name} tuned from {before} to {after}{end}", path.display());
    }
    if !values.is_empty() {
        let [before, after] = left.map(|share| 100.0 * share);
        tracing::info!(
            "{}: of the recording it leaves {before:.1} % (rms) untuned and {after:.1} % tuned",
            path.display()
        );
    }
    Ok(Simulation {
        recording: Recording {
            name: path.display().to_string(),
            begins_s: None,
            tracks: wiring.tracks(&rows),
            work: Work::default(),
        },
        tuned: values.into_iter().map(|(name, _, after, _)| (name, after)).collect(),
    })
}
