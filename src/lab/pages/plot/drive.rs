//! What a page keeps of a drive: a column for each quantity.

use crate::report::interactive::Clock;
use physics::estimates::Estimate;
use physics::time::{Clock as BothClocks, Moment};
use physics::{Estimates, Faults, Micros, Quantity, Sample};

/// A drive as it comes, sample by sample. Numbers are SI; not-a-number: not available.
#[derive(Clone, Debug)]
pub struct Drive {
    /// What is configured.
    pub(super) quantities: Vec<Quantity>,
    /// Where recordings begin on the page's time axis.
    pub(super) clocks: Vec<Clock>,
    /// Of the samples, s from the start.
    pub(super) times: Vec<f64>,
    /// Of each configured quantity.
    pub(super) signals: Vec<Vec<f32>>,
    pub(super) speed: Vec<f32>,
    pub(super) sideslip: Vec<f32>,
    /// Front, rear.
    pub(super) slip_angle: [Vec<f32>; 2],
    /// Of each wheel.
    pub(super) slope: [Interval; 4],
    /// Front, rear.
    pub(super) cornering: [Interval; 2],
    pub(super) friction_used: Vec<f32>,
    pub(super) friction: Interval,
    pub(super) flags: Vec<Flags>,
    pub(super) faults: Vec<Faults>,
    pub(super) changes: Vec<u32>,
    /// What was learned last.
    pub(super) last: Estimates,
    /// Only what is between these is kept.
    part: [Option<Moment>; 2],
    /// The last sample came after it.
    is_over: bool,
    /// Stamp of the first frame.
    first: Micros,
    /// A recording has begun, and no sample of it has come.
    begun: Option<(String, Micros)>,
    /// What is subtracted from a clock to have the page's time.
    offset_s: f64,
    /// Time of the last sample that came, by its clock and by the page's, s.
    before: Option<(f64, f64)>,
}

/// A number with its 95 % interval.
#[derive(Clone, Debug, Default)]
pub(super) struct Interval {
    pub value: Vec<f32>,
    pub low: Vec<f32>,
    pub high: Vec<f32>,
}

/// What may be acted upon.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Flags {
    pub motion: bool,
    pub slope: bool,
    pub cornering: bool,
    pub friction: bool,
}

impl Interval {
    fn push(&mut self, value: Option<f64>, low: Option<f64>, high: Option<f64>) {
        self.value.push(or_gap(value));
        self.low.push(or_gap(low));
        self.high.push(or_gap(high));
    }

    fn push_estimate(&mut self, estimate: Option<Estimate>) {
        let ends = estimate.map(|it| it.ci95());
        self.push(estimate.map(|it| it.value), ends.map(|it| it.0), ends.map(|it| it.1));
    }
}

fn or_gap(value: Option<f64>) -> f32 {
    value.map_or(f32::NAN, |value| value as f32)
}

impl Drive {
    /// Between recordings that do not follow each other at once the page has a pause of this length, s.
    const PAUSE_S: f64 = 1.0;

    /// Of these quantities; only what is between the ends of `part` is kept.
    pub fn new(quantities: Vec<Quantity>, part: [Option<Moment>; 2]) -> Self {
        Self {
            signals: vec![Vec::new(); quantities.len()],
            quantities,
            clocks: Vec::new(),
            times: Vec::new(),
            speed: Vec::new(),
            sideslip: Vec::new(),
            slip_angle: Default::default(),
            slope: Default::default(),
            cornering: Default::default(),
            friction_used: Vec::new(),
            friction: Interval::default(),
            flags: Vec::new(),
            faults: Vec::new(),
            changes: Vec::new(),
            last: Estimates::default(),
            part,
            is_over: false,
            first: Micros(0),
            begun: None,
            offset_s: 0.0,
            before: None,
        }
    }

    /// The next recording begins with a frame at this time.
    pub fn begin(&mut self, name: &str, first: Micros) {
        if self.before.is_none() {
            self.first = first;
        }
        self.begun = Some((name.to_owned(), first));
    }

    /// No sample that may come is wanted any more.
    pub fn is_over(&self) -> bool {
        self.is_over
    }

    /// No sample was kept.
    pub fn is_empty(&self) -> bool {
        self.times.is_empty()
    }

    /// How long all recordings are that came so far, s.
    pub fn seconds(&self) -> f64 {
        self.before.map_or(0.0, |(_, time)| time)
    }

    /// From when to when they are, by their clocks.
    pub fn span(&self) -> String {
        BothClocks::of(self.first).over([0.0, self.seconds()])
    }

    /// A sample, and what the estimators know after it.
    pub fn push(&mut self, sample: &Sample, now: &Estimates) {
        let time = self.place(sample.time);
        let since = |moment: Moment| match moment {
            Moment::After(seconds) => time - seconds,
            Moment::At(then) => (sample.time - then).seconds(),
        };
        let [from, to] = self.part.map(|end| end.map(since));
        self.is_over = to.is_some_and(|since| since > 0.0);
        if self.is_over || from.is_some_and(|since| since < 0.0) {
            return;
        }
        self.times.push(time);
        for (quantity, column) in self.quantities.iter().zip(&mut self.signals) {
            column.push(or_gap(sample.get(*quantity)));
        }
        let motion = &now.motion;
        self.speed.push(or_gap(motion.speed));
        self.sideslip.push(or_gap(motion.sideslip));
        self.slip_angle[0].push(or_gap(motion.slip_angle_front));
        self.slip_angle[1].push(or_gap(motion.slip_angle_rear));
        for (column, slope) in self.slope.iter_mut().zip(now.slope) {
            column.push_estimate(slope);
        }
        for (column, stiffness) in self.cornering.iter_mut().zip(now.cornering) {
            column.push_estimate(stiffness);
        }
        let friction = &now.friction;
        self.friction_used.push(or_gap(friction.used));
        self.friction.push(friction.max, friction.low, friction.high);
        self.flags.push(Flags {
            motion: motion.valid,
            slope: now.slope_valid,
            cornering: now.cornering_valid,
            friction: friction.valid,
        });
        self.faults.push(now.faults);
        self.changes.push(now.surface_changes);
        self.last = *now;
    }

