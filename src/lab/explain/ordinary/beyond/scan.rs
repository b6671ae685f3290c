//! All candidates to first order, beside decoys.

use std::collections::BTreeMap;

use nalgebra::DVector;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rayon::prelude::*;

use super::Search;
use super::climb::State;
use super::rows::{EVERY, normal, weights};
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

impl Search<'_> {
    /// All candidates to first order, best first, the best one of each name (of a patch, of either side); and the most that a
    /// decoy gains.
    pub(super) fn scan(&self, state: &State<'_>, trials: &[Trial], seed: u64) -> (Vec<Scored>, f64) {
        let colour = &self.short_colour(&state.errors);
        let rows = self.rows(colour, &state.errors);
        let white = self.white(colour, &rows, &state.errors, 0);
        let own: Vec<DVector<f64>> =
            state.slopes.iter().map(|slopes| self.white(colour, &rows, slopes, 0)).collect();
        let (information, gradient) = normal(&own, &white, &rows, &state.free, &state.at);
        let Some(factor) = information.cholesky() else { return (Vec::new(), f64::INFINITY) };
        let weights = weights(&white, &rows);
        let weighed: Vec<DVector<f64>> = own.iter().map(|own| own.component_mul(&weights)).collect();
        let errors = white.component_mul(&weights);
        // Gain and step along a column, all ordinary numbers refitted.
        let score = |column: &DVector<f64>, std: f64| -> Option<(f64, f64)> {
            let with = DVector::from_iterator(weighed.len(), weighed.iter().map(|own| own.dot(column)));
            let taken = factor.solve(&with);
            let slope = errors.dot(column) - taken.dot(&gradient);
            let own = column.component_mul(column).dot(&weights);
            let information = own - taken.dot(&with) + std.powi(-2);
            (information > 0.0 && own > 0.0).then(|| (slope * slope / information, slope / information))
        };
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        let shortest = self.drives.iter().map(|drive| drive.points() / EVERY).min().unwrap_or(1);
        let least = LEAST_SHIFT.min(shortest / 4);
        let shifts: Vec<usize> =
            (0..DECOYS).map(|_| random.random_range(least..(shortest - least).max(least + 1))).collect();
        let tracks = self.tracks(&state.model, &state.free, &state.at);
        let scored: Vec<(Scored, f64, bool)> = trials
            .par_iter()
            .filter_map(|trial| {
                let (model, free, at) = state.beside(trial);
                let first = state.free.len();
                let mut best: Option<(f64, usize, f64, bool)> = None;
                let mut decoy = 0.0_f64;
                for place in first..free.len() {
                    if !trial.is_main(&free[place]) {
                        continue;
                    }
                    for share in trial.ways() {
                        let step = share.map_or(free[place].step, |share| share * free[place].prior.1);
                        let (low, high) = free[place].bounds;
                        if !(low..=high).contains(&(at[place] + step)) {
                            continue;
                        }
                        let branch = trial.acts().map(|between| (&tracks[..], between));
                        let slope = self.slope(&model, &free, (&at, &state.errors), (place, step), branch);
                        let column = self.white(colour, &rows, &slope, 0);
                        let Some((gain, by)) = score(&column, free[place].prior.1) else { continue };
                        if best.is_none_or(|(most, ..)| gain > most) {
                            best = Some((gain, place - first, free[place].prior.0 + by, by > 0.0));
                        }
                        if !trial.has_time() {
                            for shift in &shifts {
                                let column = self.white(colour, &rows, &slope, *shift);
                                decoy = decoy
                                    .max(score(&column, free[place].prior.1).map_or(0.0, |(gain, _)| gain));
                            }
                        }
                    }
                }
                let (gain, number, coordinate, is_more) = best?;
                let scored = Scored { trial: trial.clone(), gain, numbers: vec![(number, coordinate)] };
                Some((scored, decoy, is_more))
            })
            .collect();
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
