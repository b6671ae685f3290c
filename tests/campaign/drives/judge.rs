//! What the service says of a drive against what is true.

use std::fmt;

use gripd::Estimates;
use gripd::estimates::MuSource;
use gripd::model::Truth;

use super::cornering::{self, Cornering};
use super::drive::Drive;

/// After a change of surface an interval may be of the one before for so long, s of driving that uses
/// [`NOTICEABLE`] of the new friction.
const GRACE_S: f64 = 1.0;
const NOTICEABLE: f64 = 0.5;

/// A fall of friction has to be noticed within this, s of the same driving.
const NOTICED_S: f64 = 0.5;

/// An interval that excludes the truth by more than this is a lie.
const MOST_OFF: f64 = 0.1;

/// Rows over which one surface goes over into the next: a tenth of a second, and a little.
pub const TRANSITION: usize = 12;

/// Edges of the use of friction by which samples are sorted.
const EDGES: [f64; 4] = [0.2, 0.5, 0.8, 0.95];

/// Classes of use: those below and above each edge.
pub const CLASSES: usize = EDGES.len() + 1;

/// A friction is bounded from above below this: nearly every road gives less.
pub const BOUNDED: f64 = 1.15;

/// Samples of one range of use.
#[derive(Clone, Copy, Debug, Default)]
struct Use {
    samples: u64,
    /// With a bound from above, below [`BOUNDED`].
    bounded: u64,
    covered: u64,
    valid: u64,
    /// Valid and off by more than [`MOST_OFF`].
    valid_wrong: u64,
    /// Σ of the bounded intervals' widths.
    width: f64,
}

/// The worst interval of a drive.
#[derive(Clone, Debug)]
struct Lie {
    seed: u64,
    off: f64,
    at_s: f64,
    truth: f64,
    interval: [f64; 2],
    source: MuSource,
    about: String,
}

/// All that is counted.
#[derive(Clone, Debug, Default)]
pub struct Judgement {
    drives: u64,
    by_use: [Use; CLASSES],
    by_source: [(u64, u64); 7],
    /// Drives whose interval excluded the truth by more than [`MOST_OFF`] after the grace.
    lies: Vec<Lie>,
    /// Drops to less than half of the friction, and in how many seconds of noticeable driving the interval held it.
    drops: Vec<f64>,
    drops_unnoticed: u64,
    cornering: Cornering,
    /// Sideslip up to 6 m/s²: count and sum of squares, rad²; all, and those that are valid.
    sideslip: [(u64, f64); 2],
}

/// Is there anything to judge? Creeping and standing cars are not estimated.
pub fn counts(truth: &Truth) -> bool {
    truth.speed >= 4.0 && truth.mu_max.is_finite()
}

/// To which class of use a sample belongs.
pub fn class(truth: &Truth) -> usize {
    let used = truth.mu_used / truth.mu_max;
    EDGES.iter().take_while(|edge| used >= **edge).count()
}

/// The name of a class of use.
pub fn class_name(class: usize) -> String {
    format!("{:.0} % …", if class == 0 { 0.0 } else { 100.0 * EDGES[class - 1] })
}

/// Percent of all.
pub fn share(part: u64, all: u64) -> f64 {
    100.0 * part as f64 / all.max(1) as f64
}

/// Of a count and a sum of squares, rad²; degrees.
fn rms((count, squares): (u64, f64)) -> f64 {
    (squares / count.max(1) as f64).sqrt().to_degrees()
}

/// By how much an interval excludes a value.
fn excludes(estimates: &Estimates, truth: f64) -> f64 {
    let friction = &estimates.friction;
    let below = friction.low.map_or(0.0, |low| low - truth);
    let above = friction.high.map_or(0.0, |high| truth - high);
    below.max(above).max(0.0)
}

