//! All candidates to first order, beside decoys.

use std::collections::BTreeMap;

use nalgebra::{Cholesky, DMatrix, DVector, Dyn};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rayon::prelude::*;

use super::super::run::Track;
use super::Search;
use super::climb::State;
use super::colour::Colour;
use super::rows::{EVERY, Rows, normal, weights, whitened};
use super::trial::Trial;

/// Decoys. Statistical: the largest of twenty, of all candidates together.
const DECOYS: usize = 20;

/// Decoys are so many rows away at least: 10 s.
const LEAST_SHIFT: usize = 333;

/// A candidate with first-order numbers.
pub struct Scored {
    /// What.
    pub trial: Trial,
    /// By how much −2 ln likelihood falls.
    pub gain: f64,
    /// Its numbers: which of those that are free, and coordinate.
    pub numbers: Vec<(usize, f64)>,
}

/// The state that candidates are scored beside: its normal equations, in a colour of the noise.
pub(super) struct Ground<'g> {
    search: &'g Search<'g>,
    state: &'g State<'g>,
    pub(super) colour: Colour,
    pub(super) rows: Rows,
    /// Each ordinary number's slope …
    own: Vec<DVector<f64>>,
    /// … the same and the errors, weighed.
    weighed: Vec<DVector<f64>>,
    errors: DVector<f64>,
    pub(super) weights: DVector<f64>,
    factor: Cholesky<f64, Dyn>,
    gradient: DVector<f64>,
    tracks: Vec<Track>,
}

/// What the points of a course do, each by itself: their places among what is free, the columns, and how far they are
/// thought to be from nothing.
type Points = (Vec<(usize, f64)>, Vec<DVector<f64>>, Vec<f64>);

impl<'g> Ground<'g> {
    /// None where the ordinary numbers have no solution.
    pub(super) fn new(search: &'g Search<'g>, state: &'g State<'g>, colour: Colour) -> Option<Self> {
        let rows = search.rows(&colour, &state.errors);
        let white = search.white(&colour, &rows, &state.errors);
        let own: Vec<DVector<f64>> =
            state.slopes.iter().map(|slopes| search.white(&colour, &rows, slopes)).collect();
        let (information, gradient) =
            normal(&own.iter().collect::<Vec<_>>(), &white, &rows, &state.free, &state.at);
        let factor = information.cholesky()?;
        let weights = weights(&white, &rows);
        let weighed = own.iter().map(|own| own.component_mul(&weights)).collect();
        let errors = white.component_mul(&weights);
        let tracks = search.tracks(&state.model, &state.free, &state.at);
        Some(Self { search, state, colour, rows, own, weighed, errors, weights, factor, gradient, tracks })
    }

    /// The ordinary numbers' products with a column, and what they take of it.
    fn taken(&self, column: &DVector<f64>) -> (DVector<f64>, DVector<f64>) {
        let with = DVector::from_iterator(self.weighed.len(), self.weighed.iter().map(|own| own.dot(column)));
        let taken = self.factor.solve(&with);
        (with, taken)
    }

    /// Gain and step along a column, all ordinary numbers refitted.
    fn score(&self, column: &DVector<f64>, std: f64) -> Option<(f64, f64)> {
        let (with, taken) = self.taken(column);
        let slope = self.errors.dot(column) - taken.dot(&self.gradient);
        let own = column.component_mul(column).dot(&self.weights);
        let information = own - taken.dot(&with) + std.powi(-2);
        (information > 0.0 && own > 0.0).then(|| (slope * slope / information, slope / information))
    }

    /// The same of columns that are taken together. What so many numbers gain by chance is no gain.
    fn score_together(&self, columns: &[DVector<f64>], stds: &[f64]) -> Option<(f64, DVector<f64>)> {
        let count = columns.len();
        let with =
            DMatrix::from_fn(self.weighed.len(), count, |own, place| self.weighed[own].dot(&columns[place]));
        let taken = self.factor.solve(&with);
        let slope = DVector::from_fn(count, |place, _| self.errors.dot(&columns[place]));
        let slope = slope - taken.tr_mul(&self.gradient);
        let mut information = -with.tr_mul(&taken);
        for (i, column) in columns.iter().enumerate() {
            let column = column.component_mul(&self.weights);
            for (j, other) in columns.iter().enumerate() {
                information[(i, j)] += column.dot(other);
            }
            information[(i, i)] += stds[i].powi(-2);
        }
        let factor = information.cholesky()?;
        let by = factor.solve(&slope);
        let freedom: f64 = factor.l().diagonal().iter().zip(stds).map(|(l, std)| (l * std).ln()).sum();
        Some((slope.dot(&by) - 2.0 * freedom.max(0.0), by))
    }

