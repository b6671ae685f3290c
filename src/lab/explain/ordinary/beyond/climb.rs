//! Where a model predicts best, for noise of a given colour.

use std::ops::Range;

use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;

use super::super::damped::damped_step;
use super::super::numbers::{Free, prior_cost};
use super::Search;
use super::colour::{Colour, Series};
use super::rows::normal;
use super::trial::Trial;
use crate::explain::model::Model;

/// Steps of a fit. Numerical: Gauss–Newton's, the ordinary numbers' slopes kept. Where most errors are outliers at first,
/// each goes a part of the way only.
const STEPS: usize = 25;

/// So many dampings of a step are tried. Numerical.
const TRIES: usize = 6;

/// A search ends where a step gains less, −2 ln likelihood.
const LEAST_STEP: f64 = 0.3;

/// Slopes of a candidate's own numbers are kept as long as a step gains more, −2 ln likelihood; none ends by old ones.
/// Numerical.
const STILL_SERVES: f64 = 10.0 * LEAST_STEP;

/// All slopes are taken anew where they mislead and the search has gained more since they were, −2 ln likelihood. Numerical.
const SERVES_FOR: f64 = 100.0 * LEAST_STEP;

/// What becomes of the damping after a step: where it was needed, it will be again. Numerical.
const LESS_DAMPING: [f64; 2] = [0.1, 0.7];

/// Rounds of learning the noise's colour at most, and what one gains at least. Numerical: what the car without a candidate has not
/// learned, the candidate would gain; what it has not, it would lose.
pub const ROUNDS: usize = 20;
pub const LEAST_ROUND: f64 = 1.0;

/// The best model so far.
#[derive(Clone)]
pub struct State<'a> {
    /// The car.
    pub model: Model<'a>,
    /// What is free of it …
    pub free: Vec<Free>,
    /// … and where that is.
    pub at: Vec<f64>,
    /// What it does not predict of each drive.
    pub errors: Vec<Series>,
    /// How the predictions change with each number.
    pub slopes: Vec<Vec<Series>>,
    /// The noise's colour.
    pub colour: Colour,
    /// The likeliest cost in that colour …
    pub cost: f64,
    /// … and the covariance of the coordinates there.
    pub covariance: DMatrix<f64>,
}

impl<'a> State<'a> {
    /// From where it is.
    pub(super) fn start(&self) -> Start {
        Start { at: self.at.clone(), errors: self.errors.clone(), ..Start::default() }
    }

    /// The car with a trial where it makes no difference; what is free of both, the trial's last, and where that is.
    pub(super) fn beside(&self, trial: &Trial) -> (Model<'a>, Vec<Free>, Vec<f64>) {
        let model = trial.put_into(&self.model);
        let own = trial.free(&model);
        let at = self.at.iter().copied().chain(own.iter().map(|free| free.prior.0)).collect();
        (model, self.free.iter().copied().chain(own).collect(), at)
    }
}

/// What the freedom of these numbers counts against them, 2 ln: how much narrower the data make what was thought before.
pub fn freedom(free: &[Free], covariance: &DMatrix<f64>, places: impl Iterator<Item = usize>) -> f64 {
    let of =
        |place: usize| (free[place].prior.1.powi(2) / covariance[(place, place)].max(1e-300)).ln().max(0.0);
    places.map(of).sum()
}

/// The same of all of them together: neighbours on a course are not known apart.
pub fn freedom_together(free: &[Free], covariance: &DMatrix<f64>, places: std::ops::Range<usize>) -> f64 {
    let before: f64 = free[places.clone()].iter().map(|free| 2.0 * free.prior.1.ln()).sum();
    let block = covariance.view((places.start, places.start), (places.len(), places.len()));
    let after = block.clone_owned().cholesky().map(|factor| factor.l().diagonal().map(f64::ln).sum());
    after.map_or(0.0, |after| (before - 2.0 * after).max(0.0))
}

/// Where a search begins.
#[derive(Clone, Default)]
pub struct Start {
    /// The coordinates.
    pub at: Vec<f64>,
    /// What is not predicted there.
    pub errors: Vec<Series>,
    /// How the predictions change with each number somewhere near, if anybody knows.
    pub slopes: Vec<Vec<Series>>,
}

/// Where a search ended.
pub struct Climbed {
    /// The coordinates.
    pub at: Vec<f64>,
    /// What is not predicted there.
    pub errors: Vec<Series>,
    /// How the predictions change with each number near there.
    pub slopes: Vec<Vec<Series>>,
    /// −2 ln likelihood of the training part, the prior's counted in.
    pub cost: f64,
    /// Covariance of the coordinates.
    pub covariance: DMatrix<f64>,
}

impl Climbed {
    /// From where it ended.
    pub(super) fn start(&self) -> Start {
        Start { at: self.at.clone(), errors: self.errors.clone(), slopes: self.slopes.clone() }
    }
}

