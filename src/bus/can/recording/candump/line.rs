//! Takes one line of a candump log apart.
//!
//! Works on bytes, allocates nothing and looks at each byte about once: a recording is read at the
//! speed of the disk.

use super::usual;
use crate::can::recording::Damage;
use crate::can::recording::digits::{HEX, NO_DIGIT};
use crate::can::wire::{ERROR, EXTENDED, REMOTE, fd_kind};
use crate::can::{CanId, Frame, FrameError, FrameKind};
use physics::Micros;

/// What a line says.
#[derive(Debug, PartialEq)]
pub(super) enum Line<'a> {
    /// A frame on an interface.
    Frame {
        /// The interface's name.
        interface: &'a [u8],
        /// The frame.
        frame: Frame,
    },
    /// A CAN XL frame, whose content is not of interest.
    Xl,
    /// The recorder says that it lost so many frames.
    Dropped(u64),
    /// Blank, or a comment.
    Blank,
}

/// Takes one line (without its newline) apart.
#[inline]
pub(super) fn parse(line: &[u8]) -> Result<Line<'_>, Damage> {
    let line = line.trim_ascii();
    match line.first() {
        None | Some(b'#' | b';') => return Ok(Line::Blank),
        Some(b'(') => {}
        Some(_) => return parse_note(line),
    }
    let (time, rest) = parse_stamp(&line[1..])?;
    let (interface, rest) = word(rest).ok_or(Damage::Incomplete)?;
    let text = match rest.trim_ascii_start() {
        [] => return Err(Damage::Incomplete),
        [text @ .., b' ' | b'\t', b'T' | b'R'] => text.trim_ascii_end(),
        text => text,
    };
    match parse_frame(time, text) {
        Ok(Some(frame)) => Ok(Line::Frame { interface, frame }),
        Ok(None) => Ok(Line::Xl),
        Err(damage) => Err(diagnose(text, damage)),
    }
}

/// The frame was not understood: perhaps because something stands behind it.
#[cold]
fn diagnose(text: &[u8], damage: Damage) -> Damage {
    match word(text) {
        Some((first, rest)) if !rest.is_empty() => {
            if first.contains(&b'#') {
                Damage::Trailing
            } else {
                Damage::NoFrame
            }
        }
        _ => damage,
    }
}

/// A line without a stamp: `DROPCOUNT: dropped 3 CAN frames on 'can0' socket (total drops 5)`.
#[cold]
fn parse_note(line: &[u8]) -> Result<Line<'_>, Damage> {
    let rest = line.strip_prefix(b"DROPCOUNT: dropped ").ok_or(Damage::NoStamp)?;
    let digits = rest.iter().take_while(|byte| byte.is_ascii_digit()).count();
    if digits == 0 || digits > 18 {
        return Err(Damage::BadDropCount);
    }
    Ok(Line::Dropped(rest[..digits].iter().fold(0, |sum, &byte| sum * 10 + u64::from(byte - b'0'))))
}

/// The next word and what follows it, if there is one.
#[inline]
fn word(text: &[u8]) -> Option<(&[u8], &[u8])> {
    let start = text.iter().position(|byte| !is_blank(*byte))?;
    let text = &text[start..];
    let end = text.iter().position(|byte| is_blank(*byte)).unwrap_or(text.len());
    Some(text.split_at(end))
}

#[inline]
fn is_blank(byte: u8) -> bool {
    byte == b' ' || byte == b'\t'
}

/// Digits at the start as a number (at most 18 of them) and how many there are.
fn number(text: &[u8]) -> (i64, usize) {
    let mut value = 0;
    let mut count = 0;
    for &byte in text {
        let digit = byte.wrapping_sub(b'0');
        if digit > 9 || count == 18 {
            break;
        }
        value = value * 10 + i64::from(digit);
        count += 1;
    }
    (value, count)
}

/// `seconds.fraction)`, cut to whole microseconds as candump itself does; what follows it.
#[inline]
fn parse_stamp(text: &[u8]) -> Result<(Micros, &[u8]), Damage> {
    usual::stamp(text, &mut usual::Second::default()).map_or_else(|| any_stamp(text), Ok)
}

/// Seconds and fraction of any length.
fn any_stamp(text: &[u8]) -> Result<(Micros, &[u8]), Damage> {
    let (negative, text) = match text {
        [b'-', rest @ ..] => (true, rest),
        _ => (false, text),
    };
    let (seconds, digits) = number(text);
    // 12 digits: until the year 33658, and no overflow below.
    if digits == 0 || digits > 12 {
        return Err(Damage::BadStamp);
    }
    let mut rest = &text[digits..];
    let mut micros = 0;
    if let [b'.', fraction @ ..] = rest {
        let (value, digits) = number(fraction);
        if digits == 0 {
            return Err(Damage::BadStamp);
        }
        micros = match digits {
            6 => value,
            1..6 => value * 10_i64.pow(6 - digits as u32),
            _ => value / 10_i64.pow(digits as u32 - 6),
        };
        rest = &fraction[digits..];
    }
    let [b')', rest @ ..] = rest else { return Err(Damage::BadStamp) };
    let time = seconds * Micros::PER_SECOND + micros;
    Ok((Micros(if negative { -time } else { time }), rest))
}

