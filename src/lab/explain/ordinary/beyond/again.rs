//! The second pass beside somebody's simulation. Each effect was found before those that came after it, and fitted as the car
//! was then. Here all of them are in both runs: with and without each, everything else is there. So that effects add up is not
//! assumed: by how much they do not is told.

use std::collections::BTreeMap;
use std::ops::Range;

use nalgebra::DMatrix;
use rayon::prelude::*;

use super::super::numbers::{Free, Number};
use super::Search;
use super::climb::{State, freedom};
use super::colour::{CHANNELS, Series};
use super::refit::Refitted;
use super::told::SHOWN_IN;
use super::trial::Trial;
use super::without::without;
use crate::explain::model::Model;
use crate::explain::result::{ByChannel, Estimate, Finding, SecondPass};
use crate::explain::select::LEAST_EVIDENCE;

/// What was taken in the first pass.
pub(super) struct Taken {
    pub trial: Trial,
    /// Where its own numbers stand among what is free.
    pub own: Range<usize>,
}

/// What the second pass came to.
pub(super) struct Again<'a> {
    /// The car with all of it.
    pub state: State<'a>,
    /// Names of what was found first and is not needed beside the rest.
    pub fell_away: Vec<String>,
}

/// The car without one of the findings, all else fitted again.
struct Dropped {
    evidence: f64,
    errors: Vec<Series>,
}

impl Search<'_> {
    /// Fits everything that was taken together, and asks of each finding what it is beside the others. What is not needed
    /// beside them falls away.
    pub(super) fn again<'a>(
        &self,
        state: State<'a>,
        taken: &mut Vec<Taken>,
        findings: &mut Vec<Finding>,
    ) -> Again<'a> {
        let mut state = self.learned(&state.model, &state.free, &state.at);
        let mut fell_away = Vec::new();
        loop {
            let dropped: Vec<Dropped> = taken.par_iter().map(|it| self.dropped(&state, it)).collect();
            let weakest = (0..dropped.len())
                .min_by(|a, b| dropped[*a].evidence.total_cmp(&dropped[*b].evidence))
                .filter(|weakest| taken.len() > 1 && dropped[*weakest].evidence < LEAST_EVIDENCE);
            if let Some(weakest) = weakest {
                tracing::debug!(
                    name = taken[weakest].trial.name(),
                    evidence = dropped[weakest].evidence,
                    "is not needed beside what was found after it"
                );
                fell_away.push(taken[weakest].trial.name());
                let (model, free, at) = taken_out(state, &taken.remove(weakest), taken);
                state = self.learned(&model, &free, &at);
                findings.remove(weakest);
                continue;
            }
            let runs = Runs::new(self, &state, taken);
            for ((it, dropped), finding) in taken.iter().zip(&dropped).zip(findings.iter_mut()) {
                self.second(&runs, (it, dropped), finding);
            }
            return Again { state, fell_away };
        }
    }

    fn dropped(&self, state: &State<'_>, it: &Taken) -> Dropped {
        let mut others = state.clone();
        let own = others.free.drain(it.own.clone());
        // Where it makes no difference, and held there.
        let fixed: Vec<_> = own.map(|free| free.held_at(free.prior.0)).collect();
        others.at.drain(it.own.clone());
        others.slopes.drain(it.own.clone());
        let free: Vec<_> = others.free.iter().copied().chain(fixed.iter().copied()).collect();
        let from = others.at.iter().copied().chain(fixed.iter().map(|free| free.prior.0)).collect();
        let from = self.start_at(&state.model, &free, from);
        let climbed = self.climb(&others, &state.colour, &state.model, &free, from);
        let freedom = freedom(&state.free, &state.covariance, it.own.clone());
        let evidence = climbed.cost - state.cost - freedom - self.price_of_trying(&it.trial.name());
        Dropped { evidence, errors: climbed.errors }
    }

    /// Says of a finding what it is beside the others.
    fn second(&self, runs: &Runs<'_, '_>, (it, dropped): (&Taken, &Dropped), finding: &mut Finding) {
        let state = runs.state;
        let here = fitted(state, it);
        let first = std::mem::replace(&mut finding.parameters, here.parameters());
        if finding.reference_value.is_some() {
            finding.reference_value = here.unchanged();
        }
        if let (Some(law), Some(coefficient)) = (&mut finding.law, finding.parameters.values().next()) {
            law.take(*coefficient);
            finding.equation = format!("Δ({}) = {}", law.place, law.expression);
        }
        let others = runs.without(self, it);
        let beside = runs.changes(&others, &state.errors);
        let alone = runs.changes(&runs.nothing, &runs.alone(self, it));
        finding.second_pass = Some(SecondPass {
            moved: moved(&first, &finding.parameters),
            first_parameters: first,
            evidence: dropped.evidence,
            explained_share: self.share(&dropped.errors, &state.errors),
            interplay: interplay(&beside, &alone),
            without: without(self.drives, state, &it.own, &beside),
        });
    }
}

/// Runs with and without what was taken, all other numbers where they are.
struct Runs<'r, 'a> {
    state: &'r State<'a>,
    /// Where nothing of it makes a difference.
    neutral: Vec<f64>,
    /// What is not predicted there.
    nothing: Vec<Series>,
}

