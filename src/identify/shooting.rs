//! All segments together: their common parameters, the start of each, and what ties them.
//!
//! Each segment is simulated from a start of its own (multiple shooting), and pays for it where that
//! differs from the end of the one before, as much as [`Tie`] says:
//!
//! | tie | what it is |
//! |---|---|
//! | none | segments on their own: any model error of the past is forgotten |
//! | some | process noise, gathered over a segment: a prediction-error method |
//! | tight | one simulation through everything: output error, free run |
//!
//! The normal equations of a Gauss–Newton step are block tridiagonal (3 × 3) with the parameters as border;
//! the blocks are eliminated from the first segment to the last, so that a step's cost grows with the length of
//! the recordings only.

use nalgebra::{DMatrix, DVector, Matrix3, Vector3};
use rayon::prelude::*;

use super::car::PlainCar;
use super::free::Free;
use super::longitudinal_input::LongitudinalInput;
use super::motion::{Output, State};
use super::normal_equations::{Block, Border, Linearized, Point, Score};
use super::parameter::Values;
use super::segment::{LANES, Segment, trace};
use super::segment_sums::SegmentSums;
use physics::model::{Dual, Real, Vehicle};

/// How the start of a segment is tied to the end of the one before: standard deviation of what may
/// come between, in the state's units; infinite for segments on their own.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Tie(pub(super) State<f64>);

impl Tie {
    /// Segments on their own.
    pub(super) const NONE: Self = Self([f64::INFINITY; 3]);
    /// One simulation through everything, to rounding.
    pub(super) const TIGHT: Self = Self([1e-5, 1e-5, 1e-6]);

    fn weight(&self) -> Vector3<f64> {
        Vector3::from_fn(|i, _| if self.0[i].is_finite() { 1.0 / (self.0[i] * self.0[i]) } else { 0.0 })
    }
}

/// What is known of a segment's start without the equations: measured speed and yaw rate, and that no
/// car drifts much.
const START_STD: State<f64> = [0.5, 2.0, 0.1];

/// All there is to fit.
#[derive(Clone, Debug)]
pub(super) struct Problem<'a> {
    pub(super) vehicle: &'a Vehicle,
    pub(super) values: &'a Values,
    pub(super) free: &'a [Free],
    pub(super) segments: &'a [Segment],
    pub(super) drive: LongitudinalInput,
    /// 1 / noise² by channel.
    pub(super) weight: [f64; Output::COUNT],
    pub(super) tie: Tie,
}

/// The same, weighted and summed over the channels, parameters apart from start.
#[derive(Clone, Debug)]
struct Own {
    gradient: DVector<f64>,
    information: DMatrix<f64>,
    start_gradient: Vector3<f64>,
    start_information: Matrix3<f64>,
    border: Border,
    end: Vector3<f64>,
    end_by_start: Matrix3<f64>,
    end_by_theta: Border,
}

impl Own {
    fn new(said: &SegmentSums, weight: &[f64; Output::COUNT], count: usize) -> Self {
        let mut gradient = DVector::zeros(count + 3);
        let mut information = DMatrix::zeros(count + 3, count + 3);
        for sums in &said.channels {
            gradient += weight[sums.channel] * &sums.gradient;
            information += weight[sums.channel] * &sums.information;
        }
        Self {
            start_gradient: Vector3::from_fn(|i, _| gradient[count + i]),
            start_information: Matrix3::from_fn(|i, j| information[(count + i, count + j)]),
            border: Border::from_fn(count, |i, j| information[(count + i, j)]),
            gradient: gradient.rows(0, count).into_owned(),
            information: information.view((0, 0), (count, count)).into_owned(),
            end: said.end,
            end_by_start: Matrix3::from_fn(|i, j| said.end_by[(i, count + j)]),
            end_by_theta: Border::from_fn(count, |i, j| said.end_by[(i, j)]),
        }
    }
}

