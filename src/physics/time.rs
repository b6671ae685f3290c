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

    /// Whatever the times and the period are, the ends of what an integer holds included.
    #[test]
    fn a_grid_point_is_the_first_one_that_is_not_before() {
        let near = |time: i64| (-3..=3).map(move |by| time.saturating_add(by));
        let times = [0, i64::MIN, i64::MAX, 1_760_000_000_000_000, -1_760_000_000_000_000];
        for time in times.into_iter().flat_map(near) {
            for period in [1, 2, 7, 10_000, 20_000, Micros::PER_SECOND, i64::MAX].into_iter().flat_map(near) {
                let next = Micros(time).next_multiple_of(Micros(period)).0;
                let period = i128::from(period.max(1));
                let exact = -(-i128::from(time)).div_euclid(period) * period;
                assert_eq!(i128::from(next), exact.min(i64::MAX.into()), "{time} {period}");
            }
        }
    }

    /// Sums and differences saturate: exact wherever the result is one, the nearest end elsewhere.
    #[test]
    fn sums_are_exact_or_at_the_end() {
        let near = |time: i64| (-2..=2).map(move |by| time.saturating_add(by));
        let all: Vec<i64> = [0, i64::MIN, i64::MAX, i64::MIN / 2, i64::MAX / 2, 1_760_000_000_000_000]
            .into_iter()
            .flat_map(near)
            .collect();
        let nearest = |exact: i128| exact.clamp(i64::MIN.into(), i64::MAX.into());
        for (a, b) in all.iter().flat_map(|a| all.iter().map(move |b| (*a, *b))) {
            let exact = (i128::from(a) + i128::from(b), i128::from(a) - i128::from(b));
            assert_eq!(i128::from((Micros(a) + Micros(b)).0), nearest(exact.0), "{a} + {b}");
            assert_eq!(i128::from((Micros(a) - Micros(b)).0), nearest(exact.1), "{a} - {b}");
        }
    }

    /// To seconds and back: every microsecond of this century that is near a power of two or ten, and a second in a row.
    #[test]
    fn seconds_are_exact_in_this_century() {
        let end = 4_102_444_800 * Micros::PER_SECOND;
        let powers = (0..52).map(|n| 1_i64 << n).chain((0..16).map(|n| 10_i64.pow(n)));
        let around =
            powers.filter(|time| *time < end).flat_map(|time| (-1000..=1000).map(move |by| time + by));
        for time in around.chain(end - Micros::PER_SECOND..=end) {
            assert_eq!(Micros::from_seconds(Micros(time).seconds()), Micros(time));
            assert_eq!(Micros::from_seconds(Micros(-time).seconds()), Micros(-time));
        }
    }

    #[test]
    fn prints_as_candump_does() {
        assert_eq!(Micros(1_760_000_000_000_584).to_string(), "1760000000.000584");
        assert_eq!(Micros(-1).to_string(), "-0.000001");
    }
}
