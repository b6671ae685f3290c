//! Recordings in every format that is read and written. Which one is read is told by the content.
//!
//! | Format | Times | Channel becomes |
//! |---|---|---|
//! | candump (`-L`, `-l`), python-can's `.log` | microseconds | the interface as it stands |
//! | Vector ASC | usually microseconds since the start, which is given to the millisecond | 1: `can0` |
//! | Vector BLF | nanoseconds (or 10 µs) since the start, which is given to the millisecond | 1: `can0` |
//! | ASAM MF4, bus logging | as its master channel has them, since a start given to the nanosecond | 1: `can1` |
//! | Peak TRC | tenths of milliseconds (1.1), microseconds (2.1) since the start | 1: `can0` |
//! | python-can CSV | decimals of seconds, as many as there are | none: `can0` |
//!
//! Times become whole microseconds, rounded to the nearest, and are written as such, so that they are read back the
//! same. Where a format has a local time without its zone
//! (ASC, TRC, BLF), it is taken for UTC: the same file gives the same times on every machine.
//!
//! The formats were learned from what their makers and users publish, and from files; no code was taken over:
//! ASC and BLF from python-can 4.6's documentation and files it wrote, TRC from Peak's "PEAK CAN TRC File
//! Format" (PEAK_CAN_TRC_File_Format.pdf), MF4 from ASAM's public MDF 4 wiki and files by asammdf 8.

mod asc;
mod blf;
mod bytes;
pub mod candump;
mod csv;
mod damage;
mod date;
mod digits;
mod error;
mod lines;
mod mf4;
mod number;
mod pack;
mod reader;
mod recognize;
mod stats;
mod trc;
mod unpack;
mod write;

pub use damage::Damage;
pub use error::LogError;
pub use reader::Reader;
pub use recognize::Format;
pub use stats::{LogStats, SkippedLine};
pub use unpack::Compression;
pub use write::{Loss, Writer, Written};

pub use write::mdf;

pub(super) use pack::TextOutput;
pub(super) use unpack::{Content, unpack};

use super::{CanId, Frame, FrameError, FrameKind};
use physics::Micros;

/// A line that is longer than this is damaged. The longest line of any of the grammars, a CAN XL frame of
/// 2,048 bytes, has about 6 KiB.
pub(super) const LONGEST_LINE: usize = 1 << 18;

/// SocketCAN's class of errors on the bus, for formats that tell of an error frame and no more.
const BUS_ERROR: u32 = 0x80;

/// Something that delivers frames: a reader of one format.
trait Source: Send {
    /// As [`Reader::next_frame`].
    fn next_frame(&mut self) -> Result<Option<Frame>, LogError>;
    /// What there is to say of it.
    fn about(&self) -> &About;
}

/// What every source keeps.
#[derive(Default)]
struct About {
    /// As [`Reader::name`].
    name: String,
    /// As [`Reader::interface`].
    interface: Interface,
    /// As [`Reader::stats`].
    stats: LogStats,
}

impl About {
    fn of(name: String) -> Self {
        Self { name, ..Self::default() }
    }

    /// A frame is delivered, of a channel that becomes `canN`.
    fn delivered(&mut self, channel: u32, frame: Frame) -> Frame {
        self.interface.set(channel);
        self.stats.frame(frame.time);
        frame
    }
}

/// The identifier of that number and kind.
fn identifier(number: u32, extended: bool) -> Result<CanId, Damage> {
    let id = if extended { CanId::extended(number) } else { CanId::standard(number) };
    id.ok_or(Damage::BadNumber)
}

/// A time that a clock can show: until the year 33658, as in candump logs.
fn clock_time(time: Micros) -> Result<Micros, Damage> {
    const END: u64 = 1_000_000_000_000 * Micros::PER_SECOND.unsigned_abs();
    if time.0.unsigned_abs() < END { Ok(time) } else { Err(Damage::BadTime) }
}

/// A frame of what was read, its length as that of its data.
fn data_frame(time: Micros, id: CanId, kind: FrameKind, data: &[u8]) -> Result<Frame, Damage> {
    Frame::new(clock_time(time)?, id, kind, data).map_err(|error| match error {
        FrameError::NotAnFdLength(_) => Damage::NotAnFdLength,
        FrameError::TooLongForClassic(_) => Damage::TooLong,
    })
}

/// A remote request; a length code above 8 means 8.
fn remote_frame(time: Micros, id: CanId, length: usize) -> Result<Frame, Damage> {
    Frame::remote(clock_time(time)?, id, length.min(8)).map_err(|_| Damage::BadLength)
}

/// An error frame of which no more is known.
fn error_frame(time: Micros) -> Result<Frame, Damage> {
    data_frame(time, identifier(BUS_ERROR, true)?, FrameKind::Error, &[])
}

/// Bytes in a frame of FD with this length code.
fn fd_length(code: u32) -> Option<usize> {
    FD_LENGTHS.get(usize::try_from(code).ok()?).copied()
}

/// The length code of so many bytes.
fn fd_code(length: usize) -> u8 {
    FD_LENGTHS.iter().position(|known| *known >= length).unwrap_or(15) as u8
}

/// Bytes of each length code.
const FD_LENGTHS: [usize; 16] = [0, 1, 2, 3, 4, 5, 6, 7, 8, 12, 16, 20, 24, 32, 48, 64];

/// The name of an interface, kept until it changes.
#[derive(Default)]
struct Interface {
    number: Option<u32>,
    name: String,
}

impl Interface {
    /// `canN`.
    fn set(&mut self, number: u32) {
        use std::fmt::Write;
        if self.number != Some(number) {
            self.number = Some(number);
            self.name.clear();
            // Writing to a string cannot fail.
            let _ = write!(self.name, "can{number}");
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn interfaces_are_named_by_their_number() {
        let mut interface = Interface::default();
        assert_eq!(interface.name, "");
        interface.set(0);
        assert_eq!(interface.name, "can0");
        interface.set(12);
        assert_eq!(interface.name, "can12");
    }
}
