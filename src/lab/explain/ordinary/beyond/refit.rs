//! A candidate fitted with everything else.

use nalgebra::DMatrix;
use rayon::prelude::*;

use super::super::numbers::{Free, Scope};
use super::super::run::Track;
use super::Search;
use super::climb::{Climbed, Start, State, freedom, freedom_together};
use super::colour::{CHANNELS, Series};
use super::scan::Scored;
use super::trial::Trial;
use crate::explain::model::Model;
use crate::explain::select::LEAST_EVIDENCE;

/// Steps by which beginnings and ends are moved, s.
const LARGEST_MOVE_S: f64 = 4.0;
const LEAST_MOVE_S: f64 = 0.125;

/// More of them only go to and fro: each is judged beside numbers that were fitted before it. Numerical.
const MOST_MOVES: usize = 20;

/// Such a step may cost so much of the gain on all rows: another colour of the noise is learned beside it. When something
/// began while driving was held out, nothing else says when.
const LEAST_WORSE: f64 = 2.0;

/// A candidate fitted with everything else.
pub struct Refitted<'a> {
    /// What.
    pub trial: Trial,
    /// The car with it.
    pub model: Model<'a>,
    /// What is free, the candidate's own numbers last …
    pub free: Vec<Free>,
    /// … how many those are …
    pub own: usize,
    /// … and where all are.
    pub at: Vec<f64>,
    /// What is not predicted.
    pub errors: Vec<Series>,
    /// Covariance of the coordinates.
    pub covariance: DMatrix<f64>,
    /// The likeliest cost in the colour of these errors.
    pub cost: f64,
    /// Twice the logarithm of the odds for it.
    pub evidence: f64,
    /// By how much −2 ln likelihood of the held-out part falls.
    pub held_gain: f64,
    /// By how much that of the training part falls, by channel.
    pub gains: [f64; CHANNELS],
    /// The largest share of the plain model's held-out squares that it explains of a channel.
    pub share: f64,
}

impl Refitted<'_> {
    /// On driving that it was fitted to, less what it had to choose from, and on the other.
    fn all_gain(&self) -> f64 {
        self.evidence + self.held_gain
    }
}

/// Between which moments, s, two trials differ that are the same but for the times at which they act.
fn differs(one: &Trial, other: &Trial) -> Option<[f64; 2]> {
    let edges = |trial: &Trial| -> Vec<f64> {
        trial
            .onset()
            .map(|(at, _)| at)
            .into_iter()
            .chain(trial.stretches().iter().flatten().copied())
            .collect()
    };
    let (one, other) = (edges(one), edges(other));
    let moved = || one.iter().zip(&other).filter(|(one, other)| one != other);
    moved().next()?;
    let most = |of: fn(f64, f64) -> f64| move |most: f64, (a, b): (&f64, &f64)| of(most, of(*a, *b));
    Some([moved().fold(f64::INFINITY, most(f64::min)), moved().fold(f64::NEG_INFINITY, most(f64::max))])
}

