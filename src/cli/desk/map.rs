//! `gripd map`: which signals of an unknown car's DBC are which quantities.

use std::path::{Path, PathBuf};

use clap::Args;

use super::output::{check_outputs, write_json, write_text};
use super::part::Part;
use super::progress::Progress;
use super::{Failure, recordings};
use bus::dbc::Database;
use bus::propose::{Confidence, Drive, propose, table};
use physics::Quantity;

/// Proposes the `[signals]` table of a configuration from the names in a DBC file and, with recordings, from how the
/// signals behave: for a person to confirm. Every line tells why, and how sure it is. Ends with 1 if something that
/// is needed was not found; what was found is written all the same.
#[derive(Args)]
pub struct Map {
    /// The car's DBC file.
    dbc: PathBuf,
    /// Recorded drives (candump, Vector ASC or BLF, ASAM MF4, Peak TRC, python-can CSV; gzip or zstd around them;
    /// `-` is the standard input): a few minutes with curves, starts and brakings.
    logs: Vec<PathBuf>,
    /// Write the configuration into this new file instead of the standard output.
    #[arg(short, long, value_name = "TOML")]
    out: Option<PathBuf>,
    /// Write everything as JSON (`-`: to the standard output, instead of the configuration).
    #[arg(long, value_name = "JSON")]
    json: Option<PathBuf>,
    #[command(flatten)]
    part: Part,
}

impl Map {
    /// Runs it.
    pub fn run(self) -> Result<(), Failure> {
        check_outputs(std::iter::once(&self.dbc).chain(&self.logs), self.out.iter().chain(&self.json))?;
        if let Some(out) =
            self.out.as_deref().filter(|out| out.as_os_str() != "-" && out.symlink_metadata().is_ok())
        {
            return Err(Failure::usage(format_args!(
                "{} is already there and is not overwritten; give another name",
                out.display()
            )));
        }
        let database = Database::load(&self.dbc).map_err(Failure::usage)?;
        let (drive, broken) = if self.logs.is_empty() {
            (None, None)
        } else {
            let (drive, broken) = gather(&self.logs, self.part, &database)?;
            (Some(drive), broken)
        };
        let proposal = propose(&database, drive.as_ref());
        let out = self.out.as_deref().unwrap_or(Path::new("-"));
        let dbc = relative(&self.dbc, out);
        let text = table(&proposal, &[&dbc]);
        let dash = Path::new("-");
        if self.out.is_some() || self.json.as_deref() != Some(dash) {
            write_text(out, &text)?;
        }
        if let Some(json) = &self.json {
            write_json(json, &proposal)?;
        }
        for choice in &proposal.quantities {
            for other in &choice.contradicted {
                tracing::warn!(
                    "{} is called {}, and does not behave so: {}",
                    other.signal,
                    choice.quantity,
                    other.data
                );
            }
        }
        for note in &proposal.notes {
            tracing::warn!("{note}");
        }
        let found = proposal.quantities.iter().filter(|choice| choice.confidence > Confidence::NotFound);
        tracing::info!(
            "{} of {} quantities found; check the result with `gripd check`",
            found.count(),
            Quantity::COUNT
        );
        if let Some(broken) = broken {
            return Err(Failure::Work(broken));
        }
        let either =
            |group: Vec<Quantity>| group.into_iter().map(Quantity::name).collect::<Vec<_>>().join(" or ");
        let missing: Vec<String> = proposal.missing().into_iter().map(either).collect();
        if missing.is_empty() {
            return Ok(());
        }
        // What is missing may stand in a line that was not understood.
        for warning in database.warnings().iter().take(3) {
            tracing::warn!("{warning}");
        }
        let has_nearest = proposal
            .quantities
            .iter()
            .any(|choice| choice.mapping.is_some() || !choice.alternatives.is_empty());
        let hint = if has_nearest { "the comments say what is nearest" } else { "nothing is called so" };
        Err(Failure::Work(format!("not found, and needed: {}; {hint}", missing.join(", "))))
    }
}

/// Reads the recordings once. What could be read of a broken one is used; the reason comes second.
pub(super) fn gather(
    logs: &[PathBuf],
    part: Part,
    database: &Database,
) -> Result<(Drive, Option<String>), Failure> {
    let mut drive = Drive::new(database);
    let mut broken = None;
    let progress = Progress::of_files(logs);
    for path in logs {
        let mut reader = part.open(path)?;
        loop {
            match reader.next_frame() {
                Ok(Some(frame)) => {
                    drive.frame(&frame);
                    progress.advance(reader.stats().lines);
                }
                Ok(None) => break,
                Err(error) => {
                    broken = Some(error.to_string());
                    break;
                }
            }
        }
        drive.end_of_recording();
        recordings::warn(&reader);
        let stats = reader.stats();
        if stats.frames == 0 {
            return Err(Failure::Work(recordings::nothing_in(&reader)));
        }
    }
    progress.finish();
    if drive.frames() == 0 {
        return Err(Failure::Work(format!(
            "{}: none of the recorded frames has an identifier of the DBC; is it the right bus, and the right car?",
            logs.iter().map(|log| log.display().to_string()).collect::<Vec<_>>().join(", "),
        )));
    }
    Ok((drive, broken))
}

/// A file's path as a configuration at `out` has to name it: relative to its folder, absolute where that is
/// elsewhere.
pub(super) fn relative(file: &Path, out: &Path) -> PathBuf {
    let folder = match out.parent() {
        Some(folder) if out.as_os_str() != "-" && !folder.as_os_str().is_empty() => folder,
        _ => return file.to_owned(),
    };
    // What does not exist yet has a place all the same.
    match (file.canonicalize().or_else(|_| std::path::absolute(file)), folder.canonicalize()) {
        (Ok(file), Ok(folder)) => file.strip_prefix(&folder).map(Path::to_owned).unwrap_or(file),
        _ => file.to_owned(),
    }
}
