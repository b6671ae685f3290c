//! Says the same thing not too often.

use std::time::{Duration, Instant};

/// Lets the first message of its kind through at once. While more keep coming, the pauses between
/// those let through double up to a minute; once it has been quiet for a pause, all begins anew.
#[derive(Debug, Default)]
pub(super) struct Throttle {
    /// When the next may be said, and after how long a pause.
    next: Option<(Instant, Duration)>,
    withheld: u64,
}

impl Throttle {
    const SHORTEST: Duration = Duration::from_secs(1);
    const LONGEST: Duration = Duration::from_secs(60);

    /// May it be said now? If so, how many were not since the last that was.
    pub(super) fn pass(&mut self, now: Instant) -> Option<u64> {
        let pause = match self.next {
            Some((next, _)) if now < next => {
                self.withheld += 1;
                return None;
            }
            Some((next, pause)) if now < next + pause => (2 * pause).min(Self::LONGEST),
            _ => Self::SHORTEST,
        };
        self.next = Some((now + pause, pause));
        Some(std::mem::take(&mut self.withheld))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_keeps_coming_is_said_ever_less_often_but_never_lost() {
        let start = Instant::now();
        let mut throttle = Throttle::default();
        let mut said = Vec::new();
        let mut counted = 0;
        for millis in (0..600_000).step_by(10) {
            if let Some(withheld) = throttle.pass(start + Duration::from_millis(millis)) {
                said.push(millis / 1000);
                counted += withheld + 1;
            }
        }
        assert_eq!(said[..7], [0, 1, 3, 7, 15, 31, 63]);
        assert_eq!(said[7..], [123, 183, 243, 303, 363, 423, 483, 543]);
        assert_eq!(counted + throttle.withheld, 60_000);
    }

    #[test]
    fn after_a_quiet_time_it_is_said_at_once_again() {
        let start = Instant::now();
        let mut throttle = Throttle::default();
        assert_eq!(throttle.pass(start), Some(0));
        assert_eq!(throttle.pass(start + Duration::from_millis(500)), None);
        assert_eq!(throttle.pass(start + Duration::from_millis(2500)), Some(1));
        assert_eq!(throttle.pass(start + Duration::from_millis(3400)), None);
        assert_eq!(throttle.pass(start + Duration::from_millis(3500)), Some(1), "one second again");
    }
}
