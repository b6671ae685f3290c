//! A state with its covariance, and the Kalman filter's two steps on it (thesis 2.16–2.22).

use nalgebra::{SMatrix, SVector};

use super::small::{dot, product, products};

/// What a measurement said against the prediction.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Innovation {
    /// Measured minus predicted.
    pub residual: f64,
    /// Variance the filter expected of it.
    pub variance: f64,
}

impl Innovation {
    /// The residual in standard deviations.
    pub fn normalized(&self) -> f64 {
        self.residual / self.variance.sqrt()
    }

    /// Normalized innovation squared: one on average while the filter is consistent.
    pub fn nis(&self) -> f64 {
        self.residual * self.residual / self.variance
    }
}

/// A normally distributed state of `N` components.
///
/// Measurements are taken one scalar at a time (their noises being independent), in Joseph's form:
/// no matrix is inverted, and the covariance stays symmetric and positive over days.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Gaussian<const N: usize> {
    /// Best value.
    pub mean: SVector<f64, N>,
    /// Covariance.
    pub covariance: SMatrix<f64, N, N>,
}

impl<const N: usize> Gaussian<N> {
    /// Independent components with these standard deviations.
    pub fn new(mean: [f64; N], std: [f64; N]) -> Self {
        let variance = SVector::from(std).map(|s| s * s);
        Self { mean: SVector::from(mean), covariance: SMatrix::from_diagonal(&variance) }
    }

    /// Standard deviation of component `i`.
    #[inline]
    pub fn std(&self, i: usize) -> f64 {
        self.covariance[(i, i)].max(0.0).sqrt()
    }

    /// Standard deviation with which component `i` may stand alone. Independent components with these
    /// deviations are nowhere surer than this state is of all of `among` together, however they are
    /// correlated: a symmetric matrix that dominates its diagonal is positive.
    pub fn alone_std(&self, i: usize, among: &[usize]) -> f64 {
        let own = self.std(i);
        let shared: f64 = among
            .iter()
            .filter(|&&j| j != i && self.std(j) > 0.0)
            .map(|&j| self.covariance[(i, j)].abs() / self.std(j))
            .sum();
        (own * (own + shared)).sqrt()
    }

    /// Linear time update: mean ← F mean, P ← F P Fᵀ + Q.
    pub fn predict(&mut self, transition: &SMatrix<f64, N, N>, noise: &SMatrix<f64, N, N>) {
        self.mean = transition * self.mean;
        self.predict_covariance(transition, noise);
    }

    /// The covariance's part of a time update whose mean was propagated by a nonlinear model.
    pub fn predict_covariance(&mut self, transition: &SMatrix<f64, N, N>, noise: &SMatrix<f64, N, N>) {
        let (f, q) = (&transition.data.0, &noise.data.0);
        let fp = products(f, &self.covariance.data.0);
        for j in 0..N {
            let mut column = q[j];
            for (fp, f) in fp.iter().zip(f) {
                for i in j..N {
                    column[i] += fp[i] * f[j];
                }
            }
            self.set_column(j, &column);
        }
    }

    /// The same where only the first `M` components move; the others stay as they are and act on these (their rows of
    /// the whole transition are the identity's). `noise`: the variance that each component gets.
    pub fn predict_covariance_of_moving<const M: usize>(
        &mut self,
        transition: &SMatrix<f64, M, N>,
        noise: &[f64; N],
    ) {
        let f = &transition.data.0;
        let fp = products(f, &self.covariance.data.0);
        for (moving, fp) in fp[M..].iter().enumerate() {
            for (i, &element) in fp.iter().enumerate() {
                self.set(i, M + moving, element);
            }
        }
        for j in 0..M {
            let mut column = [0.0; M];
            for (fp, f) in fp.iter().zip(f) {
                for i in j..M {
                    column[i] += fp[i] * f[j];
                }
            }
            self.set_column(j, &column);
        }
        for (i, variance) in noise.iter().enumerate() {
            self.inflate(i, *variance);
        }
    }

