//! Numbers as texts have them, exactly.

use crate::can::recording::digits;
use physics::Micros;

/// Where texts are read until the end of the year 33658, as candump logs.
const END: i64 = 1_000_000_000_000 * Micros::PER_SECOND;

/// A decimal number (`12`, `-0.5`, `1.5e-05`) in units of `10^places` a microsecond (6: seconds, 3:
/// milliseconds), rounded to the nearest; `None` if it is none, or beyond any clock.
pub fn micros(text: &[u8], places: i32) -> Option<Micros> {
    plain_micros(text, places).or_else(|| any_micros(text, places))
}

/// The usual number: up to 18 digits and no more decimals than microseconds have.
fn plain_micros(text: &[u8], places: i32) -> Option<Micros> {
    let (mut value, mut point) = (0_i64, None);
    if text.len() > 18 {
        return None;
    }
    for (place, &byte) in text.iter().enumerate() {
        let digit = byte.wrapping_sub(b'0');
        if digit <= 9 {
            value = 10 * value + i64::from(digit);
        } else if byte == b'.' && point.is_none() {
            point = Some(place);
        } else {
            return None;
        }
    }
    let decimals = point.map_or(0, |point| text.len() - point - 1);
    let is_number = text.len() > usize::from(point.is_some());
    let missing = u32::try_from(places).ok()?.checked_sub(u32::try_from(decimals).ok()?)?;
    let value = value.checked_mul(10_i64.checked_pow(missing)?)?;
    (is_number && value < END).then_some(Micros(value))
}

/// Any number.
fn any_micros(text: &[u8], places: i32) -> Option<Micros> {
    let (negative, text) = match text {
        [b'-', rest @ ..] => (true, rest),
        [b'+', rest @ ..] => (false, rest),
        _ => (false, text),
    };
    let (text, mut exponent) = match text.iter().position(|byte| matches!(byte, b'e' | b'E')) {
        Some(place) => (&text[..place], signed(&text[place + 1..])?),
        None => (text, 0),
    };
    // Digits beyond these say nothing of microseconds.
    const DIGITS: u32 = 30;
    let (mut value, mut digits, mut any, mut point) = (0_i128, 0, false, false);
    for &byte in text {
        match byte {
            b'.' if !point => point = true,
            b'0'..=b'9' => {
                any = true;
                if digits < DIGITS {
                    value = value * 10 + i128::from(byte - b'0');
                    digits += u32::from(value != 0);
                    exponent -= i32::from(point);
                } else if !point {
                    return None;
                }
            }
            _ => return None,
        }
    }
    let shift = exponent.checked_add(places)?;
    let value = match shift {
        _ if !any => return None,
        0.. => value.checked_mul(10_i128.checked_pow(shift.unsigned_abs())?)?,
        _ => match 10_i128.checked_pow(shift.unsigned_abs()) {
            Some(unit) => (value + unit / 2) / unit,
            None => 0,
        },
    };
    let value = i64::try_from(value).ok().filter(|value| *value < END)?;
    Some(Micros(if negative { -value } else { value }))
}

/// A small decimal number with a sign.
fn signed(text: &[u8]) -> Option<i32> {
    std::str::from_utf8(text).ok()?.parse().ok().filter(|number: &i32| number.abs() < 100)
}

/// A number without a sign in base 10 or 16, of at most ten digits.
pub fn unsigned(text: &[u8], base: u32) -> Option<u32> {
    if text.is_empty() || text.len() > 10 {
        return None;
    }
    let mut value = 0_u64;
    for &byte in text {
        let digit = digits::digit(byte).filter(|digit| *digit < base)?;
        value = value * u64::from(base) + u64::from(digit);
    }
    u32::try_from(value).ok()
}

/// A byte: two hexadecimal digits, or up to three decimal ones.
pub fn byte(text: &[u8], base: u32) -> Option<u8> {
    match (base, text) {
        (16, [high, low]) => digits::pair(*high, *low),
        (16, _) => None,
        _ if text.len() <= 3 => u8::try_from(unsigned(text, base)?).ok(),
        _ => None,
    }
}

/// The words of a line.
pub fn words(line: &[u8]) -> Words<'_> {
    Words(line)
}

/// What is left of a line, word by word.
#[derive(Clone)]
pub struct Words<'a>(&'a [u8]);