/// `identifier#…`; `None` for a CAN XL frame.
#[inline]
fn parse_frame(time: Micros, text: &[u8]) -> Result<Option<Frame>, Damage> {
    let (id_text, body) = if text.get(3) == Some(&b'#') {
        (&text[..3], &text[4..])
    } else if text.get(8) == Some(&b'#') {
        (&text[..8], &text[9..])
    } else if text.get(5) == Some(&b'#') && is_xl(&text[6..]) {
        // Two digits of virtual network and three of priority.
        return if hex_number(&text[..5]).is_some() { Ok(None) } else { Err(Damage::BadId) };
    } else {
        return Err(if text.contains(&b'#') { Damage::BadId } else { Damage::NoFrame });
    };
    let number = hex_number(id_text).ok_or(Damage::BadId)?;
    if id_text.len() == 3 && is_xl(body) {
        return Ok(None);
    }
    let (id, is_error) = identifier(number, id_text.len() == 3)?;
    let (kind, data) = match body {
        [b'R' | b'r', length @ ..] if !is_error => return parse_remote(time, id, length).map(Some),
        [b'#', rest @ ..] if !is_error => parse_fd_flags(rest)?,
        _ if is_error => (FrameKind::Error, body),
        _ => (FrameKind::Data, body),
    };
    Ok(Some(parse_data(time, id, kind, data)?))
}

/// Is what follows the `#` the header of a CAN XL frame, `flags:sdt:af#data`?
#[inline]
fn is_xl(body: &[u8]) -> bool {
    body.get(2) == Some(&b':') && body.get(5) == Some(&b':') && body.get(14) == Some(&b'#')
}

/// The identifier (of an error frame: its class), and whether it marks an error frame.
#[inline]
fn identifier(number: u32, standard: bool) -> Result<(CanId, bool), Damage> {
    if standard {
        return CanId::standard(number).map(|id| (id, false)).ok_or(Damage::IdTooLarge);
    }
    // Some writers print the kernel's mark of an extended identifier; canplayer ignores it as well.
    let number = number & !EXTENDED;
    if number & REMOTE != 0 {
        return Err(Damage::IdTooLarge);
    }
    let id = CanId::extended(number & !ERROR).ok_or(Damage::IdTooLarge)?;
    Ok((id, number & ERROR != 0))
}

/// The flags digit after `##`, and the data after it.
#[inline]
fn parse_fd_flags(text: &[u8]) -> Result<(FrameKind, &[u8]), Damage> {
    let [flags, data @ ..] = text else { return Err(Damage::BadFlags) };
    let flags = HEX[usize::from(*flags)];
    if flags == NO_DIGIT {
        return Err(Damage::BadFlags);
    }
    Ok((fd_kind(flags), data))
}

/// What follows the `R`: nothing, a length, a length of 8 and a raw length code.
fn parse_remote(time: Micros, id: CanId, text: &[u8]) -> Result<Frame, Damage> {
    let length = match without_raw_length_code(text) {
        [] => 0,
        [digit @ b'0'..=b'8'] => usize::from(digit - b'0'),
        _ => return Err(Damage::BadRemote),
    };
    Frame::remote(time, id, length).map_err(|_| Damage::BadRemote)
}

/// Data of a classic, FD or error frame.
#[inline]
fn parse_data(time: Micros, id: CanId, kind: FrameKind, text: &[u8]) -> Result<Frame, Damage> {
    let mut bytes = [0; 64];
    let length = match hex_bytes(text, &mut bytes) {
        Some(length) => length,
        None => {
            let is_fd = matches!(kind, FrameKind::Fd { .. });
            let text = if is_fd { text } else { without_raw_length_code(text) };
            spaced_hex_bytes(text, &mut bytes)?
        }
    };
    Frame::from_payload(time, id, kind, bytes, length).map_err(|error| match error {
        FrameError::NotAnFdLength(_) => Damage::NotAnFdLength,
        FrameError::TooLongForClassic(_) => Damage::TooLong,
    })
}

/// A classic frame of 8 bytes can carry a raw length code above 8: `…#1122334455667788_C`. It says
/// nothing about the data.
fn without_raw_length_code(text: &[u8]) -> &[u8] {
    match text {
        [data @ .., b'_', b'9' | b'A'..=b'F' | b'a'..=b'f'] => data,
        _ => text,
    }
}

/// Up to eight hexadecimal digits.
#[inline]
fn hex_number(text: &[u8]) -> Option<u32> {
    let mut value = 0;
    let mut seen = 0;
    for &byte in text {
        let digit = HEX[usize::from(byte)];
        seen |= digit;
        value = value << 4 | u32::from(digit & 0xF);
    }
    (seen != NO_DIGIT).then_some(value)
}

/// Pairs of digits without anything between them: the fast way, for nearly every line.
#[inline]
fn hex_bytes(text: &[u8], bytes: &mut [u8; 64]) -> Option<usize> {
    if text.len() > 128 || !text.len().is_multiple_of(2) {
        return None;
    }
    let mut seen = 0;
    for (pair, byte) in text.chunks_exact(2).zip(bytes.iter_mut()) {
        let (high, low) = (HEX[usize::from(pair[0])], HEX[usize::from(pair[1])]);
        seen |= high | low;
        *byte = high << 4 | low & 0xF;
    }
    (seen != NO_DIGIT).then_some(text.len() / 2)
}

/// Pairs of digits, any of them with a `.` before it.
#[cold]
fn spaced_hex_bytes(text: &[u8], bytes: &mut [u8; 64]) -> Result<usize, Damage> {
    let mut length = 0;
    let mut rest = text;
    while let [high, low, after @ ..] = rest.strip_prefix(b".").unwrap_or(rest) {
        let value = hex_number(&[*high, *low]).ok_or(Damage::BadData)?;
        *bytes.get_mut(length).ok_or(Damage::TooLong)? = value as u8;
        length += 1;
        rest = after;
    }
    if rest.is_empty() { Ok(length) } else { Err(Damage::BadData) }
}
