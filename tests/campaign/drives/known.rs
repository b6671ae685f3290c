//! How much of what can be known of the friction the service knows.

use std::fmt;

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::StandardNormal;

use super::drive::Drive;
use super::ideal::Ideal;
use super::judge::{BOUNDED, CLASSES, class, class_name, counts, share};

/// The ideal observer looks at every so many samples: 20 times a second.
const EVERY: usize = 5;

/// Of one class of use, samples: all; whose friction each bounds, and both; whose truth the ideal interval holds.
#[derive(Clone, Copy, Debug, Default)]
struct Use {
    samples: u64,
    ideal: u64,
    service: u64,
    both: u64,
    covered: u64,
}

/// Of drives, by use.
#[derive(Clone, Debug, Default)]
pub struct Known([Use; CLASSES]);

/// Drives.
pub fn of(drive: &Drive) -> Known {
    let mut known = Known::default();
    let mut ideal = Ideal::new(&drive.config.vehicle, drive.load_sensitivity);
    let mut random = ChaCha8Rng::seed_from_u64(drive.seed);
    let mut number = 0;
    drive.through_the_engine(|_, truth, estimates| {
        number += 1;
        if number % EVERY != 0 {
            return;
        }
        let now = truth.time.seconds();
        let is_changing = |from: f64, over: f64| (from..from + over + 0.05).contains(&now);
        if drive.scenario.road.iter().any(|road| is_changing(road.from_s, road.transition_s)) {
            return ideal.change();
        }
        if !counts(truth) {
            return;
        }
        let noise = [0, 1].map(|_| [0, 1].map(|_| random.sample::<f64, _>(StandardNormal)));
        ideal.look(truth, noise);
        let [low, high] = ideal.interval(truth);
        let row = &mut known.0[class(truth)];
        let by_ideal = high < BOUNDED;
        let by_service = estimates.friction.high.is_some_and(|high| high < BOUNDED);
        row.samples += 1;
        row.ideal += u64::from(by_ideal);
        row.service += u64::from(by_service);
        row.both += u64::from(by_ideal && by_service);
        row.covered += u64::from((low..=high).contains(&truth.mu_max));
    });
    known
}

impl Known {
    pub const HEADER: &str = "use of friction | bounded by an ideal observer | its interval holds the truth | bounded \
                              by gripd | of what the ideal observer bounds, gripd does";

    pub fn and(mut self, other: Self) -> Self {
        for (mine, other) in self.0.iter_mut().zip(other.0) {
            mine.samples += other.samples;
            mine.ideal += other.ideal;
            mine.service += other.service;
            mine.both += other.both;
            mine.covered += other.covered;
        }
        self
    }

    fn sum(&self, of: impl Fn(&Use) -> u64) -> u64 {
        self.0.iter().map(of).sum()
    }

    /// Share of the samples whose truth the ideal interval holds.
    pub fn covered(&self) -> f64 {
        self.sum(|row| row.covered) as f64 / self.sum(|row| row.samples).max(1) as f64
    }

    pub fn by_the_ideal(&self) -> u64 {
        self.sum(|row| row.ideal)
    }

    pub fn by_the_service(&self) -> u64 {
        self.sum(|row| row.service)
    }

    /// By use, rows of a table.
    pub fn rows(&self) -> Vec<String> {
        let row = |(place, row): (usize, &Use)| {
            format!(
                "{} | {:.1} % | {:.1} % | {:.1} % | {:.0} %",
                class_name(place),
                share(row.ideal, row.samples),
                share(row.covered, row.samples),
                share(row.service, row.samples),
                share(row.both, row.ideal)
            )
        };
        self.0.iter().enumerate().map(row).collect()
    }
}

impl fmt::Display for Known {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "| {} |\n|---|---|---|---|---|", Self::HEADER)?;
        self.rows().iter().try_for_each(|row| writeln!(f, "| {row} |"))
    }
}