impl Problem<'_> {
    /// Values of all parameters at a point.
    pub(super) fn values_at(&self, theta: &DVector<f64>) -> Values {
        let mut values = self.values.clone();
        for (free, coordinate) in self.free.iter().zip(theta.iter()) {
            free.parameters.put(&mut values, free.value(*coordinate));
        }
        values
    }

    /// Simulates everything, with derivatives.
    pub(super) fn linearize(&self, point: &Point) -> Linearized {
        let count = self.free.len() + 3;
        let passes = count.div_ceil(LANES);
        let cars: Vec<_> = (0..passes).map(|pass| self.car(&point.theta, pass * LANES)).collect();
        let channels = self.channels();
        let said = (0..self.segments.len()).into_par_iter().map(|place| {
            let traces = cars.iter().enumerate().map(|(pass, car)| {
                let start = std::array::from_fn(|i| {
                    let value = point.starts[place][i];
                    match (self.free.len() + i).checked_sub(pass * LANES) {
                        Some(lane) if lane < LANES => Dual::variable(value, lane),
                        _ => Dual::constant(value),
                    }
                });
                trace(&self.segments[place], car, self.drive, start, &channels)
            });
            SegmentSums::new(&traces.collect::<Vec<_>>(), &channels, count)
        });
        self.gather(point, said.collect())
    }

    /// The same simulation with other weights or ties.
    pub(super) fn weigh_anew(&self, point: &Point, all: Linearized) -> Linearized {
        self.gather(point, all.said)
    }

    /// Channels that count and are measured somewhere.
    fn channels(&self) -> Vec<usize> {
        let is_measured = |channel: usize| {
            self.segments.iter().any(|segment| segment.measured.iter().any(|row| !row[channel].is_nan()))
        };
        (0..Output::COUNT).filter(|channel| self.weight[*channel] > 0.0 && is_measured(*channel)).collect()
    }

    /// The car with derivatives by the free parameters from `first` on.
    fn car(&self, theta: &DVector<f64>, first: usize) -> PlainCar<Dual<LANES>> {
        let values = self.values_at(theta);
        PlainCar::new(self.vehicle, self.drive, |parameter| {
            let mut number = Dual::constant(values.get(parameter));
            for (place, free) in self.free.iter().enumerate() {
                if free.parameters.is(parameter)
                    && let Some(lane) = place.checked_sub(first)
                    && lane < LANES
                {
                    number.by[lane] = free.parameters.value_by_coordinate(theta[place]);
                }
            }
            number
        })
    }

    fn gather(&self, point: &Point, said: Vec<SegmentSums>) -> Linearized {
        let count = self.free.len();
        let mut all = Linearized {
            cost: 0.0,
            squares: [0.0; Output::COUNT],
            gradient: DVector::zeros(count),
            information: DMatrix::zeros(count, count),
            blocks: Vec::with_capacity(said.len()),
            scores: Vec::with_capacity(said.len()),
            jumps: Vec::with_capacity(said.len()),
            jump_covariance: Vec::with_capacity(said.len()),
            said: Vec::new(),
        };
        for (place, free) in self.free.iter().enumerate() {
            if free.std.is_finite() {
                let weight = 1.0 / (free.std * free.std);
                let off = point.theta[place] - free.mean;
                all.cost += weight * off * off;
                all.gradient[place] += weight * off;
                all.information[(place, place)] += weight;
            }
        }
        let tie = self.tie.weight();
        let weighed: Vec<Own> = said.iter().map(|said| Own::new(said, &self.weight, count)).collect();
        for (place, (said, own)) in said.iter().zip(&weighed).enumerate() {
            for sums in &said.channels {
                all.cost += self.weight[sums.channel] * sums.square;
                all.squares[sums.channel] += sums.square;
            }
            all.gradient += &own.gradient;
            all.information += &own.information;
            let mut score =
                Score { theta: own.gradient.clone(), own: own.start_gradient, before: Vector3::zeros() };
            let mut block = Block {
                gradient: own.start_gradient,
                information: own.start_information,
                next: Matrix3::zeros(),
                border: own.border.clone(),
            };
            let segment = &self.segments[place];
            let before = place.checked_sub(1).filter(|_| segment.continues);
            if before.is_none() || tie[0] == 0.0 {
                for (i, std) in START_STD.into_iter().enumerate() {
                    let weight = 1.0 / (std * std);
                    let off = point.starts[place][i] - segment.start[i];
                    all.cost += weight * off * off;
                    block.gradient[i] += weight * off;
                    block.information[(i, i)] += weight;
                }
            }
            let mut jump = Vector3::from_element(f64::NAN);
            let mut covariance = None;
            if let Some(before) = before {
                let earlier = &weighed[before];
                jump = point.starts[place] - earlier.end;
                let inverse = |m: &Matrix3<f64>| m.try_inverse();
                covariance = inverse(&own.start_information).zip(inverse(&earlier.start_information)).map(
                    |(here, there)| here + earlier.end_by_start * there * earlier.end_by_start.transpose(),
                );
                if tie[0] > 0.0 {
                    let weight = Matrix3::from_diagonal(&tie);
                    let pull = weight * jump;
                    all.cost += jump.dot(&pull);
                    block.gradient += pull;
                    block.information += weight;
                    let by_start = &earlier.end_by_start;
                    let by_theta = &earlier.end_by_theta;
                    score.theta -= by_theta.transpose() * pull;
                    score.own += pull;
                    score.before -= by_start.transpose() * pull;
                    all.gradient -= by_theta.transpose() * pull;
                    all.information += by_theta.transpose() * weight * by_theta;
                    block.border -= weight * by_theta;
                    if let Some(last) = all.blocks.last_mut() {
                        let last: &mut Block = last;
                        last.gradient -= by_start.transpose() * pull;
                        last.information += by_start.transpose() * weight * by_start;
                        last.border += by_start.transpose() * weight * by_theta;
                        last.next = -(by_start.transpose() * weight);
                    }
                }
            }
            all.jumps.push(jump);
            all.jump_covariance.push(covariance);
            all.blocks.push(block);
            all.scores.push(score);
        }
        all.said = said;
        all
    }
}
