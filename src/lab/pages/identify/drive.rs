//! Measured beside simulated, with the table's numbers and with the identified ones.

use std::ops::Range;

use super::Story;
use crate::pages::beside::{Axis, Beside, Channel, Drive, Model, Said};
use crate::report::Color;
use crate::report::interactive::Mark;
use identify::{FitRow, Output, Record};

/// Shorter stretches show little, s.
const SHORTEST_S: f64 = 5.0;

/// All of it.
pub fn beside(story: &Story<'_>) -> Beside {
    let models = vec![
        Model { name: "the table's numbers", color: Color::Second },
        Model { name: "identified", color: Color::First },
    ];
    let found = story.found;
    let fitted = [&found.before, &found.after].map(|fits| fits.rows.as_slice());
    let held_out = story.predicted.each_ref().map(|fits| fits.rows.as_slice());
    let measured: Vec<Output> = found.noise.iter().map(|(channel, _)| *channel).collect();
    let drive = |(place, record): (usize, &Record), both: [&[FitRow]; 2], is_held_out: bool| {
        let both = both.map(|rows| rows.iter().filter(|row| row.record == place).collect::<Vec<_>>());
        let channel = |channel: &Output| Channel {
            name: channel.name().into(),
            unit: channel.unit().into(),
            said: both.iter().map(|rows| said(rows, *channel)).collect(),
        };
        let ends = record.rows.first().zip(record.rows.last()).filter(|_| is_held_out);
        Drive {
            name: record.name.clone(),
            begins_utc: record.clock.utc(0.0),
            channels: measured.iter().map(channel).collect(),
            driven: record.rows.iter().map(|row| [row.t, row.speed(story.vehicle), row.steering]).collect(),
            held_out: ends.map(|(first, last)| [first.t, last.t]).into_iter().collect(),
            yaw_rate_offset: found.value("yaw_rate_offset").unwrap_or(0.0),
        }
    };
    let records = story.records.iter().enumerate().map(|record| drive(record, fitted, false));
    let held = story.held_out.iter().enumerate().map(|record| drive(record, held_out, true));
    let drives = records.chain(held).collect();
    let (error_is, rows) = match story.held_out {
        [] => ("error of the free run", fitted),
        _ => ("held-out error", held_out),
    };
    let mut beside = Beside { models, drives, error_is, ..Beside::default() };
    for channel in measured {
        let errors = rows.map(|rows| root_mean_square(rows, channel));
        beside.error.insert(channel.name().into(), errors.to_vec());
    }
    beside
}

fn said(rows: &[&FitRow], channel: Output) -> Said {
    let place = channel as usize;
    Said {
        t: rows.iter().map(|row| row.t).collect(),
        measured: rows.iter().map(|row| row.measured[place]).collect(),
        predicted: rows.iter().map(|row| row.simulated[place]).collect(),
    }
}

fn root_mean_square(rows: &[FitRow], channel: Output) -> f64 {
    let place = channel as usize;
    let off = rows.iter().map(|row| row.measured[place] - row.simulated[place]).filter(|it| it.is_finite());
    let (count, square) = off.fold((0.0, 0.0), |(count, sum), off| (count + 1.0, sum + off * off));
    f64::sqrt(square / count)
}

/// Where a typical stretch begins, and the one that fits worst.
pub fn marks(story: &Story<'_>, axis: &Axis) -> Vec<Mark> {
    let rows = &story.found.after.rows;
    let Some((worst, typical)) = worst_and_typical(story) else { return Vec::new() };
    let mut shown = vec![("A typical stretch", typical.start)];
    if worst != typical {
        shown.push(("The stretch that fits worst", worst.start));
    }
    let mark = |(name, row): (&str, usize)| {
        let row = rows.get(row)?;
        Some(Mark { at_s: axis.at(row.record, row.t), name: name.into() })
    };
    shown.into_iter().filter_map(mark).collect()
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
                && row.t - rows[start].t < 1.5 * identify::BLOCK_S
        });
        if !goes_on {
            stretches.push(start..place);
            start = place;
        }
    }
    stretches.retain(|stretch| stretch.len() > 2);
    stretches
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
}
