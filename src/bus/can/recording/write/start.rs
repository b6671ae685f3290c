//! What a recording's times count from.

use super::loss::Loss;
use physics::Micros;
use physics::time::Date;

/// A whole second, at least so much before the first frame: frames of several interfaces are not always in order.
const SLACK: Micros = Micros(Micros::PER_SECOND / 2);

/// Set by the first frame.
#[derive(Clone, Copy, Debug, Default)]
pub struct Start(Option<(Micros, Date)>);

impl Start {
    /// The time since the start; sets it if there is none.
    pub fn since(&mut self, time: Micros) -> Result<Micros, Loss> {
        let start = match self.0 {
            Some((start, _)) => start,
            None => {
                let before = (time - SLACK).0.div_euclid(Micros::PER_SECOND) * Micros::PER_SECOND;
                let start = Micros(if time.0 < 0 { before } else { before.max(0) });
                let date = Date::of(start).ok_or(Loss::NoDate)?;
                self.0 = Some((start, date));
                start
            }
        };
        let since = time - start;
        // Beyond the dates there are, and what 64 bits of nanoseconds hold.
        if Date::of(time).is_none() {
            return Err(Loss::NoDate);
        }
        if since < Micros(0) { Err(Loss::BeforeStart) } else { Ok(since) }
    }

    /// The start; 1970 if there were no frames.
    pub fn time(&self) -> Micros {
        self.0.map_or(Micros(0), |(start, _)| start)
    }

    /// The same, as a date.
    pub fn date(&self) -> Date {
        self.0.map_or_else(|| Date::of(Micros(0)).unwrap_or_default(), |(_, date)| date)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn times_count_from_a_whole_second_before_the_first() {
        let mut start = Start::default();
        assert_eq!(start.since(Micros(-1)).err(), Some(Loss::NoDate));
        assert_eq!(start.since(Micros(10_400_000)).ok(), Some(Micros(1_400_000)));
        assert_eq!(start.time(), Micros(9_000_000));
        assert_eq!(start.since(Micros(9_000_000)).ok(), Some(Micros(0)));
        assert_eq!(start.since(Micros(8_999_999)).err(), Some(Loss::BeforeStart));
        assert_eq!(start.since(Micros(i64::MAX)).err(), Some(Loss::NoDate));
        assert_eq!(Start::default().since(Micros(0)).ok(), Some(Micros(0)));
    }
}
