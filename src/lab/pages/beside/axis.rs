//! One time axis for all recordings, which stand behind each other.

use super::{Beside, Drive};
use crate::report::interactive::{Clock, Grid, Mark, Numbers, Plots};
use physics::time::{Date, Micros};

/// Rows before they are thinned, s.
const STEP_S: f64 = 0.05;
/// Between two recordings, s.
const PAUSE_S: f64 = 1.0;
/// Between readings that are so many times further apart than usual there is a gap …
const GAP: f64 = 5.0;
/// … if they are so far apart, s.
const LEAST_GAP_S: f64 = 0.25;

/// The axis.
pub struct Axis {
    /// Of all rows, s on the page.
    pub times: Vec<f64>,
    /// The rows of each recording, and what is added to its seconds to be on the page.
    parts: Vec<(std::ops::Range<usize>, f64)>,
    /// The rows that the page has.
    pub grid: Grid,
}

impl Axis {
    /// Of recordings that are drawn in so many lines.
    pub fn new(beside: &Beside, lines: usize) -> Self {
        let mut times: Vec<f64> = Vec::new();
        let mut parts = Vec::new();
        for drive in &beside.drives {
            let own = rows(drive);
            let first = own.first().copied().unwrap_or(0.0);
            let offset = times.last().map_or(0.0, |last| last + PAUSE_S - first);
            let begin = times.len();
            times.extend(own.iter().map(|t| t + offset));
            parts.push((begin..times.len(), offset));
        }
        Self { grid: Grid::of_page(&times, lines, beside.points()), times, parts }
    }

    /// Plots without panels: where recordings begin.
    pub fn plots(&self, beside: &Beside) -> Plots {
        let mut plots = Plots {
            times: Numbers::rounded(self.grid.times().to_vec(), 3),
            stretch_s: self.grid.stretch_s(),
            panels_first: true,
            ..Plots::default()
        };
        for ((rows, offset), drive) in self.parts.iter().zip(&beside.drives) {
            let Some(from_s) = self.times.get(rows.start).copied().filter(|_| !rows.is_empty()) else {
                continue;
            };
            let begins = drive.begins_utc.as_deref().and_then(Date::parse_iso).map(Micros::seconds);
            let name = crate::pages::file_name(&drive.name).to_owned();
            if !plots.clocks.is_empty() {
                plots.marks.push(Mark { at_s: from_s, name: name.clone() });
            }
            let own_s = Some(from_s - offset);
            plots.clocks.push(Clock { from_s, utc_s: begins.map(|it| it + from_s - offset), name, own_s });
        }
        plots
    }

    /// The rows of a recording.
    pub fn rows(&self, drive: usize) -> std::ops::Range<usize> {
        self.parts.get(drive).map_or(0..0, |(rows, _)| rows.clone())
    }

    /// A moment of a recording on the page.
    pub fn at(&self, drive: usize, t: f64) -> f64 {
        t + self.parts.get(drive).map_or(0.0, |(_, offset)| *offset)
    }

    /// Stretches of a recording on the page, as far as they are on it.
    pub fn on_page<'s>(
        &'s self,
        drive: usize,
        stretches: &'s [[f64; 2]],
    ) -> impl Iterator<Item = (f64, f64)> + 's {
        let rows = self.times.get(self.rows(drive)).unwrap_or_default();
        let ends = rows.first().zip(rows.last());
        stretches.iter().filter_map(move |[from, to]| {
            let (first, last) = ends?;
            let (from, to) = (self.at(drive, *from).max(*first), self.at(drive, *to).min(*last));
            (from <= to).then_some((from, to))
        })
    }

    /// What each recording has of something (times and values), a number for each row: interpolated, with gaps.
    pub fn column<'d>(
        &self,
        drives: &'d [Drive],
        of: impl Fn(usize, &'d Drive) -> Option<(&'d [f64], &'d [f64])>,
    ) -> Vec<f32> {
        let mut column = vec![f32::NAN; self.times.len()];
        for (place, ((rows, offset), drive)) in self.parts.iter().zip(drives).enumerate() {
            let Some((t, values)) = of(place, drive) else { continue };
            let gap = (GAP * usual_step(t)).max(LEAST_GAP_S);
            let mut next = 0;
            for row in rows.clone() {
                let time = self.times[row] - offset;
                while t.get(next).is_some_and(|t| *t < time) {
                    next += 1;
                }
                column[row] = between(t, values, next, time, gap) as f32;
            }
        }
        column
    }
}

