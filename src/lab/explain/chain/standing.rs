//! What the yaw rate reads while the car stands: its zero, and whether that moves.

use super::report::{AuditFinding, ChainReport, Confidence};
use super::series::Series;
use crate::explain::ordinary::{deviation, zero_wanders};
use physics::Quantity;
use physics::model::effect;

/// Wheels slower than this stand, rad/s. Physical: less than one of 48 teeth a second.
const STANDING: f64 = 0.13;
/// Standing for less than this is not counted, s. Tuned, no test on record.
const STANDING_S: f64 = 1.0;

/// Seconds of standing that tell of a drift. Statistical: fewer are fitted by a step.
const LEAST_SECONDS: usize = 8;
/// So many of them before the car moves, and after it, tell that the zero is still. Statistical: the noise of a second's mean is
/// a third of what counts.
const LEAST_BEFORE_AND_AFTER: usize = 2;
/// Drift against the noise of a second's mean, as variances. Statistical: of white noise a ratio of 3 is one in a million with
/// twenty seconds.
const SLOW: f64 = 10.0;
/// Over so many seconds the zero's wander is measured, s: longer than the noise, shorter than most stops.
const WANDER_S: f64 = 5.0;

/// Means of the yaw rate over seconds in which the car stands.
#[derive(Clone, Debug)]
pub struct Standing {
    /// The middle of each second, s, and the mean.
    seconds: Vec<[f64; 2]>,
    /// The recording's first and last moment, s …
    ends: [f64; 2],
    /// … and those in which the car moves.
    moving: [f64; 2],
}

impl Standing {
    /// None where the car does not stand for two seconds.
    pub(super) fn of(series: &Series) -> Option<Self> {
        let standing: Vec<bool> = (0..series.len()).map(|row| series.stands(row, STANDING)).collect();
        let yaw = series.raw(Quantity::YawRate);
        let least = ((STANDING_S / series.dt) as usize).max(1);
        let mut seconds = Vec::new();
        let mut row = 0;
        while row < series.len() {
            let length = standing[row..].iter().take_while(|stands| **stands).count();
            // The first half second is still rocking.
            let settled = row + length.min(least / 2);
            for first in (settled..row + length).step_by(least).filter(|first| first + least <= row + length)
            {
                let mean = yaw[first..first + least].iter().sum::<f64>() / least as f64;
                let middle = 0.5 * (series.time(first) + series.time(first + least - 1));
                if mean.is_finite() {
                    seconds.push([middle, mean]);
                }
            }
            row += length.max(1);
        }
        let ends = [series.time(0), series.time(series.len() - 1)];
        let moves = |row: &usize| series.moves(*row);
        let [first, last] = [(0..series.len()).find(moves), (0..series.len()).rev().find(moves)];
        let moving = first.zip(last).map_or(ends, |(first, last)| [first, last].map(|row| series.time(row)));
        (seconds.len() >= 2).then_some(Self { seconds, ends, moving })
    }

    /// So many seconds.
    pub(super) fn count(&self) -> usize {
        self.seconds.len()
    }

    /// The mean of all, and its standard deviation.
    pub(super) fn zero(&self) -> (f64, f64) {
        let (mean, square) = about_mean(&self.seconds);
        let count = self.count() as f64;
        (mean, (square / (count - 1.0) / count).sqrt().max(1e-6))
    }

    /// The recording's length, s.
    pub fn recorded_s(&self) -> f64 {
        self.ends[1] - self.ends[0]
    }

    /// The zero's course, if it moves by more than an ordinary sensor's, and not in one step: that is a jump, which shows in
    /// the driving as well.
    fn drift(&self) -> Option<ZeroCourse> {
        let noise = self.noise()?;
        let moved = Moved::of(&self.seconds)?;
        tracing::debug!(
            seconds = self.count(),
            beside_a_step = moved.beside_a_step.sqrt(),
            mostly = moved.mostly,
            noise = noise.sqrt(),
            "zero of the yaw rate at standstill"
        );
        let is_slow = moved.beside_a_step > SLOW * noise;
        (is_slow && moved.mostly > self.ordinary()).then(|| self.course(noise))
    }

