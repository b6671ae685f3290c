//! What healthy drives of the same car say of a candidate: a car's numbers differ a little from drive to drive, because its
//! equations are simpler than it is. What the references have as well, or what is within what they differ by, has not
//! changed.

use std::collections::BTreeSet;

use rayon::prelude::*;

use super::super::numbers::Scope;
use super::Search;
use super::climb::State;
use super::refit::Refitted;
use super::scan::Scored;
use super::trial::Trial;

/// A candidate as a reference has it, to first order.
#[derive(Clone, Debug)]
pub struct Healthy {
    /// The name of the candidate.
    name: String,
    /// The coordinate of its clearest main number.
    coordinate: f64,
    /// By how much −2 ln likelihood falls with it.
    gain: f64,
}

/// Before references are seen, a number is thought to differ from drive to drive by this share of what it could be, and
/// that counts as much as so many of them. Tuned: `references` (campaign).
const SPREAD: f64 = 0.1;
const WORTH: f64 = 6.0;

/// A number must be so many deviations of that, and of its own, from the references'. Statistical: one in a thousand of
/// Student's distribution with eight degrees of freedom, for each of some tens of candidates.
const LEAST_DISTANCE: f64 = 5.0;

impl Search<'_> {
    /// What each reference says of these candidates.
    pub(super) fn healthy(
        &self,
        state: &State<'_>,
        trials: &[Trial],
        names: &BTreeSet<String>,
        seed: u64,
    ) -> Vec<Healthy> {
        let of = |reference: usize| -> Vec<Healthy> {
            let there = trials.iter().filter(|trial| names.contains(&trial.name()));
            let own: Vec<Trial> = there.map(|trial| trial.within(Scope::Recording(reference))).collect();
            let (scored, _) = self.scan(state, &own, seed);
            scored.into_iter().filter_map(Healthy::of).collect()
        };
        (0..self.references).into_par_iter().flat_map_iter(of).collect()
    }
}

impl Healthy {
    fn of(scored: Scored) -> Option<Self> {
        let (_, coordinate) = *scored.numbers.first()?;
        Some(Self { name: scored.trial.name(), coordinate, gain: scored.gain })
    }
}

impl Refitted<'_> {
    /// Is it beyond what these references have and differ by?
    pub fn is_beyond(&self, references: &[Healthy]) -> bool {
        self.distance(references).is_none_or(|distance| distance > LEAST_DISTANCE)
    }

    /// How far its clearest main number is from what the references have, in deviations; none where it is not always there.
    pub fn distance(&self, references: &[Healthy]) -> Option<f64> {
        if !self.trial.is_always_there() {
            return None;
        }
        let own = self.clearest_main();
        let name = self.trial.name();
        let there: Vec<&Healthy> = references.iter().filter(|healthy| healthy.name == name).collect();
        let count = there.len() as f64;
        let neutral = self.thought_of_clearest().0;
        let values = || there.iter().map(|healthy| healthy.coordinate);
        let mean = if there.is_empty() { neutral } else { values().sum::<f64>() / count };
        let square: f64 = values().map(|value| (value - mean).powi(2)).sum();
        let thought = (SPREAD * self.thought_of_clearest().1).powi(2);
        let spread = (WORTH * thought + square) / (WORTH + (count - 1.0).max(0.0));
        let variance = own.std.powi(2) + spread * (1.0 + 1.0 / count.max(1.0));
        Some((own.value - mean).abs() / variance.sqrt())
    }

    /// Its evidence beyond the most that a reference has of the same at any time; of what is always there the distance says
    /// more.
    pub fn evidence_beyond(&self, references: &[Healthy]) -> f64 {
        if self.trial.is_always_there() {
            return self.evidence;
        }
        let name = self.trial.name();
        let same = references.iter().filter(|healthy| healthy.name == name);
        self.evidence - same.map(|healthy| healthy.gain).fold(0.0, f64::max)
    }
}
