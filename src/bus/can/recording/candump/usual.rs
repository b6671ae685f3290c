//! The line of nearly every recording, `(1760000000.000584) can0 123#0011223344556677`: a data frame of classic CAN,
//! with nothing unusual about it.
//!
//! It is read a word at a time, not a character at a time. What it is not sure of it leaves to [`line`](super::line),
//! which knows the whole grammar and says what is wrong.

use crate::can::recording::digits::{decimal, digit, first, first_up_to, hexadecimal};
use crate::can::{CanId, Frame};
use physics::Micros;

/// What a usual line says, and where it ends.
pub(super) struct Usual<'a> {
    pub interface: &'a [u8],
    pub time: Micros,
    id: CanId,
    /// The frame's bytes, zeros behind them, and how many there are.
    data: [u8; 8],
    count: usize,
    /// Bytes of the line, its newline among them.
    pub length: usize,
}

impl Usual<'_> {
    /// The frame. To be asked for where it is to stay: it is several times as large as what there is to say of it.
    #[inline]
    pub fn frame(&self) -> Frame {
        Frame::of_eight(self.time, self.id, self.data, self.count)
    }
}

/// The second that was read last: of thousands of lines it is the same.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Second {
    /// Its digits and the point after them, and where they are in a word; no text has none of them.
    text: u128,
    place: u128,
    count: usize,
    time: Micros,
}

/// Reads the line that `text` begins with. Whole words are looked at, so a little more than the line must be there.
#[inline]
pub(super) fn parse<'a>(text: &'a [u8], second: &mut Second) -> Option<Usual<'a>> {
    let (time, rest) = stamp(text.strip_prefix(b"(")?, second)?;
    let rest = rest.strip_prefix(b" ")?;
    // Names of interfaces are shorter than eight characters, but for some.
    let space = match first_up_to(*rest.first_chunk()?, b' ') {
        8 => rest.iter().position(|byte| *byte == b' ' || *byte == b'\n')?,
        space => space,
    };
    if space == 0 {
        return None;
    }
    let (interface, rest) = rest.split_at(space);
    let (id, digits) = identifier(rest.strip_prefix(b" ")?)?;
    let (data, digits_of_data) = data(digits)?;
    let length = text.len() - digits.len() + digits_of_data + 1;
    Some(Usual { interface, time, id, data, count: digits_of_data / 2, length })
}

/// `1760000000.000584)`: seconds of up to twelve digits and whole microseconds.
#[inline]
pub(super) fn stamp<'a>(text: &'a [u8], second: &mut Second) -> Option<(Micros, &'a [u8])> {
    let start = text.first_chunk::<16>()?;
    let is_the_same = second.count > 0 && (u128::from_le_bytes(*start) ^ second.text) & second.place == 0;
    if !is_the_same {
        *second = seconds(start)?;
    }
    let (fraction, rest) = text[second.count..].split_first_chunk::<8>()?;
    let [.., b')'] = fraction else { return None };
    // The parenthesis is pushed out at the end; zeros take the place of the point and of what was before it.
    let digits = u64::from_le_bytes(*fraction) << 8 & !0xFFFF | u64::from_le_bytes(*b"00\0\0\0\0\0\0");
    let micros = decimal(digits.to_le_bytes())?;
    Some((Micros(second.time.0 + micros), rest))
}

/// The digits before the point.
fn seconds(start: &[u8; 16]) -> Option<Second> {
    let [low, high] = [0, 1].map(|half| start.as_chunks().0[half]);
    let count = match first(low, b'.') {
        8 => 8 + first(high, b'.'),
        count => count,
    };
    if count == 0 || count > 12 {
        return None;
    }
    // The digits moved to the end of the word, zeros before them.
    let zeros = u128::from_le_bytes([b'0'; 16]);
    let text = u128::from_le_bytes(*start);
    let digits = text << (128 - 8 * count) | zeros >> (8 * count);
    let high = decimal((digits as u64).to_le_bytes())?;
    let low = decimal(((digits >> 64) as u64).to_le_bytes())?;
    let time = Micros((high * 100_000_000 + low) * Micros::PER_SECOND);
    Some(Second { text, place: u128::MAX >> (120 - 8 * count), count, time })
}

/// Three digits of a standard or eight of an extended identifier, and what follows the `#`.
#[inline]
fn identifier(text: &[u8]) -> Option<(CanId, &[u8])> {
    match text {
        [a, b, c, b'#', digits @ ..] => {
            let number = digit(*a)? << 8 | digit(*b)? << 4 | digit(*c)?;
            Some((CanId::standard(number)?, digits))
        }
        _ => {
            let (number, rest) = text.split_first_chunk::<8>()?;
            let id = CanId::extended(u32::from_be_bytes(hexadecimal(*number)?))?;
            Some((id, rest.strip_prefix(b"#")?))
        }
    }
}

