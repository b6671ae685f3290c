//! Which stretch of which channel shows best what the answer is about.

use crate::explain::{Explanation, Trace, Verdict};

/// A longer stretch shows no detail, s.
const LONGEST_S: f64 = 25.0;
/// Bins in which the best part of a long block is looked for, s.
const BIN_S: f64 = 1.0;

/// A stretch of one channel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stretch<'a> {
    /// The channel.
    pub trace: &'a Trace,
    /// From, to, s.
    pub t: [f64; 2],
    /// Was it held out?
    pub is_holdout: bool,
}

/// What is looked for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Aim {
    /// Where the extended model is better than the plain one.
    Gain,
    /// Where the plain model is furthest off.
    Miss,
}

/// The stretch for the first screen.
pub fn first<'a>(explanation: &'a Explanation) -> Option<Stretch<'a>> {
    let gains = gains(explanation);
    let is_better = gains.first().is_some_and(|gain| gain.points() > 0.0);
    let (aim, names): (Aim, Vec<&str>) = match explanation.verdict {
        Verdict::MissingPhysics | Verdict::UnknownPhysics if is_better => {
            (Aim::Gain, gains.iter().map(|gain| gain.channel).collect())
        }
        _ => (Aim::Miss, worst(explanation)),
    };
    names.into_iter().find_map(|name| {
        let traces = explanation.traces.iter().filter(|trace| trace.channel == name);
        best(traces.flat_map(|trace| stretches(explanation, trace, aim)))
    })
}

/// The held-out stretch of this channel of one recording that gains most.
pub fn of_trace<'a>(explanation: &'a Explanation, trace: &'a Trace) -> Option<Stretch<'a>> {
    best(stretches(explanation, trace, Aim::Gain))
}

/// Held-out before fitted, then the largest.
fn best<'a>(stretches: impl IntoIterator<Item = (f64, Stretch<'a>)>) -> Option<Stretch<'a>> {
    let all = stretches
        .into_iter()
        .max_by(|(a, one), (b, other)| one.is_holdout.cmp(&other.is_holdout).then(a.total_cmp(b)));
    all.map(|(_, stretch)| stretch)
}

/// The best stretch of each block of the trace's recording, with how much of the aim it has.
fn stretches<'a>(explanation: &Explanation, trace: &'a Trace, aim: Aim) -> Vec<(f64, Stretch<'a>)> {
    let blocks = explanation.split.iter().filter(|block| block.recording == trace.recording);
    let mut blocks: Vec<([f64; 2], bool)> = blocks.map(|block| (block.t, block.is_holdout)).collect();
    if let (true, Some(&first), Some(&last)) = (blocks.is_empty(), trace.t.first(), trace.t.last()) {
        blocks.push(([first, last], false));
    }
    let within = |(t, is_holdout)| {
        let (amount, t) = most(trace, t, aim)?;
        Some((amount, Stretch { trace, t, is_holdout }))
    };
    blocks.into_iter().filter_map(within).collect()
}

/// The part of a block with most of the aim, no longer than can be looked at.
fn most(trace: &Trace, [from, to]: [f64; 2], aim: Aim) -> Option<(f64, [f64; 2])> {
    let start = trace.t.partition_point(|t| *t < from);
    let end = trace.t.partition_point(|t| *t <= to);
    let (from, to) = (*trace.t.get(start)?, *trace.t.get(end.checked_sub(1)?)?);
    if to <= from {
        return None;
    }
    let mut bins = vec![0.0; ((to - from) / BIN_S) as usize + 1];
    for place in start..end {
        let bin = trace.t.get(place).and_then(|t| bins.get_mut(((t - from) / BIN_S) as usize));
        let Some(bin) = bin else { continue };
        let off = |series: &[f64]| {
            let off = series.get(place)? - trace.measured.get(place)?;
            off.is_finite().then_some(off * off)
        };
        let (Some(baseline), extended) = (off(&trace.baseline), off(&trace.extended)) else { continue };
        *bin += match aim {
            Aim::Gain => extended.map_or(0.0, |extended| baseline - extended),
            Aim::Miss => baseline,
        };
    }
    let count = ((LONGEST_S / BIN_S) as usize).min(bins.len());
    let best = bins
        .windows(count)
        .map(|window| window.iter().sum::<f64>())
        .enumerate()
        .max_by(|a, b| a.1.total_cmp(&b.1))?;
    let from = from + BIN_S * best.0 as f64;
    Some((best.1, [from, to.min(from + BIN_S * count as f64)]))
}

