//! The equations of one Gauss–Newton step: a chain of starts with the parameters as its border.

use nalgebra::{DMatrix, DVector, Dyn, Matrix3, OMatrix, U3, Vector3};

use super::motion::Channel;
use super::shooting::Said;

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

/// Everything at a point: cost and normal equations.
#[derive(Clone, Debug)]
pub(super) struct Linearized {
    pub(super) cost: f64,
    /// Σ residual² by channel.
    pub(super) squares: [f64; Channel::COUNT],
    pub(super) gradient: DVector<f64>,
    pub(super) information: DMatrix<f64>,
    pub(super) blocks: Vec<Block>,
    pub(super) scores: Vec<Score>,
    pub(super) said: Vec<Said>,
    /// Start of each segment after the first less the end of the one before; where it does not continue
    /// one, not-a-number.
    pub(super) jumps: Vec<Vector3<f64>>,
    /// Covariance of each jump, were the segments on their own and the parameters known.
    pub(super) jump_covariance: Vec<Option<Matrix3<f64>>>,
}

/// One segment's start in the chain.
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
