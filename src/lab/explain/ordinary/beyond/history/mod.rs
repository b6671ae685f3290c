//! Many drives in time order: what has changed, since which drive, and whether it grows.
//!
//! ```text
//! FreeFit of all drives ─► Linear (each candidate as a number of each drive) ─► courses over the drives, judged
//!                                       └──── once more, with what was taken ◄──── refit (as beside references) ◄─┘
//! ```
//!
//! The drives before a moment are the references of those after it: what is thought of delays and scales of the later ones
//! is what these have ([`expected`]). So every moment asks the question of `--reference`, and all moments share one
//! car and one run of each candidate along each drive.

mod over_drives;
mod profiles;
mod told;

use std::collections::BTreeSet;
use std::ops::Range;

use rayon::prelude::*;

use super::super::fit::FreeFit;
use super::super::inputs::FreeDrive;
use super::super::numbers::{Free, Scope};
use super::climb::{Climbed, State};
use super::references::expected;
use super::refit::Refitted;
use super::round::{LEAST_CLEAR, LEAST_HELD_GAIN};
use super::trial::{self, Trial};
use super::{Beyond, Question, Search};
use crate::explain::result::{Estimate, Ranked};
use crate::explain::select::LEAST_EVIDENCE;
use over_drives::{Course, Shape};
use physics::model::Vehicle;
use profiles::{Linear, Spread};

/// A number over the drives.
#[derive(Clone, Debug, PartialEq)]
pub struct OverDrives {
    /// The effect with its channel, or the number of the car.
    pub name: String,
    /// The key of its number …
    pub number: String,
    /// … and its unit.
    pub unit: String,
    /// In each drive. Of a number of the car its value; of an effect how much more there is of it than in the first drives.
    pub values: Vec<Estimate>,
    /// The smallest change from the middle of the drives on that is told with 90 % probability.
    pub told_from: f64,
    /// What it could be.
    pub usual: f64,
}

/// A number that is another one from a drive on.
#[derive(Clone, Debug, PartialEq)]
pub struct Since {
    /// Its values.
    pub number: OverDrives,
    /// The first drive that has it …
    pub since: usize,
    /// … and the first and the last one which that could be, with 95 % probability.
    pub since_ci: [usize; 2],
    /// By how much it changes from drive to drive since then; none where that is in the last one.
    pub trend: Option<Estimate>,
    /// Does it grow? None where the drives do not tell.
    pub grows: Option<bool>,
}

/// Numbers over the drives: those that have changed, in the order of the findings, and all others.
#[derive(Clone, Debug, Default)]
pub struct History {
    /// Changed.
    pub changes: Vec<Since>,
    /// As they were.
    pub unchanged: Vec<OverDrives>,
}

/// Most changes that are told.
const MOST: usize = 4;

/// Of a round so many candidates are fitted together with everything else.
const MOST_REFITTED: usize = 6;

/// So much evidence beyond the numbers' scatter from drive to drive a change must have, twice the logarithm of the odds, the
/// choice of moment and shape paid for. Tuned: `healthy_drives_in_order` (campaign).
const LEAST_BEYOND_SCATTER: f64 = 12.0;

/// A candidate with its course.
struct Scored<'t> {
    trial: &'t Trial,
    course: Course,
    beyond_scatter: f64,
}

/// A candidate that was fitted with everything else.
struct Candidate<'t, 'a> {
    scored: &'t Scored<'t>,
    refitted: Refitted<'a>,
    /// Twice the logarithm of the odds for it.
    evidence: f64,
    /// Is it there for sure?
    is_sure: bool,
}

