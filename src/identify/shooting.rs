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
//! The equations of a Gauss–Newton step are a chain of 3 × 3 blocks with the parameters as its border;
//! it is eliminated from the first segment to the last, so that a step's cost grows with the length of
//! the recordings only.

use multiversion::multiversion;
use nalgebra::{DMatrix, DVector, Dyn, Matrix3, OMatrix, U3, Vector3};
use rayon::prelude::*;

use super::car::{Car, Drive};
use super::motion::{Channel, State};
use super::parameter::{Parameter, Values};
use super::segment::{Evidence, Segment};
use crate::model::{Dual, Real, Vehicle};

type Border = OMatrix<f64, U3, Dyn>;

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

/// A free parameter: where it is in the search's own coordinate.
#[derive(Clone, Copy, Debug)]
pub(super) struct Free {
    pub(super) parameters: Tied,
    /// Prior of the coordinate.
    pub(super) mean: f64,
    /// Zero information where infinite.
    pub(super) std: f64,
}

/// A parameter, or the stiffnesses of both axles as one (thesis: C_F = C_R).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Tied {
    One(Parameter),
    BothLateral,
}

impl Tied {
    pub(super) fn name(self) -> &'static str {
        match self {
            Self::One(parameter) => parameter.name(),
            Self::BothLateral => "lateral_stiffness",
        }
    }

    /// The one that stands for it.
    pub(super) fn first(self) -> Parameter {
        match self {
            Self::One(parameter) => parameter,
            Self::BothLateral => Parameter::LateralFront,
        }
    }

    /// Sets its value.
    pub(super) fn put(self, values: &mut Values, value: f64) {
        for parameter in Parameter::ALL.into_iter().filter(|parameter| self.is(*parameter)) {
            values.set(parameter, value);
        }
    }

    /// Do both have a parameter in common?
    pub(super) fn overlaps(self, other: Self) -> bool {
        Parameter::ALL.into_iter().any(|parameter| self.is(parameter) && other.is(parameter))
    }

    fn is(self, parameter: Parameter) -> bool {
        match self {
            Self::One(one) => one == parameter,
            Self::BothLateral => matches!(parameter, Parameter::LateralFront | Parameter::LateralRear),
        }
    }

    /// From the parameter's unit to the search's coordinate.
    pub(super) fn coordinate(self, value: f64) -> f64 {
        let first = self.first();
        if first.is_logarithmic() { value.ln() } else { value / first.scale() }
    }

    /// And back.
    pub(super) fn value(self, coordinate: f64) -> f64 {
        let first = self.first();
        if first.is_logarithmic() { coordinate.exp() } else { coordinate * first.scale() }
    }

    /// Derivative of the value by the coordinate.
    pub(super) fn value_by_coordinate(self, coordinate: f64) -> f64 {
        let first = self.first();
        if first.is_logarithmic() { coordinate.exp() } else { first.scale() }
    }
}

/// Where a search is.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Point {
    /// Coordinates of the free parameters.
    pub(super) theta: DVector<f64>,
    /// Start of each segment.
    pub(super) starts: Vec<Vector3<f64>>,
}

/// All there is to fit.
#[derive(Clone, Debug)]
pub(super) struct Problem<'a> {
    pub(super) vehicle: &'a Vehicle,
    pub(super) values: &'a Values,
    pub(super) free: &'a [Free],
    pub(super) segments: &'a [Segment],
    pub(super) drive: Drive,
    /// 1 / noise² by channel.
    pub(super) weight: [f64; Channel::COUNT],
    pub(super) tie: Tie,
}

/// What one segment says, sized at run time.
#[derive(Clone, Debug)]
struct Said {
    cost: f64,
    squares: [f64; Channel::COUNT],
    /// By parameters.
    gradient: DVector<f64>,
    information: DMatrix<f64>,
    /// By the start.
    start_gradient: Vector3<f64>,
    start_information: Matrix3<f64>,
    border: Border,
    end: Vector3<f64>,
    end_by_start: Matrix3<f64>,
    end_by_theta: Border,
}

/// Everything at a point: cost and normal equations.
#[derive(Clone, Debug)]
pub(super) struct Linearized {
    pub(super) cost: f64,
    /// Σ residual² by channel.
    pub(super) squares: [f64; Channel::COUNT],
    gradient: DVector<f64>,
    information: DMatrix<f64>,
    blocks: Vec<Block>,
    scores: Vec<Score>,
    said: Vec<Said>,
    /// Start of each segment after the first less the end of the one before; where it does not continue
    /// one, not-a-number.
    pub(super) jumps: Vec<Vector3<f64>>,
    /// Covariance of each jump, were the segments on their own and the parameters known.
    pub(super) jump_covariance: Vec<Option<Matrix3<f64>>>,
}