impl Search<'_> {
    /// From a place of a model.
    pub(super) fn start_at(&self, model: &Model<'_>, free: &[Free], at: Vec<f64>) -> Start {
        Start { errors: self.errors(model, free, &at), at, ..Start::default() }
    }

    /// Fits a model from a place on and learns the colour of its noise, in turn: what the numbers miss at first is noise.
    pub(super) fn settle(
        &self,
        state: &State<'_>,
        learned: impl Fn(&[Series]) -> Colour,
        mut colour: Colour,
        (model, free, from): (&Model<'_>, &[Free], Start),
    ) -> (Climbed, Colour) {
        let mut here = self.climb(state, &colour, model, free, from);
        for _ in 0..ROUNDS {
            let next_colour = learned(&here.errors);
            let next = self.climb(state, &next_colour, model, free, here.start());
            let gained = here.cost - next.cost;
            if gained > 0.0 {
                (here, colour) = (next, next_colour);
            }
            if gained < LEAST_ROUND {
                break;
            }
        }
        (here, colour)
    }

    /// Fits a model from a place on. The slopes of its first numbers are those of the state, as long as they serve.
    pub(super) fn climb(
        &self,
        state: &State<'_>,
        colour: &Colour,
        model: &Model<'_>,
        free: &[Free],
        from: Start,
    ) -> Climbed {
        let count = free.len();
        let Start { mut at, mut errors, slopes } = from;
        let rows = self.rows(colour, &state.errors);
        let white_all = |slopes: &[Vec<Series>]| -> Vec<DVector<f64>> {
            slopes.par_iter().map(|slope| self.white(colour, &rows, slope)).collect()
        };
        let mut slopes = if slopes.is_empty() { state.slopes.clone() } else { slopes };
        let mut columns = white_all(&slopes);
        let mut white = self.white(colour, &rows, &errors);
        let mut cost = self.cost(colour, &rows, &white).train + prior_cost(free, &at);
        let mut covariance = DMatrix::identity(count, count);
        let mut damping = 0.0;
        let (mut renewed, mut are_own_new) = (slopes.len()..count, true);
        let mut serves_from = if at == state.at { cost } else { f64::INFINITY };
        for _ in 0..STEPS {
            let new = self.slopes_of(model, free, (&at, &errors), renewed.clone());
            columns.splice(renewed.start.., white_all(&new));
            slopes.splice(renewed.start.., new);
            let (information, gradient) =
                normal(&columns.iter().collect::<Vec<_>>(), &white, &rows, free, &at);
            let before = cost;
            let mut misleads = false;
            // Levenberg's and Marquardt's.
            for tries in 0..TRIES {
                let Some(next) = damped_step(&information, &gradient, damping, free, &at) else { break };
                let step = DVector::from_fn(count, |i, _| next[i] - at[i]);
                if are_own_new && 2.0 * step.dot(&gradient) - step.dot(&(&information * &step)) < LEAST_STEP {
                    break;
                }
                let there = self.errors(model, free, &next);
                let white_there = self.white(colour, &rows, &there);
                let cost_there = self.cost(colour, &rows, &white_there).train + prior_cost(free, &next);
                if cost_there < cost {
                    (at, errors, white, cost) = (next, there, white_there, cost_there);
                    damping *= LESS_DAMPING[usize::from(tries > 0)];
                    break;
                }
                misleads = serves_from - cost > SERVES_FOR;
                if misleads {
                    break;
                }
                damping = (10.0 * damping).max(1e-3);
            }
            covariance = information.cholesky().map_or(covariance, |factor| factor.inverse());
            let gained = before - cost;
            if misleads {
                (renewed, are_own_new, serves_from) = (0..count, true, cost);
                continue;
            }
            if gained < LEAST_STEP && are_own_new {
                break;
            }
            are_own_new = gained <= STILL_SERVES;
            renewed = if are_own_new { state.slopes.len()..count } else { count..count };
        }
        Climbed { at, errors, slopes, cost, covariance }
    }

    /// How the predictions change with these numbers; of the points of a course where they act only.
    fn slopes_of(
        &self,
        model: &Model<'_>,
        free: &[Free],
        (at, errors): (&[f64], &[Series]),
        places: Range<usize>,
    ) -> Vec<Vec<Series>> {
        let between = |place: usize| free[place].number.place().and_then(|place| model.course_between(place));
        let has_course = places.clone().any(|place| between(place).is_some());
        let tracks = has_course.then(|| self.tracks(model, free, at));
        let of = |place: usize| {
            let branch = tracks.as_deref().zip(between(place));
            self.slope(model, free, (at, errors), (place, free[place].step), branch)
        };
        places.into_par_iter().map(of).collect()
    }
}
