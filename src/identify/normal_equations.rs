//! The normal equations of one Gauss–Newton step. They are block tridiagonal in the starts of the segments, with the
//! parameters as border.

use nalgebra::{DMatrix, DVector, Dyn, Matrix3, OMatrix, U3, Vector3};

use super::bounded::bounded_step;
use super::motion::Output;
use super::segment_sums::SegmentSums;

/// Three states by the parameters.
pub(super) type Border = OMatrix<f64, U3, Dyn>;

/// Where a search is.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Point {
    /// Coordinates of the free parameters.
    pub(super) theta: DVector<f64>,
    /// Start of each segment.
    pub(super) starts: Vec<Vector3<f64>>,
}

impl Point {
    /// As far as a share of a step leads.
    pub(super) fn moved(&self, step: &Self, share: f64) -> Self {
        let starts = self.starts.iter().zip(&step.starts).map(|(at, by)| at + share * by);
        Self { theta: &self.theta + share * &step.theta, starts: starts.collect() }
    }

    /// The step that leads here.
    pub(super) fn way_from(&self, other: &Self) -> Self {
        let starts = self.starts.iter().zip(&other.starts).map(|(to, from)| to - from);
        Self { theta: &self.theta - &other.theta, starts: starts.collect() }
    }
}

/// Everything at a point: cost and normal equations.
#[derive(Clone, Debug)]
pub(super) struct Linearized {
    pub(super) cost: f64,
    /// Σ residual² by channel.
    pub(super) squares: [f64; Output::COUNT],
    pub(super) gradient: DVector<f64>,
    pub(super) information: DMatrix<f64>,
    pub(super) blocks: Vec<Block>,
    pub(super) scores: Vec<Score>,
    pub(super) said: Vec<SegmentSums>,
    /// Start of each segment after the first less the end of the one before; where it does not continue
    /// one, not-a-number.
    pub(super) jumps: Vec<Vector3<f64>>,
    /// Covariance of each jump, were the segments on their own and the parameters known.
    pub(super) jump_covariance: Vec<Option<Matrix3<f64>>>,
}

/// One segment's start: a block of the diagonal, the one beside it, and its border.
#[derive(Clone, Debug)]
pub(super) struct Block {
    pub(super) gradient: Vector3<f64>,
    pub(super) information: Matrix3<f64>,
    /// With the next segment's start.
    pub(super) next: Matrix3<f64>,
    pub(super) border: Border,
}

/// What one segment adds to the gradient.
#[derive(Clone, Debug)]
pub(super) struct Score {
    pub(super) theta: DVector<f64>,
    pub(super) own: Vector3<f64>,
    pub(super) before: Vector3<f64>,
}

/// The equations with the starts eliminated.
pub(super) struct Eliminated<'a> {
    all: &'a Linearized,
    /// Inverse of each start's block, borders and gradients as they are when its turn comes.
    starts: Vec<(Matrix3<f64>, Border, Vector3<f64>)>,
    /// Of the parameters, the starts following.
    pub(super) information: DMatrix<f64>,
    gradient: DVector<f64>,
}

impl Linearized {
    /// Eliminates the starts; `damping` is Levenberg's and Marquardt's, relative to the diagonal. `None`
    /// if some start is not determined at all.
    pub(super) fn eliminate(&self, damping: f64) -> Option<Eliminated<'_>> {
        let mut information = self.information.clone();
        let mut gradient = self.gradient.clone();
        for i in 0..information.nrows() {
            information[(i, i)] += damping * information[(i, i)].max(f64::MIN_POSITIVE);
        }
        let mut starts: Vec<(Matrix3<f64>, Border, Vector3<f64>)> = Vec::with_capacity(self.blocks.len());
        let mut link: Option<Matrix3<f64>> = None;
        for block in &self.blocks {
            let mut own = block.information;
            for i in 0..3 {
                own[(i, i)] += damping * own[(i, i)];
            }
            let (mut border, mut pull) = (block.border.clone(), block.gradient);
            if let (Some(next), Some((inverse, before, gradient))) = (link, starts.last()) {
                let through: Matrix3<f64> = next.transpose() * inverse;
                own -= through * next;
                border -= through * before;
                pull -= through * gradient;
            }
            let inverse = own.cholesky()?.inverse();
            let weighted = inverse * &border;
            information -= border.transpose() * &weighted;
            gradient -= weighted.transpose() * pull;
            starts.push((inverse, border, pull));
            link = Some(block.next);
        }
        Some(Eliminated { all: self, starts, information, gradient })
    }

    /// By how much a step would lower the cost were all linear.
    fn gain(&self, step: &Point) -> f64 {
        let mut slope = self.gradient.dot(&step.theta);
        let mut bend = (&self.information * &step.theta).dot(&step.theta);
        for (place, (block, start)) in self.blocks.iter().zip(&step.starts).enumerate() {
            let after = step.starts.get(place + 1).map_or_else(Vector3::zeros, |after| block.next * after);
            slope += block.gradient.dot(start);
            bend += (block.information * start + 2.0 * (&block.border * &step.theta + after)).dot(start);
        }
        -2.0 * slope - bend
    }
}

