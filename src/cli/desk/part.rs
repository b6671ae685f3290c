//! `--from` and `--to`: a part of a recording.

use std::ops::{Deref, RangeInclusive};
use std::path::Path;

use bus::can::Frame;
use bus::can::recording::{LogError, Reader};
use clap::Args;
use physics::Micros;

use super::Failure;

/// Which part of the recordings is asked for.
#[derive(Args, Clone, Copy, Default)]
pub struct Part {
    /// Only what is so many seconds after the first frame, or later.
    #[arg(long, value_name = "S")]
    from: Option<f64>,
    /// Only what is so many seconds after the first frame, or earlier.
    #[arg(long, value_name = "S")]
    to: Option<f64>,
}

impl Part {
    /// As seconds; everything where nothing is asked for.
    pub fn seconds(self) -> Result<RangeInclusive<f64>, Failure> {
        let (from, to) = (self.from.unwrap_or(0.0), self.to.unwrap_or(f64::INFINITY));
        if !(from >= 0.0 && from.is_finite()) {
            return Err(Failure::usage(format_args!("--from {from}: must be zero or more seconds")));
        }
        if to.is_nan() || to <= from {
            return Err(Failure::usage(format_args!(
                "--to {to}: must be more than --from, which is {from} s"
            )));
        }
        Ok(from..=to)
    }

    /// Opens a recording, of which only the part is delivered.
    pub fn open(self, path: &Path) -> Result<PartReader, Failure> {
        self.seconds()?;
        let reader = Reader::open(path).map_err(Failure::work)?;
        Ok(PartReader { reader, part: self, start: None, is_any_within: false })
    }
}

/// A part of a recording.
pub struct PartReader {
    reader: Reader,
    part: Part,
    /// The time of the recording's first frame.
    start: Option<Micros>,
    is_any_within: bool,
}

impl PartReader {
    /// The next frame of the part; none at its end.
    ///
    /// # Errors
    /// Those of the recording.
    pub fn next_frame(&mut self) -> Result<Option<Frame>, LogError> {
        let mut last = 0.0;
        while let Some(frame) = self.reader.next_frame()? {
            last = (frame.time - *self.start.get_or_insert(frame.time)).seconds();
            if self.part.to.is_some_and(|to| last > to) {
                break;
            }
            // Where clocks are set back, frames are earlier than the first one: without --from they belong to all of it.
            if self.part.from.is_none_or(|from| last >= from) {
                self.is_any_within = true;
                return Ok(Some(frame));
            }
        }
        if self.start.is_some() && !self.is_any_within {
            tracing::warn!("{}: nothing is between --from and --to; it ends after {last:.1} s", self.name());
        }
        Ok(None)
    }

    /// From where on its seconds are counted, if that is not the first frame that is used.
    pub fn counted_from(&self) -> Option<Micros> {
        self.start.filter(|_| self.part.from.is_some_and(|from| from > 0.0))
    }
}

impl Deref for PartReader {
    type Target = Reader;

    fn deref(&self) -> &Reader {
        &self.reader
    }
}
