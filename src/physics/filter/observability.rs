//! What measurements can tell about a state (thesis 2.12; methods.md §6).
//!
//! The rank test asks whether they tell it at all, the Gramian how well: over a stretch of time, with
//! models and measurements that change from instant to instant (a linearization along a drive, say).

use nalgebra::{DMatrix, SMatrix, SVector};

/// Collects what measurements say about the state at the start of the stretch.
///
/// Kept as a triangular root R of the Gramian W = Σ Φᵀ h hᵀ Φ / variance = Rᵀ R, turned into shape by
/// rotations: forming W itself would square its condition, and lose every direction weaker than 1e-8.
///
/// ```
/// use physics::filter::Observability;
/// use nalgebra::{matrix, vector};
///
/// // A position is measured twice, a second apart: that tells the velocity, too.
/// let mut seen = Observability::<2>::new();
/// seen.measure(&vector![1.0, 0.0], 1.0);
/// assert_eq!(seen.spectrum(&vector![1.0, 1.0]).rank(1e-9), 1);
/// seen.advance(&matrix![1.0, 1.0; 0.0, 1.0]);
/// seen.measure(&vector![1.0, 0.0], 1.0);
/// assert_eq!(seen.spectrum(&vector![1.0, 1.0]).rank(1e-9), 2);
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Observability<const N: usize> {
    root: SMatrix<f64, N, N>,
    /// From the start to now.
    transition: SMatrix<f64, N, N>,
}

impl<const N: usize> Default for Observability<N> {
    fn default() -> Self {
        Self::new()
    }
}

impl<const N: usize> Observability<N> {
    /// Nothing measured yet.
    pub fn new() -> Self {
        Self { root: SMatrix::zeros(), transition: SMatrix::identity() }
    }

    /// The observability matrix of (2.12), [C; C F; … C Fᴺ⁻¹], of a time-invariant system: `rows` of C
    /// with their noise variances. With a continuous A in place of F, give it as A times a time that
    /// matters, so that its powers do not differ by the unit of time alone.
    pub fn time_invariant(transition: &SMatrix<f64, N, N>, rows: &[(SVector<f64, N>, f64)]) -> Self {
        let mut seen = Self::new();
        for power in 0..N {
            if power > 0 {
                seen.advance(transition);
            }
            for (row, variance) in rows {
                seen.measure(row, *variance);
            }
        }
        seen
    }

    /// One scalar measurement now: its sensitivity to the state now, and the variance of its noise. One
    /// that is not finite, or without noise, is left out.
    pub fn measure(&mut self, sensitivity: &SVector<f64, N>, variance: f64) {
        let mut row = (self.transition.transpose() * sensitivity) / variance.sqrt();
        if !row.iter().all(|x| x.is_finite()) {
            return;
        }
        for i in 0..N {
            let (old, new) = (self.root[(i, i)], row[i]);
            let length = old.hypot(new);
            if length == 0.0 {
                continue;
            }
            let (cos, sin) = (old / length, new / length);
            for j in i..N {
                let (upper, lower) = (self.root[(i, j)], row[j]);
                self.root[(i, j)] = cos * upper + sin * lower;
                row[j] = cos * lower - sin * upper;
            }
        }
    }

    /// The state moves on with this transition matrix (or Jacobian).
    pub fn advance(&mut self, transition: &SMatrix<f64, N, N>) {
        self.transition = transition * self.transition;
    }

    /// The Gramian of the stretch, also the Fisher information about the state at its start.
    pub fn gramian(&self) -> SMatrix<f64, N, N> {
        self.root.transpose() * self.root
    }

    /// Strength of each direction of the state, with component i in units of `scale[i]`: choose what is
    /// worth knowing (a standard deviation known beforehand, or the resolution wanted), or a stiffness of
    /// 50,000 N/rad and a velocity of 0.1 m/s cannot be compared.
    pub fn spectrum(&self, scale: &SVector<f64, N>) -> Spectrum<N> {
        let scaled = DMatrix::from_fn(N, N, |i, j| self.root[(i, j)] * scale[j]);
        let svd = scaled.svd(false, true);
        let mut order: Vec<usize> = (0..N).collect();
        order.sort_by(|a, b| svd.singular_values[*b].total_cmp(&svd.singular_values[*a]));
        let direction = |index: usize| {
            svd.v_t.as_ref().map_or(SVector::zeros(), |v| SVector::from_fn(|j, _| v[(order[index], j)]))
        };
        Spectrum {
            strengths: std::array::from_fn(|i| svd.singular_values[order[i]]),
            directions: std::array::from_fn(direction),
        }
    }
}

/// Directions of the state from the best to the worst measured.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Spectrum<const N: usize> {
    /// Singular values: one over the standard deviation that the measurements alone leave in a
    /// direction (the Cramér–Rao bound), in units of the scale.
    pub strengths: [f64; N],
    /// The directions, of length one in units of the scale.
    pub directions: [SVector<f64, N>; N],
}

impl<const N: usize> Spectrum<N> {
    /// A tolerance for [`Self::rank`] that lets rounding pass for nothing in the systems of this crate.
    pub const ROUNDING: f64 = 1e-10;

    /// How many directions are measured at all: those stronger than `tolerance` times the strongest.
    pub fn rank(&self, tolerance: f64) -> usize {
        let strongest = self.strengths.first().copied().unwrap_or(0.0);
        self.strengths.iter().filter(|strength| **strength > tolerance * strongest).count()
    }

