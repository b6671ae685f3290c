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

/// Lets a number of messages through in each minute, and says when it begins to withhold.
#[derive(Debug, Default)]
pub(super) struct Quota {
    begun: Option<Instant>,
    said: u32,
}

/// May it be said?
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Allowed {
    Yes,
    /// And nothing more of the kind for a while.
    LastForNow,
    No,
}

impl Quota {
    const EACH_MINUTE: u32 = 20;

    pub(super) fn pass(&mut self, now: Instant) -> Allowed {
        if self.begun.is_none_or(|begun| now - begun >= Duration::from_secs(60)) {
            (self.begun, self.said) = (Some(now), 0);
        }
        self.said = self.said.saturating_add(1);
        match self.said {
            ..Self::EACH_MINUTE => Allowed::Yes,
            Self::EACH_MINUTE => Allowed::LastForNow,
            _ => Allowed::No,
        }
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
    fn a_quota_is_for_a_minute() {
        let start = Instant::now();
        let mut quota = Quota::default();
        let allowed: Vec<_> = (0..130).map(|s| quota.pass(start + Duration::from_secs(s))).collect();
        assert_eq!(allowed.iter().filter(|allowed| **allowed == Allowed::No).count(), 2 * 40);
        assert_eq!((allowed[18], allowed[19], allowed[20]), (Allowed::Yes, Allowed::LastForNow, Allowed::No));
        assert_eq!(
            (allowed[60], allowed[79], allowed[120]),
            (Allowed::Yes, Allowed::LastForNow, Allowed::Yes)
        );
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
