//! Measured beside simulated, with the table's numbers and with the identified ones.

use std::ops::Range;

use super::Story;
use crate::identify::{FitRow, Output};
use crate::report::{Color, Page, Plot, PlotError};

/// Shorter stretches show little, s.
const SHORTEST_S: f64 = 5.0;

/// The worst and a typical stretch.
pub fn plots(page: &mut Page, story: &Story<'_>) -> Result<(), PlotError> {
    let found = story.found;
    let Some((worst, typical)) = worst_and_typical(story) else { return Ok(()) };
    let mut shown = vec![("A typical stretch", typical.clone())];
    if worst != typical {
        shown.push(("The stretch that fits worst", worst));
    }
    for (name, stretch) in shown {
        let (Some(first), Some(last)) =
            (found.after.rows.get(stretch.start), found.after.rows.get(stretch.end - 1))
        else {
            continue;
        };
        let record = story.records.get(first.record).map_or("", |record| record.name.as_str());
        for channel in channels(story) {
            let place = channel as usize;
            let (label, unit) = meaning(channel);
            let measured: Vec<(f64, f64)> =
                found.after.rows[stretch.clone()].iter().map(|row| (row.t, row.measured[place])).collect();
            let simulated = |rows: &[FitRow]| -> Vec<(f64, f64)> {
                let rows = rows.get(stretch.clone()).unwrap_or_default();
                rows.iter().map(|row| (row.t, row.simulated[place])).collect()
            };
            let (before, after) = (simulated(&found.before.rows), simulated(&found.after.rows));
            // A table far off must not press everything else flat.
            let Some(y) = range(measured.iter().chain(&after).map(|point| point.1)) else { continue };
            let plot = Plot::new(&format!("{name}: {label}"), unit, first.t..last.t, y)
                .height(200)
                .line("measured", Color::Truth, measured.into_iter())
                .line("the table's numbers", Color::Second, before.into_iter())
                .line("identified", Color::First, after.into_iter());
            page.plot(&format!("{name}, {record}: {label}"), &plot, "")?;
        }
    }
    Ok(())
}

/// Yaw rate, lateral acceleration and one that tells of the wheels.
fn channels(story: &Story<'_>) -> Vec<Output> {
    let has = |channel: &Output| story.found.noise.iter().any(|(there, _)| there == channel);
    let wheels = [Output::WheelFl, Output::WheelRl, Output::WheelFr, Output::WheelRr, Output::Speed];
    let mut channels = vec![Output::YawRate, Output::LateralAcceleration];
    channels.retain(has);
    channels.extend(wheels.into_iter().find(has));
    channels
}

fn meaning(channel: Output) -> (&'static str, &'static str) {
    match channel {
        Output::WheelFl => ("front left wheel", "rad/s"),
        Output::WheelFr => ("front right wheel", "rad/s"),
        Output::WheelRl => ("rear left wheel", "rad/s"),
        Output::WheelRr => ("rear right wheel", "rad/s"),
        Output::YawRate => ("yaw rate", "rad/s"),
        Output::LateralAcceleration => ("lateral acceleration", "m/s²"),
        Output::LongitudinalAcceleration => ("longitudinal acceleration", "m/s²"),
        Output::Speed => ("speed", "m/s"),
    }
}

/// Free runs without restart, by how far they are off in units of the noise: the worst one, and the middle one.
fn worst_and_typical(story: &Story<'_>) -> Option<(Range<usize>, Range<usize>)> {
    let rows = &story.found.after.rows;
    let mut stretches = stretches(rows);
    let length = |stretch: &Range<usize>| rows[stretch.end - 1].t - rows[stretch.start].t;
    if stretches.iter().any(|stretch| length(stretch) >= SHORTEST_S) {
        stretches.retain(|stretch| length(stretch) >= SHORTEST_S);
    }
    let shown = channels(story);
    let miss = |stretch: &Range<usize>| {
        let off = rows[stretch.clone()].iter().flat_map(|row| {
            story.found.noise.iter().filter(|(channel, _)| shown.contains(channel)).map(|(channel, noise)| {
                let off = (row.measured[*channel as usize] - row.simulated[*channel as usize]) / noise;
                if off.is_finite() { off * off } else { 0.0 }
            })
        });
        off.sum::<f64>() / stretch.len() as f64
    };
    let mut by_miss: Vec<(f64, Range<usize>)> =
        stretches.into_iter().map(|stretch| (miss(&stretch), stretch)).collect();
    by_miss.sort_by(|a, b| a.0.total_cmp(&b.0));
    let worst = by_miss.last()?.1.clone();
    let typical = by_miss.get((by_miss.len() - 1) / 2)?.1.clone();
    Some((worst, typical))
}

/// Rows that follow each other without a gap, at most a block long.
fn stretches(rows: &[FitRow]) -> Vec<Range<usize>> {
    let period = rows.windows(2).map(|pair| pair[1].t - pair[0].t).find(|step| *step > 0.0).unwrap_or(0.01);
    let mut stretches = Vec::new();
    let mut start = 0;
    for place in 1..=rows.len() {
        let goes_on = rows.get(place).is_some_and(|row| {
            let before = &rows[place - 1];
            let step = row.t - before.t;
            row.record == before.record
                && step > 0.0
                && step < 1.5 * period
                && row.t - rows[start].t < 1.5 * crate::identify::BLOCK_S
        });
        if !goes_on {
            stretches.push(start..place);
            start = place;
        }
    }
    stretches.retain(|stretch| stretch.len() > 2);
    stretches
}

/// From the lowest to the highest, and a little more.
pub fn range(values: impl Iterator<Item = f64>) -> Option<Range<f64>> {
    let (low, high) = values
        .filter(|value| value.is_finite())
        .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), value| (low.min(value), high.max(value)));
    let margin = (0.08 * (high - low)).max(1e-6 + 1e-3 * high.abs());
    (low <= high).then_some(low - margin..high + margin)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn gaps_and_other_recordings_end_a_stretch() {
        let row = |record: usize, t: f64| FitRow { record, t, measured: [0.0; 8], simulated: [0.0; 8] };
        let mut rows: Vec<FitRow> = (0..10).map(|i| row(0, f64::from(i) * 0.1)).collect();
        rows.extend((20..30).map(|i| row(0, f64::from(i) * 0.1)));
        rows.extend((30..40).map(|i| row(1, f64::from(i) * 0.1)));
        assert_eq!(stretches(&rows), [0..10, 10..20, 20..30]);
        assert!(stretches(&[]).is_empty());
    }

    #[test]
    fn a_range_has_some_width_and_nothing_has_none() {
        assert_eq!(range(std::iter::empty()), None);
        let same = range([2.0, 2.0].into_iter()).unwrap();
        assert!(same.start < 2.0 && same.end > 2.0);
    }
}
