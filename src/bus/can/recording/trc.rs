//! Peak's text format, versions 1.0 to 2.1.
//!
//! ```text
//! ;$FILEVERSION=1.1                      ;$FILEVERSION=2.1
//! ;$STARTTIME=45939.3703703704           ;$STARTTIME=45939.3703703704
//!                                        ;$COLUMNS=N,O,T,B,I,d,R,L,D
//!      1)   1059.9  Rx  0300  7  00 …         1   1059.900 DT 1  0300 Rx - 7  00 00 00 00 04 00 00
//! ```

use super::lines::{Entry, Grammar};
use super::number::Words;
use super::{Damage, data_frame, error_frame, fd_length, identifier, number, remote_frame};
use crate::can::{CanId, Frame, FrameKind};
use physics::Micros;

/// Columns that a line can have; the letters are those of `$COLUMNS`.
const MOST_COLUMNS: usize = 16;

/// The grammar, and what the headers said.
pub struct Trc {
    /// The columns of a line, but for its data, which come last.
    columns: Columns,
    start: Micros,
}

/// The letters of a version's columns.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Columns {
    letters: [u8; MOST_COLUMNS],
    count: usize,
}

impl Columns {
    fn new(letters: &[u8]) -> Option<Self> {
        let mut columns = Self { letters: [0; MOST_COLUMNS], count: letters.len() };
        columns.letters.get_mut(..letters.len())?.copy_from_slice(letters);
        Some(columns)
    }

    /// As the versions before 2.0 have them: `T` is the type or the direction there.
    fn of_version(version: &[u8]) -> Option<Self> {
        Self::new(match version {
            b"1.0" => b"NOIL",
            b"1.1" => b"NOTIL",
            b"1.2" => b"NOBTIL",
            b"1.3" => b"NOBTIRL",
            b"2.0" => b"NOTIdl",
            b"2.1" => b"NOTBIdRL",
            _ => return None,
        })
    }
}

impl Default for Trc {
    fn default() -> Self {
        // A file that names no version is one of 1.0.
        let columns = Columns::of_version(b"1.0").unwrap_or(Columns { letters: [0; MOST_COLUMNS], count: 0 });
        Self { columns, start: Micros(0) }
    }
}

impl Grammar for Trc {
    fn line(&mut self, line: &[u8]) -> Result<Entry, Damage> {
        match line {
            [] => Ok(Entry::Blank),
            [b';', header @ ..] => self.header(header).map(|()| Entry::Blank),
            _ => self.frame(line),
        }
    }
}

impl Trc {
    fn header(&mut self, line: &[u8]) -> Result<(), Damage> {
        let Some(equals) = line.iter().position(|byte| *byte == b'=') else { return Ok(()) };
        let (key, value) = (&line[..equals], line[equals + 1..].trim_ascii());
        match key.trim_ascii() {
            b"$FILEVERSION" => self.columns = Columns::of_version(value).ok_or(Damage::UnknownLine)?,
            b"$STARTTIME" => self.start = start_time(value).ok_or(Damage::BadTime)?,
            b"$COLUMNS" => {
                let letters: Vec<u8> = value
                    .split(|byte| *byte == b',')
                    .filter_map(|column| column.trim_ascii().first().copied())
                    .filter(|letter| *letter != b'D')
                    .collect();
                self.columns = Columns::new(&letters).ok_or(Damage::UnknownLine)?;
            }
            _ => {}
        }
        Ok(())
    }