    /// Does it read the same before the car moves and after it?
    pub fn is_still(&self) -> bool {
        let mean = |is_there: &dyn Fn(f64) -> bool| {
            let there: Vec<[f64; 2]> = self.seconds.iter().copied().filter(|[t, _]| is_there(*t)).collect();
            (there.len() >= LEAST_BEFORE_AND_AFTER).then(|| about_mean(&there).0)
        };
        let [from, to] = self.moving;
        let changes = mean(&|t| t < from).zip(mean(&|t| t > to)).map(|(before, after)| after - before);
        changes.is_some_and(|change| change.abs() < self.ordinary()) && self.drift().is_none()
    }

    /// What a drift, as it is at each time, s, has of what it needs to be told, and that: both in deviations.
    pub fn bars(&self, drift: impl Fn(f64) -> f64) -> Option<[[f64; 2]; 2]> {
        let noise = self.noise()?;
        let seconds: Vec<[f64; 2]> =
            self.seconds.iter().map(|[t, _]| [*t, drift(t - self.ends[0])]).collect();
        let moved = Moved::of(&seconds)?;
        let std = (noise / self.count() as f64).sqrt();
        let slow = [moved.beside_a_step.sqrt() / std, (SLOW * noise).sqrt() / std];
        Some([slow, [moved.mostly / std, self.ordinary() / std]])
    }

    /// A zero that moves by less is an ordinary sensor's, rad/s rms.
    fn ordinary(&self) -> f64 {
        zero_wanders(self.recorded_s())
    }

    /// The variance of a second's mean, by how far three in a row are from a straight line: of the zero's own way nothing is
    /// in that.
    fn noise(&self) -> Option<f64> {
        let is_in_a_row = |three: &&[[f64; 2]]| three[2][0] - three[0][0] < 2.5 * STANDING_S;
        let bend = |three: &[[f64; 2]]| (three[0][1] - 2.0 * three[1][1] + three[2][1]).powi(2);
        mean_of(self.seconds.windows(3).filter(is_in_a_row).map(bend)).map(|square| (square / 6.0).max(1e-12))
    }

    fn course(&self, noise: f64) -> ZeroCourse {
        // Between stops it wanders on as it does at them: what a bridge does not know, in the mean.
        let later = |[at, value]: &[f64; 2]| {
            let after = self.seconds.iter().find(|[then, _]| then - at >= WANDER_S)?;
            (after[0] - at < 2.0 * WANDER_S).then(|| (after[1] - value).powi(2) / (after[0] - at))
        };
        let wander = mean_of(self.seconds.iter().filter_map(later)).unwrap_or(0.0);
        let gaps = self.seconds.windows(2).map(|pair| pair[1][0] - pair[0][0]);
        let bridged: f64 = gaps.map(|gap| gap * gap / 6.0).sum();
        let [first, last] = [self.seconds[0], self.seconds[self.seconds.len() - 1]];
        let open = [first[0] - self.ends[0], self.ends[1] - last[0]];
        let open: f64 = open.iter().map(|gap| gap * gap / 2.0).sum();
        let unknown = wander * (bridged + open) / self.recorded_s();
        let t = self.seconds.iter().map(|[t, _]| *t);
        let value = self.seconds.iter().map(|[_, mean]| *mean);
        let [begins, ends] = self.ends;
        let mut course = ZeroCourse {
            course: effect::Series {
                t: std::iter::once(begins).chain(t).chain([ends]).collect(),
                value: std::iter::once(first[1]).chain(value).chain([last[1]]).collect(),
            },
            rms: 0.0,
            std: (unknown + noise).sqrt(),
            clear: (about_mean(&self.seconds).1 / noise).sqrt(),
        };
        let mean = course.mean(|value| value);
        course.course.value.iter_mut().for_each(|value| *value -= mean);
        course.rms = course.mean(|value| value * value).sqrt();
        course
    }
}

/// How means move beside the one step that they fit best.
struct Moved {
    /// Their variance about that.
    beside_a_step: f64,
    /// What most of them are off, on one side of it. Wheel sensors read zero while a car creeps round a corner: that is some
    /// seconds of a stop only.
    mostly: f64,
}

