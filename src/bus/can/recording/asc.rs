//! Vector's text format.
//!
//! ```text
//! date Thu Oct 09 08:53:20.000 2025
//! base hex  timestamps absolute
//! Begin Triggerblock Thu Oct 09 08:53:20.000 2025
//!    0.010007 2  101             Rx   d 8 00 11 22 33 44 55 66 77
//!    1.500123 1  18FEF100x       Rx   r 8
//!    1.700123 CANFD   1 Rx  123  Name  1 0 9 12 00 11 22 … BB  duration length flags …
//!    1.800123 1  ErrorFrame
//! ```

use super::date;
use super::lines::{Entry, Grammar};
use super::number::Words;
use super::{Damage, data_frame, error_frame, fd_length, identifier, number, remote_frame};
use crate::can::{CanId, Frame, FrameKind};
use physics::Micros;
use physics::time::Date;

/// A trigger's time stamp may be so much before the first line after it.
const SLACK: Micros = Micros(1_500_000);

/// Flags that follow the data of a CANFD line.
const FLAG_REMOTE: u32 = 1 << 4;
const FLAG_FD: u32 = 1 << 12;

/// The grammar, and what the headers said.
pub struct Asc {
    base: u32,
    /// Each time is since the line before, not since the start.
    relative: bool,
    /// When the measurement began, by the `date` line.
    date: Option<Micros>,
    /// When the last trigger came, until the line after it tells what it counts from.
    trigger: Option<Micros>,
    /// What times count from.
    start: Option<Micros>,
    last: Micros,
}

impl Default for Asc {
    fn default() -> Self {
        Self { base: 16, relative: false, date: None, trigger: None, start: None, last: Micros(0) }
    }
}

impl Grammar for Asc {
    fn line(&mut self, line: &[u8]) -> Result<Entry, Damage> {
        let mut words = number::words(line);
        let Some(first) = words.next() else { return Ok(Entry::Blank) };
        if !first.first().is_some_and(|byte| byte.is_ascii_digit() || *byte == b'-') {
            return self.header(line, first);
        }
        let time = self.time(first)?;
        let Some(second) = words.next() else { return Err(Damage::FewColumns) };
        if second.eq_ignore_ascii_case(b"CANFD") {
            return self.fd(time, words);
        }
        // Statistics, the bus's state, other buses.
        let Some(channel) = number::unsigned(second, 10) else { return Ok(Entry::Other) };
        self.classic(time, channel.saturating_sub(1), words)
    }
}

impl Asc {
    fn header(&mut self, line: &[u8], first: &[u8]) -> Result<Entry, Damage> {
        let mut words = number::words(line).skip(1);
        match first.to_ascii_lowercase().as_slice() {
            b"date" => self.date = line.get(4..).and_then(date::parse).and_then(Date::micros),
            b"base" => {
                self.base = match words.next().map(<[u8]>::to_ascii_lowercase).as_deref() {
                    Some(b"hex") => 16,
                    Some(b"dec") => 10,
                    _ => return Err(Damage::UnknownLine),
                };
                self.relative = words.last().is_some_and(|word| word.eq_ignore_ascii_case(b"relative"));
            }
            b"begin" => {
                let rest = words.next().and_then(|_| line.get(5..)).unwrap_or_default().trim_ascii_start();
                let rest = rest.iter().position(u8::is_ascii_whitespace).map_or(&[][..], |end| &rest[end..]);
                self.trigger = date::parse(rest).and_then(Date::micros);
            }
            // `internal events logged`, `no internal events logged`, `End TriggerBlock`, `// version 13.0.0`.
            b"internal" | b"no" | b"end" => {}
            comment if comment.starts_with(b"//") => {}
            _ => return Err(Damage::UnknownLine),
        }
        Ok(Entry::Blank)
    }

    /// The time of a line, since 1970 where the start is known.
    fn time(&mut self, text: &[u8]) -> Result<Micros, Damage> {
        let stamp = number::micros(text, 6).ok_or(Damage::BadTime)?;
        let since_start = if self.relative { self.last + stamp } else { stamp };
        if let Some(trigger) = self.trigger.take() {
            // Times may count from the `date` line or, in files of some writers and where they begin anew,
            // from the trigger.
            let from_date = self.date.filter(|date| {
                let passed = trigger - *date;
                passed >= Micros(0) && (since_start + SLACK) >= passed
            });
            if self.start.is_none() || since_start < self.last {
                self.start = Some(from_date.unwrap_or(trigger));
            }
        }
        self.last = since_start;
        let start = *self.start.get_or_insert(self.date.unwrap_or_default());
        Ok(start + since_start)
    }