    /// A trial's main numbers each alone, of which the best counts, beside decoys at other times; with whether it is more.
    fn alone(&self, trial: &Trial, shifts: &[usize]) -> Option<(Scored, f64, bool)> {
        let (model, free, at) = self.state.beside(trial);
        let first = self.state.free.len();
        let mut best: Option<(f64, usize, f64, bool)> = None;
        let mut decoy = 0.0_f64;
        for place in first..free.len() {
            if !trial.is_main(&free[place]) {
                continue;
            }
            let std = free[place].prior.1;
            for share in trial.ways() {
                let step = share.map_or(free[place].step, |share| share * std);
                let (low, high) = free[place].bounds;
                if !(low..=high).contains(&(at[place] + step)) {
                    continue;
                }
                let branch = trial.acts().map(|between| (&self.tracks[..], between));
                let slope =
                    self.search.slope(&model, &free, (&at, &self.state.errors), (place, step), branch);
                let white = whitened(&self.colour, &slope);
                let Some((gain, by)) = self.score(&self.rows.of(&white, 0), std) else { continue };
                if best.is_none_or(|(most, ..)| gain > most) {
                    best = Some((gain, place - first, free[place].prior.0 + by, by > 0.0));
                }
                if !trial.has_time() {
                    for shift in shifts {
                        let gain = self.score(&self.rows.of(&white, *shift), std);
                        decoy = decoy.max(gain.map_or(0.0, |(gain, _)| gain));
                    }
                }
            }
        }
        let (gain, number, coordinate, is_more) = best?;
        let numbers = vec![(number, coordinate)];
        Some((Scored { trial: trial.clone(), gain, numbers }, decoy, is_more))
    }

    pub(super) fn points(&self, trial: &Trial) -> Option<Points> {
        let (model, free, at) = self.state.beside(trial);
        let first = self.state.free.len();
        let places: Vec<usize> = (first..free.len()).filter(|place| trial.is_main(&free[*place])).collect();
        let column = |place: &usize| {
            let between = model.course_between(free[*place].number.place()?);
            let branch = between.map(|between| (&self.tracks[..], between));
            let step = (*place, free[*place].step);
            let slope = self.search.slope(&model, &free, (&at, &self.state.errors), step, branch);
            Some(self.search.white(&self.colour, &self.rows, &slope))
        };
        let columns: Vec<DVector<f64>> = places.iter().map(column).collect::<Option<_>>()?;
        let stds = places.iter().map(|place| free[*place].prior.1).collect();
        let places = places.into_iter().map(|place| (place - first, free[place].prior.0)).collect();
        Some((places, columns, stds))
    }

    /// A course: all its points together.
    fn course(&self, trial: &Trial) -> Option<Scored> {
        let (places, columns, stds) = self.points(trial)?;
        let (gain, by) = self.score_together(&columns, &stds)?;
        let numbers = places.iter().zip(by.iter()).map(|((place, here), by)| (*place, here + by)).collect();
        Some(Scored { trial: trial.clone(), gain, numbers })
    }

    /// What is left of a column when the ordinary numbers have taken what they can.
    pub(super) fn left(&self, column: &DVector<f64>) -> DVector<f64> {
        let mut left = column.clone();
        for (own, taken) in self.own.iter().zip(self.taken(column).1.iter()) {
            left.axpy(-taken, own, 1.0);
        }
        left
    }
}

impl Search<'_> {
    /// All candidates to first order, best first, the best one of each name (of a patch, of either side); and the most that a
    /// decoy gains.
    pub(super) fn scan(&self, state: &State<'_>, trials: &[Trial], seed: u64) -> (Vec<Scored>, f64) {
        let Some(ground) = Ground::new(self, state, self.short_colour(&state.errors)) else {
            return (Vec::new(), f64::INFINITY);
        };
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        let shortest = self.drives.iter().map(|drive| drive.points() / EVERY).min().unwrap_or(1);
        let least = LEAST_SHIFT.min(shortest / 4);
        let shifts: Vec<usize> =
            (0..DECOYS).map(|_| random.random_range(least..(shortest - least).max(least + 1))).collect();
        let of = |trial: &Trial| {
            if trial.is_course() {
                return ground.course(trial).map(|scored| (scored, 0.0, false));
            }
            ground.alone(trial, &shifts)
        };
        let scored: Vec<(Scored, f64, bool)> = trials.par_iter().filter_map(of).collect();
        let null = scored.iter().map(|(_, decoy, _)| *decoy).fold(0.0, f64::max);
        let mut best: BTreeMap<(String, bool), Scored> = BTreeMap::new();
        for (scored, _, is_more) in scored {
            // A patch of more friction and one of less are at other places.
            let name = (scored.trial.name(), scored.trial.is_patch() && is_more);
            if best.get(&name).is_none_or(|other| other.gain < scored.gain) {
                best.insert(name, scored);
            }
        }
        let mut all: Vec<Scored> = best.into_values().collect();
        all.sort_by(|a, b| b.gain.total_cmp(&a.gain));
        (all, null)
    }
}