/// Searches what has changed over the drives.
pub fn history(
    found: &FreeFit<'_>,
    vehicle: &Vehicle,
    drives: &[FreeDrive],
    question: Question<'_>,
) -> Beyond {
    let Question { kinds, references, plain, seed, .. } = question;
    let first = references.max(1);
    let mut answer = Beyond { history: Some(History::default()), ..Beyond::default() };
    if first >= drives.len() {
        return answer;
    }
    let mut trials = trial::trials(found, drives, kinds, Scope::Since(first));
    trials.retain(Trial::is_always_there);
    let tried = super::tried(&trials, &[]);
    let search = Search { drives, vehicle, tried, plain, references, is_simulated: false };
    let moments = first..drives.len();
    // Moments, and at each a step or growth.
    let price = 2.0 * ((Shape::ALL.len() * moments.len()) as f64).ln();
    let mut state = search.begin(found);
    let mut taken: Vec<(Trial, usize)> = Vec::new();
    let mut names = BTreeSet::new();
    for round in 0..=MOST {
        let linear = Linear::new(&search, &state);
        let thought: Vec<Vec<Free>> =
            moments.clone().map(|moment| expected(&state.free, &state.at, moment)).collect();
        let spreads: Vec<(&Trial, Vec<Spread>)> =
            trials.par_iter().map(|trial| (trial, linear.candidate(trial))).collect();
        let mut scored: Vec<Scored<'_>> = spreads
            .par_iter()
            .filter_map(|(trial, spreads)| score(&linear, trial, spreads, (&thought, moments.clone(), price)))
            .collect();
        scored.sort_by(|a, b| b.beyond_scatter.total_cmp(&a.beyond_scatter));
        if round == 0 {
            let mut seen = BTreeSet::new();
            let once = scored.iter().filter(|of| seen.insert(of.trial.name()));
            answer.ranking = once.map(ranked).collect();
        }
        let open = scored.iter().filter(|of| !names.contains(&key(of.trial)));
        let likely = open.filter(|of| of.beyond_scatter > 0.5 * LEAST_BEYOND_SCATTER).take(MOST_REFITTED);
        let likely: Vec<&Scored<'_>> = if round < MOST { likely.collect() } else { Vec::new() };
        let mut refitted: Vec<Candidate<'_, '_>> =
            likely.into_par_iter().filter_map(|of| search.refit_course(&state, of, price, seed)).collect();
        refitted.sort_by(|a, b| b.evidence.total_cmp(&a.evidence));
        refitted.iter().for_each(Candidate::log);
        let sure = || refitted.iter().filter(|of| of.is_sure);
        let likeliest = sure().next();
        let mirrored =
            likeliest.and_then(|grown| sure().find(|shrunk| is_the_same_of_the_other_wheel(grown, shrunk)));
        let Some(best) = mirrored.or(likeliest) else {
            let middle = first + moments.len() / 2;
            let all = spreads.par_iter().filter(|(trial, _)| !names.contains(&key(trial)));
            let told = all.filter_map(|(trial, spreads)| {
                let spread = spreads.first()?;
                let profile = linear.profile(spread, thought.get(middle - first)?)?;
                // What has not changed is what it is in all of them.
                Some(search.told(&state, trial, spread.main, &profile, (drives.len(), middle), price))
            });
            let unchanged = told.collect();
            let changes = taken.iter().filter_map(|(trial, place)| {
                search.since(&linear, trial, *place, (&state, &thought), (moments.clone(), price))
            });
            answer.history = Some(History { changes: changes.collect(), unchanged });
            break;
        };
        let is_other = |of: &&Candidate<'_, '_>| key(&of.refitted.trial) != key(&best.refitted.trial);
        let others = refitted.iter().filter(is_other);
        let others: Vec<(String, f64)> =
            others.map(|of| (full_name(&of.refitted.trial), of.evidence)).collect();
        let best = &best.refitted;
        answer.findings.push(search.finding(&state, best, &others));
        answer.is_unusual = true;
        names.insert(key(&best.trial));
        let main = (state.free.len()..best.free.len()).find(|place| best.trial.is_main(&best.free[*place]));
        taken.extend(main.map(|place| (best.trial.clone(), place)));
        state = search.with(best);
        answer.predicted = Some(search.predicted(&state.model, &state.free, &state.at));
    }
    answer
}

impl Candidate<'_, '_> {
    /// For who looks on.
    fn log(&self) {
        tracing::debug!(
            name = full_name(&self.refitted.trial),
            course = ?self.scored.course,
            beyond_scatter = self.scored.beyond_scatter,
            evidence = self.evidence,
            held_gain = self.refitted.held_gain,
            numbers = ?self.refitted.parameters(),
            is_sure = self.is_sure,
            "over the drives"
        );
    }
}

/// A name, and of several numbers of an effect (four wheels) the one that it is of.
fn key(trial: &Trial) -> (String, Vec<usize>) {
    (trial.name(), trial.candidate().map(|candidate| candidate.free.clone()).unwrap_or_default())
}

