//! Which of the physics that every car has is taken: what the data do not refuse.

use super::fit::{FreeFit, Problem, fit, fit_near};
use super::inputs::FreeDrive;
use super::numbers::{free, on_time, with_ordinary};
use crate::explain::model::Model;
use physics::model::Vehicle;

/// Statistical: odds of 20 to 1, in 2 ln.
const REFUSED: f64 = 6.0;

/// So many fits to halves are compared, two for each of two cars. The third car is fitted seldom, and not counted.
pub const HALVES_FITTED: usize = 4;

/// With fewer blocks to fit to, a half of them tells too little. Statistical: two in each half.
const LEAST_BLOCKS: usize = 4;

/// Fits the model with the physics that every car has, and without what of that the data refuse: first what they may
/// refuse; then, where they do, all of it and the delays, if the car as configured foresees better what it was not fitted
/// to. A lap at the limit is such a drive (`free_runs`).
pub fn fit_ordinary<'a>(model: &Model<'a>, vehicle: &Vehicle, drives: &[FreeDrive]) -> FreeFit<'a> {
    let [usual, simpler] = with_ordinary(model);
    let fitted = |model: &Model<'a>| fit(model, free(model, vehicle, drives), drives);
    let (usual, simpler) = rayon::join(|| fitted(&usual), || fitted(&simpler));
    if drives.iter().map(FreeDrive::fitted_blocks).sum::<usize>() < LEAST_BLOCKS {
        return usual;
    }
    let memory = simpler.scale().memory;
    let surprise = |fit: &FreeFit<'_>| surprise_by_halves(fit, drives, memory);
    let (of_usual, of_simpler) = rayon::join(|| surprise(&usual), || surprise(&simpler));
    tracing::debug!(of_usual, of_simpler, "the ordinary car with what the data may refuse, and without");
    if of_usual <= of_simpler + REFUSED {
        return usual;
    }
    let bare = fit_near(&simpler, model, on_time(free(model, vehicle, drives)), drives);
    let of_bare = surprise(&bare);
    tracing::debug!(of_bare, "the car as configured");
    if of_simpler <= of_bare + REFUSED { simpler } else { bare }
}

/// −2 ln likelihood of each half of the fitted blocks by a fit to the other half, for noise of the size that is left
/// (cross-validation; Stone 1974). What a drive does not tell makes this larger, and the fit itself only better.
///
/// Every error counts in full: a run that spins where the car did not is no outlier.
fn surprise_by_halves(fit: &FreeFit<'_>, drives: &[FreeDrive], memory: [f64; 2]) -> f64 {
    let halves = [0, 1].map(|which| drives.iter().map(|drive| drive.half(which)).collect::<Vec<_>>());
    let [first, second] =
        halves.each_ref().map(|drives| Problem { model: &fit.model, free: &fit.free, drives });
    let foreseen = |of: &Problem<'_, '_>, by: &Problem<'_, '_>| of.squares(&by.fitted_from(fit));
    let (of_first, of_second) = rayon::join(|| foreseen(&first, &second), || foreseen(&second, &first));
    let of = |channel: usize| {
        let (squares, count) =
            (of_first[channel].0 + of_second[channel].0, of_first[channel].1 + of_second[channel].1);
        if count == 0.0 { 0.0 } else { count / memory[channel] * (squares / count).max(1e-12).ln() }
    };
    of(0) + of(1)
}

impl Problem<'_, '_> {
    /// Squares of the residuals of both channels, and how many there are.
    fn squares(&self, at: &[f64]) -> [(f64, f64); 2] {
        let mut sums = [(0.0, 0.0); 2];
        for (drive, predicted) in self.drives.iter().zip(&self.predict(at)) {
            for row in self.residuals(drive, predicted) {
                for (sum, error) in sums.iter_mut().zip(row).filter(|(_, error)| error.is_finite()) {
                    sum.0 += error * error;
                    sum.1 += 1.0;
                }
            }
        }
        sums
    }
}

#[cfg(test)]
mod tests {
    use super::super::inputs::Held;
    use super::*;
    use crate::explain::bench::recorded;

    /// GIVEN a drive WHEN it is halved THEN every point that is fitted to is in one half, and what is held out in none.
    #[test]
    fn halves_share_what_is_fitted_to() {
        let (vehicle, recording) = recorded("");
        let drive = FreeDrive::new(&recording, &vehicle, Held::EveryThird, 600.0).unwrap();
        let halves = [drive.half(0), drive.half(1)];
        for (i, held) in drive.held.iter().enumerate() {
            assert_eq!(halves.iter().filter(|half| !half.held[i]).count(), usize::from(!held), "point {i}");
        }
        let blocks = halves.map(|half| half.fitted_blocks());
        assert_eq!(blocks.iter().sum::<usize>(), drive.fitted_blocks());
        assert!(blocks[0].abs_diff(blocks[1]) <= 1, "{blocks:?}");
    }
}
