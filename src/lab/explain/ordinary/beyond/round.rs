//! One round of a search: what was tried beside a car, and what of that is there for sure.

use std::collections::BTreeSet;

use rayon::prelude::*;

use super::Search;
use super::climb::State;
use super::references::Healthy;
use super::refit::Refitted;
use super::scan::Scored;
use super::trial::Trial;
use crate::explain::finding::TOLD_APART;
use crate::explain::result::Ranked;
use crate::explain::select::LEAST_EVIDENCE;

/// Of a scan so many are fitted together with everything else …
const MOST_REFITTED: usize = 6;

/// … if to first order they have this share of the evidence that is needed.
const LEAST_OF_FIRST_ORDER: f64 = 0.3;

/// What to first order gains less than this share of what the best law does is no rival of it. Tuned by
/// `shared/trials/unknown`: there the best effect of the library has a tenth.
const LEAST_BESIDE_A_LAW: f64 = 0.2;

/// By so much held-out −2 ln likelihood must fall. Statistical: odds of e³ on driving that was not looked at.
pub const LEAST_HELD_GAIN: f64 = 6.0;

/// So many deviations a main number must be from nothing …
pub const LEAST_CLEAR: f64 = 4.0;

/// … and so many if driving that was not looked at speaks for it as much as what was must. Tuned by a centre of gravity that
/// shifts in the last third of a lap (`concealed_in_real_drives`).
const LEAST_CLEAR_IF_HELD: f64 = 3.0;

/// A law that explains less of what the plain model misses is of how the car is written down, not of the car. Tuned by
/// `an_ordinary_car_has_nothing_unusual`: 1.2 % with a late steering and nothing else.
const LEAST_SHARE_OF_LAW: f64 = 0.03;

/// What was tried in a round.
#[derive(Default)]
pub struct Round<'a> {
    /// Everything, to first order …
    scored: Vec<Scored>,
    /// … and the most that decoys do.
    null: f64,
    /// The best of it, fitted with everything else: its gain to first order before.
    refitted: Vec<(f64, Refitted<'a>)>,
}

impl<'a> Round<'a> {
    /// Tries some more. Laws that are asked for from the beginning come first: what gains little beside them is not
    /// refitted.
    pub fn add(
        &mut self,
        search: &Search<'_>,
        state: &State<'a>,
        trials: &[Trial],
        taken: &BTreeSet<String>,
        seed: u64,
    ) {
        let (scored, null) = search.scan(state, trials, seed);
        let laws = self.scored.iter().filter(|scored| scored.trial.is_law());
        let best_law = laws.map(|scored| scored.gain).fold(0.0, f64::max);
        let least = (LEAST_OF_FIRST_ORDER * LEAST_EVIDENCE).max(LEAST_BESIDE_A_LAW * best_law);
        let open = scored.iter().filter(|scored| !taken.contains(&scored.trial.name()));
        let best: Vec<&Scored> = open.filter(|scored| scored.gain > least).take(MOST_REFITTED).collect();
        self.refitted.par_extend(best.into_par_iter().map(|of| (of.gain, search.refit(state, of))));
        self.null = self.null.max(null);
        self.scored.extend(scored);
        self.sort();
    }

    /// Counts against each what references say of it.
    pub fn count_against(&mut self, healthy: &[Healthy]) {
        for (_, of) in &mut self.refitted {
            of.evidence = of.evidence_beyond(healthy);
        }
        self.sort();
    }

    /// Best first, and of each name the best only.
    fn sort(&mut self) {
        self.refitted.sort_by(|a, b| b.1.evidence.total_cmp(&a.1.evidence));
        let mut names = BTreeSet::new();
        self.refitted.retain(|(_, of)| names.insert(of.trial.name()));
    }

    /// What was refitted.
    pub fn names(&self) -> BTreeSet<String> {
        self.refitted.iter().map(|(_, of)| of.trial.name()).collect()
    }

    /// Names with their evidence, best first.
    pub fn evidence(&self) -> Vec<(String, f64)> {
        self.refitted.iter().map(|(_, of)| (of.trial.name(), of.evidence)).collect()
    }

    /// What varies as it likes and moves the car across.
    fn across(&self) -> impl Iterator<Item = &Scored> {
        self.scored.iter().filter(|scored| scored.trial.moves_across())
    }