    /// Adds to the variance of component `i`: the time update of a random walk.
    #[inline]
    pub fn inflate(&mut self, i: usize, variance: f64) {
        self.covariance[(i, i)] += variance;
    }

    /// Component `i` loses this share of its way from `mean`, and tends to a deviation of `std`: a first-order process.
    pub fn tend(&mut self, i: usize, mean: f64, std: f64, share: f64) {
        let kept = 1.0 - share;
        self.mean[i] = mean + kept * (self.mean[i] - mean);
        self.covariance.row_mut(i).scale_mut(kept);
        self.covariance.column_mut(i).scale_mut(kept);
        self.inflate(i, std * std * (1.0 - kept * kept));
    }

    /// Component `i` is unknown again, and unrelated to the others.
    pub fn forget(&mut self, i: usize, mean: f64, std: f64) {
        self.covariance.row_mut(i).fill(0.0);
        self.covariance.column_mut(i).fill(0.0);
        self.mean[i] = mean;
        self.covariance[(i, i)] = std * std;
    }

    /// What a measurement with sensitivity `h` and noise `variance` would be compared with.
    pub fn innovation(&self, h: &SVector<f64, N>, residual: f64, variance: f64) -> Innovation {
        let ph = product(&self.covariance.data.0, &h.data.0[0]);
        Innovation { residual, variance: h.dot(&ph.into()) + variance }
    }

    /// Measurement update with one scalar: `residual` = measured − predicted, `h` its sensitivity to
    /// the state, `variance` its noise. A measurement that is not finite, or one without noise and
    /// without uncertainty to reduce, changes nothing.
    pub fn update(&mut self, h: &SVector<f64, N>, residual: f64, variance: f64) -> Innovation {
        let h = h.data.0[0];
        self.correct(residual, variance, |vector| dot(vector, &h), |matrix| product(matrix, &h))
    }

    /// The same where component `i` itself is measured.
    #[inline]
    pub fn update_component(&mut self, i: usize, residual: f64, variance: f64) -> Innovation {
        self.correct(residual, variance, |vector| vector[i], |matrix| matrix[i])
    }

    /// The update; the sensitivity h is known by its products with a vector and with a symmetric matrix.
    #[inline]
    fn correct(
        &mut self,
        residual: f64,
        variance: f64,
        h_dot: impl Fn(&[f64; N]) -> f64,
        times_h: impl Fn(&[[f64; N]; N]) -> [f64; N],
    ) -> Innovation {
        let ph = times_h(&self.covariance.data.0);
        let innovation = Innovation { residual, variance: h_dot(&ph) + variance };
        if !(residual.is_finite() && innovation.variance.is_finite() && innovation.variance > 0.0) {
            return innovation;
        }
        let gain = ph.map(|ph| ph / innovation.variance);
        for (mean, gain) in self.mean.iter_mut().zip(gain) {
            *mean += gain * residual;
        }
        // Joseph: (I − k hᵀ) P (I − k hᵀ)ᵀ + r k kᵀ, as two rank-one steps.
        for (j, ph) in ph.into_iter().enumerate() {
            let mut column = self.covariance.data.0[j];
            for i in j..N {
                column[i] -= gain[i] * ph;
            }
            self.set_column(j, &column);
        }
        let left_h = times_h(&self.covariance.data.0);
        for j in 0..N {
            let mut column = self.covariance.data.0[j];
            for i in j..N {
                column[i] += gain[j] * (variance * gain[i] - left_h[i]);
            }
            self.set_column(j, &column);
        }
        innovation
    }

    /// Sets column `j` from its diagonal on, as far as it is given, and the same row with it.
    #[inline]
    fn set_column(&mut self, j: usize, column: &[f64]) {
        for (i, &element) in column.iter().enumerate().skip(j) {
            self.set(i, j, element);
        }
    }

    /// Sets one element and its mirror image.
    #[inline]
    fn set(&mut self, i: usize, j: usize, element: f64) {
        (self.covariance.data.0[j][i], self.covariance.data.0[i][j]) = (element, element);
    }

