//! Which of the physics that every car has is taken: what predicts driving best that it was not fitted to.

use rayon::prelude::*;

use super::fit::{FreeFit, Problem, Scale, fit};
use super::inputs::{BLOCK_POINTS, FreeDrive};
use super::numbers::{free, with_ordinary};
use crate::explain::model::Model;
use physics::model::Vehicle;

/// So much better the simpler car must predict to be taken, in 2 ln. Statistical: odds of 20 to 1.
const REFUSED: f64 = 6.0;

/// Steps from the whole fit's end to that of a half. Numerical.
const STEPS: usize = 12;

/// Fits the model with the physics that every car has, and without what of that the data refuse.
///
/// The fitted blocks are halved in turns: each half is predicted by the car that is fitted to the other (two-fold
/// cross-validation; Stone 1974). At the limit, what the equations lack about differentials, brakes and tires can
/// make a fuller car fit better and predict worse.
pub fn fit_ordinary<'a>(model: &Model<'a>, vehicle: &Vehicle, drives: &[FreeDrive]) -> FreeFit<'a> {
    let fitted = |model: &Model<'a>| fit(model, free(model, vehicle, drives), drives);
    let mut fits: Vec<FreeFit<'a>> = with_ordinary(model).par_iter().map(fitted).collect();
    let halves = [0, 1].map(|parity| half(drives, parity));
    // One noise for all: the least that is left.
    let closest =
        (1..fits.len()).fold(0, |best, i| if fits[i].noise[0] < fits[best].noise[0] { i } else { best });
    let scale = fits[closest].scale();
    let misfits: Vec<f64> = fits.par_iter().map(|fit| across(fit, &halves, &scale)).collect();
    tracing::debug!(?misfits, "the ordinary car, without what the data may refuse, and the plain one");
    let mut best = 0;
    for place in 1..fits.len() {
        if misfits[place] + REFUSED < misfits[best] {
            best = place;
        }
    }
    fits.swap_remove(best)
}

/// The drives with every second of their fitted blocks.
fn half(drives: &[FreeDrive], parity: usize) -> Vec<FreeDrive> {
    let halved = |drive: &FreeDrive| {
        let mut drive = drive.clone();
        let fitted = drive.held.chunks_mut(BLOCK_POINTS).filter(|block| !block[0]);
        for block in fitted.skip(1 - parity).step_by(2) {
            block.fill(true);
        }
        drive
    };
    drives.iter().map(halved).collect()
}

/// −2 ln likelihood of each half by the car that is fitted to the other.
fn across(whole: &FreeFit<'_>, halves: &[Vec<FreeDrive>; 2], scale: &Scale) -> f64 {
    let of = |fitted: usize| {
        let problem = Problem { model: &whole.model, free: &whole.free, drives: &halves[fitted] };
        let (_, at) = problem.search(whole.at.clone(), scale, STEPS);
        Problem { drives: &halves[1 - fitted], ..problem }.misfit(&at, scale)
    };
    of(0) + of(1)
}

impl Problem<'_, '_> {
    /// −2 ln likelihood of the residuals for noise of the size that they have. Every error counts in full: a run that
    /// spins where the car did not is no outlier.
    fn misfit(&self, at: &[f64], scale: &Scale) -> f64 {
        let (mut squares, mut count) = ([0.0; 2], [0.0; 2]);
        let predicted = self.predict(at);
        let all = self.drives.iter().zip(&predicted);
        for row in all.flat_map(|(drive, predicted)| self.residuals(drive, predicted)) {
            for (channel, error) in row.into_iter().enumerate().filter(|(_, error)| error.is_finite()) {
                squares[channel] += error * error;
                count[channel] += 1.0;
            }
        }
        let of = |channel: usize| match count[channel] {
            0.0 => 0.0,
            count => count / scale.memory[channel] * (squares[channel] / count).max(1e-12).ln(),
        };
        of(0) + of(1)
    }
}
