//! What else could be where a number is one that no such car or sensor has: a speed that reads 6 % too much, an accelerometer
//! that comes 0.1 s before its time, a steering that gives way as none does. The ordinary car has no other place for a gyroscope
//! that reads too much, for an accelerometer ahead of the centre of gravity, or for a steering ratio that changes; its numbers
//! take them.

use rayon::prelude::*;

use super::super::numbers::Free;
use super::Search;
use super::climb::{Climbed, Start, State, freedom};
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

/// Numbers that are further off than is usual, and what could be there in their place.
pub struct InPlace<'a> {
    /// The effects that they are, with their channels.
    numbers: Vec<String>,
    /// The car that has exactly what is usual in their place.
    usual: State<'a>,
    /// What was fitted beside that; by how much it is likelier than the numbers as they were found, 2 ln odds.
    fitted: Vec<(f64, Refitted<'a>)>,
}

impl<'a> Search<'_> {
    /// None where all numbers are usual ones.
    pub(super) fn in_place_of_unusual(
        &self,
        state: &State<'a>,
        trials: &[Trial],
        seed: u64,
    ) -> Option<InPlace<'a>> {
        let name = |told: &Told| full_name(told.kind.name, told.channel.map(|of| of.to_string()).as_deref());
        let (unusual, numbers): (Vec<usize>, Vec<String>) = (0..state.free.len())
            .filter_map(|place| {
                unusual(state, &state.free, &state.at, place).map(|told| (place, name(&told)))
            })
            .unzip();
        if unusual.is_empty() {
            return None;
        }
        let mut usual = state.clone();
        for place in &unusual {
            let free = &mut usual.free[*place];
            usual.at[*place] = free.prior.0;
            *free = free.held_at(free.prior.0);
        }
        usual.errors = self.errors(&usual.model, &usual.free, &usual.at);
        let Climbed { at, errors, cost, covariance, .. } =
            self.climb(&usual, &state.colour, &usual.model, &usual.free, usual.start());
        usual.slopes = self.slopes(&usual.model, &usual.free, &at, &errors);
        (usual.at, usual.errors, usual.cost, usual.covariance) = (at, errors, cost, covariance);
        let others: Vec<Trial> = trials
            .iter()
            .filter(|trial| trial.is_always_there() && !trial.has_time() && !numbers.contains(&trial.name()))
            .cloned()
            .collect();
        let (scored, _) = self.scan(&usual, &others, seed);
        let best: Vec<_> = scored.iter().take(MOST_FITTED).collect();
        let fitted = best
            .into_par_iter()
            .filter_map(|scored| self.released(state, &usual, self.refit(&usual, scored), &unusual));
        let mut fitted: Vec<_> = fitted.collect();
        fitted.sort_by(|a, b| b.0.total_cmp(&a.0));
        for (ahead, of) in &fitted {
            let name = of.trial.name();
            tracing::debug!(name, ahead, held_gain = of.held_gain, ?numbers, "in place of unusual numbers");
        }
        Some(InPlace { numbers, usual, fitted })
    }

    /// What was fitted beside what is usual, with the numbers free again; and by how much it is likelier than those as they were
    /// found, 2 ln odds. None where it leaves them unusual.
    fn released(
        &self,
        state: &State<'a>,
        usual: &State<'a>,
        held: Refitted<'a>,
        places: &[usize],
    ) -> Option<(f64, Refitted<'a>)> {
        let count = state.free.len();
        let mut free = held.free.clone();
        free[..count].copy_from_slice(&state.free);
        let mut slopes = self.slopes(&held.model, &free, &held.at, &held.errors);
        slopes.truncate(count);
        let there = State { slopes, ..usual.clone() };
        let colour = self.colour(&held.errors);
        let from = Start { at: held.at.clone(), errors: held.errors.clone(), ..Start::default() };
        let Climbed { at, errors, cost, covariance, .. } =
            self.climb(&there, &colour, &held.model, &free, from);
        if places.iter().any(|place| unusual(state, &free, &at, *place).is_some()) {
            return None;
        }
        let own = || count..free.len();
        let (narrower, was) =
            (freedom(&free, &covariance, own()), freedom(&held.free, &held.covariance, own()));
        let evidence = held.evidence + held.cost - cost + was - narrower;
        // The numbers, too, may have found a better place on the way.
        let from = self.start_at(&state.model, &state.free, at[..count].to_vec());
        let alone = self.climb(state, &state.colour, &state.model, &state.free, from);
        let ahead = state.cost.min(alone.cost) - cost - narrower - self.price_of_trying(&held.trial.name());
        Some((ahead, Refitted { free, at, errors, cost, covariance, evidence, ..held }))
    }
}

/// What this number of the car or of a sensor is, if it is further off than is usual.
fn unusual(state: &State<'_>, free: &[Free], at: &[f64], place: usize) -> Option<Told> {
    Told::of(state, &free[place]).filter(|told| told.off_usual(&free[place], at[place]).abs() > ASKED)
}

impl<'a> InPlace<'a> {
    /// What is clearly likelier than such numbers.
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