/// Drives, and judges.
pub fn judge(drive: &Drive) -> Judgement {
    let mut rows: Vec<(Truth, Estimates)> = Vec::new();
    drive.through_the_engine(|_, truth, estimates| rows.push((*truth, *estimates)));
    let mut sum = Judgement { drives: 1, ..Judgement::default() };
    let (mut drops, mut noticeable_s) = (false, f64::INFINITY);
    let mut waiting: Option<f64> = None;
    let mut worst: Option<Lie> = None;
    let mut cornering = cornering::Watch::default();
    for (place, (truth, estimates)) in rows.iter().enumerate() {
        if !counts(truth) {
            continue;
        }
        let used = truth.mu_used / truth.mu_max;
        // A change is one of more than a fifth.
        let change = truth.mu_max / rows[place.saturating_sub(TRANSITION)].0.mu_max;
        if (change - 1.0).abs() > 0.2 {
            noticeable_s = 0.0;
        }
        let dropped_before = std::mem::replace(&mut drops, change < 0.5);
        if drops && !dropped_before {
            sum.drops_unnoticed += u64::from(waiting.is_some());
            waiting = Some(0.0);
        }
        if used > NOTICEABLE {
            noticeable_s += 0.01;
            if let Some(waited) = &mut waiting {
                *waited += 0.01;
            }
        }
        let off = excludes(estimates, truth.mu_max);
        if let Some(waited) = waiting.filter(|_| off == 0.0 && used > NOTICEABLE) {
            sum.drops.push(waited);
            waiting = None;
        }
        sum.add(truth, estimates, off);
        cornering.step(truth, estimates);
        if noticeable_s > GRACE_S && off > worst.as_ref().map_or(MOST_OFF, |worst| worst.off) {
            let friction = &estimates.friction;
            worst = Some(Lie {
                seed: drive.seed,
                off,
                at_s: truth.time.seconds(),
                truth: truth.mu_max,
                interval: [friction.low.unwrap_or(0.0), friction.high.unwrap_or(f64::INFINITY)],
                source: friction.source,
                about: drive.about.clone(),
            });
        }
    }
    sum.drops_unnoticed += u64::from(waiting.is_some_and(|waited| waited > GRACE_S));
    sum.lies.extend(worst);
    sum.cornering = cornering.finish();
    sum
}

impl Judgement {
    fn add(&mut self, truth: &Truth, estimates: &Estimates, off: f64) {
        let friction = &estimates.friction;
        let row = &mut self.by_use[class(truth)];
        row.samples += 1;
        row.covered += u64::from(off == 0.0);
        if let Some(high) = friction.high.filter(|high| *high < BOUNDED) {
            row.bounded += 1;
            row.width += high - friction.low.unwrap_or(0.0);
        }
        if friction.valid {
            row.valid += 1;
            let is_wrong = friction.max.is_none_or(|max| (max - truth.mu_max).abs() > MOST_OFF);
            row.valid_wrong += u64::from(is_wrong);
        }
        let (all, covered) = &mut self.by_source[friction.source as usize];
        *all += 1;
        *covered += u64::from(off == 0.0);
        if let Some(sideslip) = estimates.motion.sideslip.filter(|_| truth.lateral_acceleration.abs() < 6.0) {
            let counted = if estimates.motion.valid { 2 } else { 1 };
            for (count, squares) in &mut self.sideslip[..counted] {
                *count += 1;
                *squares += (sideslip - truth.sideslip).powi(2);
            }
        }
    }

    /// Both together.
    pub fn and(mut self, other: Self) -> Self {
        self.drives += other.drives;
        for (mine, other) in self.by_use.iter_mut().zip(other.by_use) {
            mine.samples += other.samples;
            mine.bounded += other.bounded;
            mine.covered += other.covered;
            mine.valid += other.valid;
            mine.valid_wrong += other.valid_wrong;
            mine.width += other.width;
        }
        for (mine, other) in self.by_source.iter_mut().zip(other.by_source) {
            mine.0 += other.0;
            mine.1 += other.1;
        }
        self.lies.extend(other.lies);
        self.drops.extend(other.drops);
        self.drops_unnoticed += other.drops_unnoticed;
        self.cornering = self.cornering.and(other.cornering);
        for (mine, other) in self.sideslip.iter_mut().zip(other.sideslip) {
            *mine = (mine.0 + other.0, mine.1 + other.1);
        }
        self
    }

