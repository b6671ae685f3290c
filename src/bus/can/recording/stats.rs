//! What a reader has seen so far.

use super::Damage;
use physics::Micros;

/// A line that could not be understood. Of BLF and MF4 recordings, which have no lines, an object or a record.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SkippedLine {
    /// Its number, from 1.
    pub line: u64,
    /// What is wrong with it.
    pub reason: Damage,
}

/// Counts of everything a reader met.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct LogStats {
    /// Lines read.
    pub lines: u64,
    /// Frames delivered.
    pub frames: u64,
    /// Damaged lines, which were skipped.
    pub skipped_lines: u64,
    /// How many for each reason.
    pub reasons: Vec<(Damage, u64)>,
    /// The first [`LogStats::KEPT`] of them.
    pub first_skipped: Vec<SkippedLine>,
    /// Empty lines and comments.
    pub blank_lines: u64,
    /// CAN XL frames: understood, but not delivered.
    pub xl_frames: u64,
    /// What else is understood and no frame: statistics, markers, the state of the hardware, other buses.
    pub others: u64,
    /// Frames that the recorder itself lost, as its `DROPCOUNT` lines say.
    pub dropped: u64,
    /// How often a frame was older than the one before it.
    pub time_backwards: u64,
    /// The line where that happened first.
    pub first_backwards: Option<u64>,
    /// Time of the first frame.
    pub first_time: Option<Micros>,
    /// Time of the last frame.
    pub last_time: Option<Micros>,
}

impl LogStats {
    /// How many damaged lines are kept with number and reason.
    pub const KEPT: usize = 20;

    /// Seconds from the first to the last frame.
    pub fn seconds(&self) -> f64 {
        match (self.first_time, self.last_time) {
            (Some(first), Some(last)) => (last - first).seconds().max(0.0),
            _ => 0.0,
        }
    }

    /// Counts a frame.
    #[inline]
    pub(in crate::can) fn frame(&mut self, time: Micros) {
        self.frames += 1;
        match self.last_time {
            None => self.first_time = Some(time),
            Some(last) if time < last => {
                self.time_backwards += 1;
                self.first_backwards.get_or_insert(self.lines);
            }
            Some(_) => {}
        }
        self.last_time = Some(time);
    }

    /// Counts the current line as damaged.
    #[cold]
    pub(in crate::can) fn skipped(&mut self, reason: Damage) {
        self.skipped_lines += 1;
        match self.reasons.iter_mut().find(|(known, _)| *known == reason) {
            Some((_, count)) => *count += 1,
            None => self.reasons.push((reason, 1)),
        }
        if self.first_skipped.len() < Self::KEPT {
            self.first_skipped.push(SkippedLine { line: self.lines, reason });
        }
    }
}