    fn frame(&self, line: &[u8]) -> Result<Entry, Damage> {
        let mut words = number::words(line);
        let mut found: [&[u8]; MOST_COLUMNS] = [&[]; MOST_COLUMNS];
        for place in found.iter_mut().take(self.columns.count) {
            // Only status lines are shorter, and they are told by their type.
            *place = words.next().unwrap_or_default();
        }
        let column = |letter: u8| {
            let place = self.columns.letters[..self.columns.count].iter().position(|l| *l == letter);
            place.map(|place| found[place])
        };
        let stamp = column(b'O').ok_or(Damage::FewColumns)?;
        let time = self.start + number::micros(stamp, 3).ok_or(Damage::BadTime)?;
        // Buses are counted from 1.
        let bus = column(b'B').and_then(|bus| number::unsigned(bus, 10)).unwrap_or(1).saturating_sub(1);
        let kind = match column(b'T') {
            None | Some(b"Rx" | b"Tx" | b"DT") => FrameKind::Data,
            Some(b"RR") => FrameKind::Remote,
            Some(b"FD") => FrameKind::Fd { bit_rate_switch: false, error_state: false },
            Some(b"FB") => FrameKind::Fd { bit_rate_switch: true, error_state: false },
            Some(b"FE") => FrameKind::Fd { bit_rate_switch: true, error_state: true },
            Some(b"BI") => FrameKind::Fd { bit_rate_switch: false, error_state: true },
            Some(b"ER" | b"Error") => return Ok(Entry::Frame(bus, error_frame(time)?)),
            Some(b"ST" | b"EC" | b"EV" | b"Warng" | b"Event") => return Ok(Entry::Other),
            Some(_) => return Err(Damage::UnknownLine),
        };
        let id = column(b'I').ok_or(Damage::FewColumns)?;
        // The bus's state in version 1.0.
        if id == b"FFFFFFFF" {
            return Ok(Entry::Other);
        }
        // Four digits for a standard identifier, more for an extended one.
        let number = number::unsigned(id, 16).ok_or(Damage::BadNumber)?;
        let id = identifier(number, id.len() > 4)?;
        let length = match (column(b'l'), column(b'L')) {
            (Some(length), _) => number::unsigned(length, 10).map(|length| length as usize),
            // Of an FD frame the length code.
            (None, Some(code)) => {
                let code = number::unsigned(code, 10);
                let is_fd = matches!(kind, FrameKind::Fd { .. });
                code.and_then(|code| if is_fd { fd_length(code) } else { Some(code.min(8) as usize) })
            }
            (None, None) => return Err(Damage::FewColumns),
        };
        let length = length.filter(|length| *length <= 64).ok_or(Damage::BadLength)?;
        data(time, id, kind, length, words).map(|frame| Entry::Frame(bus, frame))
    }
}

/// The frame of the bytes at the end of a line.
fn data(time: Micros, id: CanId, kind: FrameKind, length: usize, mut words: Words) -> Result<Frame, Damage> {
    if kind == FrameKind::Remote {
        return remote_frame(time, id, length);
    }
    // Before version 2.0 a remote request says so in place of its data.
    if words.clone().next() == Some(b"RTR") {
        return remote_frame(time, id, length);
    }
    let mut bytes = [0; 64];
    if !words.bytes(16, &mut bytes[..length]) {
        return Err(Damage::BadBytes);
    }
    data_frame(time, id, kind, &bytes[..length])
}

/// Days since 30 December 1899, to the microsecond.
fn start_time(text: &[u8]) -> Option<Micros> {
    const DAYS_UNTIL_1970: f64 = 25_569.0;
    const DAY_US: f64 = 86_400e6;
    let days: f64 = std::str::from_utf8(text).ok()?.parse().ok()?;
    // The product of the whole number would need more digits than there are.
    let (whole, rest) = (days.trunc() - DAYS_UNTIL_1970, days.fract());
    if whole.is_nan() || whole.abs() >= 1e7 {
        return None;
    }
    Some(Micros((whole * DAY_US) as i64 + (rest * DAY_US).round() as i64))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_start_is_that_of_the_days() {
        assert_eq!(start_time(b"25569"), Some(Micros(0)));
        assert_eq!(start_time(b"45939.37037037037"), Some(Micros(1_760_000_000_000_000)));
        assert_eq!(start_time(b"nan"), None);
        assert_eq!(start_time(b"1e300"), None);
        assert_eq!(start_time(b"x"), None);
    }
}
