//! How well each peer knows the friction, where much of it is used.

use super::judge::{counts, share};
use super::peers::{Driven, Row};

/// Use of friction from which on samples count, for each of the two tables.
pub const USES: [f64; 2] = [0.5, 0.9];

/// What a peer says: a value, and the ends of its 95 % interval, or of ±2 std.
#[derive(Clone, Copy, Debug, Default)]
pub struct Said {
    value: Option<f64>,
    interval: Option<[f64; 2]>,
}

/// A name in the table, and how it speaks.
pub type Peer = (&'static str, fn(&Row) -> Said);

/// The peers, in the order of the table.
pub const PEERS: [Peer; 6] = [
    ("gripd, value", |row| ours(row, row.ours.friction.max.is_some())),
    ("gripd, where valid", |row| ours(row, row.ours.friction.valid)),
    ("gripd, interval, bounds from below too", |row| Said { value: None, interval: Some(bounds(row)) }),
    ("thesis 8.1, brush", |row| brush(row.thesis.friction.brush, row.thesis.friction.brush_std)),
    ("the brush as gripd compensates it", |row| brush(row.ours.friction.brush, row.ours.friction.brush_std)),
    ("thesis 8.2, Dahl", |row| Said { value: row.ours.thesis.friction_dahl, interval: None }),
];

fn bounds(row: &Row) -> [f64; 2] {
    [row.ours.friction.low.unwrap_or(0.0), row.ours.friction.high.unwrap_or(f64::INFINITY)]
}

fn ours(row: &Row, counts: bool) -> Said {
    if !counts {
        return Said::default();
    }
    Said { value: row.ours.friction.max, interval: Some(bounds(row)) }
}

fn brush(value: Option<f64>, std: Option<f64>) -> Said {
    let interval = value.zip(std).map(|(value, std)| [value - 2.0 * std, value + 2.0 * std]);
    Said { value, interval }
}

/// What one peer achieved at one use of friction.
#[derive(Clone, Copy, Debug, Default)]
pub struct Score {
    samples: u64,
    with_value: u64,
    square: f64,
    intervals: u64,
    held: u64,
}

/// How all of [`PEERS`] do on a drive, at each of [`USES`].
pub fn scores(drive: &Driven) -> [[Score; PEERS.len()]; USES.len()] {
    let mut scores = [[Score::default(); PEERS.len()]; USES.len()];
    for row in &drive.rows {
        let truth = &row.truth;
        if !counts(truth) {
            continue;
        }
        for (from, scores) in USES.iter().zip(&mut scores) {
            if truth.mu_used < from * truth.mu_max {
                continue;
            }
            for ((_, of), score) in PEERS.iter().zip(scores) {
                score.add(of(row), truth.mu_max);
            }
        }
    }
    scores
}

impl Score {
    fn add(&mut self, said: Said, truth: f64) {
        self.samples += 1;
        if let Some(value) = said.value {
            self.with_value += 1;
            self.square += (value - truth).powi(2);
        }
        if let Some([low, high]) = said.interval {
            self.intervals += 1;
            self.held += u64::from((low..=high).contains(&truth));
        }
    }

    pub fn and(self, other: Self) -> Self {
        Self {
            samples: self.samples + other.samples,
            with_value: self.with_value + other.with_value,
            square: self.square + other.square,
            intervals: self.intervals + other.intervals,
            held: self.held + other.held,
        }
    }

    /// The table's head, for the samples that [`Self::line`] counted.
    pub fn header(&self, from: f64) -> String {
        format!(
            "| friction, {:.0} % of it used or more: {} samples | has a value | rms error | truth in the interval, \
             or within ±2 std |\n|---|---|---|---|",
            100.0 * from,
            self.samples
        )
    }

    /// Its line of the table.
    pub fn line(&self, name: &str) -> String {
        let or_none = |is_some: bool, text: String| if is_some { text } else { "–".to_owned() };
        let rms = (self.square / self.with_value.max(1) as f64).sqrt();
        format!(
            "| {name} | {} | {} | {} |",
            or_none(self.with_value > 0, format!("{:.1} %", share(self.with_value, self.samples))),
            or_none(self.with_value > 0, format!("{rms:.3}")),
            or_none(self.intervals > 0, format!("{:.1} %", share(self.held, self.intervals)))
        )
    }
}
