//! python-can's CSV: `timestamp,arbitration_id,extended,remote,error,dlc,data`, the data in base64.
//!
//! It does not tell FD frames from others: more than 8 bytes are one, without a bit rate switch.

use super::lines::{Entry, Grammar};
use super::{Damage, data_frame, error_frame, identifier, number, remote_frame};
use crate::can::FrameKind;
use crate::can::recording::digits::NO_DIGIT;

/// The grammar; no line depends on another.
pub struct Csv;

impl Grammar for Csv {
    fn line(&mut self, line: &[u8]) -> Result<Entry, Damage> {
        if line.is_empty() || line.starts_with(b"timestamp,") {
            return Ok(Entry::Blank);
        }
        let mut columns = line.split(|byte| *byte == b',');
        let mut column = || columns.next().map(<[u8]>::trim_ascii).ok_or(Damage::FewColumns);
        let (time, id, extended) = (column()?, column()?, flag(column()?)?);
        let (remote, error) = (flag(column()?)?, flag(column()?)?);
        let (length, data) = (column()?, column()?);
        if columns.next().is_some() {
            return Err(Damage::UnknownLine);
        }
        let time = number::micros(time, 6).ok_or(Damage::BadTime)?;
        let id = id.strip_prefix(b"0x").or_else(|| id.strip_prefix(b"0X")).unwrap_or(id);
        let id = identifier(number::unsigned(id, 16).ok_or(Damage::BadNumber)?, extended)?;
        let length = number::unsigned(length, 10).ok_or(Damage::BadLength)? as usize;
        if error {
            return Ok(Entry::Frame(0, error_frame(time)?));
        }
        if remote {
            return Ok(Entry::Frame(0, remote_frame(time, id, length)?));
        }
        let mut bytes = [0; 64];
        let count = base64(data, &mut bytes).ok_or(Damage::BadBytes)?;
        if count != length {
            return Err(Damage::BadBytes);
        }
        let fd = FrameKind::Fd { bit_rate_switch: false, error_state: false };
        let kind = if count > 8 { fd } else { FrameKind::Data };
        Ok(Entry::Frame(0, data_frame(time, id, kind, &bytes[..count])?))
    }
}

fn flag(text: &[u8]) -> Result<bool, Damage> {
    match text {
        b"0" => Ok(false),
        b"1" => Ok(true),
        _ => Err(Damage::UnknownLine),
    }
}

/// Value of each digit of base64, else [`NO_DIGIT`].
const VALUES: [u8; 256] = {
    let digits = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    let mut table = [NO_DIGIT; 256];
    let mut value = 0;
    while value < 64 {
        table[digits[value] as usize] = value as u8;
        value += 1;
    }
    table
};

/// Bytes of a text in base64 (RFC 4648, with its padding); `None` if it is none, or of more than 64 bytes.
fn base64(text: &[u8], bytes: &mut [u8; 64]) -> Option<usize> {
    if !text.len().is_multiple_of(4) {
        return None;
    }
    let digits = text.strip_suffix(b"==").or_else(|| text.strip_suffix(b"=")).unwrap_or(text);
    let count = digits.len() * 3 / 4;
    let mut places = bytes.get_mut(..count)?.iter_mut();
    for group in digits.chunks(4) {
        let mut bits = 0_u32;
        for place in 0..4 {
            let value = group.get(place).map_or(0, |byte| VALUES[usize::from(*byte)]);
            if value == NO_DIGIT {
                return None;
            }
            bits = bits << 6 | u32::from(value);
        }
        let [_, group @ ..] = bits.to_be_bytes();
        for byte in group {
            if let Some(place) = places.next() {
                *place = byte;
            }
        }
    }
    Some(count)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn base64_is_that_of_the_rfc() {
        for (text, expected) in [
            ("", ""),
            ("Zg==", "f"),
            ("Zm8=", "fo"),
            ("Zm9v", "foo"),
            ("Zm9vYg==", "foob"),
            ("Zm9vYmFy", "foobar"),
        ] {
            let mut bytes = [0; 64];
            let count = base64(text.as_bytes(), &mut bytes).unwrap();
            assert_eq!(&bytes[..count], expected.as_bytes());
        }
        for bad in ["Z", "Zg=", "Z===", "Zm9v\u{e9}", "Zm 9"] {
            assert_eq!(base64(bad.as_bytes(), &mut [0; 64]).filter(|count| *count > 0), None, "{bad}");
        }
        assert_eq!(base64("AAAA".repeat(22).as_bytes(), &mut [0; 64]), None, "66 bytes");
    }
}
