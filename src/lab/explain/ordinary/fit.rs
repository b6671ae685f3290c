//! Fits the numbers of a model to drives by free runs: robust least squares, several starts, and what the residuals'
//! own length of memory leaves of their count.

use nalgebra::DMatrix;

use super::damped::damped_step;
use super::grid::STEP_S;
use super::inputs::FreeDrive;
use super::numbers::{Free, Number};
use super::problem::{Normal, Problem, Scale};
use super::run::Predicted;
use crate::explain::model::{Model, Place};
use identify::Parameter;
use predict::delay::Delayed;

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

/// Steps from each start, and from the best two of them. Numerical.
pub(super) const STEPS: [usize; 2] = [8, 25];

/// Rounds of learning the residuals' size.
const ROUNDS: usize = 2;

/// From so few drives their scatter tells nothing. Statistical: with four its deviation is known to 40 %.
pub(super) const LEAST_DRIVES: usize = 4;

/// The search stops where a step gains less than this share.
const LEAST_GAIN: f64 = 1e-4;

/// Slopes are kept as long as a step gains this share of what the steps before it have gained with them. Numerical.
const STILL_SERVES: f64 = 0.1;

/// How far apart the starts are: factor of the stiffnesses, friction, delay of the steering, s. The first four are
/// the yardstick's; from the last one a car with passengers finds its friction (`free_runs`).
const STARTS: [(f64, f64, f64); 5] =
    [(1.0, 1.0, 0.0), (2.0, 1.0, 0.1), (1.0, 0.5, 0.0), (1.5, 0.8, -0.1), (1.0, 1.5, 0.0)];

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

/// The same from where another model of the car has ended: what both have is nearly known, and the other's starts serve for both.
pub fn fit_from<'a>(
    model: &Model<'a>,
    free: Vec<Free>,
    drives: &[FreeDrive],
    other: &FreeFit<'_>,
) -> FreeFit<'a> {
    let carried = |coordinates: &[f64]| -> Vec<f64> {
        let there = |own: &Free| {
            let mut all = other.free.iter().zip(coordinates);
            all.find(|(free, _)| own.is_same(model, free, &other.model)).map(|(_, coordinate)| *coordinate)
        };
        free.iter().map(|own| there(own).unwrap_or(own.prior.0).clamp(own.bounds.0, own.bounds.1)).collect()
    };
    let problem = Problem { model, free: &free, drives };
    let starts = other.starts.iter().map(|(from, to, cost)| (carried(from), carried(to), *cost));
    FreeFit { starts: starts.collect(), ..problem.refined(carried(&other.at), problem.first_scale()) }
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

/// So many fits to these drives begin, and count.
pub fn begin_counting(drives: &[FreeDrive], fits: usize) {
    if let [first, ..] = drives {
        first.work.begin(fits * counts(drives));
    }
}

/// So many more follow that begin where another one has ended.
pub fn count_more(drives: &[FreeDrive], fits: usize) {
    expect(drives, fits * ROUNDS * counted(STEPS[1]) * points(drives));
}

/// So many searches follow from where a fit has ended.
pub(super) fn count_searches(drives: &[FreeDrive], searches: usize) {
    expect(drives, searches * counted(STEPS[1]) * points(drives));
}

fn expect(drives: &[FreeDrive], steps: usize) {
    if let [first, ..] = drives {
        first.work.expect(steps);
    }
}

/// What a fit to these drives counts.
fn counts(drives: &[FreeDrive]) -> usize {
    let of_all = points(drives);
    let of_pilot =
        drives.get(liveliest(drives)).map_or(0, FreeDrive::points).min((PILOT_S / STEP_S) as usize);
    let [short, long] = STEPS.map(counted);
    let from_starts = STARTS.len() * short + 2 * long;
    let rounds = ROUNDS + usize::from(of_pilot < of_all);
    from_starts * of_pilot + rounds * long * of_all
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

impl<'a> Problem<'_, 'a> {
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

    /// Levenberg's and Marquardt's search within the bounds, with slopes that are kept as long as they serve: they are nearly
    /// all of the computing. Returns the cost and the end.
    pub(super) fn search(&self, from: Vec<f64>, scale: &Scale, steps: usize) -> (f64, Vec<f64>) {
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
                    let (information, gradient) = (&normal.information, &normal.gradient);
                    let step = damped_step(information, gradient, damping, self.free, &at);
                    let next = step.unwrap_or_else(|| at.clone());
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
}
