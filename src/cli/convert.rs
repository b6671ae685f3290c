//! `gripd convert`: a recording of any format as a candump log.

use std::path::PathBuf;

use clap::Args;

use super::output::outputs_are_no_inputs;
use super::progress::Progress;
use super::{Failure, recordings};
use crate::can::candump::Writer;
use crate::can::recording::Reader;

/// Reads candump, Vector ASC and BLF, ASAM MF4 (bus logging), Peak TRC and python-can CSV; which it is, the
/// content tells. Every frame is written, with its time to the microsecond; what could not be understood is
/// counted and named.
#[derive(Args)]
pub struct Convert {
    /// The recording (gzip or zstd around it; `-` is the standard input).
    recording: PathBuf,
    /// The candump log (`.gz` and `.zst` are packed; `-` is the standard output).
    #[arg(short, long)]
    out: PathBuf,
    /// Write this interface with every frame, instead of the recording's own (channel 1 of ASC, BLF and TRC is
    /// can0).
    #[arg(short, long, value_name = "IF")]
    interface: Option<String>,
}

impl Convert {
    /// Runs it.
    pub fn run(self) -> Result<(), Failure> {
        outputs_are_no_inputs([&self.recording], [&self.out])?;
        if let Some(name) = &self.interface {
            name.parse::<crate::can::InterfaceName>().map_err(Failure::usage)?;
        }
        let mut reader = Reader::open(&self.recording).map_err(Failure::work)?;
        let mut log = Writer::create(&self.out, "can0").map_err(Failure::work)?;
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
        log.finish()?;
        recordings::warn(&reader);
        tell(&reader);
        if let Some(broken) = broken {
            return Err(Failure::Work(broken));
        }
        let stats = reader.stats();
        if stats.frames == 0 && stats.skipped_lines > 0 {
            return Err(Failure::Work(recordings::nothing_in(&reader)));
        }
        Ok(())
    }
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
