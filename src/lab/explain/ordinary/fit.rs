//! Fits the numbers of a model to drives by free runs: robust least squares, several starts, and what the residuals'
//! own length of memory leaves of their count.

use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;

use super::grid::STEP_S;
use super::inputs::{BLOCK_POINTS, FreeDrive};
use super::numbers::{Free, Number, placed};
use super::robust::{deviation, loss, memory, weight};
use super::run::{Predicted, run};
use crate::explain::model::{Model, Place};
use crate::explain::predict::car::Compute;
use crate::explain::predict::delay::Delayed;
use crate::identify::Parameter;

/// A fitted model.
#[derive(Clone, Debug)]
pub struct FreeFit<'a> {
    /// The model that the coordinates are put into.
    pub model: Model<'a>,
    /// What was free.
    pub free: Vec<Free>,
    /// Where it is.
    pub at: Vec<f64>,
    /// Covariance of the coordinates.
    pub covariance: DMatrix<f64>,
    /// What the model says of each drive.
    pub predicted: Vec<Predicted>,
    /// Robust deviation of the residuals of yaw rate and lateral acceleration.
    pub noise: [f64; 2],
    /// How long they remember, s.
    pub time_constants_s: [f64; 2],
    /// Where the searches began and came to in their first steps, with the cost there.
    pub starts: Vec<FreeStart>,
}

/// A search: from, to, cost.
pub type FreeStart = (Vec<f64>, Vec<f64>, f64);

/// Of so many grid points one is fitted to: residuals next to each other say the same.
const EVERY: usize = 3;

/// Steps from each start, and from the best two of them. Numerical.
const STEPS: [usize; 2] = [8, 25];

/// Rounds of learning the residuals' size.
const ROUNDS: usize = 2;

/// From so few drives their scatter tells nothing. Statistical: with four its deviation is known to 40 %.
const LEAST_DRIVES: usize = 4;

/// The search stops where a step gains less than this share.
const LEAST_GAIN: f64 = 1e-4;

/// Slopes are kept as long as a step gains this share of what the steps before it have gained with them. Numerical.
const STILL_SERVES: f64 = 0.1;

/// How far apart the starts are: factor of the stiffnesses, friction, delay of the steering, s. The first four are
/// the yardstick's; from the last one a car with passengers finds its friction (`free_runs`).
const STARTS: [(f64, f64, f64); 5] =
    [(1.0, 1.0, 0.0), (2.0, 1.0, 0.1), (1.0, 0.5, 0.0), (1.5, 0.8, -0.1), (1.0, 1.5, 0.0)];

/// What a residual is divided by: size of a channel, and the memory of its residuals in points.
#[derive(Clone, Copy, Debug)]
pub struct Scale {
    noise: [f64; 2],
    memory: [f64; 2],
}

impl Scale {
    /// 1 + 2 Σ ρ of a first-order noise is twice its time constant over the rows' distance.
    fn time_constant(memory: f64) -> f64 {
        0.5 * memory * EVERY as f64 * STEP_S
    }

    /// The other way round.
    pub fn memory_of(time_constant_s: f64) -> f64 {
        2.0 * time_constant_s / (EVERY as f64 * STEP_S)
    }
}

/// A problem.
#[derive(Clone, Copy)]
pub struct Problem<'p, 'a> {
    /// What is fitted …
    pub model: &'p Model<'a>,
    /// … by these numbers of it …
    pub free: &'p [Free],
    /// … to the fitted part of these.
    pub drives: &'p [FreeDrive],
}

/// By drive: for each number that it has, how the residuals of both channels change with it.
type Slopes = Vec<Vec<(usize, Vec<[f64; 2]>)>>;

/// Normal equations at a point.
struct Normal {
    information: DMatrix<f64>,
    gradient: DVector<f64>,
    /// Outer products of the gradients of the blocks …
    scatter: DMatrix<f64>,
    /// … and of the drives.
    scatter_of_drives: DMatrix<f64>,
}