impl Search<'_> {
    /// Fits a candidate together with all that is free, with the noise's colour learned beside it.
    pub(super) fn refit<'a>(&self, state: &State<'a>, scored: &Scored) -> Refitted<'a> {
        let trial = scored.trial.clone();
        let free = trial.free(&trial.put_into(&state.model));
        let start = |from: &[f64], share: f64| {
            let of = |(number, free): (usize, &Free)| {
                let told = scored.numbers.iter().find(|(place, _)| *place == number);
                let by = told.map_or(0.0, |(_, to)| share * (to - free.prior.0));
                let by = by.clamp(-3.0 * free.prior.1, 3.0 * free.prior.1);
                (free.prior.0 + by).clamp(free.bounds.0, free.bounds.1)
            };
            from.iter().copied().chain(free.iter().enumerate().map(of)).collect()
        };
        let mut starts = vec![start(&state.at, 1.0), start(&state.at, 0.4)];
        if self.is_simulated {
            // A model may be far off: then delays and scales have taken what is none of theirs.
            let own = |(free, at): (&Free, &f64)| if free.of == Scope::Car { *at } else { free.prior.0 };
            let untouched: Vec<f64> = state.free.iter().zip(&state.at).map(own).collect();
            starts.extend([0.4, 1.0, 3.0].map(|share| start(&untouched, share)));
        }
        let mut best = self.refit_from(state, trial, starts);
        // Where it begins and ends was on a grid.
        let (mut step, mut moves) = (LARGEST_MOVE_S, 0);
        let mut known = None;
        while step >= LEAST_MOVE_S && moves < MOST_MOVES {
            let tracks = known.get_or_insert_with(|| self.tracks(&best.model, &best.free, &best.at));
            let moved = best.trial.moved(step).into_par_iter().map(|trial| {
                let errors = self.errors_moved(state, (&best, tracks), &trial);
                (self.own_cost(state, &errors), trial)
            });
            let here = self.own_cost(state, &best.errors);
            let better = moved.filter(|(cost, _)| *cost < here).min_by(|a, b| a.0.total_cmp(&b.0));
            let next = better.map(|(_, trial)| self.refit_from(state, trial, vec![best.at.clone()]));
            match next.filter(|next| next.all_gain() > best.all_gain() - LEAST_WORSE) {
                Some(next) => {
                    best = next;
                    known = None;
                    moves += 1;
                }
                None => step *= 0.5,
            }
        }
        best
    }

    /// What is not predicted if it acts at another time, all numbers where they are.
    fn errors_moved(
        &self,
        state: &State<'_>,
        (best, tracks): (&Refitted<'_>, &[Track]),
        trial: &Trial,
    ) -> Vec<Series> {
        let model = trial.put_into(&state.model);
        let there = (&model, &best.free[..], &best.at[..]);
        let of = |drive: usize| match differs(&best.trial, trial) {
            Some(between) => self.branched(tracks, between, there, drive),
            None => self.errors_of(there.0, there.1, there.2, drive),
        };
        (0..self.drives.len()).into_par_iter().map(of).collect()
    }

    /// Of everything, held-out rows included: when something began may show nowhere else.
    fn own_cost(&self, state: &State<'_>, errors: &[Series]) -> f64 {
        let short = self.short_colour(&state.errors);
        let rows = self.rows(&short, &state.errors);
        let cost = self.cost(&short, &rows, &self.white(&short, &rows, errors));
        cost.train + cost.held
    }

    fn refit_from<'a>(&self, state: &State<'a>, trial: Trial, starts: Vec<Vec<f64>>) -> Refitted<'a> {
        let model = trial.put_into(&state.model);
        let mut free = state.free.clone();
        let first = free.len();
        free.extend(trial.free(&model));
        let short = self.short_colour(&state.errors);
        let climb = |at| self.climb(state, &short, &model, &free, self.start_at(&model, &free, at));
        let climbed = starts.into_iter().map(climb);
        let best = climbed.min_by(|a, b| a.cost.total_cmp(&b.cost));
        let best = best.map(|best| best.start()).unwrap_or_default();
        let there = self.is_simulated.then(|| {
            let mut slopes = self.slopes(&model, &free, &best.at, &best.errors);
            slopes.truncate(first);
            State { slopes, ..state.clone() }
        });
        let state = there.as_ref().unwrap_or(state);
        // With the noise as it is beside it; a zero that wanders is no noise.
        let of_zero = trial.is_of_zero();
        let learned =
            |errors: &[Series]| if of_zero { self.short_colour(errors) } else { self.colour(errors) };
        let (Climbed { at, errors, slopes, cost, covariance }, colour) =
            self.settle(state, learned, learned(&best.errors), (&model, &free, best));
        let colour = &colour;
        let rows = self.rows(colour, &state.errors);
        let with = self.cost(colour, &rows, &self.white(colour, &rows, &errors));
        let without = self.cost(colour, &rows, &self.white(colour, &rows, &state.errors));
        // The ordinary numbers may have found a better place on the way, which has nothing to do with the effect.
        let without_it = if of_zero { &short } else { &state.colour };
        let alone = |from: Start| self.climb(state, without_it, &state.model, &state.free, from).cost;
        let mut from_there = self.start_at(&state.model, &state.free, at[..first].to_vec());
        from_there.slopes = slopes[..first].to_vec();
        let before = if of_zero { alone(state.start()) } else { state.cost };
        let before = before.min(alone(from_there.clone()));
        let own = first..free.len();
        let freedom = if trial.is_course() {
            freedom_together(&free, &covariance, own)
        } else {
            freedom(&free, &covariance, own)
        };
        let mut evidence = before - cost - freedom - self.price_of_trying(&trial.name());
        if evidence > LEAST_EVIDENCE {
            // And the noise another colour.
            let there = (&state.model, &state.free[..], from_there);
            let (alone, _) = self.settle(state, learned, colour.clone(), there);
            evidence -= (before - alone.cost).max(0.0);
        }
        let share = self.share(&state.errors, &errors).into_values().fold(0.0, f64::max);
        Refitted {
            trial,
            model,
            own: free.len() - first,
            free,
            at,
            errors,
            covariance,
            cost,
            evidence,
            held_gain: without.held - with.held,
            gains: std::array::from_fn(|channel| without.by_channel[channel] - with.by_channel[channel]),
            share,
        }
    }

    /// The next state.
    pub(super) fn with<'a>(&self, best: &Refitted<'a>) -> State<'a> {
        State {
            model: best.model.clone(),
            free: best.free.clone(),
            at: best.at.clone(),
            cost: best.cost,
            covariance: best.covariance.clone(),
            slopes: self.slopes(&best.model, &best.free, &best.at, &best.errors),
            colour: self.colour(&best.errors),
            errors: best.errors.clone(),
        }
    }
}
