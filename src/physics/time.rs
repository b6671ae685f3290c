//! Time as frames carry it: whole microseconds, and the two ways in which people say it.

mod clock;
mod date;

use std::fmt;
use std::ops::{Add, Sub};

pub use clock::{Clock, Moment, stretch};
pub use date::Date;

/// A point in time (or a difference of two): whole microseconds, as `candump -L` writes them.
///
/// Live it is the kernel's receive stamp (since 1970), in a recording the log's own stamp. Being an
/// integer it makes a replay agree with the live run to the last bit.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Micros(pub i64);

impl Micros {
    /// Microseconds in a second.
    pub const PER_SECOND: i64 = 1_000_000;

    /// From whole milliseconds.
    pub const fn from_millis(ms: i64) -> Self {
        Self(ms.saturating_mul(1000))
    }

    /// From seconds, rounded to the nearest microsecond; not-a-number becomes zero.
    pub fn from_seconds(seconds: f64) -> Self {
        Self((seconds * Self::PER_SECOND as f64).round() as i64)
    }

    /// In seconds. Exact to the microsecond for any date of this century.
    #[inline]
    pub fn seconds(self) -> f64 {
        self.0 as f64 / Self::PER_SECOND as f64
    }

    /// The first multiple of `period` that is not before this time. A period of zero or less counts
    /// as one microsecond.
    pub fn next_multiple_of(self, period: Micros) -> Self {
        let period = period.0.max(1);
        let past = self.0.rem_euclid(period);
        if past == 0 { self } else { Self(self.0.saturating_add(period - past)) }
    }
}

impl Add for Micros {
    type Output = Self;
    #[inline]
    fn add(self, other: Self) -> Self {
        Self(self.0.saturating_add(other.0))
    }
}

impl Sub for Micros {
    type Output = Self;
    #[inline]
    fn sub(self, other: Self) -> Self {
        Self(self.0.saturating_sub(other.0))
    }
}

/// Seconds with six decimals, as in a candump line.
impl fmt::Display for Micros {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let sign = if self.0 < 0 { "-" } else { "" };
        let magnitude = self.0.unsigned_abs();
        write!(f, "{sign}{}.{:06}", magnitude / 1_000_000, magnitude % 1_000_000)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn grid_points_do_not_depend_on_where_one_starts() {
        let period = Micros(20_000);
        assert_eq!(Micros(1).next_multiple_of(period), Micros(20_000));
        assert_eq!(Micros(20_000).next_multiple_of(period), Micros(20_000));
        assert_eq!(Micros(-1).next_multiple_of(period), Micros(0));
    }

    #[test]
    fn prints_as_candump_does() {
        assert_eq!(Micros(1_760_000_000_000_584).to_string(), "1760000000.000584");
        assert_eq!(Micros(-1).to_string(), "-0.000001");
    }
}
