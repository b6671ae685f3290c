//! What a linear system's outputs tell of its state: rank (thesis 2.12) and Gramian.

use nalgebra::{DMatrix, SMatrix, SVector};

/// Rank of [C; C F; …; C Fᴺ⁻¹]: all `N` states can be told from the outputs when it is `N`. A direction
/// counts when it is seen more than `tolerance` times as strongly as the one that is seen best.
pub fn rank<const M: usize, const N: usize>(
    transition: &SMatrix<f64, N, N>,
    output: &SMatrix<f64, M, N>,
    tolerance: f64,
) -> usize {
    let mut rows = DMatrix::zeros(M * N, N);
    let mut block = *output;
    for k in 0..N {
        rows.view_mut((k * M, 0), (M, N)).copy_from(&block);
        block *= transition;
    }
    let singular = rows.singular_values();
    let least = tolerance * singular.max();
    singular.iter().filter(|value| **value > least).count()
}

/// Observability Gramian of a system that may change with time: Σ Φₖᵀ h hᵀ Φₖ / R, with Φₖ the way from
/// the first instant to that of the measurement. It is the information that the measurements hold of
/// the *first* state, so its inverse is the least covariance with which that can be known.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Gramian<const N: usize> {
    transition: SMatrix<f64, N, N>,
    information: SMatrix<f64, N, N>,
}

impl<const N: usize> Default for Gramian<N> {
    fn default() -> Self {
        Self { transition: SMatrix::identity(), information: SMatrix::zeros() }
    }
}

impl<const N: usize> Gramian<N> {
    /// A measurement with sensitivity `h` and noise `variance`.
    pub fn measure(&mut self, h: &SVector<f64, N>, variance: f64) {
        let seen = self.transition.transpose() * h;
        self.information += seen * seen.transpose() / variance;
    }

    /// The system goes on by one step.
    pub fn advance(&mut self, transition: &SMatrix<f64, N, N>) {
        self.transition = transition * self.transition;
    }

    /// The Gramian.
    pub fn information(&self) -> &SMatrix<f64, N, N> {
        &self.information
    }

    /// Least standard deviation of each component of the first state; infinite while the
    /// measurements do not determine it.
    pub fn std(&self) -> SVector<f64, N> {
        match self.information.cholesky() {
            Some(cholesky) => cholesky.inverse().diagonal().map(f64::sqrt),
            None => SVector::repeat(f64::INFINITY),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::filter::discretize::exponential;
    use nalgebra::{matrix, vector};

    #[test]
    fn a_turning_body_shows_its_lateral_velocity_and_one_going_straight_does_not() {
        let turn = |r: f64| exponential(&(matrix![0.0, r; -r, 0.0] * 0.01));
        assert_eq!(rank(&turn(0.0), &matrix![1.0, 0.0], 1e-9), 1);
        assert_eq!(rank(&turn(0.3), &matrix![1.0, 0.0], 1e-9), 2);
    }

    #[test]
    fn the_gramian_of_a_straight_line_is_the_regressions() {
        // Place and velocity from places at 0, 1 … 9 s with noise 0.5.
        let mut gramian = Gramian::<2>::default();
        for _ in 0..10 {
            gramian.measure(&vector![1.0, 0.0], 0.25);
            gramian.advance(&matrix![1.0, 1.0; 0.0, 1.0]);
        }
        assert_eq!(*gramian.information(), matrix![40.0, 180.0; 180.0, 1140.0]);
        let spread: f64 = (0..10).map(|t| (f64::from(t) - 4.5).powi(2)).sum();
        assert!((gramian.std()[1] - 0.5 / spread.sqrt()).abs() < 1e-12);
    }

    #[test]
    fn what_is_not_seen_is_not_known() {
        let mut gramian = Gramian::<2>::default();
        gramian.measure(&vector![1.0, 0.0], 1.0);
        assert!(gramian.std()[1].is_infinite());
    }
}