/// The value at a time before the reading with this number, and not before the one before.
fn between(t: &[f64], values: &[f64], next: usize, time: f64, gap: f64) -> f64 {
    let of = |place: usize| Some((*t.get(place)?, *values.get(place)?));
    match (next.checked_sub(1).and_then(of), of(next)) {
        (_, Some((after, value))) if after == time => value,
        (Some((before, from)), Some((after, to))) if after - before <= gap => {
            from + (to - from) * (time - before) / (after - before)
        }
        _ => f64::NAN,
    }
}

/// The rows of a recording: where any model says anything.
fn rows(drive: &Drive) -> Vec<f64> {
    let said = drive.channels.iter().flat_map(|channel| &channel.said);
    let mut all: Vec<f64> = said.flat_map(|said| said.t.iter().copied()).filter(|t| t.is_finite()).collect();
    all.sort_by(f64::total_cmp);
    let mut rows: Vec<f64> = Vec::new();
    for t in all {
        match rows.last().copied() {
            None => rows.push(t),
            Some(last) if t - last > LEAST_GAP_S => rows.push(t),
            // Steps of one length, up to where there is something.
            Some(last) if t - last >= STEP_S => {
                let steps = ((t - last) / STEP_S + 1e-6) as u32;
                rows.extend((1..=steps).map(|step| last + f64::from(step) * STEP_S));
            }
            Some(_) => {}
        }
    }
    rows
}

/// The median of the first steps, s.
fn usual_step(t: &[f64]) -> f64 {
    let mut steps: Vec<f64> = t.windows(2).take(500).map(|pair| pair[1] - pair[0]).collect();
    steps.sort_by(f64::total_cmp);
    steps.get(steps.len() / 2).copied().unwrap_or(f64::INFINITY)
}

#[cfg(test)]
mod tests {
    use super::super::{Channel, Said};
    use super::*;

    fn drive(name: &str, t: Vec<f64>) -> Drive {
        let said = Said { measured: t.iter().map(|t| 2.0 * t).collect(), predicted: t.clone(), t };
        let channel = Channel { name: "yaw_rate".into(), unit: "rad/s".into(), said: vec![said] };
        Drive { name: name.into(), channels: vec![channel], ..Drive::default() }
    }

    fn beside() -> Beside {
        let steps = |from: f64, count: u32| (0..count).map(move |it| from + 0.1 * f64::from(it));
        let first = steps(0.0, 20).chain(steps(30.0, 20)).collect();
        let mut second = drive("b/two.log", steps(500.0, 20).collect());
        second.begins_utc = Some("2025-10-09T08:53:20.000Z".into());
        Beside { drives: vec![drive("a/one.log", first), second], ..Beside::default() }
    }

    #[test]
    fn recordings_stand_behind_each_other_with_gaps_and_their_own_clocks() {
        let beside = beside();
        let axis = Axis::new(&beside, 10);
        let values = axis.column(&beside.drives, |_, drive| drive.measured("yaw_rate"));
        for (drive, own) in [(0, 0.05), (0, 1.85), (0, 30.9), (1, 500.0), (1, 501.85)] {
            let row = axis.times.partition_point(|t| *t < axis.at(drive, own) - 1e-6);
            assert!((f64::from(values[row]) - 2.0 * own).abs() < 1e-3, "{own}: {}", values[row]);
        }
        assert!(!axis.times.iter().any(|t| (2.5..29.5).contains(t)), "nothing was there");
        let plots = axis.plots(&beside);
        assert_eq!((plots.clocks[0].own_s, plots.clocks[0].utc_s), (Some(0.0), None));
        assert!((plots.clocks[1].own_s.unwrap() - 500.0).abs() < 1e-9);
        assert!((plots.clocks[1].utc_s.unwrap() - 1_760_000_500.0).abs() < 1e-3);
        assert_eq!((plots.marks.len(), plots.marks[0].name.as_str()), (1, "two.log"));
        let stretch: Vec<_> = axis.on_page(1, &[[400.0, 500.5], [600.0, 700.0]]).collect();
        assert_eq!(stretch.len(), 1);
        assert!((stretch[0].0 - plots.clocks[1].from_s).abs() < 1e-9);
    }

    #[test]
    fn a_hole_in_one_channel_is_a_gap_of_its_line() {
        let beside = beside();
        let axis = Axis::new(&beside, 10);
        let t = [0.0, 0.1, 0.2, 1.5, 1.6];
        let values = axis.column(&beside.drives, |place, _| (place == 0).then_some((&t[..], &t[..])));
        assert!(values[2].is_finite() && values[12].is_nan() && values[31].is_finite(), "{values:?}");
    }
}
