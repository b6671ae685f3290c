//! What else could be where a sensor's number is one that no such sensor has: a speed that reads 6 % too much, an accelerometer
//! that comes 0.1 s before its time. The ordinary car has no other place for a gyroscope that reads too much, or for an
//! accelerometer ahead of the centre of gravity; its numbers take them.

use rayon::prelude::*;

use super::super::numbers::Free;
use super::Search;
use super::climb::{Climbed, State, freedom};
use super::refit::Refitted;
use super::round::{LEAST_CLEAR, LEAST_HELD_GAIN};
use super::told::Told;
use super::trial::Trial;
use crate::explain::finding::TOLD_APART;
use crate::explain::result::{Finding, full_name};
use crate::explain::select::LEAST_EVIDENCE;

/// So many deviations from what is usual are asked about. Less than what is told as unusual: a yaw rate that reads 10 % too
/// much is a speed that reads 6 % too little, where 3 % are usual (`concealed_in_real_drives`).
const ASKED: f64 = 2.0;

/// So many are fitted in the numbers' place, the best to first order.
const MOST_FITTED: usize = 6;

/// Numbers of sensors that are further off than such sensors are, and what could be there in their place.
pub struct InPlace<'a> {
    /// The effects that they are, with their channels.
    numbers: Vec<String>,
    /// All numbers as they were free …
    free: Vec<Free>,
    /// … and the car whose sensors have what is usual.
    usual: State<'a>,
    /// What was fitted beside that; by how much it is likelier than the numbers as they were found, 2 ln odds.
    fitted: Vec<(f64, Refitted<'a>)>,
}

impl<'a> Search<'_> {
    /// None where all sensors are usual ones.
    pub(super) fn in_place_of_unusual(
        &self,
        state: &State<'a>,
        trials: &[Trial],
        seed: u64,
    ) -> Option<InPlace<'a>> {
        let name = |told: &Told| full_name(told.kind.name, told.channel.map(|of| of.to_string()).as_deref());
        let unusual: Vec<(usize, String)> = (0..state.free.len())
            .filter_map(|place| {
                let told = Told::of(state, &state.free[place]).filter(|told| told.channel.is_some())?;
                let (mean, std) = state.free[place].prior;
                ((state.at[place] - mean).abs() > ASKED * std).then(|| (place, name(&told)))
            })
            .collect();
        if unusual.is_empty() {
            return None;
        }
        let mut usual = state.clone();
        for (place, _) in &unusual {
            let free = &mut usual.free[*place];
            usual.at[*place] = free.prior.0;
            *free = free.held_at(free.prior.0);
        }
        usual.errors = self.errors(&usual.model, &usual.free, &usual.at);
        let Climbed { at, errors, cost, covariance } =
            self.climb(&usual, &state.colour, &usual.model, &usual.free, usual.at.clone());
        usual.slopes = self.slopes(&usual.model, &usual.free, &at, &errors);
        (usual.at, usual.errors, usual.cost, usual.covariance) = (at, errors, cost, covariance);
        let numbers: Vec<String> = unusual.iter().map(|(_, name)| name.clone()).collect();
        let others: Vec<Trial> = trials
            .iter()
            .filter(|trial| trial.is_always_there() && !trial.has_time() && !numbers.contains(&trial.name()))
            .cloned()
            .collect();
        let (scored, _) = self.scan(&usual, &others, seed);
        // What the numbers could be chosen from, and had not to be told.
        let places = unusual.iter().map(|(place, _)| *place);
        let by_numbers = usual.cost - state.cost - freedom(&state.free, &state.covariance, places);
        let best: Vec<_> = scored.iter().take(MOST_FITTED).collect();
        let fitted = best.into_par_iter().map(|scored| {
            let refitted = self.refit(&usual, scored);
            (refitted.evidence - by_numbers, refitted)
        });
        let mut fitted: Vec<_> = fitted.collect();
        fitted.sort_by(|a, b| b.0.total_cmp(&a.0));
        for (ahead, of) in &fitted {
            let name = of.trial.name();
            tracing::debug!(name, ahead, held_gain = of.held_gain, ?numbers, "in place of unusual sensors");
        }
        Some(InPlace { numbers, free: state.free.clone(), usual, fitted })
    }
}

impl<'a> InPlace<'a> {
    /// What is clearly likelier than such sensors.
    pub fn likelier(&self) -> Option<&Refitted<'a>> {
        let is_sure = |(ahead, of): &&(f64, Refitted<'a>)| {
            *ahead > TOLD_APART
                && of.evidence > LEAST_EVIDENCE
                && of.held_gain > LEAST_HELD_GAIN
                && of.clearest() > LEAST_CLEAR
                && !of.is_at_bound()
        };
        self.fitted.iter().find(is_sure).map(|(_, of)| of)
    }

    /// What is told of it.
    pub fn finding(&self, search: &Search<'_>, best: &Refitted<'a>) -> Finding {
        let all: Vec<_> = self.fitted.iter().map(|(_, of)| (of.trial.name(), of.evidence)).collect();
        search.finding(&self.usual, best, &all)
    }

    /// The same car with the sensors' numbers free again.
    pub fn released(&self, mut state: State<'a>) -> State<'a> {
        let count = self.free.len();
        state.free[..count].copy_from_slice(&self.free);
        state
    }

    /// Adds to what is told of the numbers what they cannot be told from.
    pub fn tell_alike(&self, findings: &mut [(Finding, bool)]) {
        let close = self
            .fitted
            .iter()
            .filter(|(ahead, of)| *ahead > -TOLD_APART && of.evidence > LEAST_EVIDENCE && !of.is_at_bound());
        let alike: Vec<String> = close.map(|(_, of)| of.trial.name()).collect();
        for (finding, _) in findings {
            if self.numbers.contains(&full_name(&finding.effect, finding.channel.as_deref())) {
                finding.indistinguishable_from.extend(alike.iter().cloned());
            }
        }
    }
}