impl Moved {
    /// None of too few, and where the clock went back.
    fn of(seconds: &[[f64; 2]]) -> Option<Self> {
        let count = seconds.len();
        if count < LEAST_SECONDS || seconds.windows(2).any(|pair| pair[1][0] <= pair[0][0]) {
            return None;
        }
        let squares = |at: usize| about_mean(&seconds[..at]).1 + about_mean(&seconds[at..]).1;
        let step = (1..count).min_by(|a, b| squares(*a).total_cmp(&squares(*b)))?;
        Some(Self {
            beside_a_step: squares(step) / (count - 2) as f64,
            mostly: typical(&seconds[..step]).max(typical(&seconds[step..])),
        })
    }
}

/// How a sensor's zero moves about its mean: straight lines between what it reads while the car stands.
#[derive(Clone, Debug, PartialEq)]
pub struct ZeroCourse {
    /// By the samples' clock: what it reads too much.
    course: effect::Series,
    /// The root of its mean square …
    pub rms: f64,
    /// … and the standard deviation of that.
    pub std: f64,
    /// How far beyond noise it is while the car stands, in deviations.
    clear: f64,
}

impl ZeroCourse {
    /// What the sensor reads too much at a time, s; beyond the ends as there.
    pub fn at(&self, t: f64) -> f64 {
        let ends = self.course.t.first().zip(self.course.t.last());
        ends.map_or(0.0, |(first, last)| self.course.at(t.clamp(*first, *last)))
    }

    /// The times, s, and values between which it is a straight line.
    pub fn points(&self) -> &effect::Series {
        &self.course
    }

    /// The mean over time of something of it.
    fn mean(&self, of: impl Fn(f64) -> f64) -> f64 {
        let effect::Series { t, value } = &self.course;
        // Simpson's rule is exact for squares of lines.
        let line = |(t, value): (&[f64], &[f64])| {
            let middle = 0.5 * (value[0] + value[1]);
            (t[1] - t[0]) * (of(value[0]) + 4.0 * of(middle) + of(value[1])) / 6.0
        };
        let sum: f64 = t.windows(2).zip(value.windows(2)).map(line).sum();
        let seconds = t.last().zip(t.first()).map_or(0.0, |(last, first)| last - first);
        sum / seconds.max(1e-9)
    }
}

/// Takes a drift of the yaw rate's zero out, and reports it.
pub(super) fn drift(series: &mut Series, report: &mut ChainReport) {
    report.standing = Standing::of(series);
    let Some(course) = report.standing.as_ref().and_then(Standing::drift) else { return };
    let value = &course.course.value;
    let ends = [value.first(), value.last()].map(|value| value.copied().unwrap_or_default());
    report.findings.push(AuditFinding {
        effect: AuditFinding::DRIFT,
        channel: Quantity::YawRate.name().to_owned(),
        value: Some(course.rms),
        std: Some(course.std),
        t: course.clear,
        evidence: format!(
            "its zero moves while the car stands, from {:+.4} at the recording's first stop to {:+.4} rad/s at its last, \
             about its mean",
            ends[0], ends[1]
        ),
        confidence: Confidence::Certain,
        repair: "look at the sensor's supply and temperature; no offset takes a zero out that moves".into(),
        or: Vec::new(),
    });
    series.take_course(Quantity::YawRate, |t| course.at(t));
    series.refresh();
    report.drift = Some(course);
}

/// The mean of some means, and the sum of their squares about it.
fn about_mean(seconds: &[[f64; 2]]) -> (f64, f64) {
    let mean = seconds.iter().map(|[_, mean]| mean).sum::<f64>() / seconds.len().max(1) as f64;
    (mean, seconds.iter().map(|[_, of]| (of - mean).powi(2)).sum())
}

/// The robust deviation of some means from the middle one.
fn typical(seconds: &[[f64; 2]]) -> f64 {
    let mut values: Vec<f64> = seconds.iter().map(|[_, mean]| *mean).collect();
    values.sort_by(f64::total_cmp);
    let Some(middle) = values.get(values.len() / 2) else { return 0.0 };
    deviation(values.iter().map(|value| value - middle)).unwrap_or(0.0)
}

fn mean_of(values: impl Iterator<Item = f64>) -> Option<f64> {
    let (sum, count) = values.fold((0.0, 0.0), |(sum, count), value| (sum + value, count + 1.0));
    (count > 0.0).then(|| sum / count)
}