/// Of the four wheels each has its own.
fn full_name(trial: &Trial) -> String {
    let main = trial.candidate().filter(|candidate| candidate.kind.search.each_number_alone);
    let wheel = main.and_then(|candidate| {
        let spec = candidate.kind.parameters.get(*candidate.free.first()?)?;
        spec.name.rsplit('_').next()
    });
    wheel.map_or_else(|| trial.name(), |wheel| format!("{}:{wheel}", trial.name()))
}

fn ranked(of: &Scored<'_>) -> Ranked {
    Ranked {
        effect: of.trial.candidate().map_or_else(|| of.trial.name(), |candidate| candidate.kind.name.into()),
        channel: of.trial.candidate().and_then(|candidate| Some(candidate.channel?.to_string())),
        score: of.beyond_scatter,
        refitted: false,
    }
}

/// A candidate with its likeliest course; each moment with what the drives before it let expect.
fn score<'t>(
    linear: &Linear<'_, '_>,
    trial: &'t Trial,
    spreads: &[Spread],
    (thought, moments, price): (&[Vec<Free>], Range<usize>, f64),
) -> Option<Scored<'t>> {
    let at = |spread: &Spread, (moment, thought): (usize, &Vec<Free>)| {
        Some(linear.profile(spread, thought)?.from(moment))
    };
    let of = |spread| moments.clone().zip(thought).filter_map(move |moment| at(spread, moment));
    let best = spreads.iter().flat_map(of).max_by(|a, b| a.evidence.total_cmp(&b.evidence))?;
    Some(Scored { trial, course: best.course, beyond_scatter: best.evidence - price })
}

/// Of an axle's wheels only the difference is compared, so that one has grown and that the other has shrunk differ by what is
/// of second order only: by less than this share of their evidence.
const OF_SECOND_ORDER: f64 = 0.1;

/// Is it a wheel that has grown, where the other wheel's shrinking does the same? A tire loses pressure and tread; for a
/// larger one somebody must have done something.
fn is_the_same_of_the_other_wheel(grown: &Candidate<'_, '_>, shrunk: &Candidate<'_, '_>) -> bool {
    let size = |of: &Candidate<'_, '_>| {
        let trial = &of.refitted.trial;
        let is_of_a_wheel =
            trial.candidate().is_some_and(|candidate| candidate.kind.search.each_number_alone);
        is_of_a_wheel.then(|| of.refitted.clearest_main().value)
    };
    let has_signs = size(grown).zip(size(shrunk)).is_some_and(|(grown, shrunk)| grown > 0.0 && shrunk < 0.0);
    has_signs && shrunk.evidence > (1.0 - OF_SECOND_ORDER) * grown.evidence
}

impl Search<'_> {
    /// A candidate with its course, fitted with everything else as beside references: its evidence, and whether it is there
    /// for sure.
    fn refit_course<'a, 't>(
        &self,
        state: &State<'a>,
        of: &'t Scored<'t>,
        price: f64,
        seed: u64,
    ) -> Option<Candidate<'t, 'a>> {
        let Course { since, shape } = of.course;
        let scope = match shape {
            Shape::Step => Scope::Since(since),
            Shape::Growth => Scope::Growing { first: since, last: self.drives.len() - 1 },
        };
        let state = self.expecting(state, since);
        let (scored, null) = self.scan(&state, &[of.trial.within(scope)], seed);
        let first = scored.first()?;
        let refitted = self.refit(&state, first);
        let evidence = refitted.evidence - price;
        let is_sure = evidence > LEAST_EVIDENCE
            && of.beyond_scatter > LEAST_BEYOND_SCATTER
            && refitted.held_gain > -LEAST_HELD_GAIN
            && (refitted.trial.has_time() || first.gain > null)
            && refitted.clearest() > LEAST_CLEAR
            && !refitted.is_at_bound();
        Some(Candidate { scored: of, refitted, evidence, is_sure })
    }

    /// The same car with what the first drives let expect of the others.
    fn expecting<'a>(&self, state: &State<'a>, healthy: usize) -> State<'a> {
        let free = expected(&state.free, &state.at, healthy);
        let Climbed { at, errors, cost, covariance, .. } =
            self.climb(state, &state.colour, &state.model, &free, state.start());
        State { free, at, errors, cost, covariance, ..state.clone() }
    }
}
