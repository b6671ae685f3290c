//! The uniform grid of sample times, driven by the frames' own time.

use super::config::{SamplerConfig, micros};
use physics::Micros;

/// A frame this much older than the newest one means that the clock was set, or that two recordings
/// were joined.
const STEP_BACK: Micros = Micros::from_millis(1000);
/// Without frames, samples go on (without values) for so long and then wait for the next frame.
const GAP: Micros = Micros::from_millis(1000);

/// What a frame's time says.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Step {
    /// Not before the newest frame.
    Onward,
    /// A little before the newest frame.
    Late,
    /// Far after the newest frame: the samples between are left out.
    Gap,
    /// Far before the newest frame: everything starts anew.
    Back,
}

/// The next sample's time and when it may be made.
#[derive(Clone, Debug)]
pub(super) struct Grid {
    period: Micros,
    /// How long a sample waits for late frames.
    lag: Micros,
    /// How long the first sample waits for the required quantities.
    patience: Micros,
    /// The newest frame's time.
    now: Option<Micros>,
    /// The first frame's, since the start or the last restart.
    first: Micros,
    next: Option<Micros>,
    last: Option<Micros>,
    /// After the first time, go on at the second.
    jump: Option<(Micros, Micros)>,
    ending: bool,
}

impl Grid {
    pub(super) fn new(config: &SamplerConfig, longest_delay: Micros) -> Self {
        Self {
            period: Micros(config.period().0.max(1000)),
            lag: micros(config.lag_ms.max(0.0)) + longest_delay,
            patience: micros(config.start_ms.max(0.0)),
            now: None,
            first: Micros(0),
            next: None,
            last: None,
            jump: None,
            ending: false,
        }
    }

    /// How far back values are asked for, seen from the newest frame.
    pub(super) fn reach(&self) -> Micros {
        self.lag + self.period + self.period
    }

    /// The newest frame's time.
    pub(super) fn now(&self) -> Option<Micros> {
        self.now
    }

    /// The newest sample's time.
    pub(super) fn last(&self) -> Option<Micros> {
        self.last
    }

    /// Is it too early to miss a quantity that has not been heard of since the start?
    pub(super) fn is_starting(&self) -> bool {
        self.now.is_none_or(|now| now - self.first <= self.patience)
    }

    /// Takes note of a frame's time.
    pub(super) fn advance(&mut self, time: Micros) -> Step {
        self.ending = false;
        let Some(now) = self.now else {
            (self.now, self.first) = (Some(time), time);
            return Step::Onward;
        };
        if now - time > STEP_BACK {
            (self.now, self.first) = (Some(time), time);
            (self.next, self.last, self.jump) = (None, None, None);
            return Step::Back;
        }
        if time < now {
            return Step::Late;
        }
        self.now = Some(time);
        if time - now <= GAP {
            return Step::Onward;
        }
        if self.next.is_some() {
            let from = self.jump.map_or(now + GAP, |(from, _)| from);
            self.jump = Some((from, time.next_multiple_of(self.period)));
        } else {
            self.first = time;
        }
        Step::Gap
    }

    /// Lays the first sample at the newest frame, if all that is `complete` or waited for long enough.
    pub(super) fn start(&mut self, complete: bool) {
        if self.next.is_none()
            && let Some(now) = self.now
            && (complete || self.ending || now - self.first > self.patience)
        {
            let earliest = self.last.map_or(now, |last| now.max(last + Micros(1)));
            self.next = Some(earliest.next_multiple_of(self.period));
        }
    }

    /// Goes on in the time of another grid: no sample is made where that one made some already.
    pub(super) fn follow(&mut self, before: &Grid) {
        (self.now, self.last) = (before.now, before.last);
        self.first = before.now.unwrap_or_default();
    }

    /// Nothing more will come: what is left may be sampled up to the last frame.
    pub(super) fn end(&mut self) {
        self.ending = true;
        self.start(true);
    }