#[cfg(test)]
mod tests {
    use rand::{RngExt, SeedableRng};
    use rand_chacha::ChaCha8Rng;

    use super::*;

    /// A car that stands for 20 s, drives for 40 and stands for 12, with this zero and a sensor's noise.
    fn standing(zero: impl Fn(f64) -> f64) -> Standing {
        let mut random = ChaCha8Rng::seed_from_u64(7);
        let times = (0..20).chain(60..72).map(|second| f64::from(second) + 0.5);
        let noise = |random: &mut ChaCha8Rng| 0.0014 * (random.random::<f64>() - 0.5);
        Standing {
            seconds: times.map(|t| [t, zero(t) + noise(&mut random)]).collect(),
            ends: [0.0, 72.0],
            moving: [21.0, 59.0],
        }
    }

    #[test]
    fn a_zero_that_moves_is_seen_with_its_size() {
        let course = standing(|t| 0.03 * (t / 12.0).cos()).drift().unwrap();
        let truth = |t: f64| 0.03 * (t / 12.0).cos() - 0.03 * 12.0 * 6f64.sin() / 72.0;
        assert!((course.at(10.0) - course.at(0.5) - (truth(10.0) - truth(0.5))).abs() < 0.002);
        assert!((course.rms - 0.021).abs() < 2.0 * course.std && course.std < 0.02, "{course:?}");
        // Straight from one stop to the next, and the same before the first moment and after the last.
        let [from, to] = [19.5, 60.5].map(|t| course.at(t));
        assert!((course.at(40.0) - 0.5 * (from + to)).abs() < 1e-12);
        assert_eq!((course.at(-5.0), course.at(99.0)), (course.at(0.0), course.at(72.0)));
    }

    #[test]
    fn a_zero_that_is_still_or_jumps_does_not_drift() {
        assert_eq!(standing(|_| 0.02).drift(), None);
        assert_eq!(standing(|t| if t < 14.0 { 0.0 } else { 0.03 }).drift(), None);
        assert_eq!(standing(|t| if t < 30.0 { 0.0 } else { 0.03 }).drift(), None);
        // It creeps round a corner, slower than its wheel sensors know.
        assert_eq!(standing(|t| if (6.0..10.0).contains(&t) { 0.05 * (t - 6.0) } else { 0.0 }).drift(), None);
    }

    /// GIVEN stops THEN a drift has what it needs to be told exactly if it would be told.
    #[test]
    fn what_a_drift_needs_is_what_it_is_told_by() {
        let drift = |size: f64| move |t: f64| size * (t / 12.0).cos();
        for size in [0.0005, 0.002, 0.008, 0.03] {
            let is_clear = |[has, needs]: [f64; 2]| has > needs;
            let would_be = standing(|_| 0.01).bars(drift(size)).unwrap().into_iter().all(is_clear);
            assert_eq!(standing(drift(size)).drift().is_some(), would_be, "{size}");
            assert_eq!(would_be, size > 0.005, "{size}");
        }
    }

    #[test]
    fn a_zero_is_still_that_is_the_same_before_and_after() {
        assert!(standing(|_| 0.02).is_still());
        assert!(!standing(|t| if t < 30.0 { 0.0 } else { 0.01 }).is_still());
        assert!(!standing(|t| 0.03 * (t / 12.0).cos()).is_still());
        // It stands after the drive only.
        let late = Standing { moving: [0.2, 59.0], ..standing(|_| 0.02) };
        assert!(!late.is_still());
    }

    #[test]
    fn where_the_clock_goes_back_nothing_is_said() {
        let mut standing = standing(|t| 0.03 * (t / 12.0).cos());
        standing.seconds.swap(3, 9);
        assert_eq!(standing.drift(), None);
    }

    #[test]
    fn a_course_has_no_mean_and_the_mean_square_of_its_lines() {
        let course = effect::Series { t: vec![0.0, 1.0, 3.0], value: vec![-1.0, -1.0, 1.0] };
        let course = ZeroCourse { course, rms: 0.0, std: 0.0, clear: 0.0 };
        assert!((course.mean(|value| value) + 1.0 / 3.0).abs() < 1e-12);
        assert!((course.mean(|value| value * value) - 5.0 / 9.0).abs() < 1e-12);
    }
}
