//! One pass of the filter over a drive, with other cars beside it.
//!
//! The filter is made for one car. The others differ in one number each, and are corrected by the same gains. So the
//! difference of their innovations is the exact effect of that number, whatever states and delays it has. One pass
//! gives all derivatives by differences, and the drive need not be stored.

use std::ops::Range;

use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;

use super::algebra::Gain;
use super::car::ExtendedCar;
use super::drive::GriddedDrive;
use super::filter::Filter;
use super::grid::{STEP_S, points};
use super::noise::Noise;
use super::sums::{BLOCK_S, BlockOutput, BlockSums, Filtered, PassOptions, UsedReadings};
use super::trajectory::{Derivatives, Trajectory};

/// A car that differs from the one the filter is made for.
#[derive(Debug)]
pub struct Other {
    /// The car.
    pub car: ExtendedCar,
    /// By how much of something it differs.
    pub by: f64,
    /// Until when it is the same, s.
    pub same_until: f64,
}

impl Other {
    /// Does it differ by this grid point?
    fn differs(&self, k: usize) -> bool {
        k as f64 * STEP_S + AHEAD_S > self.same_until
    }
}

/// Readings may be so late, s, or ahead: so long before anything can be seen of it, a car that begins to differ
/// goes its own way. Physical: longer than any delay.
const AHEAD_S: f64 = 1.0;

/// The cars beside the one of the filter.
#[derive(Clone, Copy, Default)]
pub struct Beside<'a> {
    /// Those whose differences are regressed on together: the numbers of a fit.
    pub together: &'a [Other],
    /// Candidates. Each is regressed on beside the former only, so the cost is linear in their count.
    pub alone: &'a [Other],
}

/// One pass over all runs of a drive.
pub fn pass(
    (number, drive): (usize, &GriddedDrive),
    car: &ExtendedCar,
    beside: Beside<'_>,
    noise: &Noise,
    mut options: PassOptions<'_>,
) -> Vec<BlockSums> {
    let runs = drive.runs.iter();
    runs.flat_map(|run| pass_run((number, drive), *run, car, beside, noise, &mut options)).collect()
}

/// One pass over a run of a drive.
pub fn pass_run(
    (number, drive): (usize, &GriddedDrive),
    (from, to): (usize, usize),
    car: &ExtendedCar,
    beside: Beside<'_>,
    noise: &Noise,
    options: &mut PassOptions<'_>,
) -> Vec<BlockSums> {
    let mut all = Vec::new();
    let per_block = points(BLOCK_S);
    let mut filter = Filter::new((car, drive, noise), from);
    let mut together = Trajectories::start(beside.together, drive, from);
    let mut alone = Trajectories::start(beside.alone, drive, from);
    // The filter over one block, with where it was at its beginning. The blocks' borders are the drive's, not
    // the run's.
    let mut filtered = |filter: &mut Filter, k: usize| {
        let end = ((k / per_block + 1) * per_block).min(to);
        let begin = filter.trajectory.clone();
        let mut out = BlockOutput::new(number, (k, end));
        out.derivatives.reserve(end - k);
        for step in k..end {
            filter.step((car, drive, noise), (step, step == from), &mut out, options);
        }
        let BlockOutput { gains, errors, derivatives, sums } = out;
        (Block { drive, noise, steps: k..end, begin, gains, errors, derivatives }, sums)
    };
    let mut block = (from < to).then(|| filtered(&mut filter, from));
    while let Some((over, mut sums)) = block.take() {
        let end = over.steps.end;
        let mut go_on = || (end < to).then(|| filtered(&mut filter, end));
        let mut follow = || over.products(&mut together, &mut alone);
        // The filter goes ahead while the others follow.
        let has_others = !(beside.together.is_empty() && beside.alone.is_empty());
        let (next, products) = if has_others { rayon::join(go_on, follow) } else { (go_on(), follow()) };
        (sums.gram, sums.alone) = products;
        all.push(sums);
        block = next;
    }
    all
}

/// Steps that the filter has gone over.
struct Block<'a> {
    drive: &'a GriddedDrive,
    noise: &'a Noise,
    steps: Range<usize>,
    /// Where it was at their beginning.
    begin: Trajectory,
    gains: Vec<Gain>,
    errors: Vec<f64>,
    derivatives: Vec<Derivatives>,
}

