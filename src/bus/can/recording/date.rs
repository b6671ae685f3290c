//! Dates as formats give the start of a recording, taken for UTC.

use super::number;
use physics::time::Date;

/// As Vector writes it, `Thu Oct 09 08:53:20.123 2025`.
pub fn text(date: Date) -> String {
    const DAYS: [&str; 7] = ["Sun", "Mon", "Tue", "Wed", "Thu", "Fri", "Sat"];
    const MONTHS: [&str; 12] =
        ["Jan", "Feb", "Mar", "Apr", "May", "Jun", "Jul", "Aug", "Sep", "Oct", "Nov", "Dec"];
    let weekday = DAYS.get(date.weekday() as usize).unwrap_or(&"Sun");
    let month = MONTHS.get(date.month.saturating_sub(1) as usize).unwrap_or(&"Jan");
    let Date { year, day, hour, minute, second, milli, .. } = date;
    format!("{weekday} {month} {day:02} {hour:02}:{minute:02}:{second:02}.{milli:03} {year}")
}

/// As Vector writes it, `Thu Oct 09 08:53:20.123 am 2025`, with 12 or 24 hours, English or German.
pub fn parse(text: &[u8]) -> Option<Date> {
    let words: Vec<&[u8]> = number::words(text).collect();
    let (month, day, time, half, year) = match words.as_slice() {
        [_, month, day, time, year] => (month, day, time, None, year),
        [_, month, day, time, half, year] => (month, day, time, Some(half.to_ascii_lowercase()), year),
        _ => return None,
    };
    let mut parts = time.split(|byte| *byte == b':');
    let (hour, minute, rest) = (parts.next()?, parts.next()?, parts.next()?);
    let mut seconds = rest.splitn(2, |byte| *byte == b'.');
    let second = seconds.next()?;
    // Always thousandths: python-can leaves their leading zeros out.
    let milli = seconds.next().map_or(Some(0), |digits| {
        if digits.len() > 3 { number::unsigned(digits.get(..3)?, 10) } else { number::unsigned(digits, 10) }
    })?;
    let hour = number::unsigned(hour, 10)?;
    let hour = match half.as_deref() {
        None => hour,
        Some(b"am") => hour % 12,
        Some(b"pm") => hour % 12 + 12,
        Some(_) => return None,
    };
    Some(Date {
        year: number::unsigned(year, 10)?,
        month: month_number(month)?,
        day: number::unsigned(day, 10)?,
        hour,
        minute: number::unsigned(minute, 10)?,
        second: number::unsigned(second, 10)?,
        milli,
    })
}

/// From the first letters of its name, in English or German (of which the ä may be in any encoding).
fn month_number(name: &[u8]) -> Option<u32> {
    let lower = name.to_ascii_lowercase();
    Some(match lower.as_slice() {
        [b'j', b'a', ..] => 1,
        [b'f', ..] => 2,
        [b'm', b'a', b'i' | b'y', ..] => 5,
        [b'm', ..] => 3,
        [b'a', b'p', ..] => 4,
        [b'j', b'u', b'n', ..] => 6,
        [b'j', b'u', b'l', ..] => 7,
        [b'a', b'u', ..] => 8,
        [b's', ..] => 9,
        [b'o', ..] => 10,
        [b'n', ..] => 11,
        [b'd', ..] => 12,
        _ => return None,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use physics::Micros;

    fn micros(text: &str) -> Option<i64> {
        parse(text.as_bytes())?.micros().map(|time| time.0)
    }

    #[test]
    fn every_day_comes_back() {
        for day in (0..2_932_897).step_by(13).chain([0, 11_016, 2_932_896]) {
            let time = Micros((day * 86_400_000 + day % 86_400_000) * 1000);
            let date = Date::of(time).unwrap();
            assert_eq!(parse(text(date).as_bytes()).and_then(Date::micros), Some(time));
        }
        assert_eq!(text(Date::of(Micros(1_760_000_000_000_000)).unwrap()), "Thu Oct 09 08:53:20.000 2025");
    }

    #[test]
    fn dates_are_those_of_the_calendar() {
        assert_eq!(micros("Thu Jan 01 00:00:00 1970"), Some(0));
        assert_eq!(micros("Thu Oct 09 08:53:20.000 2025"), Some(1_760_000_000_000_000));
        assert_eq!(micros("Thu Oct 9 08:53:20.5 am 2025"), Some(1_760_000_000_005_000));
        assert_eq!(micros("Do Okt 09 08:53:20.123456 2025"), Some(1_760_000_000_123_000));
        assert_eq!(micros("Thu Feb 29 12:00:00.000 pm 2024"), Some(1_709_208_000_000_000));
        assert_eq!(micros("Thu Feb 29 12:00:00.000 am 2024"), Some(1_709_164_800_000_000));
        let march = parse(b"Sa M\xE4r 01 00:00:00 2025").and_then(Date::micros);
        assert_eq!(march, Some(Micros(1_740_787_200_000_000)));
        for bad in
            ["", "Thu Oct 09 08:53:20", "Thu Xyz 09 08:53:20 2025", "Thu Oct 32 08:53:20 2025", "a b c d e f"]
        {
            assert_eq!(micros(bad), None, "{bad}");
        }
    }
}