    /// The strongest over the weakest; infinite if something is not measured at all.
    pub fn condition(&self) -> f64 {
        match (self.strengths.first(), self.strengths.last()) {
            (Some(strongest), Some(weakest)) if *weakest > 0.0 => strongest / weakest,
            _ => f64::INFINITY,
        }
    }

    /// The direction about which least is known, and the standard deviation left in it (infinite if
    /// nothing is), both in units of the scale.
    pub fn weakest(&self) -> Option<(&SVector<f64, N>, f64)> {
        Some((self.directions.last()?, self.strengths.last()?.recip()))
    }

    /// The least standard deviation any unbiased estimator can have of component `i`, in units of the
    /// scale (Cramér–Rao); infinite if it cannot be told from the others.
    pub fn bound(&self, i: usize) -> f64 {
        let parts = self.directions.iter().zip(self.strengths);
        parts
            .map(
                |(direction, strength)| {
                    if direction[i] == 0.0 { 0.0 } else { (direction[i] / strength).powi(2) }
                },
            )
            .sum::<f64>()
            .sqrt()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::filter::Gaussian;
    use crate::filter::discretize::exponential;
    use nalgebra::{matrix, vector};

    /// Method 2 of the thesis (5.10): [vx vy] turn with the yaw rate, vx is measured.
    fn kinematic(yaw_rate: f64) -> SMatrix<f64, 2, 2> {
        exponential(&(matrix![0.0, yaw_rate; -yaw_rate, 0.0] * 0.01))
    }

    #[test]
    fn the_lateral_velocity_is_not_observable_without_yaw() {
        let rank = |yaw_rate: f64| {
            let seen = Observability::time_invariant(&kinematic(yaw_rate), &[(vector![1.0, 0.0], 1.0)]);
            seen.spectrum(&vector![1.0, 1.0]).rank(Spectrum::<2>::ROUNDING)
        };
        assert_eq!([rank(0.0), rank(0.01), rank(-0.3)], [1, 2, 2]);
    }

    #[test]
    fn one_turn_in_a_long_straight_makes_it_observable_and_the_bound_tells_how_well() {
        let mut seen = Observability::<2>::new();
        let scale = vector![1.0, 1.0];
        let mut drive = |seconds: f64, yaw_rate: f64| {
            for _ in 0..(seconds * 100.0) as usize {
                seen.measure(&vector![1.0, 0.0], 1e-4);
                seen.advance(&kinematic(yaw_rate));
            }
            seen.spectrum(&scale)
        };
        let straight = drive(10.0, 0.0);
        let (direction, left) = straight.weakest().unwrap();
        assert!(direction[1].abs() > 0.999 && left.is_infinite() && straight.condition().is_infinite());
        assert!(straight.bound(1).is_infinite() && (straight.bound(0) - 0.01 / 1000f64.sqrt()).abs() < 1e-6);
        let turned = drive(1.0, 0.3);
        assert_eq!(turned.rank(Spectrum::<2>::ROUNDING), 2);
        assert!(turned.bound(1) > 5.0 * turned.bound(0) && turned.bound(1) < 0.1, "{}", turned.bound(1));
    }

    /// The Gramian's inverse is the covariance of a Kalman filter that knows nothing beforehand.
    #[test]
    fn the_bound_is_what_a_kalman_filter_reaches() {
        let mut seen = Observability::<3>::new();
        let mut filter = Gaussian::<3>::new([0.0; 3], [1e5; 3]);
        let f = matrix![1.0, 0.1, 0.005; 0.0, 1.0, 0.1; 0.0, 0.0, 1.0];
        let mut back = SMatrix::<f64, 3, 3>::identity();
        for i in 0..50 {
            let h = vector![1.0, 0.0, f64::from(i % 3)];
            seen.measure(&h, 0.04);
            filter.update(&h, 0.0, 0.04);
            if i < 49 {
                seen.advance(&f);
                filter.predict(&f, &SMatrix::zeros());
                back *= f.try_inverse().unwrap();
            }
        }
        let at_start = back * filter.covariance * back.transpose();
        let spectrum = seen.spectrum(&vector![1.0, 1.0, 1.0]);
        for i in 0..3 {
            let (bound, reached) = (spectrum.bound(i), at_start[(i, i)].sqrt());
            assert!((bound / reached - 1.0).abs() < 1e-4, "{i}: {bound} {reached}");
        }
        assert!((seen.gramian().try_inverse().unwrap() - at_start).norm() < 1e-3 * at_start.norm());
    }

    #[test]
    fn units_decide_nothing_when_the_state_is_scaled() {
        let rows = |unit: f64| [(vector![1.0, 2.0 / unit], 1.0), (vector![1.0, -2.0 / unit], 1.0)];
        let condition = |unit: f64| {
            let seen = Observability::time_invariant(&SMatrix::identity(), &rows(unit));
            seen.spectrum(&vector![1.0, unit]).condition()
        };
        assert!((condition(1.0) - 2.0).abs() < 1e-12 && (condition(1e12) - 2.0).abs() < 1e-12);
    }

    /// Two directions measured with strengths 1 and 1e-12: the product Rᵀ R would lose the second.
    #[test]
    fn the_root_keeps_what_the_square_would_lose() {
        let mut seen = Observability::<2>::new();
        seen.measure(&vector![1.0, 1.0], 1.0);
        seen.measure(&vector![1.0, 1.0 + 2e-12], 1.0);
        let condition = seen.spectrum(&vector![1.0, 1.0]).condition();
        assert!((condition / 2e12).log10().abs() < 0.05, "{condition:e}");
    }
}