    /// All numbers are finite and no variance is negative.
    pub fn is_sound(&self) -> bool {
        // To look at all of them at once is quicker than to stop at the first.
        let are_finite = |numbers: &[f64]| numbers.iter().fold(true, |all, x| all & x.is_finite());
        are_finite(&self.mean.data.0[0])
            && are_finite(self.covariance.data.0.as_flattened())
            && (0..N).all(|i| self.covariance[(i, i)] >= 0.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::vector;

    #[test]
    fn a_constant_is_learned_as_the_mean_of_its_measurements() {
        let mut filter = Gaussian::<1>::new([0.0], [1e6]);
        for y in [1.0, 2.0, 3.0, 6.0] {
            filter.update(&vector![1.0], y - filter.mean[0], 4.0);
        }
        assert!((filter.mean[0] - 3.0).abs() < 1e-6);
        assert!((filter.std(0) - 1.0).abs() < 1e-6, "2/√4, got {}", filter.std(0));
    }

    #[test]
    fn the_covariance_stays_positive_over_a_million_exact_measurements() {
        let mut filter = Gaussian::<3>::new([0.0; 3], [1e3, 1.0, 1e-6]);
        let mut angle = 0.0_f64;
        for _ in 0..1_000_000 {
            angle += 0.1;
            let h = vector![angle.sin(), 1.0, 1e3 * angle.cos()];
            filter.inflate(0, 1e-12);
            filter.update(&h, 0.0, 1e-9);
        }
        assert!(filter.is_sound());
        assert!(filter.covariance.symmetric_eigenvalues().min() >= 0.0);
    }

    #[test]
    fn components_that_stand_alone_are_together_no_surer_than_they_were() {
        let mut filter = Gaussian::<4>::new([0.0; 4], [1.0, 0.1, 10.0, 2.0]);
        for i in 0..50 {
            let t = f64::from(i);
            let h = vector![t.sin(), 10.0 * (0.7 * t).cos(), 0.1, (1.9 * t).sin()];
            filter.update(&h, 0.0, 0.3);
            let among = [0, 1, 3];
            let alone = vector![0, 1, 3].map(|i| filter.alone_std(i, &among).powi(2));
            let together = SMatrix::<f64, 3, 3>::from_fn(|i, j| filter.covariance[(among[i], among[j])]);
            let more = SMatrix::from_diagonal(&alone) - together;
            assert!(more.symmetric_eigenvalues().min() >= -1e-12, "{more}");
        }
    }

    #[test]
    fn components_that_stay_need_no_rows_of_a_transition() {
        let mut whole = Gaussian::<5>::new([0.0; 5], [1.0, 0.1, 10.0, 2.0, 0.5]);
        whole.update(&vector![1.0, -2.0, 0.3, 0.7, -1.1], 0.0, 0.3);
        whole.update(&vector![0.2, 1.5, -0.4, 0.1, 2.0], 0.0, 0.2);
        let mut moving = whole;
        let rows = SMatrix::<f64, 3, 5>::from_fn(|i, j| {
            f64::from(i == j) + 0.1 * (i as f64 + 1.0) - 0.03 * (j * j) as f64
        });
        let mut transition = SMatrix::<f64, 5, 5>::identity();
        transition.fixed_view_mut::<3, 5>(0, 0).copy_from(&rows);
        let noise = [0.1, 0.2, 0.0, 0.4, 0.01];
        whole.predict_covariance(&transition, &SMatrix::from_diagonal(&SVector::from(noise)));
        moving.predict_covariance_of_moving(&rows, &noise);
        assert!((whole.covariance - moving.covariance).amax() < 1e-12 * whole.covariance.amax());
    }

    #[test]
    fn a_measurement_that_is_not_a_number_changes_nothing() {
        let mut filter = Gaussian::<2>::new([1.0, 2.0], [1.0, 1.0]);
        let before = filter;
        filter.update(&vector![1.0, 0.0], f64::NAN, 1.0);
        filter.update(&vector![1.0, 0.0], 1.0, f64::INFINITY);
        assert_eq!(filter, before);
    }
}