/// Up to eight bytes, and how many digits there are of them before the newline.
#[inline]
fn data(text: &[u8]) -> Option<([u8; 8], usize)> {
    let (words, after) = text.split_first_chunk::<16>()?;
    let [low, high] = *words.as_chunks::<8>().0 else { return None };
    // Most frames have all eight bytes.
    if after.first() == Some(&b'\n')
        && let (Some([a, b, c, d]), Some([e, f, g, h])) = (hexadecimal(low), hexadecimal(high))
    {
        return Some(([a, b, c, d, e, f, g, h], 16));
    }
    let count = match (first(low, b'\n'), first(high, b'\n')) {
        (8, 8) => return None,
        (8, further) => 8 + further,
        (count, _) => count,
    };
    if !count.is_multiple_of(2) {
        return None;
    }
    // Zeros from the newline on.
    let zeros = u64::from_le_bytes([b'0'; 8]);
    let up_to = |word: [u8; 8], digits: usize| match digits {
        8.. => word,
        digits => {
            let kept = (1 << (8 * digits)) - 1;
            (u64::from_le_bytes(word) & kept | zeros & !kept).to_le_bytes()
        }
    };
    let [a, b, c, d] = hexadecimal(up_to(low, count))?;
    let [e, f, g, h] = hexadecimal(up_to(high, count.saturating_sub(8)))?;
    Some(([a, b, c, d, e, f, g, h], count))
}

#[cfg(test)]
mod tests {
    use super::super::line::{self, Line};
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn what_it_reads_is_what_the_whole_grammar_reads() {
        let mut usual = 0;
        let mut second = Second::default();
        for data in
            ["", "00", "a1B2", "112233", "11223344556677", "0011223344556677", "1", "0g", "R", "R8", "#1AB"]
        {
            for id in ["123", "7FF", "800", "12345678", "1FFFFFFF", "20000080", "F00"] {
                for interface in ["can0", "vcan1", "x", ""] {
                    for stamp in [
                        "1760000000.000584",
                        "0000000001.000000",
                        "46408.584930",
                        "7.000001",
                        "123456789012.999999",
                        "1234567890123.000000",
                        ".123456",
                        "1.5",
                        "-1.500000",
                        "176000000O.000584",
                    ] {
                        for end in ["", " ", "\r", " R"] {
                            let line = format!("({stamp}) {interface} {id}#{data}{end}");
                            let text = format!("{line}\n{line}\n");
                            let Some(read) = parse(text.as_bytes(), &mut second) else { continue };
                            usual += 1;
                            let whole = Line::Frame { interface: read.interface, frame: read.frame() };
                            assert_eq!(line::parse(line.as_bytes()), Ok(whole), "{line}");
                            assert_eq!((read.interface, read.length), (interface.as_bytes(), line.len() + 1));
                        }
                    }
                }
            }
        }
        // Five stamps, three interfaces, six lengths, four identifiers (F00 is above 7FF).
        assert_eq!(usual, 5 * 3 * 6 * 4);
    }

    proptest! {
        #[test]
        fn spoiled_lines_are_read_alike_or_left_to_the_grammar(
            start in 0usize..3,
            before in 0usize..4,
            spoiled in proptest::collection::vec((any::<proptest::sample::Index>(), any::<u8>(), 0u8..3), 0..4),
        ) {
            let usual = ["(1760000000.000584) can0 123#0011223344556677", "(46408.584930) vcan12 18FEF100#1A2B", "(0.000001) c 7FF#"];
            let mut line = usual[start].as_bytes().to_vec();
            for (place, byte, how) in spoiled {
                let place = place.index(line.len());
                match how {
                    0 => line[place] = byte,
                    1 => line[place] = b"0123456789abcdefABCDEF#. )(R\n"[usize::from(byte) % 29],
                    _ => line.truncate(place.max(1)),
                }
            }
            let text = [line.as_slice(), b"\n(1760000000.000584) can0 123#0011223344556677\n"].concat();
            // The second of this line or of another one was read before, or none.
            let mut second = Second::default();
            if let Some(line) = usual.get(before) {
                let text = [line, "\n", line, "\n"].concat();
                prop_assert!(parse(text.as_bytes(), &mut second).is_some());
            }
            if let Some(usual) = parse(&text, &mut second) {
                let read = &text[..usual.length - 1];
                prop_assert!(text[usual.length - 1] == b'\n' && !read.contains(&b'\n'));
                let (interface, frame) = (usual.interface, usual.frame());
                prop_assert_eq!(line::parse(read), Ok(Line::Frame { interface, frame }));
            }
        }
    }
}
