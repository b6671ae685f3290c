//! Recordings beyond candump: what each format says, and what becomes of damage, packing and truncation; and written
//! ones, read again. (Files of and for other programs: [`super::peers`]; mutated ones: [`super::fuzz`].)

mod blf;
mod blf_file;
mod convert;
mod mf4;
mod mf4_file;
mod text;
mod writing;

use std::io::Cursor;

use gripd::Micros;
use gripd::can::candump::write_line;
use gripd::can::recording::{Damage, Format, LogError, LogStats, Reader};

/// Everything that was read.
struct Read {
    format: Format,
    /// As candump lines.
    lines: Vec<String>,
    stats: LogStats,
    error: Option<LogError>,
}

fn drain(mut reader: Reader) -> Read {
    let mut lines = Vec::new();
    let error = loop {
        match reader.next_frame() {
            Ok(Some(frame)) => {
                let mut line = Vec::new();
                write_line(&mut line, reader.interface(), &frame);
                lines.push(String::from_utf8(line).unwrap().trim_end().to_owned());
            }
            Ok(None) => break None,
            Err(error) => {
                assert!(matches!(reader.next_frame(), Ok(None)), "the error comes once");
                break Some(error);
            }
        }
    };
    Read { format: reader.format(), lines, stats: reader.stats().clone(), error }
}

fn read(bytes: impl Into<Vec<u8>>) -> Read {
    drain(Reader::from_read(Box::new(Cursor::new(bytes.into())), "test").unwrap())
}

/// The reason for which the only damaged part was skipped.
#[track_caller]
fn damage(read: &Read) -> Damage {
    assert_eq!(read.stats.skipped_lines, 1, "{:?}", read.stats);
    assert_eq!(read.stats.reasons, [(read.stats.first_skipped[0].reason, 1)]);
    read.stats.first_skipped[0].reason
}