/// How the held-out fit of a channel changes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Gain<'a> {
    /// The channel.
    pub channel: &'a str,
    /// Of the plain model, %.
    pub from: f64,
    /// Of the extended one, %.
    pub to: f64,
    /// 95 % interval of the difference, percentage points.
    pub interval: Option<[f64; 2]>,
}

impl Gain<'_> {
    /// Percentage points.
    pub fn points(&self) -> f64 {
        self.to - self.from
    }

    /// Is it above zero with the whole interval?
    pub fn is_certain(&self) -> bool {
        self.interval.is_none_or(|[low, _]| low > 0.0)
    }

    /// A fit below zero is no fit: what happens there counts for nothing.
    fn visible(&self) -> f64 {
        self.to.max(0.0) - self.from.max(0.0)
    }
}

/// Of all channels, the largest certain one first.
pub fn gains(explanation: &Explanation) -> Vec<Gain<'_>> {
    let fit = &explanation.fit;
    let mut gains: Vec<Gain<'_>> = fit
        .extended
        .holdout
        .iter()
        .filter_map(|(channel, to)| {
            let from = *fit.baseline.holdout.get(channel)?;
            let interval = explanation.improvement_ci95.get(channel).copied();
            let interval = interval.filter(|it| it.iter().all(|end| end.is_finite()));
            (from.is_finite() && to.is_finite()).then_some(Gain { channel, from, to: *to, interval })
        })
        .collect();
    gains.sort_by(|a, b| {
        let certain = b.is_certain().cmp(&a.is_certain());
        certain.then(b.visible().total_cmp(&a.visible())).then(b.points().total_cmp(&a.points()))
    });
    gains
}

/// Channels in the order in which the plain model leaves something of them unexplained; those of which
/// the mismatch is, first.
fn worst(explanation: &Explanation) -> Vec<&str> {
    let mut names: Vec<&str> = Vec::new();
    for trace in &explanation.traces {
        if !names.contains(&trace.channel.as_str()) {
            names.push(&trace.channel);
        }
    }
    let left = |name: &str| explanation.unexplained.get(name).copied().unwrap_or(f64::NEG_INFINITY);
    let place = |name: &str| explanation.place.channels.iter().position(|channel| channel == name);
    let rank = |name: &str| place(name).unwrap_or(usize::MAX);
    names.sort_by(|a, b| rank(a).cmp(&rank(b)).then(left(b).total_cmp(&left(a))));
    names
}

#[cfg(test)]
mod tests {
    use super::super::sample;
    use super::*;

    #[test]
    fn the_first_plot_is_of_the_channel_and_block_that_gain_most() {
        let mut explanation = sample::missing();
        let stretch = first(&explanation).unwrap();
        assert_eq!(stretch.trace.channel, "lateral_acceleration");
        assert!(stretch.is_holdout);
        assert!(stretch.t[1] - stretch.t[0] <= LONGEST_S);
        let gain = gains(&explanation)[0];
        assert_eq!(gain.channel, "lateral_acceleration");
        assert!(gain.is_certain() && gain.points() > 5.0);
        // Where its improvement is not certain, another channel comes first.
        explanation.improvement_ci95.insert("lateral_acceleration".into(), [-3.0, 20.0]);
        assert_eq!(first(&explanation).unwrap().trace.channel, "yaw_rate");
    }

    #[test]
    fn of_a_long_block_the_part_that_gains_most_is_shown() {
        let count = 6000;
        let t: Vec<f64> = (0..count).map(|i| f64::from(i) * 0.1).collect();
        let off = |t: &f64| if (400.0..410.0).contains(t) { 1.0 } else { 0.01 };
        let trace = Trace {
            baseline: t.iter().map(off).collect(),
            measured: vec![0.0; t.len()],
            extended: vec![0.0; t.len()],
            t,
            ..Trace::default()
        };
        let (amount, [from, to]) = most(&trace, [0.0, 600.0], Aim::Gain).unwrap();
        assert!(from <= 400.0 && to >= 410.0 && to - from <= LONGEST_S, "{from} to {to}");
        assert!((amount - 100.0).abs() < 1.0, "{amount}");
        assert_eq!(most(&trace, [700.0, 800.0], Aim::Gain), None);
        assert_eq!(most(&Trace::default(), [0.0, 10.0], Aim::Miss), None);
    }

    #[test]
    fn without_a_split_and_without_traces_nothing_breaks() {
        let mut explanation = sample::missing();
        explanation.split.clear();
        assert!(!first(&explanation).unwrap().is_holdout);
        explanation.traces.clear();
        assert_eq!(first(&explanation), None);
    }
}