    /// `100x Rx d 8 00 11 …`, `100 Rx r 8`, `ErrorFrame`.
    fn classic(&self, time: Micros, channel: u32, mut words: Words) -> Result<Entry, Damage> {
        let Some(id) = words.next() else { return Err(Damage::FewColumns) };
        if id.eq_ignore_ascii_case(b"ErrorFrame") {
            return Ok(Entry::Frame(channel, error_frame(time)?));
        }
        let direction = words.next().unwrap_or_default();
        if !is_on_the_bus(direction) {
            return Ok(Entry::Other);
        }
        let id = self.id(id)?;
        let kind = words.next().ok_or(Damage::FewColumns)?;
        let length = words.next().map(|text| number::unsigned(text, self.base));
        let frame = match kind {
            b"d" | b"D" => {
                let length = length.ok_or(Damage::FewColumns)?.ok_or(Damage::BadLength)?;
                let mut bytes = [0; 64];
                // A length code above 8 means 8.
                let data = &mut bytes[..length.min(8) as usize];
                if !words.bytes(self.base, data) {
                    return Err(Damage::BadBytes);
                }
                data_frame(time, id, FrameKind::Data, data)?
            }
            // Older versions give no length.
            b"r" | b"R" => remote_frame(time, id, length.flatten().unwrap_or(0) as usize)?,
            _ => return Ok(Entry::Other),
        };
        Ok(Entry::Frame(channel, frame))
    }

    /// `1 Rx 123 [Name] brs esi dlc length data… duration length flags …`.
    fn fd(&self, time: Micros, mut words: Words) -> Result<Entry, Damage> {
        let mut next = || words.next().ok_or(Damage::FewColumns);
        let channel = number::unsigned(next()?, 10).ok_or(Damage::BadNumber)?.saturating_sub(1);
        let direction = next()?;
        let id = next()?;
        if id.eq_ignore_ascii_case(b"ErrorFrame") {
            return Ok(Entry::Frame(channel, error_frame(time)?));
        }
        if !is_on_the_bus(direction) {
            return Ok(Entry::Other);
        }
        let id = self.id(id)?;
        // A name cannot begin with a digit.
        let mut switch = next()?;
        if !switch.first().is_some_and(u8::is_ascii_digit) {
            switch = next()?;
        }
        let error_state = next()? == b"1";
        // Always hexadecimal, whatever the base.
        let code = number::unsigned(next()?, 16).ok_or(Damage::BadLength)?;
        let length = number::unsigned(next()?, 10).ok_or(Damage::BadLength)? as usize;
        let mut bytes = [0; 64];
        if length > bytes.len() {
            return Err(Damage::TooLong);
        }
        if !words.bytes(self.base, &mut bytes[..length]) {
            return Err(Damage::BadBytes);
        }
        let flags = words.nth(2).and_then(|flags| number::unsigned(flags, 16));
        let kind = FrameKind::Fd { bit_rate_switch: switch == b"1", error_state };
        // Lines of an FD channel can be classic frames.
        let frame = match flags {
            Some(flags) if flags & FLAG_REMOTE != 0 => remote_frame(time, id, code as usize)?,
            Some(flags) if flags & FLAG_FD == 0 => Self::plain(time, id, &bytes[..length])?,
            _ if length == 0 && fd_length(code) != Some(0) => remote_frame(time, id, code as usize)?,
            _ => data_frame(time, id, kind, &bytes[..length])?,
        };
        Ok(Entry::Frame(channel, frame))
    }

    fn plain(time: Micros, id: CanId, data: &[u8]) -> Result<Frame, Damage> {
        data_frame(time, id, FrameKind::Data, data)
    }

    fn id(&self, text: &[u8]) -> Result<CanId, Damage> {
        let (digits, extended) = match text {
            [digits @ .., b'x' | b'X'] => (digits, true),
            _ => (text, false),
        };
        identifier(number::unsigned(digits, self.base).ok_or(Damage::BadNumber)?, extended)
    }
}

/// A `TxRq` is a wish only.
fn is_on_the_bus(direction: &[u8]) -> bool {
    direction.eq_ignore_ascii_case(b"Rx") || direction.eq_ignore_ascii_case(b"Tx")
}
