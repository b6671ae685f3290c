//! Where a model predicts best, for noise of a given colour.

use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;

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

/// Where a search ended.
pub struct Climbed {
    /// The coordinates.
    pub at: Vec<f64>,
    /// What is not predicted there.
    pub errors: Vec<Series>,
    /// −2 ln likelihood of the training part, the prior's counted in.
    pub cost: f64,
    /// Covariance of the coordinates.
    pub covariance: DMatrix<f64>,
}

impl Search<'_> {
    /// Fits a model from a place on and learns the colour of its noise, in turn: what the numbers miss at first is noise.
    pub(super) fn settle(
        &self,
        state: &State<'_>,
        learned: impl Fn(&[Series]) -> Colour,
        mut colour: Colour,
        (model, free, from): (&Model<'_>, &[Free], Vec<f64>),
    ) -> (Climbed, Colour) {
        let mut here = self.climb(state, &colour, model, free, from);
        for _ in 0..ROUNDS {
            let next_colour = learned(&here.errors);
            let next = self.climb(state, &next_colour, model, free, here.at.clone());
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

    /// Fits a model from a place on, the slopes of its first numbers being those of the state.
    pub(super) fn climb(
        &self,
        state: &State<'_>,
        colour: &Colour,
        model: &Model<'_>,
        free: &[Free],
        from: Vec<f64>,
    ) -> Climbed {
        let count = free.len();
        let mut at = from;
        let mut errors = self.errors(model, free, &at);
        let rows = self.rows(colour, &state.errors);
        let kept: Vec<DVector<f64>> =
            state.slopes.iter().map(|slopes| self.white(colour, &rows, slopes, 0)).collect();
        let mut white = self.white(colour, &rows, &errors, 0);
        let mut cost = self.cost(colour, &rows, &white).train + prior_cost(free, &at);
        let mut covariance = DMatrix::identity(count, count);
        let mut damping = 0.0;
        for _ in 0..STEPS {
            let between =
                |place: usize| free[place].number.place().and_then(|place| model.course_between(place));
            let has_course = (kept.len()..count).any(|place| between(place).is_some());
            let tracks = has_course.then(|| self.tracks(model, free, &at));
            let own = (kept.len()..count).into_par_iter().map(|place| {
                let branch = tracks.as_deref().zip(between(place));
                let slope = self.slope(model, free, (&at, &errors), (place, free[place].step), branch);
                self.white(colour, &rows, &slope, 0)
            });
            let own: Vec<DVector<f64>> = own.collect();
            let columns: Vec<DVector<f64>> = kept.iter().cloned().chain(own).collect();
            let (information, gradient) = normal(&columns, &white, &rows, free, &at);
            let before = cost;
            // Levenberg's and Marquardt's.
            for _ in 0..TRIES {
                let mut damped = information.clone();
                for i in 0..count {
                    damped[(i, i)] *= 1.0 + damping;
                }
                let Some(factor) = damped.cholesky() else { break };
                let step = factor.solve(&gradient);
                let next: Vec<f64> =
                    (0..count).map(|i| (at[i] + step[i]).clamp(free[i].bounds.0, free[i].bounds.1)).collect();
                let there = self.errors(model, free, &next);
                let white_there = self.white(colour, &rows, &there, 0);
                let cost_there = self.cost(colour, &rows, &white_there).train + prior_cost(free, &next);
                if cost_there < cost {
                    (at, errors, white, cost) = (next, there, white_there, cost_there);
                    damping *= 0.1;
                    break;
                }
                damping = (10.0 * damping).max(1e-3);
            }
            covariance = information.cholesky().map_or(covariance, |factor| factor.inverse());
            if before - cost < LEAST_STEP {
                break;
            }
        }
        Climbed { at, errors, cost, covariance }
    }
}