    /// The place of a clock's time on the page's axis.
    fn place(&mut self, clock: Micros) -> f64 {
        let clock_s = clock.seconds();
        let follows = self.before.is_some_and(|(last, _)| (0.0..=Self::PAUSE_S).contains(&(clock_s - last)));
        // The last samples of a recording come when the next one has begun.
        let joins =
            |first: Micros| clock >= first && self.before.is_some_and(|(last, _)| first.seconds() >= last);
        let begins = self.begun.as_ref().is_some_and(|(_, first)| !follows || joins(*first));
        let runs_back = self.before.is_some_and(|(last, _)| clock_s < last);
        if begins || runs_back {
            let (name, first) = self
                .begun
                .take()
                .map_or((None, clock_s), |(name, first)| (Some(name), first.seconds().min(clock_s)));
            match self.before {
                None => self.offset_s = first,
                Some((_, last)) if !follows => self.offset_s = first - (last + Self::PAUSE_S),
                Some(_) => {}
            }
            let from_s = first - self.offset_s;
            let utc_s = BothClocks::of(Micros::from_seconds(first)).date().map(|_| first);
            let name = name.or_else(|| self.clocks.last().map(|clock| clock.name.clone()));
            self.clocks.push(Clock { from_s, utc_s, name: name.unwrap_or_default(), own_s: None });
        }
        let time = clock_s - self.offset_s;
        self.before = Some((clock_s, time));
        time
    }

    /// The column of a quantity, if it is configured and has a value anywhere.
    pub(super) fn signal(&self, quantity: Quantity) -> Option<&[f32]> {
        let place = self.quantities.iter().position(|it| *it == quantity)?;
        self.signals.get(place).map(Vec::as_slice).filter(|column| column.iter().any(|it| it.is_finite()))
    }

    /// Distance of samples, s; a pause counts as nothing.
    pub(super) fn step_s(&self, place: usize) -> f64 {
        let before = place.checked_sub(1).and_then(|before| self.times.get(before));
        let step = self.times.get(place).zip(before).map_or(0.0, |(now, before)| now - before);
        if step <= crate::report::interactive::Grid::LONGEST_STEP_S { step } else { 0.0 }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const DAY: i64 = 1_760_000_000;

    fn drive(part: [Option<Moment>; 2]) -> Drive {
        Drive::new(vec![Quantity::YawRate], part)
    }

    fn push(drive: &mut Drive, second: i64) {
        drive.push(&Sample::empty(Micros(second * Micros::PER_SECOND), 1.0), &Estimates::default());
    }

    #[test]
    fn recordings_stand_behind_each_other_with_their_own_clocks() {
        let mut drive = drive([None; 2]);
        drive.begin("a", Micros(DAY * Micros::PER_SECOND));
        (0..3).for_each(|second| push(&mut drive, DAY + second));
        drive.begin("b", Micros((DAY - 500) * Micros::PER_SECOND));
        // What waited comes now.
        push(&mut drive, DAY + 3);
        (0..3).for_each(|second| push(&mut drive, DAY - 500 + second));
        assert_eq!(drive.times, [0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0]);
        let clocks: Vec<_> = drive.clocks.iter().map(|it| (it.from_s, it.utc_s, it.name.as_str())).collect();
        assert_eq!(clocks, [(0.0, Some(DAY as f64), "a"), (4.0, Some(DAY as f64 - 500.0), "b")]);
    }

    #[test]
    fn a_part_keeps_its_times_and_a_clock_that_was_never_set_tells_no_date() {
        let mut drive = drive([2.0, 4.0].map(|s| Some(Moment::After(s))));
        drive.begin("a", Micros(0));
        (0..10).for_each(|second| push(&mut drive, second));
        assert_eq!(drive.times, [2.0, 3.0, 4.0]);
        assert!(drive.is_over());
        assert_eq!(drive.seconds(), 9.0);
        assert_eq!(drive.clocks[0].utc_s, None);
        assert_eq!(drive.span(), "0.0 to 9.0 s");
    }

    #[test]
    fn a_part_is_asked_for_by_the_date_too() {
        let at = |second: i64| Some(Moment::At(Micros((DAY + second) * Micros::PER_SECOND)));
        let mut drive = drive([at(2), at(4)]);
        drive.begin("a", Micros(DAY * Micros::PER_SECOND));
        (0..10).for_each(|second| push(&mut drive, DAY + second));
        assert_eq!(drive.times, [2.0, 3.0, 4.0]);
        assert_eq!(drive.span(), "0.0 to 9.0 s (2025-10-09T08:53:20.000Z to 08:53:29.000Z)");
    }
}