impl Eliminated<'_> {
    /// The step of parameters and starts, and by how much the cost would fall were all linear. No parameter goes
    /// farther than its limits, down and up.
    pub(super) fn step(&self, limits: &[(f64, f64)]) -> Option<(Point, f64)> {
        let theta = bounded_step(&self.information, &-&self.gradient, limits)?;
        let mut starts = vec![Vector3::zeros(); self.starts.len()];
        let mut after = Vector3::zeros();
        for (place, (inverse, border, gradient)) in self.starts.iter().enumerate().rev() {
            let next = self.all.blocks[place].next;
            starts[place] = -(inverse * (gradient + next * after + border * &theta));
            after = starts[place];
        }
        let step = Point { theta, starts };
        let gain = self.all.gain(&step);
        Some((step, gain))
    }

    /// What each segment says of the parameters, once the starts have followed: the terms whose sum is
    /// zero at the optimum, and whose scatter is the uncertainty, whatever the residuals' colour within
    /// a segment.
    pub(super) fn scores(&self) -> Vec<DVector<f64>> {
        // How the starts follow the parameters.
        let mut follow: Vec<Border> = Vec::with_capacity(self.starts.len());
        for (place, (inverse, border, _)) in self.starts.iter().enumerate().rev() {
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

#[cfg(test)]
mod tests {
    use super::*;

    /// Two parameters, and one segment that says nothing of them.
    fn linearized(information: [f64; 4], gradient: [f64; 2]) -> Linearized {
        let block = Block {
            gradient: Vector3::new(1.0, 0.0, 0.0),
            information: Matrix3::identity(),
            next: Matrix3::zeros(),
            border: Border::zeros(2),
        };
        Linearized {
            cost: 0.0,
            squares: [0.0; Output::COUNT],
            gradient: DVector::from_row_slice(&gradient),
            information: DMatrix::from_row_slice(2, 2, &information),
            blocks: vec![block],
            scores: Vec::new(),
            said: Vec::new(),
            jumps: Vec::new(),
            jump_covariance: Vec::new(),
        }
    }

    #[test]
    fn at_its_limit_a_parameter_stays_and_the_others_make_the_best_of_it() {
        let all = linearized([4.0, 3.9, 3.9, 4.0], [-1.0, 1.0]);
        let eliminated = all.eliminate(0.0).unwrap();
        let (step, gain) = eliminated.step(&[(-99.0, 99.0); 2]).unwrap();
        assert!((step.theta[0] - 10.0).abs() < 1e-9 && (step.theta[1] + 10.0).abs() < 1e-9, "{step:?}");
        assert_eq!(step.starts, [Vector3::new(-1.0, 0.0, 0.0)]);
        // Half of what the slopes promise; the start adds its own.
        assert!((gain - 21.0).abs() < 1e-9, "{gain}");
        let (step, gain) = eliminated.step(&[(-0.5, 0.5), (-99.0, 99.0)]).unwrap();
        assert!((step.theta[0] - 0.5).abs() < 1e-12 && (step.theta[1] + 2.95 / 4.0).abs() < 1e-9, "{step:?}");
        let cost = |x: f64, y: f64| 4.0 * (x * x + y * y) + 7.8 * x * y + 2.0 * (y - x);
        assert!((gain - 1.0 + cost(step.theta[0], step.theta[1])).abs() < 1e-9, "{gain}");
        // Nowhere to go.
        let (step, gain) = eliminated.step(&[(0.0, 0.0), (0.0, 0.0)]).unwrap();
        assert!(step.theta.amax() == 0.0 && (gain - 1.0).abs() < 1e-12);
    }
}