impl<'a> Iterator for Words<'a> {
    type Item = &'a [u8];

    #[inline]
    fn next(&mut self) -> Option<&'a [u8]> {
        let start = self.0.iter().position(|byte| !byte.is_ascii_whitespace())?;
        let rest = &self.0[start..];
        let end = rest.iter().position(u8::is_ascii_whitespace).unwrap_or(rest.len());
        let (word, rest) = rest.split_at(end);
        self.0 = rest;
        Some(word)
    }
}

impl Words<'_> {
    /// Takes words that are bytes in base 10 or 16; `false` if there are not as many.
    pub fn bytes(&mut self, base: u32, bytes: &mut [u8]) -> bool {
        for place in bytes {
            // Nearly always so.
            if let [b' ', high, low, rest @ ..] = self.0
                && base == 16
                && rest.first().is_none_or(u8::is_ascii_whitespace)
                && let Some(byte) = digits::pair(*high, *low)
            {
                (*place, self.0) = (byte, rest);
                continue;
            }
            let Some(byte) = self.next().and_then(|word| byte(word, base)) else { return false };
            *place = byte;
        }
        true
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn times_are_exact_and_rounded_to_the_nearest() {
        let seconds = |text: &str| micros(text.as_bytes(), 6).map(|time| time.0);
        assert_eq!(seconds("1760000000.000584"), Some(1_760_000_000_000_584));
        assert_eq!(seconds("1760000000.00058449"), Some(1_760_000_000_000_584));
        assert_eq!(seconds(".5"), Some(500_000));
        assert_eq!(seconds("5."), Some(5_000_000));
        assert_eq!(
            (seconds("999999999999.9"), seconds("1000000000000")),
            (Some(999_999_999_999_900_000), None)
        );
        assert_eq!(seconds("0.0000004999"), Some(0));
        assert_eq!(seconds("0.0000005"), Some(1));
        assert_eq!(seconds("-1.5"), Some(-1_500_000));
        assert_eq!(seconds("1.5e-05"), Some(15));
        assert_eq!(seconds("2E3"), Some(2_000_000_000));
        assert_eq!(seconds("1e-99"), Some(0));
        assert_eq!(micros(b"1841.3", 3), Some(Micros(1_841_300)));
        for bad in ["", ".", "-", "1.2.3", "1e", "1e999", "nan", "1,5", "99999999999999", "1 "] {
            assert_eq!(seconds(bad), None, "{bad}");
        }
        assert_eq!(seconds(&"9".repeat(400)), None);
        assert_eq!(seconds(&format!("0.{}", "3".repeat(400))), Some(333_333));
    }

    proptest::proptest! {
        #[test]
        fn the_usual_number_is_read_as_any(text in "[0-9]{0,12}[.]?[0-9]{0,9}|[-0-9.e]{0,20}", places in 3..7) {
            let plain = plain_micros(text.as_bytes(), places);
            proptest::prop_assert!(plain.is_none() || plain == any_micros(text.as_bytes(), places));
        }
    }

    #[test]
    fn bytes_are_words() {
        for (text, base, expected) in [
            (" 1a FF 07", 16, Some([0x1A, 0xFF, 7])),
            ("1a  FF\t07 ", 16, Some([0x1A, 0xFF, 7])),
            (" 1 255 007 9", 10, Some([1, 255, 7])),
            (" 1a FF", 16, None),
            (" 1a FF 7", 16, None),
            (" 1a FF 071", 16, None),
            (" 1a FG 07", 16, None),
            (" 1 256 7", 10, None),
        ] {
            let mut bytes = [0; 3];
            let all = words(text.as_bytes()).bytes(base, &mut bytes);
            assert_eq!(all.then_some(bytes), expected, "{text}");
        }
    }

    #[test]
    fn numbers_fit_or_are_none() {
        assert_eq!(unsigned(b"1FFFFFFF", 16), Some(0x1FFF_FFFF));
        assert_eq!(unsigned(b"4294967295", 10), Some(u32::MAX));
        assert_eq!(unsigned(b"4294967296", 10), None);
        assert_eq!(unsigned(b"", 10), None);
        assert_eq!(
            (byte(b"fF", 16), byte(b"F", 16), byte(b"256", 10), byte(b"7", 10)),
            (Some(255), None, None, Some(7))
        );
    }
}
