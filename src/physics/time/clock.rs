//! The two clocks of a recording: seconds from its start, and UTC where its stamps are dates.

use std::fmt;
use std::str::FromStr;

use super::{Date, Micros};

/// Stamps before 1990 count from when something was switched on: nobody recorded a CAN bus earlier.
const FIRST_DATE: Micros = Micros(631_152_000 * Micros::PER_SECOND);

/// Of one recording.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Clock {
    begins: Micros,
}

impl Clock {
    /// Of a recording whose first frame has this stamp.
    pub const fn of(begins: Micros) -> Self {
        Self { begins }
    }

    /// The stamp of its first frame.
    pub const fn begins(self) -> Micros {
        self.begins
    }

    /// The stamp of its first frame as a date; none where stamps are none.
    pub fn date(self) -> Option<Date> {
        Date::of(self.begins).filter(|_| self.begins >= FIRST_DATE)
    }

    /// So many seconds after the start in UTC, as ISO 8601 has it; none where stamps are no dates.
    pub fn utc(self, seconds: f64) -> Option<String> {
        self.date()?;
        Some(Date::of(self.begins + Micros::from_seconds(seconds))?.to_string())
    }

    /// Both ends of a stretch in UTC.
    pub fn utc_of(self, [from, to]: [f64; 2]) -> Option<[String; 2]> {
        Some([self.utc(from)?, self.utc(to)?])
    }

    /// A moment by both clocks: `12.3 s (2025-10-09T08:53:32.300Z)`.
    pub fn at(self, seconds: f64) -> String {
        match self.utc(seconds) {
            Some(utc) => format!("{seconds:.1} s ({utc})"),
            None => format!("{seconds:.1} s"),
        }
    }

    /// A stretch by both clocks: `12.3 to 18.9 s (2025-10-09T08:53:32.300Z to 08:53:38.900Z)`.
    pub fn over(self, [from, to]: [f64; 2]) -> String {
        match self.utc_of([from, to]) {
            Some(utc) => format!("{from:.1} to {to:.1} s ({})", stretch(&utc)),
            None => format!("{from:.1} to {to:.1} s"),
        }
    }
}

/// A stretch between two times as ISO 8601 has them, the day once where it is one.
pub fn stretch([from, to]: &[String; 2]) -> String {
    let hour = to.split_once('T').filter(|(day, _)| from.starts_with(day));
    format!("{from} to {}", hour.map_or(to.as_str(), |(_, hour)| hour))
}

/// A moment of a recording, as people name it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Moment {
    /// So many seconds after its first frame.
    After(f64),
    /// At this time of the calendar.
    At(Micros),
}

impl Moment {
    /// In seconds after the first frame, which has this stamp.
    pub fn seconds(self, begins: Micros) -> f64 {
        match self {
            Self::After(seconds) => seconds,
            Self::At(time) => (time - begins).seconds(),
        }
    }
}

/// Not a moment.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct NoMoment;

impl fmt::Display for NoMoment {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(
            "is neither seconds from the start, such as 12.5, nor a time, such as 2025-10-09T08:53:20.123Z",
        )
    }
}

impl FromStr for Moment {
    type Err = NoMoment;

    fn from_str(text: &str) -> Result<Self, NoMoment> {
        match text.trim().parse::<f64>() {
            Ok(seconds) if seconds.is_finite() => Ok(Self::After(seconds)),
            _ => Date::parse_iso(text).map(Self::At).ok_or(NoMoment),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn both_clocks_are_told_where_there_are_two() {
        let clock = Clock::of(Micros(1_760_000_000_000_000));
        assert_eq!(clock.at(12.3), "12.3 s (2025-10-09T08:53:32.300Z)");
        assert_eq!(clock.over([12.3, 18.9]), "12.3 to 18.9 s (2025-10-09T08:53:32.300Z to 08:53:38.900Z)");
        let days = "2025-10-09T08:53:20.000Z to 2025-10-10T08:53:20.000Z";
        assert!(clock.over([0.0, 86_400.0]).contains(days));
        let since_ignition = Clock::of(Micros(5_000_000));
        assert_eq!(since_ignition.at(12.3), "12.3 s");
        assert_eq!(since_ignition.over([0.0, 1.0]), "0.0 to 1.0 s");
        assert_eq!((since_ignition.utc(1.0), since_ignition.date()), (None, None));
    }

    #[test]
    fn a_moment_is_said_by_either_clock() {
        let begins = Micros(1_760_000_000_000_000);
        let seconds = |text: &str| text.parse::<Moment>().map(|moment| moment.seconds(begins));
        assert_eq!(seconds("12.5"), Ok(12.5));
        assert_eq!(seconds("2025-10-09T08:53:32.500Z"), Ok(12.5));
        assert_eq!(seconds("2025-10-09T08:53:10Z"), Ok(-10.0));
        for bad in ["", "soon", "NaN", "inf", "2025-10-09", "12.5 s"] {
            assert_eq!(seconds(bad), Err(NoMoment), "{bad}");
        }
    }
}