impl Block<'_> {
    /// [`BlockSums::gram`] and [`BlockSums::alone`].
    fn products(
        &self,
        together: &mut Trajectories<'_>,
        alone: &mut Trajectories<'_>,
    ) -> (DMatrix<f64>, DMatrix<f64>) {
        let count = self.errors.len();
        let first = self.errors.iter().zip(&self.gains).map(|(error, gain)| error / gain.s.sqrt());
        let mut columns: Vec<f64> = first.collect();
        // One that is still the same makes no difference.
        for own in together.follow(self, |own| own) {
            columns.extend(own.unwrap_or_else(|| vec![0.0; count]));
        }
        let z = DMatrix::from_vec(count, together.others.len() + 1, columns);
        let of_one = |own: Vec<f64>| {
            let own = DVector::from_vec(own);
            let square = own.norm_squared();
            z.tr_mul(&own).push(square)
        };
        let mut by_one = DMatrix::zeros(z.ncols() + 1, alone.others.len());
        for (mut column, own) in by_one.column_iter_mut().zip(alone.follow(self, of_one)) {
            if let Some(own) = own {
                column.copy_from(&own);
            }
        }
        (z.transpose() * &z, by_one)
    }
}

/// Other cars on their way; those that are still the same as the first have no trajectory of their own.
struct Trajectories<'a> {
    others: &'a [Other],
    trajectories: Vec<Option<Trajectory>>,
}

impl<'a> Trajectories<'a> {
    fn start(others: &'a [Other], drive: &GriddedDrive, k: usize) -> Self {
        let trajectory = |other: &Other| other.differs(k).then(|| Trajectory::start(&other.car, drive, k));
        Self { others, trajectories: others.iter().map(trajectory).collect() }
    }

    /// Follows over a block: what is made of the innovations' derivatives by each difference, in standard deviations.
    fn follow<T: Send>(&mut self, over: &Block<'_>, of: impl Fn(Vec<f64>) -> T + Sync) -> Vec<Option<T>> {
        let own = |(trajectory, other): (&mut Option<Trajectory>, &Other)| {
            if trajectory.is_none() && other.differs(over.steps.end) {
                *trajectory = Some(over.begin.clone());
            }
            let trajectory = trajectory.as_mut()?;
            let mut errors = Vec::with_capacity(over.errors.len());
            for (step, derivatives) in over.steps.clone().zip(&over.derivatives) {
                let how = (over.gains.as_slice(), derivatives);
                trajectory.follow(&other.car, over.drive, step, over.noise, how, &mut errors);
            }
            for (own, (error, gain)) in errors.iter_mut().zip(over.errors.iter().zip(&over.gains)) {
                *own = (error - *own) * (1.0 / gain.s.sqrt()) / other.by;
            }
            Some(of(errors))
        };
        self.trajectories.par_iter_mut().zip(self.others).map(own).collect()
    }
}

/// Steps of the filter that are kept at a time, on the way back. Numerical: bounds the memory.
const KEPT: usize = points(60.0);

/// Goes over a drive with one car only, and then shows its steps, stretch by stretch from the end: the steps of a
/// stretch are made again, for those of an hour would fill the memory.
pub fn pass_backwards(
    drive: &GriddedDrive,
    car: &ExtendedCar,
    noise: &Noise,
    readings: UsedReadings,
    show: &mut impl FnMut(&[Filtered]),
) {
    let mut steps = Vec::new();
    for &(from, to) in drive.runs.iter().rev() {
        let mut filter = Filter::new((car, drive, noise), from);
        let mut out = BlockOutput::new(0, (from, to));
        let mut go = |filter: &mut Filter, k: usize, steps: Option<&mut Vec<Filtered>>| {
            let mut options = PassOptions { readings, innovations: None, steps };
            for step in k..(k + KEPT).min(to) {
                out.forget_steps();
                filter.step((car, drive, noise), (step, step == from), &mut out, &mut options);
            }
        };
        let mut begins: Vec<(usize, Filter)> = Vec::new();
        for k in (from..to).step_by(KEPT) {
            begins.push((k, filter.clone()));
            go(&mut filter, k, None);
        }
        for (k, mut filter) in begins.into_iter().rev() {
            steps.clear();
            go(&mut filter, k, Some(&mut steps));
            show(&steps);
        }
    }
}

/// Goes over a drive with one car only; `watch` sees it at the beginning of each step: the step, the end of
/// its run, and whether it begins one.
pub(super) fn pass_with(
    (number, drive): (usize, &GriddedDrive),
    car: &ExtendedCar,
    noise: &Noise,
    watch: &mut impl FnMut(&Trajectory, usize, usize, bool),
) {
    for &(from, to) in &drive.runs {
        let mut filter = Filter::new((car, drive, noise), from);
        let mut out = BlockOutput::new(number, (from, to));
        for step in from..to {
            watch(&filter.trajectory, step, to, step == from);
            out.forget_steps();
            filter.step((car, drive, noise), (step, step == from), &mut out, &mut PassOptions::default());
        }
    }
}