/// One segment's start in the chain.
#[derive(Clone, Debug)]
struct Block {
    gradient: Vector3<f64>,
    information: Matrix3<f64>,
    /// With the next segment's start.
    next: Matrix3<f64>,
    border: Border,
}

/// What one segment adds to the gradient.
#[derive(Clone, Debug)]
struct Score {
    theta: DVector<f64>,
    own: Vector3<f64>,
    before: Vector3<f64>,
}

/// The same on machines with wider vector registers: a derivative is four numbers at once there.
#[multiversion(targets("x86_64+avx2+fma"))]
fn evidence<const N: usize>(
    segment: &Segment,
    car: &Car<Dual<N>>,
    drive: Drive,
    start: State<Dual<N>>,
    weight: &[f64; Channel::COUNT],
) -> Evidence<N> {
    segment.evidence(car, drive, start, weight)
}

impl Said {
    fn new<const N: usize>(evidence: &Evidence<N>, count: usize) -> Self {
        let information = |i: usize, j: usize| evidence.information[i][j];
        let by = |i: usize, j: usize| evidence.end[i].by[j];
        Self {
            cost: evidence.cost,
            squares: evidence.squares,
            gradient: DVector::from_fn(count, |i, _| evidence.gradient[i]),
            information: DMatrix::from_fn(count, count, information),
            start_gradient: Vector3::from_fn(|i, _| evidence.gradient[count + i]),
            start_information: Matrix3::from_fn(|i, j| information(count + i, count + j)),
            border: Border::from_fn(count, |i, j| information(count + i, j)),
            end: Vector3::from_fn(|i, _| evidence.end[i].value),
            end_by_start: Matrix3::from_fn(|i, j| by(i, count + j)),
            end_by_theta: Border::from_fn(count, by),
        }
    }
}

