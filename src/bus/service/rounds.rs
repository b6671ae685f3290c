//! The round that goes out next, and whether it may: what is old must not look like the present.
//!
//! After a pause of ours the kernel has frames of some seconds for us, and many would bring a round of their own. So a
//! round is held until there is nothing more to be read, and a newer one takes the place of the one that is held. What
//! goes out is the newest; the one after it is due later than now; and so there is no burst.

use crate::can::Frame;
use physics::{Faults, Micros};

/// A round on its way out, on a link that has a clock.
#[derive(Debug)]
pub(super) struct Rounds {
    /// Its frames; none, if there is none.
    pub frames: Vec<Frame>,
    /// The faults that it tells.
    pub told: Faults,
    /// Since when there is always something newer to be read.
    held_since: Option<Micros>,
    /// Not before: one went although there was more to be read.
    earliest: Micros,
}

/// May it go?
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Verdict {
    /// There is none.
    Nothing,
    /// Yes.
    Now,
    /// It would be stale.
    TooLate,
    /// Not before everything that has come is read.
    OnceAllIsRead,
    /// It would be a burst: after so long.
    After(Micros),
}

impl Rounds {
    /// A round does not go out later than this after it was due.
    const TOO_LATE: Micros = Micros::from_millis(100);
    /// Frames of two rounds, of as many messages as there can be.
    const ROOM: usize = 32;

    pub(super) fn new() -> Self {
        let frames = Vec::with_capacity(Self::ROOM);
        Self { frames, told: Faults::empty(), held_since: None, earliest: Micros(0) }
    }

    /// Of a cycle of `period`; `all_is_read`: nothing newer waits to be read.
    pub(super) fn judge(&mut self, now: Micros, period: Micros, all_is_read: bool) -> Verdict {
        let Some(first) = self.frames.first() else { return Verdict::Nothing };
        let late = now - first.time;
        if late > Self::TOO_LATE {
            return Verdict::TooLate;
        }
        let held_since = *self.held_since.get_or_insert(now);
        // On a flooded bus there is always more to be read: before the next one is due it goes all the same.
        if !all_is_read && now - held_since < Micros(period.0 / 2) {
            return Verdict::OnceAllIsRead;
        }
        let wait = self.earliest - now;
        if wait > Micros(0) { Verdict::After(wait.min(period)) } else { Verdict::Now }
    }

    /// It went.
    pub(super) fn went(&mut self, now: Micros, period: Micros, all_is_read: bool) {
        self.earliest = if all_is_read { Micros(0) } else { now + Micros(3 * period.0 / 4) };
        self.held_since = None;
        self.frames.clear();
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::can::CanId;

    const PERIOD: Micros = Micros::from_millis(20);

    fn round(time: i64) -> Frame {
        Frame::data_frame(Micros::from_millis(time), CanId::standard(1).unwrap(), &[]).unwrap()
    }

    /// What goes out, ms, of rounds that are due each 20 ms but are not looked at in the pauses; reading one takes a
    /// tenth of a millisecond.
    fn sent(end: i64, pause: std::ops::Range<i64>) -> Vec<(i64, i64)> {
        let mut rounds = Rounds::new();
        let (mut sent, mut due) = (Vec::new(), 0);
        let mut now = Micros(0);
        while now < Micros::from_millis(end) {
            now = now + Micros(100);
            if pause.contains(&(now.0 / 1000)) {
                continue;
            }
            if Micros::from_millis(due) <= now {
                rounds.frames.clear();
                rounds.frames.push(round(due));
                due += 20;
            }
            let all_is_read = Micros::from_millis(due) > now;
            match rounds.judge(now, PERIOD, all_is_read) {
                Verdict::Now => {
                    sent.push((rounds.frames[0].time.0 / 1000, now.0 / 1000));
                    rounds.went(now, PERIOD, all_is_read);
                }
                Verdict::TooLate => rounds.frames.clear(),
                _ => {}
            }
        }
        sent
    }

    #[test]
    fn without_a_pause_all_go_at_once() {
        let sent = sent(1000, 0..0);
        assert!((50..=51).contains(&sent.len()));
        assert!(sent.iter().all(|(due, at)| at - due <= 1), "{sent:?}");
    }

    #[test]
    fn after_a_pause_the_newest_goes_and_nothing_stale_and_no_burst() {
        for pause in [30, 50, 90, 150, 3000] {
            for begin in 100..120 {
                let sent = sent(begin + pause + 500, begin..begin + pause);
                assert!(sent.iter().all(|(due, at)| at - due <= 100), "{sent:?}");
                for (place, (_, first)) in sent.iter().enumerate() {
                    for (more, (_, last)) in sent[place..].iter().enumerate() {
                        let by_rate = (last - first) as f64 / 20.0 + 1.0;
                        assert!(more as f64 + 1.0 <= by_rate + 1.0, "{pause} from {begin}: {sent:?}");
                    }
                }
                // The first one afterwards is the newest that there was, and none is missing after it.
                let after = sent.iter().position(|(_, at)| *at >= begin + pause).unwrap();
                assert!(sent[after].1 - sent[after].0 <= 22, "{pause} from {begin}: {:?}", &sent[after..]);
                assert!(sent[after..].windows(2).all(|pair| pair[1].0 - pair[0].0 == 20));
            }
        }
    }

    /// GIVEN inputs that bring a round each 100 ms, and whose frames come within 15 ms THEN each one is sent.
    #[test]
    fn slow_inputs_lose_nothing() {
        let mut rounds = Rounds::new();
        let mut sent = Vec::new();
        for now in 0..10_000 {
            let in_burst = now % 100;
            if in_burst == 12 {
                assert!(rounds.frames.is_empty(), "the round before still waits at {now} ms");
                // Of the moment of the burst's first frame, as the sampler waits for the last.
                rounds.frames.push(round(now - 12));
            }
            let all_is_read = in_burst >= 15;
            if rounds.judge(Micros::from_millis(now), PERIOD, all_is_read) == Verdict::Now {
                sent.push((rounds.frames[0].time.0 / 1000, now));
                rounds.went(Micros::from_millis(now), PERIOD, all_is_read);
            }
        }
        assert_eq!(sent.len(), 100);
        assert!(sent.iter().all(|(due, at)| at - due <= 15), "{sent:?}");
    }

    #[test]
    fn a_flood_that_is_never_read_to_its_end_lets_one_in_a_cycle_through() {
        let mut rounds = Rounds::new();
        let mut sent = 0;
        // Always 50 ms behind.
        for now in 1000..2000 {
            if now % 20 == 0 {
                rounds.frames.clear();
                rounds.frames.push(round(now - 50));
            }
            if rounds.judge(Micros::from_millis(now), PERIOD, false) == Verdict::Now {
                rounds.went(Micros::from_millis(now), PERIOD, false);
                sent += 1;
            }
        }
        assert!((49..=50).contains(&sent), "{sent}");
    }
}
