//! ASAM MDF 4 with bus logging: records of `CAN_DataFrame`, `CAN_RemoteFrame` and `CAN_ErrorFrame`, sorted or
//! not, finished or not, their data in the records or elsewhere (VLSD).
//!
//! ```text
//! ID ─ HD ─┬ DG ─┬ CG ─ CN …           groups and channels: where in a record is what
//!          │     └ DT | DZ | HL ─ DL …  the records, perhaps compressed, perhaps in pieces
//!          └ DG …                       groups are read side by side, and their frames given out by time
//! ```

mod block;
mod data;
mod layout;
mod records;

use std::fs::File;

use self::block::Blocks;
use self::records::{Record, Records};
use super::{About, LogError, LogStats, Source};
use crate::can::Frame;

/// Where the first block is, behind the file's identification.
const HEADER: u64 = 64;

/// Frames of an MF4 file.
pub struct Reader {
    file: Blocks,
    groups: Vec<Ahead>,
    /// To be told when all that can be read has been delivered.
    failure: Option<LogError>,
    about: About,
}

/// A data group and its next frame.
struct Ahead {
    records: Records,
    next: Option<(u32, Frame)>,
    ended: bool,
}

impl Reader {
    /// Of a file that begins as one.
    ///
    /// # Errors
    /// If it is of another version, broken at its beginning, or has no CAN frames.
    pub fn open(file: File, name: String) -> Result<Self, LogError> {
        let mut file = Blocks::new(file, name)?;
        let mut identification = Vec::new();
        file.read(0, HEADER as usize, &mut identification)?;
        let Some((magic, rest)) = identification.split_at_checked(8).filter(|(_, rest)| rest.len() == 56)
        else {
            return Err(LogError::CutOff { name: file.name().into(), what: "its identification", byte: 0 });
        };
        if rest[0] != b'4' {
            return Err(LogError::NotARecording {
                name: file.name().into(),
                format: "an ASAM MDF recording of another version than 4",
            });
        }
        file.unfinished = magic.starts_with(b"UnFin");
        let header = file.expect(HEADER, b"HD")?;
        let start_ns = i64::try_from(header.u64(0)).unwrap_or(0);
        let mut groups = Vec::new();
        for group in layout::read(&file, header.link(0))? {
            let records = Records::new(&file, group, start_ns)?;
            groups.push(Ahead { records, next: None, ended: false });
        }
        if groups.is_empty() {
            return Err(LogError::NotARecording {
                name: file.name().into(),
                format: "an ASAM MDF recording without CAN frames (it has signals, but no CAN_DataFrame)",
            });
        }
        let about = About::of(file.name().to_owned());
        Ok(Self { file, groups, failure: None, about })
    }
}

impl Ahead {
    /// Reads on to the next frame.
    fn fill(&mut self, file: &Blocks, stats: &mut LogStats, failure: &mut Option<LogError>) {
        while self.next.is_none() && !self.ended {
            match self.records.next(file) {
                Ok(Some(record)) => {
                    stats.lines += 1;
                    match record {
                        Record::Frame(channel, frame) => self.next = Some((channel, frame)),
                        Record::Other => stats.others += 1,
                        Record::Damaged(reason) => stats.skipped(reason),
                    }
                }
                Ok(None) => {
                    self.ended = true;
                    if let Some(byte) = self.records.cut_off() {
                        let name = file.name().to_owned();
                        failure.get_or_insert(LogError::CutOff { name, what: "a data block", byte });
                    }
                }
                Err(error) => {
                    // Records that wait for their data are still to come.
                    failure.get_or_insert(error);
                }
            }
        }
    }
}

impl Source for Reader {
    fn next_frame(&mut self) -> Result<Option<Frame>, LogError> {
        for group in &mut self.groups {
            group.fill(&self.file, &mut self.about.stats, &mut self.failure);
        }
        let time = |group: &&mut Ahead| group.next.map(|(_, frame)| frame.time);
        let earliest = self.groups.iter_mut().filter(|group| group.next.is_some()).min_by_key(time);
        let Some((channel, frame)) = earliest.and_then(|group| group.next.take()) else {
            return self.failure.take().map_or(Ok(None), Err);
        };
        Ok(Some(self.about.delivered(channel, frame)))
    }

    fn about(&self) -> &About {
        &self.about
    }
}
