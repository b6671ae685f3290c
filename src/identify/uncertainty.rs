//! How sure the parameters are, and which of them the recording says anything about.

use nalgebra::{DMatrix, DVector};

use super::fit::Fit;
use super::free::Free;
use physics::filter::student;

/// Covariance of the search's coordinates at its end.
#[derive(Clone, Debug)]
pub(super) struct Uncertainty {
    /// Standard deviations.
    pub(super) std: DVector<f64>,
    /// Standard deviations if the residuals were white noise: by the curvature at the end alone.
    pub(super) by_curvature: DVector<f64>,
    /// Correlations.
    pub(super) correlation: DMatrix<f64>,
    /// What the recording alone would leave, the priors taken away; infinite where it says nothing.
    pub(super) by_data: DVector<f64>,
    /// How far the noise of the inputs has moved each coordinate: to be taken off.
    pub(super) correction: DVector<f64>,
    /// Where it has moved a coordinate so far that nothing can be taken off any more.
    pub(super) decided_by_noise: Vec<bool>,
    /// Half of the 95 % interval / standard deviation.
    pub(super) factor: f64,
}

/// What the noise of the inputs does to the coordinates.
#[derive(Clone, Debug)]
pub(super) struct Shift {
    mean: DVector<f64>,
    /// Variance of the mean.
    scatter: DVector<f64>,
}

impl Shift {
    /// So often the noise is added again.
    pub(super) const DRAWS: u32 = 4;
    /// The extrapolation is a straight line; so much of the correction may be wrong.
    const CURVED: f64 = 0.3;

    pub(super) fn new(draws: &[DVector<f64>], of: usize) -> Self {
        let count = draws.len() as f64;
        let zero = || DVector::zeros(of);
        if draws.len() < 2 {
            return Self { mean: zero(), scatter: zero() };
        }
        let mean = draws.iter().fold(zero(), |sum, draw| sum + draw) / count;
        let squares = draws.iter().map(|draw| (draw - &mean).map(|off| off * off));
        let scatter = squares.fold(zero(), |sum, square| sum + square) / ((count - 1.0) * count);
        Self { mean, scatter }
    }

    /// What it adds to the uncertainty.
    fn variance(&self) -> DVector<f64> {
        self.scatter.zip_map(&self.mean, |scatter, mean| scatter + (Self::CURVED * mean).powi(2))
    }
}

/// From curvature and from scatter: residuals that are no white noise (a model that is not quite right, noise
/// of the inputs) make segments differ more than their own noise explains, and the sum of the segments'
/// squared scores says by how much ("sandwich", Huber 1967, with segments as clusters). Of both the larger
/// counts. `None` if the parameters are not determined.
pub(super) fn of(fit: &Fit, free: &[Free], shift: &Shift) -> Option<Uncertainty> {
    let eliminated = fit.all.eliminate(0.0)?;
    let information = eliminated.information.clone();
    let inverse = information.clone().cholesky()?.inverse();
    let scores = eliminated.scores();
    let (count, of) = (scores.len() as f64, free.len() as f64);
    let dof = (count - of).max(1.0);
    let scatter = scatter_of(&scores) * (count / dof);
    let prior = prior_of(free);
    let robust = &inverse * (&scatter + &prior) * &inverse;
    // Too few segments do not tell by how much for each direction: then all of them get the mean of it.
    let enough = count > 3.0 * of + 10.0;
    // That mean is of all directions, so that it has at least as much freedom as the segments' scatter in one.
    let (covariance, freedom) = if enough {
        (robust, dof)
    } else {
        (&inverse * inflation(&inverse, &scatter_of(&scores), &prior), (count - 1.0).max(1.0))
    };
    let variance =
        DVector::from_fn(free.len(), |i, _| covariance[(i, i)].max(inverse[(i, i)]).max(f64::MIN_POSITIVE));
    let std = (variance + shift.variance()).map(f64::sqrt);
    let own = covariance.diagonal().map(|v| v.max(f64::MIN_POSITIVE).sqrt());
    let correlation = DMatrix::from_fn(free.len(), free.len(), |i, j| covariance[(i, j)] / (own[i] * own[j]));
    let decides = |(free, mean): (&Free, &f64)| {
        mean.abs() > if free.parameters.first().is_logarithmic() { 0.1 } else { 10.0 }
    };
    let decided_by_noise: Vec<bool> = free.iter().zip(shift.mean.iter()).map(decides).collect();
    // They belong together: with one that cannot be corrected, none is.
    let correction = if decided_by_noise.contains(&true) { 0.0 * &shift.mean } else { shift.mean.clone() };
    let by_data = alone(&(&information - &prior), &std, &inverse);
    Some(Uncertainty {
        std,
        by_curvature: inverse.diagonal().map(|v| v.max(f64::MIN_POSITIVE).sqrt()),
        correlation,
        by_data,
        correction,
        decided_by_noise,
        factor: student::quantile(0.95, freedom),
    })
}

/// By how much segments differ more than their noise explains, in the directions that the recordings tell of: so many times
/// too much a likelihood of independent residuals counts beside a prior (Ribatet, Cooley & Davison 2012). At least 1.
pub(super) fn overstated(fit: &Fit, free: &[Free]) -> Option<f64> {
    let eliminated = fit.all.eliminate(0.0)?;
    let inverse = eliminated.information.clone().cholesky()?.inverse();
    let told = (&inverse * (&eliminated.information - prior_of(free))).trace();
    let scatter = (&inverse * scatter_of(&eliminated.scores())).trace();
    Some((scatter / told.max(1.0)).max(1.0))
}

/// Information of the priors.
fn prior_of(free: &[Free]) -> DMatrix<f64> {
    let mut prior = DMatrix::zeros(free.len(), free.len());
    for (i, free) in free.iter().enumerate() {
        if free.std.is_finite() {
            prior[(i, i)] = 1.0 / (free.std * free.std);
        }
    }
    prior
}

fn scatter_of(scores: &[DVector<f64>]) -> DMatrix<f64> {
    let count = scores.first().map_or(0, DVector::len);
    scores.iter().fold(DMatrix::zeros(count, count), |sum, score| sum + score * score.transpose())
}

/// By how much segments differ more than their noise explains, over all directions; at least 1.
fn inflation(inverse: &DMatrix<f64>, scatter: &DMatrix<f64>, prior: &DMatrix<f64>) -> f64 {
    ((inverse * (scatter + prior)).trace() / inverse.nrows().max(1) as f64).max(1.0)
}

/// Standard deviations without the priors, scaled by what scatter adds to curvature.
fn alone(data: &DMatrix<f64>, std: &DVector<f64>, inverse: &DMatrix<f64>) -> DVector<f64> {
    let eigen = data.clone().symmetric_eigen();
    let largest = eigen.eigenvalues.amax();
    DVector::from_fn(data.nrows(), |i, _| {
        let mut variance = 0.0;
        for (value, vector) in eigen.eigenvalues.iter().zip(eigen.eigenvectors.column_iter()) {
            // A direction the data do not know at all, to rounding.
            if *value <= 1e-12 * largest {
                if vector[i].abs() > 1e-3 {
                    return f64::INFINITY;
                }
                continue;
            }
            variance += vector[i] * vector[i] / value;
        }
        variance.sqrt() * (std[i] / inverse[(i, i)].sqrt())
    })
}
