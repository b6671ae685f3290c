//! How far the car's numbers depend on which drives they are from: all fitted again without some, in turn.

use nalgebra::DMatrix;
use rayon::prelude::*;

use super::fit::{FreeFit, LEAST_DRIVES, STEPS, count_searches};
use super::inputs::FreeDrive;
use super::numbers::{Free, Scope};
use super::problem::{Problem, Scale};

/// So many groups of drives are left out in turn. Numerical: each is a search, and more would hardly change the deviations.
const MOST_GROUPS: usize = 8;

impl FreeFit<'_> {
    /// The same fit with the deviations of the car's numbers that the drives' own answers have, where that is more: the jackknife,
    /// a group of drives left out at a time (Efron and Tibshirani, An Introduction to the Bootstrap, ch. 11). What the model lacks
    /// differs from drive to drive, and moves numbers that can stand for each other much further than slopes at one point have it.
    pub fn widened_by_leaving_out(mut self, drives: &[FreeDrive]) -> Self {
        // What is only predicted has no say.
        let is_fitted = |drive: &FreeDrive| drive.held.iter().any(|held| !held);
        let fitted: Vec<usize> = (0..drives.len()).filter(|place| is_fitted(&drives[*place])).collect();
        if fitted.len() < LEAST_DRIVES {
            return self;
        }
        let groups = fitted.len().min(MOST_GROUPS);
        count_searches(drives, groups);
        let group = |number: usize| fitted.iter().copied().skip(number).step_by(groups);
        let without: Vec<Vec<f64>> =
            (0..groups).into_par_iter().map(|number| self.without(drives, group(number))).collect();
        let factor = |place: usize| {
            let variance = self.covariance[(place, place)];
            if self.free[place].of != Scope::Car || variance <= 0.0 {
                return 1.0;
            }
            let values = || without.iter().map(|at| at[place]);
            let mean = values().sum::<f64>() / groups as f64;
            let squares: f64 = values().map(|value| (value - mean).powi(2)).sum();
            let among_drives = squares * (groups - 1) as f64 / groups as f64;
            (among_drives / variance).sqrt().max(1.0)
        };
        let factors: Vec<f64> = (0..self.at.len()).map(factor).collect();
        let (rows, columns) = self.covariance.shape();
        self.covariance =
            DMatrix::from_fn(rows, columns, |i, j| self.covariance[(i, j)] * factors[i] * factors[j]);
        self
    }

    /// Where the numbers come to without a group of drives.
    fn without(&self, drives: &[FreeDrive], group: impl Iterator<Item = usize>) -> Vec<f64> {
        let mut others = drives.to_vec();
        group.for_each(|place| others[place].counts.fill(false));
        let scale = Scale { noise: self.noise, memory: self.time_constants_s.map(Scale::memory_of) };
        let problem = Problem { model: &self.model, free: &self.free, drives: &others };
        // From what was thought of the car: near the answer of all a search would stay in its valley.
        let start = |(free, at): (&Free, &f64)| if free.of == Scope::Car { free.prior.0 } else { *at };
        let start = self.free.iter().zip(&self.at).map(start).collect();
        let (_, at) = problem.search(start, &scale, STEPS[1]);
        at
    }
}

#[cfg(test)]
mod tests {
    use super::super::super::bench::recorded_as;
    use super::super::answer::{Asked, Ordinary};
    use physics::model::{TireKind, Uncertain};

    /// GIVEN four drives, each on rear tires of another stiffness WHEN one car is fitted to all THEN its stiffness is known no better
    /// than the mean of four that differ so much, and it is known better where the tires were the same.
    #[test]
    #[ignore = "long: eight drives fitted"]
    fn what_differs_from_drive_to_drive_is_not_known_well() {
        let stiffness = |of_drives: [f64; 4]| {
            let drive = |(seed, stiffness): (u64, f64)| {
                recorded_as("", |scenario| {
                    scenario.seed = seed;
                    scenario.vehicle.tire = TireKind::MagicFormula;
                    scenario.vehicle.lateral_stiffness_rear = Uncertain::known(stiffness);
                })
            };
            let (vehicles, recordings): (Vec<_>, Vec<_>) = (1..).zip(of_drives).map(drive).unzip();
            let found = Ordinary::of(&vehicles[0], &[], &recordings, Asked::CAR).unwrap();
            let number = found.numbers.iter().find(|number| number.name == "lateral_stiffness_rear");
            number.unwrap().estimate
        };
        let same = stiffness([14.0; 4]);
        let apart = stiffness([12.0, 13.0, 15.0, 16.0]);
        // Four numbers of a deviation of 1.8 have a mean of 0.9.
        assert!((0.6..2.0).contains(&apart.std), "{apart:?}");
        assert!((apart.value - 14.0).abs() < 3.0 * apart.std, "{apart:?}");
        assert!(same.std < 0.5 * apart.std && (same.value - 14.0).abs() < 0.5, "{same:?} {apart:?}");
    }
}