    /// Of what moves the car across, one looks like the other, whatever their evidence.
    pub fn tell_alike(&self, best: &Refitted<'_>, alike: &mut Vec<String>) {
        if !best.trial.moves_across() {
            return;
        }
        let own = best.trial.name();
        let others = self.across().map(|scored| scored.trial.name()).filter(|name| *name != own);
        let across: BTreeSet<String> = others.collect();
        alike.retain(|name| !across.contains(name));
        alike.extend(across);
    }

    /// The likeliest of what is there for sure.
    pub fn sure(&self, search: &Search<'_>, healthy: &[Healthy]) -> Option<&Refitted<'a>> {
        let references = search.references;
        let all = || self.refitted.iter().map(|(_, of)| of);
        let is_told_from = |of: &Refitted<'_>, rivals: fn(&Trial) -> bool| {
            all().filter(|other| rivals(&other.trial)).all(|other| of.is_told_from(other))
        };
        // A name that fits hardly better than a form without one, which has paid for all its rivals, is a forced fit.
        let laws = all().filter(|of| of.trial.is_law()).map(|of| of.evidence);
        let best_law = laws.fold(f64::NEG_INFINITY, f64::max);
        let may_be_forced = |trial: &Trial| !trial.is_law() && !trial.is_of_every_car() && !trial.is_number();
        // A motion that the model misses is in a zero's errors, too.
        let across = self.across().map(|scored| scored.gain).fold(0.0, f64::max);
        let is_sure = |(gain, of): &&(f64, Refitted<'a>)| {
            of.evidence > LEAST_EVIDENCE
                && (references > 0 || of.trial.is_of_every_car() || is_told_from(of, Trial::is_of_every_car))
                && (!of.trial.is_law()
                    || of.share > LEAST_SHARE_OF_LAW && is_told_from(of, |trial| !trial.is_law()))
                && (!of.trial.is_of_zero() || of.evidence > across + TOLD_APART)
                && (!may_be_forced(&of.trial) || of.evidence > best_law + TOLD_APART)
                && search.is_beyond(of, healthy)
                && of.held_gain > least_held_gain(references, &of.trial)
                && (of.trial.has_time() || *gain > self.null || search.is_simulated && of.is_above(self.null))
                && of.clearest() > least_clear(of.held_gain)
                && !of.is_at_bound()
                && !(references == 0 && search.takes_the_cars_place(&of.trial))
        };
        self.refitted.iter().find(is_sure).map(|(_, of)| of)
    }

    /// Everything that was tried, best first: what was refitted by its evidence, the rest to first order and never above.
    pub fn ranking(&self) -> Vec<Ranked> {
        let ranked = |trial: &Trial, score: f64, refitted: bool| Ranked {
            effect: trial.candidate().map_or_else(|| trial.name(), |candidate| candidate.kind.name.into()),
            channel: trial.candidate().and_then(|candidate| Some(candidate.channel?.to_string())),
            score,
            refitted,
        };
        let refitted = self.refitted.iter().map(|(_, of)| ranked(&of.trial, of.evidence, true));
        let mut all: Vec<Ranked> = refitted.collect();
        let least = all.last().map_or(f64::INFINITY, |last| last.score);
        let names = self.names();
        let mut others: Vec<&Scored> =
            self.scored.iter().filter(|scored| !names.contains(&scored.trial.name())).collect();
        others.sort_by(|a, b| b.gain.total_cmp(&a.gain));
        let mut seen = BTreeSet::new();
        others.retain(|scored| seen.insert(scored.trial.name()));
        all.extend(others.iter().map(|scored| ranked(&scored.trial, scored.gain.min(least), false)));
        all
    }

    /// For who looks on.
    pub fn log(&self, search: &Search<'_>, healthy: &[Healthy]) {
        for (gain, refitted) in &self.refitted {
            tracing::debug!(
                name = refitted.trial.name(),
                onset = ?refitted.trial.onset(),
                stretches = ?refitted.trial.stretches(),
                distance = ?search.distance(refitted, healthy),
                gain,
                null = self.null,
                evidence = refitted.evidence,
                held_gain = refitted.held_gain,
                numbers = ?refitted.parameters(),
                "beyond the ordinary car"
            );
        }
    }
}

fn least_clear(held_gain: f64) -> f64 {
    if held_gain > LEAST_EVIDENCE { LEAST_CLEAR_IF_HELD } else { LEAST_CLEAR }
}

/// Where references tell a number, other numbers may take its place at the price of being unlike theirs: then the evidence
/// is in that price, and held-out driving must not speak against it.
fn least_held_gain(references: usize, trial: &Trial) -> f64 {
    if references > 0 && trial.is_always_there() { -LEAST_HELD_GAIN } else { LEAST_HELD_GAIN }
}
