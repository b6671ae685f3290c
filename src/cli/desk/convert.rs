//! `gripd convert`: a recording of any format as one of another.

use std::path::PathBuf;

use clap::Args;
use clap::builder::{PossibleValuesParser, TypedValueParser};

use super::output::check_outputs;
use super::part::Part;
use super::progress::Progress;
use super::{Failure, recordings};
use bus::can::recording::{Format, Reader, Writer};

/// Reads and writes candump, Vector ASC and BLF, ASAM MF4 (bus logging), Peak TRC and python-can CSV; which is read,
/// the content tells, and which is written, the name. Every frame is written, with its time to the microsecond; what
/// could not be understood, and what the other format cannot hold, is counted and named.
#[derive(Args)]
pub struct Convert {
    /// The recording (gzip or zstd around it; `-` is the standard input).
    recording: PathBuf,
    /// What it becomes: Vector ASC where the name ends in `.asc`, BLF in `.blf`, MF4 in `.mf4`, TRC in `.trc`,
    /// python-can's CSV in `.csv`, a candump log in `.log` or without an ending; others are refused. (Texts
    /// with `.gz` and `.zst` behind are packed; `-` is the standard output.)
    #[arg(short, long)]
    out: PathBuf,
    /// The format, whatever the name ends in.
    #[arg(short, long, value_name = "FORMAT", value_parser = format_parser())]
    format: Option<Format>,
    /// Write this interface with every frame, instead of the recording's own (channel 1 of ASC, BLF and TRC is
    /// can0).
    #[arg(short, long, value_name = "IF")]
    interface: Option<String>,
    #[command(flatten)]
    part: Part,
}

impl Convert {
    /// Runs it.
    pub fn run(self) -> Result<(), Failure> {
        check_outputs([&self.recording], [&self.out])?;
        if let Some(name) = &self.interface {
            name.parse::<bus::can::InterfaceName>().map_err(Failure::usage)?;
        }
        let mut reader = self.part.open(&self.recording)?;
        let format = match self.format {
            Some(format) => format,
            None => recordings::format_of(&self.out, ", or say --format")?,
        };
        let mut log = Writer::create(&self.out, format, "can0")?;
        let progress = Progress::of_files(std::slice::from_ref(&self.recording));
        let broken = loop {
            match reader.next_frame() {
                Ok(Some(frame)) => {
                    log.write_as(self.interface.as_deref().unwrap_or(reader.interface()), &frame)?;
                    progress.advance(reader.stats().lines);
                }
                Ok(None) => break None,
                // What could be read before the damage is worth keeping.
                Err(error) => break Some(error.to_string()),
            }
        };
        progress.finish();
        let written = log.finish()?;
        recordings::warn(&reader);
        tell(&reader);
        recordings::tell_losses(&self.out, format, &written);
        if let Some(broken) = broken {
            return Err(Failure::Work(broken));
        }
        let stats = reader.stats();
        match (stats.frames, stats.skipped_lines) {
            (0, 0) => Err(Failure::Work(format!("{}: there is nothing in it", reader.name()))),
            (0, _) => Err(Failure::Work(recordings::nothing_in(&reader))),
            _ => Ok(()),
        }
    }
}

/// Formats by their short names.
fn format_parser() -> impl TypedValueParser<Value = Format> {
    let names = Format::NAMES.map(|(name, _)| name);
    // Other names do not come here.
    PossibleValuesParser::new(names).map(|name| Format::named(&name).unwrap_or(Format::Candump))
}

/// How much there was, and what was left out for what reason.
fn tell(reader: &Reader) {
    let (stats, format) = (reader.stats(), reader.format());
    tracing::info!(
        "{}: {format}, {} frames in {:.3} s; {} {}s skipped, {} were no frames",
        reader.name(),
        stats.frames,
        stats.seconds(),
        stats.skipped_lines,
        format.part(),
        stats.others + stats.xl_frames
    );
    for (reason, count) in &stats.reasons {
        tracing::info!("{count} × {reason}");
    }
}
