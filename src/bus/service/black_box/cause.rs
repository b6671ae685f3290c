//! What is worth a recording.

use std::fmt;

use physics::{Faults, Micros};

/// Why something is recorded.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Cause {
    faults: Faults,
    surface: bool,
}

impl Cause {
    /// These, too.
    pub fn add(&mut self, other: Self) {
        self.faults |= other.faults;
        self.surface |= other.surface;
    }

    /// For a file's name: the first of them.
    pub fn word(self) -> String {
        self.faults.names().next().unwrap_or_else(|| "surface".to_owned())
    }
}

/// As in `timeout, sent_twice, a change of surface`.
impl fmt::Display for Cause {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let surface = self.surface.then(|| "a change of surface".to_owned());
        let all: Vec<_> = self.faults.names().chain(surface).collect();
        f.write_str(&all.join(", "))
    }
}

/// Watches for what is new.
#[derive(Debug)]
pub(super) struct Watch {
    /// The stamp of the latest frame, and before which nothing counts.
    now: Option<Micros>,
    settled: Micros,
    /// When each bit was on last, by its number.
    last_on: [Option<Micros>; Faults::COUNT],
    surface_changes: u32,
}

impl Watch {
    /// That the link is down, a configuration refused or the service ended is in no frame: a recording would not show it.
    const WORTH_IT: Faults =
        Faults::all().difference(Faults::BUS_DOWN.union(Faults::CONFIG).union(Faults::ENDING));
    /// A bit that was off for less is not new: the recording of its beginning goes on, or a loose contact would be
    /// recorded for ever.
    const QUIET: Micros = Micros::from_millis(10_000);
    /// After so long a silence the car was parked, and a recording would begin behind it: that it was silent is no
    /// reason. As long as what is recorded before a cause.
    const PARKED: Micros = Micros::from_millis(20_000);
    /// So long all messages have to come at least once, after the start and where the car was parked. What is wrong
    /// longer than that counts.
    const STARTING: Micros = Micros::from_millis(2_000);

    pub fn new(surface_changes: u32) -> Self {
        Self { now: None, settled: Micros(0), last_on: [None; Faults::COUNT], surface_changes }
    }

    /// A frame has come.
    pub fn heard(&mut self, time: Micros) {
        if self.now.is_none_or(|before| time - before > Self::PARKED) {
            self.settled = time + Self::STARTING;
        }
        self.now = Some(time);
    }

    /// What is new since the last look, and the stamp of the latest frame.
    pub fn look(&mut self, on: Faults, surface_changes: u32) -> Option<(Micros, Cause)> {
        let before = std::mem::replace(&mut self.surface_changes, surface_changes);
        let surface = surface_changes > before;
        let on = on & Self::WORTH_IT;
        if on.is_empty() && !surface {
            return None;
        }
        let now = self.now?;
        // A clock that was set back by far is none to wait for.
        if now < self.settled && self.settled - now <= Self::STARTING {
            return None;
        }
        let mut cause = Cause { faults: Faults::empty(), surface };
        for fault in on.iter() {
            let last = self.last_on[fault.bits().trailing_zeros() as usize].replace(now);
            if last.is_none_or(|last| now - last > Self::QUIET || now < last - Self::QUIET) {
                cause.faults |= fault;
            }
        }
        (cause != Cause::default()).then_some((now, cause))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const T: Faults = Faults::TIMEOUT;
    const NONE: Faults = Faults::empty();

    /// Looks each 10 ms of these seconds at what `on` has then; what was new, and when, s.
    fn seen(watch: &mut Watch, span: std::ops::Range<i64>, on: impl Fn(f64) -> Faults) -> Vec<(f64, String)> {
        let mut seen = Vec::new();
        for time in (span.start * 1_000_000..span.end * 1_000_000).step_by(10_000) {
            watch.heard(Micros(time));
            let on = on(time as f64 / 1e6);
            seen.extend(watch.look(on, 0).map(|(at, cause)| (at.seconds(), cause.to_string())));
        }
        seen
    }

    #[test]
    fn a_fault_is_new_when_it_begins_and_after_a_quiet_time() {
        let mut watch = Watch::new(0);
        let flapping = |t: f64| if (20.0..40.0).contains(&t) && t % 5.0 < 1.0 { T } else { NONE };
        let again = |t: f64| if (60.0..70.0).contains(&t) { T } else { flapping(t) };
        let other = |t: f64| if t >= 62.0 { again(t) | Faults::INCONSISTENT } else { again(t) };
        let expected = [(20.0, "timeout"), (60.0, "timeout"), (62.0, "inconsistent")];
        let seen = seen(&mut watch, 1..100, other);
        assert_eq!(seen, expected.map(|(t, what)| (t, what.to_owned())));
    }

    #[test]
    fn a_start_is_no_fault_unless_it_lasts() {
        let mut watch = Watch::new(0);
        assert_eq!(seen(&mut watch, 100..110, |t| if t < 101.9 { T } else { NONE }), []);
        // Parked for an hour.
        assert_eq!(seen(&mut watch, 3700..3710, |t| if t < 3700.5 { T } else { NONE }), []);
        // A silence of five seconds is one, told by the first frame after it.
        let after = seen(&mut watch, 3715..3720, |t| if t < 3715.1 { T } else { NONE });
        assert_eq!(after, [(3715.0, "timeout".to_owned())]);
        let mut missing = Watch::new(0);
        assert_eq!(seen(&mut missing, 100..110, |_| T), [(102.0, "timeout".to_owned())]);
    }

    #[test]
    fn what_no_frame_shows_is_no_cause_and_a_surface_is() {
        let mut watch = Watch::new(3);
        watch.heard(Micros(0));
        watch.heard(Micros::from_millis(5000));
        assert_eq!(watch.look(Faults::CONFIG | Faults::BUS_DOWN | Faults::ENDING, 3), None);
        let (_, cause) = watch.look(NONE, 4).unwrap();
        assert_eq!((cause.word(), cause.to_string()), ("surface".into(), "a change of surface".into()));
        // Another engine counts from zero.
        assert_eq!(watch.look(NONE, 0), None);
        let (_, mut cause) = watch.look(T, 1).unwrap();
        cause.add(Cause { faults: Faults::SENT_TWICE, surface: false });
        assert_eq!(
            (cause.word(), cause.to_string()),
            ("timeout".into(), "timeout, sent_twice, a change of surface".into())
        );
    }

    /// GIVEN a clock that is set back by an hour THEN faults are still seen.
    #[test]
    fn a_clock_that_is_set_back() {
        let mut watch = Watch::new(0);
        assert_eq!(seen(&mut watch, 5000..5010, |t| if t > 5005.0 { T } else { NONE }).len(), 1);
        assert_eq!(seen(&mut watch, 1000..1010, |t| if t > 1005.0 { T } else { NONE }).len(), 1);
    }
}
