//! Measured beside simulated, as plots.

use std::ops::Range;

use super::stretch::Stretch;
use super::words;
use crate::explain::Trace;
use crate::report::{Color, Page, Plot, Stroke};

/// What the colours mean, on every plot of the page.
pub const MEASURED: (&str, Color) = ("measured", Color::Truth);
pub const PLAIN: (&str, Color) = ("plain model", Color::Second);
pub const EXTENDED: (&str, Color) = ("extended model", Color::First);

/// A step this many times longer than usual is a gap.
const GAP: f64 = 5.0;
/// Of how much of the range of the others the plain model may go beyond it.
const BEYOND: f64 = 0.5;

/// The three courses over a stretch.
pub fn plot(stretch: &Stretch<'_>, height: u32, has_extended: bool) -> Option<Plot> {
    let trace = stretch.trace;
    let (factor, unit) = words::shown_unit(&trace.channel, &trace.unit);
    let [from, to] = stretch.t;
    let series = |values: &[f64]| series(trace, values, factor, stretch.t);
    let measured = series(&trace.measured);
    let baseline = series(&trace.baseline);
    let extended = if has_extended { series(&trace.extended) } else { Vec::new() };
    let mut y = range(measured.iter().chain(&extended).map(|point| point.1))
        .or_else(|| range(baseline.iter().map(|point| point.1)))?;
    // A plain model far off must not press everything else flat.
    if let Some(plain) = range(baseline.iter().map(|point| point.1)) {
        let beyond = BEYOND * (y.end - y.start);
        y = plain.start.clamp(y.start - beyond, y.start)..plain.end.clamp(y.end, y.end + beyond);
    }
    let mut plot = Plot::new(&words::channel(&trace.channel), &axis(&unit), from..to, y)
        .height(height)
        .line(MEASURED.0, MEASURED.1, measured.into_iter())
        .stroked(
            PLAIN.0,
            PLAIN.1,
            if has_extended { Stroke::Dashed } else { Stroke::Solid },
            baseline.into_iter(),
        );
    if has_extended {
        plot = plot.line(EXTENDED.0, EXTENDED.1, extended.into_iter());
    }
    (from < to).then_some(plot)
}

/// What is written beside an axis.
pub fn axis(unit: &str) -> String {
    match unit {
        "" => "1".into(),
        // A small circle that lies on its side says nothing.
        "°" => "degrees".into(),
        unit => unit.into(),
    }
}

/// Draws it; what cannot be drawn is said instead.
pub fn draw(page: &mut Page, heading: &str, plot: &Plot, caption: &str) {
    if let Err(error) = page.plot(heading, plot, caption) {
        page.paragraph(&error.to_string());
    }
}

/// Points of a stretch, with a hole where the recording has one.
pub fn series(trace: &Trace, values: &[f64], factor: f64, [from, to]: [f64; 2]) -> Vec<(f64, f64)> {
    let usual = usual_step(&trace.t);
    let mut points: Vec<(f64, f64)> = Vec::new();
    for (&t, &value) in trace.t.iter().zip(values) {
        if !(from..=to).contains(&t) {
            continue;
        }
        if let Some(last) = points.last().filter(|last| t - last.0 > GAP * usual) {
            points.push((0.5 * (last.0 + t), f64::NAN));
        }
        points.push((t, factor * value));
    }
    points
}

/// The median of the first steps, s.
fn usual_step(t: &[f64]) -> f64 {
    let mut steps: Vec<f64> = t.windows(2).take(500).map(|pair| pair[1] - pair[0]).collect();
    steps.sort_by(f64::total_cmp);
    steps.get(steps.len() / 2).copied().unwrap_or(f64::INFINITY)
}

/// From the lowest to the highest, and a little more.
pub fn range(values: impl Iterator<Item = f64>) -> Option<Range<f64>> {
    let (low, high) = values
        .filter(|value| value.is_finite())
        .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), value| (low.min(value), high.max(value)));
    let margin = (0.06 * (high - low)).max(1e-6 + 1e-3 * high.abs());
    (low <= high).then_some(low - margin..high + margin)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_gap_in_the_recording_is_a_gap_in_the_line() {
        let trace = Trace { t: vec![0.0, 0.1, 0.2, 5.0, 5.1], ..Trace::default() };
        let points = series(&trace, &[1.0, 2.0, 3.0, 4.0, 5.0], 2.0, [0.0, 5.0]);
        assert_eq!(points.len(), 5, "{points:?}");
        assert!(points[3].1.is_nan() && points[4] == (5.0, 8.0));
    }

    #[test]
    fn a_plain_model_far_off_leaves_room_for_the_others() {
        let t: Vec<f64> = (0..100).map(f64::from).collect();
        let wave: Vec<f64> = t.iter().map(|t| t.sin()).collect();
        let trace = Trace {
            channel: "lateral_acceleration".into(),
            unit: "m/s²".into(),
            baseline: vec![1e5; t.len()],
            extended: wave.clone(),
            measured: wave,
            t,
            ..Trace::default()
        };
        let plot = plot(&Stretch { trace: &trace, t: [0.0, 99.0], is_holdout: true }, 300, true).unwrap();
        let svg = plot.svg().unwrap();
        assert!(!svg.contains("100000") && !svg.contains("NaN"), "{svg}");
    }
}