/// Fits to the training part.
pub fn fit<'a>(model: &Model<'a>, free: Vec<Free>, drives: &[FreeDrive]) -> FreeFit<'a> {
    let pilot = liveliest(drives);
    let part = drives[pilot].liveliest(PILOT_S);
    let is_all = drives.len() == 1 && part.points() == drives[pilot].points();
    let of_pilot: Vec<usize> = (0..free.len()).filter(|place| free[*place].of.has(pilot)).collect();
    let own: Vec<Free> = of_pilot.iter().map(|place| free[*place].alone()).collect();
    let (mut starts, best) =
        Problem { model, free: &own, drives: std::slice::from_ref(&part) }.search_from_all_starts();
    // The other recordings' own numbers are where they were thought to be.
    let everywhere = |from_pilot: &[f64]| {
        let mut all: Vec<f64> = free.iter().map(|free| free.prior.0).collect();
        for (place, coordinate) in of_pilot.iter().zip(from_pilot) {
            all[*place] = *coordinate;
        }
        all
    };
    for (from, to, _) in &mut starts {
        (*from, *to) = (everywhere(from), everywhere(to));
    }
    let problem = Problem { model, free: &free, drives };
    let first = problem.first_scale();
    let mut best = everywhere(&best);
    if !is_all {
        (_, best) = problem.search(best, &first, STEPS[1]);
    }
    FreeFit { starts, ..problem.refined(best, first) }
}

fn points(drives: &[FreeDrive]) -> usize {
    drives.iter().map(FreeDrive::points).sum()
}

/// So much of the liveliest drive is searched from all starts, s: far from the answer more would add computing only.
/// Numerical: long enough to have all kinds of curves.
const PILOT_S: f64 = 120.0;

/// So many steps of a search are counted: one that may take 25 mostly ends after some. Tuned by three recordings.
const fn counted(steps: usize) -> usize {
    if steps > STEPS[0] { 5 } else { steps }
}

/// What so many fits to these drives count.
pub fn begin_counting(drives: &[FreeDrive], fits: usize) {
    let of_all = points(drives);
    let of_pilot =
        drives.get(liveliest(drives)).map_or(0, FreeDrive::points).min((PILOT_S / STEP_S) as usize);
    let [short, long] = STEPS.map(counted);
    let from_starts = STARTS.len() * short + 2 * long;
    let rounds = ROUNDS + usize::from(of_pilot < of_all);
    if let [first, ..] = drives {
        first.work.begin(fits * (from_starts * of_pilot + rounds * long * of_all));
    }
}

/// The drive that tells most of a car: in which it turns most.
fn liveliest(drives: &[FreeDrive]) -> usize {
    let turning = |drive: &FreeDrive| -> f64 {
        let fitted =
            drive.yaw_rate.iter().zip(&drive.held).filter(|(rate, held)| !**held && rate.is_finite());
        fitted.map(|(rate, _)| rate * rate).sum()
    };
    (0..drives.len()).max_by(|a, b| turning(&drives[*a]).total_cmp(&turning(&drives[*b]))).unwrap_or(0)
}

impl<'p, 'a> Problem<'p, 'a> {
    /// Where the searches begin and come to in their first steps, and the best of their ends.
    fn search_from_all_starts(&self) -> (Vec<FreeStart>, Vec<f64>) {
        let first = self.first_scale();
        let path = |start: &(f64, f64, f64)| {
            let start = self.start(*start);
            let (cost, end) = self.search(start.clone(), &first, STEPS[0]);
            (start, end, cost)
        };
        let mut paths: Vec<FreeStart> = STARTS.iter().map(path).collect();
        paths.sort_by(|a, b| a.2.total_cmp(&b.2));
        let ends = paths.iter().take(2).map(|(_, end, _)| self.search(end.clone(), &first, STEPS[1]));
        let best = ends.min_by(|a, b| a.0.total_cmp(&b.0)).map(|(_, end)| end).unwrap_or_default();
        (paths, best)
    }