impl<'r, 'a> Runs<'r, 'a> {
    fn new(search: &Search<'_>, state: &'r State<'a>, taken: &[Taken]) -> Self {
        let mut neutral = state.at.clone();
        for place in taken.iter().flat_map(|it| it.own.clone()) {
            neutral[place] = state.free[place].prior.0;
        }
        let nothing = search.errors(&state.model, &state.free, &neutral);
        Self { state, neutral, nothing }
    }

    /// Everything but this one.
    fn without(&self, search: &Search<'_>, it: &Taken) -> Vec<Series> {
        let at = with(self.state.at.clone(), &self.neutral, it);
        search.errors(&self.state.model, &self.state.free, &at)
    }

    /// Nothing but this one.
    fn alone(&self, search: &Search<'_>, it: &Taken) -> Vec<Series> {
        let at = with(self.neutral.clone(), &self.state.at, it);
        search.errors(&self.state.model, &self.state.free, &at)
    }

    /// By how much the predictions of the first recording change from one run to the other, by channel.
    fn changes(&self, from: &[Series], to: &[Series]) -> [Vec<f64>; CHANNELS] {
        std::array::from_fn(|channel| {
            let both = from.first().zip(to.first());
            let both = both.into_iter().flat_map(|(from, to)| from[channel].iter().zip(&to[channel]));
            both.map(|(from, to)| from - to).collect()
        })
    }
}

/// Coordinates with one finding's own numbers from elsewhere.
fn with(mut at: Vec<f64>, from: &[f64], it: &Taken) -> Vec<f64> {
    at[it.own.clone()].copy_from_slice(&from[it.own.clone()]);
    at
}

/// Of what a finding does, how much is due to the others, by channel.
fn interplay(beside: &[Vec<f64>; CHANNELS], alone: &[Vec<f64>; CHANNELS]) -> ByChannel {
    let of = |channel: usize| {
        let both = beside[channel].iter().zip(&alone[channel]);
        let both = both.filter(|(beside, alone)| beside.is_finite() && alone.is_finite());
        let (square, differs) = both.fold((0.0, 0.0), |(square, differs), (beside, alone)| {
            (square + beside * beside, differs + (beside - alone) * (beside - alone))
        });
        (square > 0.0).then(|| (SHOWN_IN[channel].name().to_owned(), f64::sqrt(differs / square).min(1.0)))
    };
    // Of the car's motion: the wheels' speeds follow from that.
    (0..2).filter_map(of).collect()
}

/// The car without one of the findings, what is free of it and where that is; the others stand where they stand then.
fn taken_out<'a>(state: State<'a>, gone: &Taken, left: &mut [Taken]) -> (Model<'a>, Vec<Free>, Vec<f64>) {
    let State { mut model, mut free, mut at, .. } = state;
    for free in free.drain(gone.own.clone()) {
        if let Number::Of(place) = free.number {
            model.put(place, free.prior.0);
        }
    }
    at.drain(gone.own.clone());
    for it in left.iter_mut().filter(|it| it.own.start > gone.own.start) {
        it.own = it.own.start - gone.own.len()..it.own.end - gone.own.len();
    }
    (model, free, at)
}

/// One of the findings as a search fits it: its own numbers last.
fn fitted<'a>(state: &State<'a>, it: &Taken) -> Refitted<'a> {
    let others = (0..state.free.len()).filter(|place| !it.own.contains(place));
    let order: Vec<usize> = others.chain(it.own.clone()).collect();
    let count = order.len();
    Refitted {
        trial: it.trial.clone(),
        model: state.model.clone(),
        free: order.iter().map(|place| state.free[*place]).collect(),
        own: it.own.len(),
        at: order.iter().map(|place| state.at[*place]).collect(),
        errors: Vec::new(),
        covariance: DMatrix::from_fn(count, count, |i, j| state.covariance[(order[i], order[j])]),
        cost: state.cost,
        evidence: 0.0,
        held_gain: 0.0,
        gains: [0.0; CHANNELS],
        share: 0.0,
    }
}

/// Names of the numbers that moved by more than the uncertainty of both.
fn moved(first: &BTreeMap<String, Estimate>, second: &BTreeMap<String, Estimate>) -> Vec<String> {
    let has_moved = |(name, first): (&String, &Estimate)| {
        let second = second.get(name)?;
        ((second.value - first.value).abs() > first.std.hypot(second.std)).then(|| name.clone())
    };
    first.iter().filter_map(has_moved).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_number_that_moves_by_more_than_both_uncertainties_is_told() {
        let of = |value: f64, std: f64| BTreeMap::from([("length_m".to_owned(), Estimate { value, std })]);
        assert!(moved(&of(0.5, 0.03), &of(0.54, 0.04)).is_empty());
        assert_eq!(moved(&of(0.5, 0.03), &of(0.56, 0.04)), ["length_m"]);
    }

    /// GIVEN something that does the same beside the others as alone, and something that does twice as much THEN nothing and
    /// a half of it is due to them.
    #[test]
    fn what_is_due_to_the_others_is_told() {
        let channels = |of: f64| std::array::from_fn(|_| vec![of, -of, f64::NAN]);
        assert_eq!(interplay(&channels(0.2), &channels(0.2))["yaw_rate"], 0.0);
        let half = interplay(&channels(0.2), &channels(0.1))["yaw_rate"];
        assert!((half - 0.5).abs() < 1e-12, "{half}");
    }
}