    pub fn samples(&self) -> u64 {
        self.by_use.iter().map(|row| row.samples).sum()
    }

    /// Share of the samples whose interval holds the truth.
    pub fn covered(&self) -> f64 {
        self.by_use.iter().map(|row| row.covered).sum::<u64>() as f64 / self.samples().max(1) as f64
    }

    /// By the use of friction, rows of a table.
    pub fn rows(&self) -> Vec<String> {
        let row = |(i, row): (usize, &Use)| {
            format!(
                "{} | {} | {:.2} % | {:.1} % | {:.2} | {:.2} % | {}",
                class_name(i),
                row.samples,
                share(row.covered, row.samples),
                share(row.bounded, row.samples),
                row.width / row.bounded.max(1) as f64,
                share(row.valid, row.samples),
                row.valid_wrong
            )
        };
        self.by_use.iter().enumerate().map(row).collect()
    }

    /// Of all drives, a row of a table.
    pub fn of_drives(&self) -> String {
        let all = self.drops.len() as u64 + self.drops_unnoticed;
        let noticed = |within_s: f64| share(self.noticed(within_s), all);
        let [_, sideslip] = self.sideslip.map(rms);
        format!(
            "{} | {} | {all} | {:.0} % | {:.0} % | {sideslip:.3}°",
            self.drives,
            self.lies.len(),
            noticed(NOTICED_S),
            noticed(GRACE_S)
        )
    }

    /// Of the cornering stiffness, a row of a table.
    pub fn of_stiffness(&self) -> String {
        self.cornering.row()
    }

    /// Falls that were noticed within so many seconds.
    fn noticed(&self, within_s: f64) -> u64 {
        self.drops.iter().filter(|waited| **waited <= within_s).count() as u64
    }

    /// Samples beyond the last edge of use.
    pub fn at_the_limit(&self) -> u64 {
        self.by_use[CLASSES - 1].samples
    }
}

impl fmt::Display for Judgement {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(
            f,
            "{} drives, {} samples, truth in the interval {:.2} %",
            self.drives,
            self.samples(),
            100.0 * self.covered()
        )?;
        writeln!(
            f,
            "| use of friction | samples | truth in the interval | bounded, below 1.15 | mean width | valid | valid and off by > 0.1 |"
        )?;
        writeln!(f, "|---|---|---|---|---|---|---|")?;
        for row in self.rows() {
            writeln!(f, "| {row} |")?;
        }
        use MuSource::{Abs, Brush, Joint, Limit, LowerBound, None, SlopeMap};
        for source in [None, LowerBound, SlopeMap, Brush, Joint, Abs, Limit] {
            let (all, covered) = self.by_source[source as usize];
            writeln!(
                f,
                "{}: {all} samples, truth in the interval {:.2} %",
                source.name(),
                share(covered, all)
            )?;
        }
        writeln!(f, "intervals that exclude the truth by more than {MOST_OFF}: {} drives", self.lies.len())?;
        for Lie { seed, off, at_s, truth, interval: [low, high], source, about } in &self.lies {
            let source = source.name();
            writeln!(
                f,
                "  {seed}: by {off:.2} at {at_s:.1} s: {low:.2} to {high:.2} ({source}), truly {truth:.2} ({about})"
            )?;
        }
        let mut drops = self.drops.clone();
        drops.sort_by(f64::total_cmp);
        writeln!(
            f,
            "drops to less than half: {} seen, {} within {NOTICED_S} and {} within {GRACE_S} s of driving at {NOTICEABLE} of the new friction (most {:.2} s), {} not",
            drops.len(),
            self.noticed(NOTICED_S),
            self.noticed(GRACE_S),
            drops.last().copied().unwrap_or(0.0),
            self.drops_unnoticed
        )?;
        writeln!(f, "| {} |\n| {} |", Cornering::HEADER, self.cornering.row())?;
        let [all, valid] = self.sideslip;
        write!(
            f,
            "sideslip up to 6 m/s²: {:.3}° rms; where valid ({:.1} %) {:.3}°",
            rms(all),
            share(valid.0, all.0),
            rms(valid)
        )
    }
}
