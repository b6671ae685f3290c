//! Numbers as texts of recordings have them, read eight characters at once: a machine word is eight characters
//! side by side.

use physics::Micros;

use crate::can::words::{TOP, Words, all, to_hexadecimal};

/// The place of the first such character; 8 if there is none.
#[inline]
pub(in crate::can) fn first(text: [u8; 8], character: u8) -> usize {
    // Where it stands there is a zero now, which borrows when one is taken off.
    let others = u64::from_le_bytes(text) ^ all(character);
    let zeros = others.wrapping_sub(all(1)) & !others & TOP;
    zeros.trailing_zeros() as usize / 8
}

/// The place of the first ASCII character that is this one or has a lower code; 8 if there is none.
#[inline]
pub(in crate::can) fn first_up_to(text: [u8; 8], character: u8) -> usize {
    // Where one is, one more than that borrows.
    let text = u64::from_le_bytes(text);
    let few = text.wrapping_sub(all(character + 1)) & !text & TOP;
    few.trailing_zeros() as usize / 8
}

/// Eight decimal digits: neighbours become pairs, pairs fours, fours the number.
#[inline]
pub(in crate::can) fn decimal(text: [u8; 8]) -> Option<i64> {
    let digits = u64::from_le_bytes(text) ^ all(b'0');
    // A byte above 9 shows in its upper half, now or after adding 6.
    if (digits | digits.wrapping_add(all(6))) & all(0xF0) != 0 {
        return None;
    }
    let pairs = (digits * 10 + (digits >> 8)) & 0x00FF_00FF_00FF_00FF;
    let fours = (pairs * 100 + (pairs >> 16)) & 0x0000_FFFF_0000_FFFF;
    Some((fours as u32 as i64) * 10_000 + (fours >> 32) as i64)
}

/// Value of each hexadecimal digit, else [`NO_DIGIT`].
pub(in crate::can) const HEX: [u8; 256] = {
    let mut table = [NO_DIGIT; 256];
    let mut value = 0;
    while value < 16 {
        table[b"0123456789ABCDEF"[value] as usize] = value as u8;
        table[b"0123456789abcdef"[value] as usize] = value as u8;
        value += 1;
    }
    table
};

/// What is none.
pub(in crate::can) const NO_DIGIT: u8 = 0xFF;

/// One hexadecimal digit.
#[inline]
pub(in crate::can) fn digit(character: u8) -> Option<u32> {
    let value = HEX[usize::from(character)];
    (value != NO_DIGIT).then_some(value.into())
}

/// Two of them: a byte.
#[inline]
pub(in crate::can) fn pair(high: u8, low: u8) -> Option<u8> {
    let (high, low) = (HEX[usize::from(high)], HEX[usize::from(low)]);
    (high | low != NO_DIGIT).then_some(high << 4 | low & 0xF)
}

/// Eight hexadecimal digits: four bytes, the first digit being the upper half of the first of them.
#[inline]
pub(in crate::can) fn hexadecimal(text: [u8; 8]) -> Option<[u8; 4]> {
    let text = u64::from_le_bytes(text);
    let ascii = text & !TOP;
    // Of a digit 0 to 9, of a letter 1 to 6; everything else is more, or zero.
    let (digit, letter) = (ascii ^ all(b'0'), (ascii | all(0x20)) ^ all(0x60));
    let no_digit = digit + all(0x7F - 9);
    let no_letter = (letter + all(0x7F - 6)) | !(letter + all(0x7F));
    if (text | no_digit & no_letter) & TOP != 0 {
        return None;
    }
    let halves = (ascii & all(0x0F)) + 9 * ((ascii >> 6) & all(1));
    let bytes = (halves << 4 | halves >> 8) & 0x00FF_00FF_00FF_00FF;
    let twos = (bytes | bytes >> 8) & 0x0000_FFFF_0000_FFFF;
    Some(((twos | twos >> 16) as u32).to_le_bytes())
}

