//! Which of the physics that every car has is taken: what the data do not refuse.

use super::fit::{FreeFit, fit};
use super::inputs::FreeDrive;
use super::numbers::{free, with_ordinary};
use super::problem::{Problem, Scale};
use crate::explain::model::Model;
use physics::model::Vehicle;

/// Statistical: odds of 20 to 1, in 2 ln.
pub const REFUSED: f64 = 6.0;

/// Below this nobody's downforce shows, m/s: 5 m² of a race car press it with a third of its weight there, a passenger car's
/// with a hundredth.
const FAST_MPS: f64 = 30.0;

/// Fits the model with the physics that every car has, and with less or more of it where the data refuse that.
///
/// Every error counts in full for the refusal: a run that spins where the car did not is no outlier.
pub fn fit_ordinary<'a>(model: &Model<'a>, vehicle: &Vehicle, drives: &[FreeDrive]) -> FreeFit<'a> {
    let [usual, simpler, pressed] = with_ordinary(model);
    let fitted = |model: &Model<'a>| fit(model, free(model, vehicle, drives), drives);
    let (usual, simpler) = rayon::join(|| fitted(&usual), || fitted(&simpler));
    let mut best = if is_refused(&usual, &simpler, REFUSED, drives) { simpler } else { usual };
    if drives.iter().filter_map(FreeDrive::fastest).any(|fastest| fastest > FAST_MPS) {
        let pressed = fitted(&pressed);
        if is_refused(&best, &pressed, REFUSED, drives) {
            best = pressed;
        }
    }
    best
}

/// Do the data refuse the first of two fits for the other one, by so much?
pub fn is_refused(usual: &FreeFit<'_>, other: &FreeFit<'_>, least: f64, drives: &[FreeDrive]) -> bool {
    let memory = other.time_constants_s.map(Scale::memory_of);
    let [of_usual, of_other] = [usual, other].map(|fit| {
        let problem = Problem { model: &fit.model, free: &fit.free, drives };
        problem.prior_cost(&fit.at) + problem.misfit(fit, memory)
    });
    tracing::debug!(of_usual, of_other, "the ordinary car, and another one if the data refuse it");
    of_usual > of_other + least
}

impl Problem<'_, '_> {
    /// −2 ln likelihood of the residuals for noise of the size that they have.
    fn misfit(&self, fit: &FreeFit<'_>, memory: [f64; 2]) -> f64 {
        let (mut squares, mut count) = ([0.0; 2], [0.0; 2]);
        let all = self.drives.iter().zip(&fit.predicted);
        for row in all.flat_map(|(drive, predicted)| self.residuals(drive, predicted)) {
            for (channel, error) in row.into_iter().enumerate().filter(|(_, error)| error.is_finite()) {
                squares[channel] += error * error;
                count[channel] += 1.0;
            }
        }
        let of = |channel: usize| match count[channel] {
            0.0 => 0.0,
            count => count / memory[channel] * (squares[channel] / count).max(1e-12).ln(),
        };
        of(0) + of(1)
    }
}