impl Problem<'_> {
    /// Values of all parameters at a point.
    pub(super) fn values_at(&self, theta: &DVector<f64>) -> Values {
        let mut values = self.values.clone();
        for (free, coordinate) in self.free.iter().zip(theta.iter()) {
            free.parameters.put(&mut values, free.parameters.value(*coordinate));
        }
        values
    }

    /// Simulates everything, with derivatives.
    pub(super) fn linearize(&self, point: &Point) -> Linearized {
        // Derivatives by parameters and the three states; sizes that fill vector registers.
        let said = match self.free.len() + 3 {
            0..=8 => self.simulate::<8>(point),
            9..=16 => self.simulate::<16>(point),
            _ => self.simulate::<32>(point),
        };
        self.gather(point, said)
    }

    /// The same simulation, tied anew.
    pub(super) fn tie_anew(&self, point: &Point, all: Linearized) -> Linearized {
        self.gather(point, all.said)
    }

    fn simulate<const N: usize>(&self, point: &Point) -> Vec<Said> {
        let car = self.car::<N>(&point.theta);
        let count = self.free.len();
        let places = (0..self.segments.len()).into_par_iter();
        places
            .map(|place| {
                let start = std::array::from_fn(|i| Dual::variable(point.starts[place][i], count + i));
                let evidence = evidence(&self.segments[place], &car, self.drive, start, &self.weight);
                Said::new(&evidence, count)
            })
            .collect()
    }

    fn car<const N: usize>(&self, theta: &DVector<f64>) -> Car<Dual<N>> {
        let values = self.values_at(theta);
        Car::new(self.vehicle, |parameter| {
            let mut number = Dual::constant(values.get(parameter));
            for (place, free) in self.free.iter().enumerate() {
                if free.parameters.is(parameter) {
                    number.by[place] = free.parameters.value_by_coordinate(theta[place]);
                }
            }
            number
        })
    }

    fn gather(&self, point: &Point, said: Vec<Said>) -> Linearized {
        let count = self.free.len();
        let mut all = Linearized {
            cost: 0.0,
            squares: [0.0; Channel::COUNT],
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
        for (place, own) in said.iter().enumerate() {
            all.cost += own.cost;
            for (sum, square) in all.squares.iter_mut().zip(own.squares) {
                *sum += square;
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
                let earlier = &said[before];
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

/// The chain with its starts eliminated.
pub(super) struct Eliminated<'a> {
    all: &'a Linearized,
    /// Inverse of each start's block, borders and gradients as they are when its turn comes.
    chain: Vec<(Matrix3<f64>, Border, Vector3<f64>)>,
    /// Of the parameters, the starts following.
    pub(super) information: DMatrix<f64>,
    gradient: DVector<f64>,
    damping: f64,
}

impl Linearized {
    /// The cost as it is with other weights. Gradients stay as they are: good enough for the one step
    /// until all is simulated again.
    pub(super) fn reweigh(&mut self, before: &[f64; Channel::COUNT], now: &[f64; Channel::COUNT]) {
        for ((square, before), now) in self.squares.iter().zip(before).zip(now) {
            self.cost += square * (now - before);
        }
    }

    /// Eliminates the starts; `damping` is Levenberg's and Marquardt's, relative to the diagonal. `None`
    /// if some start is not determined at all.
    pub(super) fn eliminate(&self, damping: f64) -> Option<Eliminated<'_>> {
        let mut information = self.information.clone();
        let mut gradient = self.gradient.clone();
        for i in 0..information.nrows() {
            information[(i, i)] += damping * information[(i, i)].max(f64::MIN_POSITIVE);
        }
        let mut chain: Vec<(Matrix3<f64>, Border, Vector3<f64>)> = Vec::with_capacity(self.blocks.len());
        let mut link: Option<Matrix3<f64>> = None;
        for block in &self.blocks {
            let mut own = block.information;
            for i in 0..3 {
                own[(i, i)] += damping * own[(i, i)];
            }
            let (mut border, mut pull) = (block.border.clone(), block.gradient);
            if let (Some(next), Some((inverse, before, gradient))) = (link, chain.last()) {
                let through: Matrix3<f64> = next.transpose() * inverse;
                own -= through * next;
                border -= through * before;
                pull -= through * gradient;
            }
            let inverse = own.cholesky()?.inverse();
            let weighted = inverse * &border;
            information -= border.transpose() * &weighted;
            gradient -= weighted.transpose() * pull;
            chain.push((inverse, border, pull));
            link = Some(block.next);
        }
        Some(Eliminated { all: self, chain, information, gradient, damping })
    }
}

impl Eliminated<'_> {
    /// The step of parameters and starts, and by how much the cost would fall were all linear.
    pub(super) fn step(&self) -> Option<(Point, f64)> {
        let theta = if self.gradient.is_empty() {
            DVector::zeros(0)
        } else {
            -self.information.clone().cholesky()?.solve(&self.gradient)
        };
        let mut starts = vec![Vector3::zeros(); self.chain.len()];
        let mut after = Vector3::zeros();
        for (place, (inverse, border, gradient)) in self.chain.iter().enumerate().rev() {
            let next = self.all.blocks[place].next;
            starts[place] = -(inverse * (gradient + next * after + border * &theta));
            after = starts[place];
        }
        let all = self.all;
        let mut gain = -all.gradient.dot(&theta);
        for (i, step) in theta.iter().enumerate() {
            gain += self.damping * all.information[(i, i)] * step * step;
        }
        for (block, step) in all.blocks.iter().zip(&starts) {
            gain -= block.gradient.dot(step);
            for i in 0..3 {
                gain += self.damping * block.information[(i, i)] * step[i] * step[i];
            }
        }
        Some((Point { theta, starts }, gain))
    }

    /// What each segment says of the parameters, once the starts have followed: the terms whose sum is
    /// zero at the optimum, and whose scatter is the uncertainty, whatever the residuals' colour within
    /// a segment.
    pub(super) fn scores(&self) -> Vec<DVector<f64>> {
        // How the starts follow the parameters.
        let mut follow: Vec<Border> = Vec::with_capacity(self.chain.len());
        for (place, (inverse, border, _)) in self.chain.iter().enumerate().rev() {
            let next = self.all.blocks[place].next;
            let own = match follow.last() {
                Some(after) => inverse * (border - next * after),
                None => inverse * border,
            };
            follow.push(own);
        }
        follow.reverse();
        let scores = self.all.scores.iter().enumerate();
        scores
            .map(|(place, score)| {
                let mut sum = &score.theta - follow[place].transpose() * score.own;
                if place > 0 {
                    sum -= follow[place - 1].transpose() * score.before;
                }
                sum
            })
            .collect()
    }
}
