//! Dates as formats give the start of a recording, taken for UTC.

use super::number;
use physics::Micros;

/// A time of a calendar day.
#[derive(Clone, Copy, Debug, Default)]
pub struct Date {
    /// With four digits.
    pub year: u32,
    /// From 1.
    pub month: u32,
    /// From 1.
    pub day: u32,
    /// From 0 to 23.
    pub hour: u32,
    /// From 0.
    pub minute: u32,
    /// From 0.
    pub second: u32,
    /// From 0.
    pub milli: u32,
}

impl Date {
    /// Of a time from 1970 to the year 9999.
    pub fn of(time: Micros) -> Option<Self> {
        let millis = u64::try_from(time.0).ok()? / 1000;
        let (days, rest) = (millis / 86_400_000, (millis % 86_400_000) as u32);
        // As in [`Date::micros`]: years that begin in March, in turns of 400 years.
        let days = days + 719_468;
        let (turn, day) = (days / 146_097, days % 146_097);
        let year = (day - day / 1460 + day / 36_524 - day / 146_096) / 365;
        let day = day - (365 * year + year / 4 - year / 100);
        let month = (5 * day + 2) / 153;
        let day = day - (153 * month + 2) / 5 + 1;
        let (month, years) = if month < 10 { (month + 3, 0) } else { (month - 9, 1) };
        let year = u32::try_from(400 * turn + year + years).ok().filter(|year| *year <= 9999)?;
        Some(Self {
            year,
            month: month as u32,
            day: day as u32,
            hour: rest / 3_600_000,
            minute: rest / 60_000 % 60,
            second: rest / 1000 % 60,
            milli: rest % 1000,
        })
    }

    /// The day of the week, from Sunday, 0.
    pub fn weekday(self) -> u32 {
        const DAY: i64 = 86_400 * Micros::PER_SECOND;
        // 1 January 1970 was a Thursday.
        self.micros().map_or(0, |time| (time.0.div_euclid(DAY) + 4).rem_euclid(7) as u32)
    }

    /// As Vector writes it, `Thu Oct 09 08:53:20.123 2025`.
    pub fn text(self) -> String {
        const DAYS: [&str; 7] = ["Sun", "Mon", "Tue", "Wed", "Thu", "Fri", "Sat"];
        const MONTHS: [&str; 12] =
            ["Jan", "Feb", "Mar", "Apr", "May", "Jun", "Jul", "Aug", "Sep", "Oct", "Nov", "Dec"];
        let weekday = DAYS.get(self.weekday() as usize).unwrap_or(&"Sun");
        let month = MONTHS.get(self.month.saturating_sub(1) as usize).unwrap_or(&"Jan");
        let Self { year, day, hour, minute, second, milli, .. } = self;
        format!("{weekday} {month} {day:02} {hour:02}:{minute:02}:{second:02}.{milli:03} {year}")
    }

    /// Since 1970; `None` if there is no such date.
    pub fn micros(self) -> Option<Micros> {
        let fits = (1970..=9999).contains(&self.year)
            && (1..=12).contains(&self.month)
            && (1..=31).contains(&self.day)
            && self.hour < 24
            && self.minute < 60
            && self.second < 61
            && self.milli < 1000;
        if !fits {
            return None;
        }
        // Years that begin in March have their leap day at the end.
        let (year, month) = match self.month {
            1 | 2 => (self.year - 1, self.month + 9),
            month => (self.year, month - 3),
        };
        let days_before_month = (153 * month + 2) / 5;
        let days = 365 * year + year / 4 - year / 100 + year / 400 + days_before_month + self.day - 1;
        // From 1 March of the year 0 to 1970.
        let days = i64::from(days) - 719_468;
        let seconds = i64::from(self.hour * 3600 + self.minute * 60 + self.second);
        Some(Micros(((days * 86_400 + seconds) * 1000 + i64::from(self.milli)) * 1000))
    }

    /// As Vector writes it, `Thu Oct 09 08:53:20.123 am 2025`, with 12 or 24 hours, English or German.
    pub fn parse(text: &[u8]) -> Option<Self> {
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
            if digits.len() > 3 {
                number::unsigned(digits.get(..3)?, 10)
            } else {
                number::unsigned(digits, 10)
            }
        })?;
        let hour = number::unsigned(hour, 10)?;
        let hour = match half.as_deref() {
            None => hour,
            Some(b"am") => hour % 12,
            Some(b"pm") => hour % 12 + 12,
            Some(_) => return None,
        };
        Some(Self {
            year: number::unsigned(year, 10)?,
            month: month_number(month)?,
            day: number::unsigned(day, 10)?,
            hour,
            minute: number::unsigned(minute, 10)?,
            second: number::unsigned(second, 10)?,
            milli,
        })
    }
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

    fn micros(text: &str) -> Option<i64> {
        Date::parse(text.as_bytes())?.micros().map(|time| time.0)
    }

    #[test]
    fn every_day_comes_back() {
        for day in (0..2_932_897).step_by(13).chain([0, 11_016, 2_932_896]) {
            let time = Micros((day * 86_400_000 + day % 86_400_000) * 1000);
            let date = Date::of(time).unwrap();
            assert_eq!(date.micros(), Some(time), "{date:?}");
            assert_eq!(Date::parse(date.text().as_bytes()).and_then(Date::micros), Some(time));
        }
        assert_eq!(Date::of(Micros(1_760_000_000_000_000)).unwrap().text(), "Thu Oct 09 08:53:20.000 2025");
        assert!(Date::of(Micros(-1)).is_none() && Date::of(Micros(2_932_897 * 86_400_000_000)).is_none());
    }

    #[test]
    fn dates_are_those_of_the_calendar() {
        assert_eq!(micros("Thu Jan 01 00:00:00 1970"), Some(0));
        assert_eq!(micros("Thu Oct 09 08:53:20.000 2025"), Some(1_760_000_000_000_000));
        assert_eq!(micros("Thu Oct 9 08:53:20.5 am 2025"), Some(1_760_000_000_005_000));
        assert_eq!(micros("Do Okt 09 08:53:20.123456 2025"), Some(1_760_000_000_123_000));
        assert_eq!(micros("Thu Feb 29 12:00:00.000 pm 2024"), Some(1_709_208_000_000_000));
        assert_eq!(micros("Thu Feb 29 12:00:00.000 am 2024"), Some(1_709_164_800_000_000));
        let march = Date::parse(b"Sa M\xE4r 01 00:00:00 2025").and_then(Date::micros);
        assert_eq!(march, Some(Micros(1_740_787_200_000_000)));
        for bad in
            ["", "Thu Oct 09 08:53:20", "Thu Xyz 09 08:53:20 2025", "Thu Oct 32 08:53:20 2025", "a b c d e f"]
        {
            assert_eq!(micros(bad), None, "{bad}");
        }
    }
}
