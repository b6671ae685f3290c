//! Dates of the calendar, in UTC.

use std::fmt;

use super::Micros;

/// A time of a calendar day.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
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

    /// As ISO 8601 has it: `2025-10-09T08:53:20.123Z`. Date and hour may be apart by a blank; without `Z` or an offset
    /// (`+02:00`) it is UTC; seconds and their decimals, of which microseconds count, may be left out.
    pub fn parse_iso(text: &str) -> Option<Micros> {
        let number = |text: &str| -> Option<u32> {
            (!text.is_empty() && text.bytes().all(|byte| byte.is_ascii_digit())).then(|| text.parse().ok())?
        };
        let (day, hour) = text.trim().split_once(['T', 't', ' '])?;
        let mut day = day.split('-');
        let (year, month, date) = (day.next()?, day.next()?, day.next()?);
        let (hour, ahead) = match hour.strip_suffix(['Z', 'z']) {
            Some(hour) => (hour, 0),
            None => match hour.rfind(['+', '-']) {
                Some(place) => {
                    let (hours, minutes) = hour[place + 1..].split_once(':')?;
                    let minutes = i64::from(60 * number(hours)?.min(24) + number(minutes)?.min(59));
                    (&hour[..place], if hour[place..].starts_with('-') { -minutes } else { minutes })
                }
                None => (hour, 0),
            },
        };
        let mut parts = hour.split(':');
        let (hour, minute) = (parts.next()?, parts.next()?);
        let (second, decimals) = match parts.next() {
            Some(seconds) => seconds.split_once('.').unwrap_or((seconds, "0")),
            None => ("0", "0"),
        };
        if day.next().is_some() || parts.next().is_some() || year.len() != 4 {
            return None;
        }
        number(decimals)?;
        let micros = number(&format!("{decimals:0<6}")[..6])?;
        let date = Self {
            year: number(year)?,
            month: number(month)?,
            day: number(date)?,
            hour: number(hour)?,
            minute: number(minute)?,
            second: number(second)?,
            milli: 0,
        };
        // A day that its month does not have is another one.
        let time = date.micros().filter(|time| Self::of(*time).is_some_and(|it| it.day == date.day))?;
        Some(Micros(time.0 + i64::from(micros) - 60 * ahead * Micros::PER_SECOND))
    }
}

/// As ISO 8601 has it, to the millisecond: `2025-10-09T08:53:20.123Z`.
impl fmt::Display for Date {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { year, month, day, hour, minute, second, milli } = self;
        write!(f, "{year:04}-{month:02}-{day:02}T{hour:02}:{minute:02}:{second:02}.{milli:03}Z")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_day_comes_back() {
        for day in (0..2_932_897).step_by(13).chain([0, 11_016, 2_932_896]) {
            let time = Micros((day * 86_400_000 + day % 86_400_000) * 1000);
            let date = Date::of(time).unwrap();
            assert_eq!(date.micros(), Some(time), "{date:?}");
            assert_eq!(Date::parse_iso(&date.to_string()), Some(time));
        }
        assert_eq!(Date::of(Micros(1_760_000_000_123_999)).unwrap().to_string(), "2025-10-09T08:53:20.123Z");
        assert!(Date::of(Micros(-1)).is_none() && Date::of(Micros(2_932_897 * 86_400_000_000)).is_none());
    }

    #[test]
    fn iso_times_are_read_as_they_are_written() {
        let at = |text: &str| Date::parse_iso(text).map(|time| time.0);
        for same in [
            "2025-10-09T08:53:20Z",
            "2025-10-09 08:53:20.0",
            "2025-10-09T10:53:20.000+02:00",
            "2025-10-09T04:23:20-04:30",
            " 2025-10-09t08:53:20.000000z ",
        ] {
            assert_eq!(at(same), Some(1_760_000_000_000_000), "{same}");
        }
        assert_eq!(at("2025-10-09T08:53:20.0005Z"), Some(1_760_000_000_000_500));
        assert_eq!(at("2025-10-09T08:53:20.123456789Z"), Some(1_760_000_000_123_456));
        assert_eq!(at("2025-10-09T08:53"), Some(1_759_999_980_000_000));
        for bad in [
            "",
            "12",
            "2025-10-09",
            "08:53:20",
            "2025-02-30T00:00:00Z",
            "2025-10-09T25:00:00Z",
            "2025-10-09T08:53:20.Z",
            "2025-10-09T08:53:20+2",
            "2025-10-09T08:53:20:1Z",
            "2025-+1-09T08:53:20Z",
            "25-10-09T08:53:20Z",
            "2025-10-09T08:53:2é",
        ] {
            assert_eq!(at(bad), None, "{bad}");
        }
    }
}