    /// Learns the residuals' size and memory, and fits again.
    fn refined(&self, from: Vec<f64>, first: Scale) -> FreeFit<'a> {
        let (mut at, mut scale) = (from, first);
        for _ in 0..ROUNDS {
            scale = self.learned(&self.predict(&at), scale);
            (_, at) = self.search(at, &scale, STEPS[1]);
        }
        let predicted = self.predict(&at);
        let slopes = self.slopes(&at, &predicted);
        let Normal { information, scatter, scatter_of_drives, .. } =
            self.normal(&at, &predicted, &slopes, &scale);
        let inverse = information.clone().try_inverse().unwrap_or_else(|| DMatrix::zeros(at.len(), at.len()));
        // The curvature, or the scatter from block to block where that is more (White 1982), or from drive to drive:
        // what a model lacks is alike all along a drive (Liang and Zeger 1986).
        let mut robust = vec![&inverse * scatter * &inverse];
        if self.drives.len() >= LEAST_DRIVES {
            let drives = self.drives.len() as f64;
            robust.push(&inverse * scatter_of_drives * &inverse * (drives / (drives - 1.0)));
        }
        let variance =
            |i: usize| robust.iter().fold(inverse[(i, i)], |most, robust| most.max(robust[(i, i)]));
        let widen = |i: usize| (variance(i) / inverse[(i, i)].max(1e-300)).sqrt();
        let widths: Vec<f64> = (0..at.len()).map(widen).collect();
        let covariance = DMatrix::from_fn(at.len(), at.len(), |i, j| inverse[(i, j)] * widths[i] * widths[j]);
        FreeFit {
            model: self.model.clone(),
            free: self.free.to_vec(),
            at,
            covariance,
            predicted,
            noise: scale.noise,
            starts: Vec::new(),
            time_constants_s: scale.memory.map(Scale::time_constant),
        }
    }

    /// The priors' means with other stiffnesses, friction and delay.
    fn start(&self, (stiffer, friction, delay): (f64, f64, f64)) -> Vec<f64> {
        let of = |free: &Free| {
            let mean = free.prior.0;
            let (low, high) = free.bounds;
            let start = match free.number {
                Number::Of(Place::Ordinary(Parameter::LateralFront | Parameter::LateralRear)) => {
                    mean + stiffer.ln()
                }
                Number::Of(Place::Ordinary(Parameter::Friction)) => mean + friction.ln(),
                Number::Of(Place::Delay(Delayed::Steering)) => mean + delay,
                _ => mean,
            };
            start.clamp(low, high)
        };
        self.free.iter().map(of).collect()
    }

    fn predict(&self, at: &[f64]) -> Vec<Predicted> {
        (0..self.drives.len()).into_par_iter().map(|drive| self.predict_one(at, drive)).collect()
    }

    fn predict_one(&self, at: &[f64], drive: usize) -> Predicted {
        let (model, sensing) = placed(self.model, self.free, at, drive);
        run(&self.drives[drive], &model.car(), sensing, Compute::Motion)
    }

    /// Residuals of both channels at every so many grid points, not a number where there are none.
    pub fn residuals(&self, drive: &FreeDrive, predicted: &Predicted) -> Vec<[f64; 2]> {
        let at = |i: usize| {
            if !drive.counts[i] || drive.held[i] {
                return [f64::NAN; 2];
            }
            let lateral =
                drive.lateral.as_ref().map_or(f64::NAN, |lateral| lateral[i] - predicted.lateral[i]);
            [drive.yaw_rate[i] - predicted.yaw_rate[i], lateral]
        };
        (0..drive.points()).step_by(EVERY).map(at).collect()
    }

    /// A tenth of what the channels do: enough to begin with.
    fn first_scale(&self) -> Scale {
        let spread = |of: &dyn Fn(&FreeDrive) -> Option<Vec<f64>>| {
            let all: Vec<f64> =
                self.drives.iter().filter_map(of).flatten().filter(|v| v.is_finite()).collect();
            let mean = all.iter().sum::<f64>() / all.len().max(1) as f64;
            let square = all.iter().map(|v| (v - mean) * (v - mean)).sum::<f64>() / all.len().max(1) as f64;
            0.1 * square.sqrt()
        };
        let yaw = spread(&|drive| Some(drive.yaw_rate.clone())).max(1e-3);
        let lateral = spread(&|drive| drive.lateral.clone()).max(0.05);
        Scale { noise: [yaw, lateral], memory: [8.0, 8.0] }
    }

    /// Size and memory of the residuals.
    fn learned(&self, predicted: &[Predicted], before: Scale) -> Scale {
        let mut scale = before;
        let series: Vec<Vec<[f64; 2]>> = self
            .drives
            .iter()
            .zip(predicted)
            .map(|(drive, predicted)| self.residuals(drive, predicted))
            .collect();
        for channel in 0..2 {
            let errors = series.iter().flatten().map(|row| row[channel]);
            if errors.clone().filter(|error| error.is_finite()).count() < 50 {
                continue;
            }
            scale.noise[channel] = deviation(errors).unwrap_or(0.0).max(1e-6);
            scale.memory[channel] = memory(&series, channel);
        }
        scale
    }

    /// What is made as small as can be.
    fn cost(&self, at: &[f64], predicted: &[Predicted], scale: &Scale) -> f64 {
        let mut cost = self.prior_cost(at);
        for (drive, predicted) in self.drives.iter().zip(predicted) {
            for row in self.residuals(drive, predicted) {
                for (channel, error) in row.into_iter().enumerate().filter(|(_, error)| error.is_finite()) {
                    cost += loss(error / scale.noise[channel]) / scale.memory[channel];
                }
            }
        }
        cost
    }

    /// What is thought of the numbers, −2 ln.
    pub fn prior_cost(&self, at: &[f64]) -> f64 {
        let off = |(free, at): (&Free, &f64)| ((at - free.prior.0) / free.prior.1).powi(2);
        self.free.iter().zip(at).map(off).sum()
    }

    /// How the residuals of each drive change with the numbers that it has, by differences.
    fn slopes(&self, at: &[f64], predicted: &[Predicted]) -> Slopes {
        let count = self.free.len();
        let tasks: Vec<(usize, usize)> = (0..self.drives.len())
            .flat_map(|drive| (0..count).map(move |place| (drive, place)))
            .filter(|(drive, place)| self.free[*place].of.has(*drive))
            .collect();
        let moved = |(drive, place): (usize, usize)| {
            let mut there = at.to_vec();
            let free = &self.free[place];
            // Inwards from an upper bound.
            let step = if at[place] + free.step > free.bounds.1 { -free.step } else { free.step };
            there[place] += step;
            let by = self.residuals(&self.drives[drive], &self.predict_one(&there, drive));
            let here = self.residuals(&self.drives[drive], &predicted[drive]);
            let slopes =
                here.iter().zip(by).map(|(here, by)| [(here[0] - by[0]) / step, (here[1] - by[1]) / step]);
            (drive, place, slopes.collect::<Vec<_>>())
        };
        let mut slopes: Slopes = vec![Vec::new(); self.drives.len()];
        for (drive, place, column) in tasks.into_par_iter().map(moved).collect::<Vec<_>>() {
            slopes[drive].push((place, column));
        }
        slopes
    }

    /// Gauss–Newton's normal equations.
    fn normal(&self, at: &[f64], predicted: &[Predicted], slopes: &Slopes, scale: &Scale) -> Normal {
        let count = self.free.len();
        let mut normal = Normal {
            information: DMatrix::zeros(count, count),
            gradient: DVector::zeros(count),
            scatter: DMatrix::zeros(count, count),
            scatter_of_drives: DMatrix::zeros(count, count),
        };
        for ((drive, predicted), columns) in self.drives.iter().zip(predicted).zip(slopes) {
            self.add(&mut normal, drive, predicted, columns, scale);
        }
        for (i, free) in self.free.iter().enumerate() {
            let weight = 1.0 / (free.prior.1 * free.prior.1);
            normal.information[(i, i)] += weight;
            normal.gradient[i] += weight * (free.prior.0 - at[i]);
        }
        normal
    }

    /// What one drive says.
    fn add(
        &self,
        normal: &mut Normal,
        drive: &FreeDrive,
        predicted: &Predicted,
        columns: &[(usize, Vec<[f64; 2]>)],
        scale: &Scale,
    ) {
        let own = columns.len();
        let per_block = BLOCK_POINTS / EVERY;
        let mut information = DMatrix::<f64>::zeros(own, own);
        let mut of_block = DVector::<f64>::zeros(own);
        let mut of_drive = DVector::<f64>::zeros(own);
        let mut slopes = vec![0.0; own];
        let residuals = self.residuals(drive, predicted);
        for (row, errors) in residuals.iter().enumerate() {
            for channel in 0..2 {
                let error = errors[channel] / scale.noise[channel];
                if !error.is_finite() {
                    continue;
                }
                let weight = weight(error) / scale.memory[channel];
                for (slope, (_, column)) in slopes.iter_mut().zip(columns) {
                    *slope = column[row][channel] / scale.noise[channel];
                }
                for i in 0..own {
                    of_block[i] += weight * slopes[i] * error;
                    for j in 0..=i {
                        information[(i, j)] += weight * slopes[i] * slopes[j];
                    }
                }
            }
            if (row + 1) % per_block == 0 || row + 1 == residuals.len() {
                for (i, (at, _)) in columns.iter().enumerate() {
                    normal.gradient[*at] += of_block[i];
                    for (j, (to, _)) in columns.iter().enumerate() {
                        normal.scatter[(*at, *to)] += of_block[i] * of_block[j];
                    }
                }
                of_drive += &of_block;
                of_block.fill(0.0);
            }
        }
        for (i, (at, _)) in columns.iter().enumerate() {
            for (j, (to, _)) in columns.iter().enumerate() {
                normal.scatter_of_drives[(*at, *to)] += of_drive[i] * of_drive[j];
                normal.information[(*at, *to)] += information[(i.max(j), i.min(j))];
            }
        }
    }

    /// Levenberg's and Marquardt's search within the bounds, with slopes that are kept as long as they serve: they are nearly
    /// all of the computing. Returns the cost and the end.
    fn search(&self, from: Vec<f64>, scale: &Scale, steps: usize) -> (f64, Vec<f64>) {
        let mut at = from;
        let mut predicted = self.predict(&at);
        let mut cost = self.cost(&at, &predicted, scale);
        let mut damping = 1e-2;
        let mut taken = 0;
        for _ in 0..steps {
            let slopes = self.slopes(&at, &predicted);
            taken += 1;
            self.count(usize::from(taken <= counted(steps)));
            let (start, mut tries) = (cost, 5);
            loop {
                let normal = self.normal(&at, &predicted, &slopes, scale);
                let before = cost;
                for _ in 0..tries {
                    let next = self.stepped(&at, &normal, damping);
                    let there = self.predict(&next);
                    let cost_there = self.cost(&next, &there, scale);
                    if cost_there < cost {
                        (at, predicted, cost) = (next, there, cost_there);
                        damping = (0.2 * damping).max(1e-8);
                        break;
                    }
                    damping *= 8.0;
                }
                let serves = before - cost > STILL_SERVES * (start - before).max(LEAST_GAIN * start);
                if !serves {
                    break;
                }
                // Where they do not serve, it is not for want of damping.
                tries = 1;
            }
            if start - cost < LEAST_GAIN * start {
                break;
            }
        }
        // The rest, where it has come to its end early.
        self.count(counted(steps).saturating_sub(taken));
        (cost, at)
    }

    /// Counts steps.
    fn count(&self, steps: usize) {
        if let [first, ..] = self.drives {
            first.work.add(steps * points(self.drives));
        }
    }

    /// A damped step; what would leave its bounds stays there, and the others make the best of that.
    fn stepped(&self, at: &[f64], normal: &Normal, damping: f64) -> Vec<f64> {
        let count = at.len();
        let mut is_held = vec![false; count];
        loop {
            let inside: Vec<usize> = (0..count).filter(|i| !is_held[*i]).collect();
            let information = DMatrix::from_fn(inside.len(), inside.len(), |i, j| {
                let value = normal.information[(inside[i], inside[j])];
                if i == j { value * (1.0 + damping) } else { value }
            });
            let mut gradient = DVector::from_fn(inside.len(), |i, _| normal.gradient[inside[i]]);
            for i in (0..count).filter(|i| is_held[*i]) {
                let by = self.at_bound(at, normal, i) - at[i];
                for (row, own) in inside.iter().enumerate() {
                    gradient[row] -= normal.information[(*own, i)] * by;
                }
            }
            let Some(step) = information.cholesky().map(|factor| factor.solve(&gradient)) else {
                return at.to_vec();
            };
            let mut next = at.to_vec();
            for i in (0..count).filter(|i| is_held[*i]) {
                next[i] = self.at_bound(at, normal, i);
            }
            let mut leaves = false;
            for (row, own) in inside.iter().enumerate() {
                let (low, high) = self.free[*own].bounds;
                next[*own] = at[*own] + step[row];
                if next[*own] < low || next[*own] > high {
                    is_held[*own] = true;
                    leaves = true;
                }
            }
            if !leaves {
                return next;
            }
        }
    }

    /// The bound that the slope of the cost points to.
    fn at_bound(&self, at: &[f64], normal: &Normal, i: usize) -> f64 {
        let (low, high) = self.free[i].bounds;
        let direct = normal.gradient[i] / normal.information[(i, i)].max(1e-300);
        if at[i] + direct > 0.5 * (low + high) { high } else { low }
    }
}