    /// The next sample's time, if it is due, and the seconds since the one before.
    pub(super) fn due(&mut self) -> Option<(Micros, f64)> {
        let (now, mut time) = (self.now?, self.next?);
        if let Some((from, to)) = self.jump
            && time > from
        {
            time = time.max(to);
            self.next = Some(time);
            self.jump = None;
        }
        let due = if self.ending { time <= now } else { time + self.lag < now };
        if !due || self.last.is_some_and(|last| time <= last) {
            return None;
        }
        let elapsed = self.last.map_or(self.period, |last| time - last);
        self.last = Some(time);
        self.next = Some(time + self.period);
        Some((time, elapsed.seconds()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn grid() -> Grid {
        Grid::new(&SamplerConfig::default(), Micros(0))
    }

    fn drain(grid: &mut Grid) -> Vec<i64> {
        std::iter::from_fn(|| grid.due()).map(|(time, _)| time.0 / 1000).collect()
    }

    #[test]
    fn samples_wait_for_the_lag_and_lie_on_multiples_of_the_period() {
        let mut grid = grid();
        grid.advance(Micros(1_003_000));
        grid.start(true);
        assert!(drain(&mut grid).is_empty());
        grid.advance(Micros(1_030_000));
        assert!(drain(&mut grid).is_empty());
        grid.advance(Micros(1_030_001));
        assert_eq!(drain(&mut grid), [1010]);
        grid.end();
        assert_eq!(drain(&mut grid), [1020, 1030]);
    }

    #[test]
    fn the_first_sample_waits_for_completeness_but_not_for_ever() {
        let mut grid = grid();
        grid.advance(Micros(0));
        grid.start(false);
        grid.advance(Micros(500_000));
        grid.start(false);
        assert!(grid.next.is_none());
        grid.advance(Micros(500_001));
        grid.start(false);
        assert_eq!(grid.next, Some(Micros(510_000)));
    }

    #[test]
    fn a_gap_of_a_year_costs_a_second_of_samples() {
        let mut grid = grid();
        grid.advance(Micros(0));
        grid.start(true);
        assert_eq!(grid.advance(Micros(31_536_000_000_000)), Step::Gap);
        assert_eq!(drain(&mut grid).len(), 101);
        grid.advance(Micros(31_536_000_100_000));
        let (time, elapsed) = grid.due().unwrap();
        assert_eq!((time.0, elapsed), (31_536_000_000_000, 31_535_999.0));
    }

    #[test]
    fn the_ends_of_time_are_reached_without_looping() {
        let mut grid = grid();
        for time in [i64::MIN, i64::MAX, 0, i64::MIN, i64::MAX] {
            grid.advance(Micros(time));
            grid.start(true);
            assert!(drain(&mut grid).len() < 200);
        }
        grid.end();
        assert!(drain(&mut grid).len() < 200);
    }

    #[test]
    fn a_grid_that_follows_makes_no_sample_twice() {
        let mut before = grid();
        before.advance(Micros(1_000_000));
        before.start(true);
        before.advance(Micros(1_020_000));
        before.end();
        assert_eq!(drain(&mut before), [1000, 1010, 1020]);
        let mut after = grid();
        after.follow(&before);
        assert_eq!(after.advance(Micros(1_015_000)), Step::Late);
        after.start(true);
        after.advance(Micros(1_060_000));
        let made: Vec<_> = std::iter::from_fn(|| after.due()).collect();
        assert_eq!(made, [(Micros(1_030_000), 0.01)]);
    }

    #[test]
    fn a_clock_set_back_starts_anew_with_one_period_elapsed() {
        let mut grid = grid();
        grid.advance(Micros(10_000_000));
        grid.start(true);
        grid.advance(Micros(10_100_000));
        drain(&mut grid);
        assert_eq!(grid.advance(Micros(9_200_000)), Step::Late);
        assert_eq!(grid.advance(Micros(9_000_000)), Step::Back);
        grid.start(true);
        grid.advance(Micros(9_030_001));
        assert_eq!(grid.due(), Some((Micros(9_000_000), 0.01)));
    }
}