/// Appends so many hexadecimal digits, upper case; eight at most.
#[inline]
pub(in crate::can) fn push_hexadecimal(text: &mut Vec<u8>, value: u32, digits: usize) {
    text.extend_from_slice(&to_hexadecimal(value.to_be_bytes())[8 - digits..]);
}

/// Appends as many hexadecimal digits as the number has, at least one.
pub(in crate::can) fn push_short_hexadecimal(text: &mut Vec<u8>, value: u32) {
    push_hexadecimal(text, value, (32 - value.leading_zeros() as usize).div_ceil(4).max(1));
}

/// Appends bytes as two hexadecimal digits each, with a blank before each.
pub(in crate::can) fn push_bytes(text: &mut Vec<u8>, bytes: &[u8]) {
    for byte in bytes {
        text.push(b' ');
        push_hexadecimal(text, u32::from(*byte), 2);
    }
}

/// Appends a number's decimal digits.
pub(in crate::can) fn push_decimal(text: &mut Vec<u8>, number: u64) {
    text.extend_from_slice(Words::default().decimal(number).text());
}

/// Appends `seconds.micros`, six digits of them.
pub(in crate::can) fn push_seconds(text: &mut Vec<u8>, time: Micros) {
    text.extend_from_slice(Words::default().seconds(time).text());
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::can::words::to_decimal;

    #[test]
    fn the_first_of_a_character_is_found() {
        for (text, place) in [(*b"abc.ef.h", 3), (*b"abcdefg.", 7), (*b"........", 0), (*b"abcd/-fg", 8)] {
            assert_eq!(first(text, b'.'), place);
        }
        for (text, place) in
            [(*b"can0 123", 4), (*b"can0\t \n3", 4), (*b"\x80can\xff\n  ", 5), (*b"vcan1234", 8)]
        {
            assert_eq!(first_up_to(text, b' '), place);
        }
    }

    #[test]
    fn decimal_digits_there_and_back() {
        let numbers = (0..100_000_000).step_by(9_973).chain([0, 9, 99_999_999, 10_000, 9_999]);
        for number in numbers {
            let text = to_decimal(number);
            assert_eq!(text, format!("{number:08}").as_bytes(), "{number}");
            assert_eq!(decimal(text), Some(i64::from(number)));
        }
    }

    #[test]
    fn hexadecimal_digits_there_and_back() {
        for number in (0..=u32::MAX).step_by(65_521).chain([0, 0x9A09_AF90, u32::MAX]) {
            let text = to_hexadecimal(number.to_be_bytes());
            assert_eq!(text, format!("{number:08X}").as_bytes(), "{number}");
            assert_eq!(hexadecimal(text), Some(number.to_be_bytes()));
            assert_eq!(hexadecimal(text.map(|digit| digit.to_ascii_lowercase())), Some(number.to_be_bytes()));
        }
    }

    #[test]
    fn numbers_of_any_length_and_sign() {
        let numbers = (0..20).flat_map(|digits| [0, 1, 9].map(|add| 10_u64.pow(digits) - 1 + add));
        for number in numbers.chain([u64::MAX, 1_760_000_000]) {
            let mut text = b"x".to_vec();
            push_decimal(&mut text, number);
            assert_eq!(text, format!("x{number}").as_bytes());
            for time in [number as i64, (number as i64).wrapping_neg()] {
                let mut text = Vec::new();
                push_seconds(&mut text, Micros(time));
                let (sign, micros) = (if time < 0 { "-" } else { "" }, time.unsigned_abs());
                let expected = format!("{sign}{}.{:06}", micros / 1_000_000, micros % 1_000_000);
                assert_eq!(text, expected.as_bytes());
            }
        }
    }

    #[test]
    fn every_other_character_is_refused_in_every_place() {
        for byte in 0..=u8::MAX {
            for place in 0..8 {
                let mut text = *b"12345678";
                text[place] = byte;
                assert_eq!(decimal(text).is_some(), byte.is_ascii_digit(), "{byte} at {place}");
                assert_eq!(hexadecimal(text).is_some(), byte.is_ascii_hexdigit(), "{byte} at {place}");
            }
        }
    }
}
