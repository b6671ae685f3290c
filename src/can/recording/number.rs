//! Numbers as texts have them, exactly.

use crate::Micros;

/// A decimal number (`12`, `-0.5`, `1.5e-05`) in units of `10^places` a microsecond (6: seconds, 3:
/// milliseconds), rounded to the nearest; `None` if it is none, or beyond any clock.
pub fn micros(text: &[u8], places: i32) -> Option<Micros> {
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
    // Until the year 33658, as candump logs.
    let value = i64::try_from(value).ok().filter(|value| *value < 1_000_000_000_000 * Micros::PER_SECOND)?;
    Some(Micros(if negative { -value } else { value }))
}

/// A small decimal number with a sign.
fn signed(text: &[u8]) -> Option<i32> {
    std::str::from_utf8(text).ok()?.parse().ok().filter(|number: &i32| number.abs() < 100)
}

/// A number without a sign in base 10 or 16, of at most eight digits.
pub fn unsigned(text: &[u8], base: u32) -> Option<u32> {
    if text.is_empty() || text.len() > 10 {
        return None;
    }
    let mut value = 0_u32;
    for &byte in text {
        value = value.checked_mul(base)?.checked_add(char::from(byte).to_digit(base)?)?;
    }
    Some(value)
}

/// A byte: two hexadecimal digits, or up to three decimal ones.
pub fn byte(text: &[u8], base: u32) -> Option<u8> {
    let fits = if base == 16 { text.len() == 2 } else { text.len() <= 3 };
    if fits { u8::try_from(unsigned(text, base)?).ok() } else { None }
}

/// The words of a line.
pub fn words(line: &[u8]) -> impl Iterator<Item = &[u8]> {
    line.split(u8::is_ascii_whitespace).filter(|word| !word.is_empty())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn times_are_exact_and_rounded_to_the_nearest() {
        let seconds = |text: &str| micros(text.as_bytes(), 6).map(|time| time.0);
        assert_eq!(seconds("1760000000.000584"), Some(1_760_000_000_000_584));
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
