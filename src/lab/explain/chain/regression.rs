//! Linear regression whose uncertainty can be believed with coloured residuals.

use nalgebra::{SMatrix, SVector};

/// Least number of blocks for any statement. Statistical: four degrees of freedom for Student's distribution.
const LEAST_BLOCKS: usize = 5;
/// Autocorrelation is followed so many rows at most. Numerical: bounds the cost.
const LONGEST_LAG: usize = 400;
/// Significance of a verdict, in standard deviations of a normal distribution.
/// Statistical: six false alarms in 100,000.
pub(super) const SIGNIFICANT: f64 = 4.0;

/// One equation: y = x · θ + e.
#[derive(Clone, Copy, Debug)]
pub(super) struct Row<const K: usize> {
    pub(super) x: [f64; K],
    pub(super) y: f64,
    /// Which block it belongs to, ascending.
    pub(super) block: usize,
    /// Its place in time; neighbours differ by one.
    pub(super) place: usize,
}

/// What is known of a coefficient before: mean and standard deviation (infinite: nothing).
pub(super) type Prior = (f64, f64);
/// Nothing is known.
pub(super) const FREE: Prior = (0.0, f64::INFINITY);

/// The result.
#[derive(Clone, Copy, Debug)]
pub(super) struct Fit<const K: usize> {
    pub(super) value: [f64; K],
    pub(super) std: [f64; K],
    /// Share of the variance of y explained.
    pub(super) explained: f64,
    pub(super) blocks: usize,
}

impl<const K: usize> Fit<K> {
    /// A coefficient in its standard deviations.
    pub(super) fn t(&self, index: usize) -> f64 {
        self.value[index] / self.std[index]
    }

    /// Is it other than zero beyond doubt?
    pub(super) fn is_significant(&self, index: usize) -> bool {
        self.t(index).abs() > student(self.blocks)
    }
}

/// The t-value that is exceeded as seldom as four standard deviations (Cornish–Fisher).
pub(super) fn student(blocks: usize) -> f64 {
    let (z, n) = (SIGNIFICANT, blocks.saturating_sub(1).max(1) as f64);
    z + (z.powi(3) + z) / (4.0 * n) + (5.0 * z.powi(5) + 16.0 * z.powi(3) + 3.0 * z) / (96.0 * n * n)
}

/// Fits; `None` if there is too little.
pub(super) fn fit<const K: usize>(rows: &[Row<K>], prior: [Prior; K]) -> Option<Fit<K>> {
    let sums = MomentSums::of(rows)?;
    let weak = prior.map(|(mean, std)| (mean, if std.is_finite() { std } else { 1e6 }));
    // The noise decides what weight the priors have; it is known after the first fit.
    let mut theta = sums.solve(&sums.total, &weak, 1e-9)?.0;
    let mut noise = 1.0;
    for _ in 0..2 {
        noise = effective_variance(rows, &theta);
        theta = sums.solve(&sums.total, &weak, noise)?.0;
    }
    let (theta, covariance) = sums.solve(&sums.total, &weak, noise).map(|(_, c)| (theta, c))?;
    let blocks = sums.blocks.len();
    let mut jackknife = SVector::<f64, K>::zeros();
    for block in &sums.blocks {
        let without = sums.total.minus(block);
        let (leaving, _) = sums.solve(&without, &weak, noise)?;
        jackknife += (leaving - theta).map(|d| d * d);
    }
    jackknife *= (blocks - 1) as f64 / blocks as f64;
    let residual: f64 = rows.iter().map(|row| error(row, &theta).powi(2)).sum();
    let mean = rows.iter().map(|row| row.y).sum::<f64>() / rows.len() as f64;
    let total: f64 = rows.iter().map(|row| (row.y - mean).powi(2)).sum();
    Some(Fit {
        value: theta.into(),
        std: std::array::from_fn(|i| covariance[(i, i)].max(jackknife[i]).sqrt().max(1e-12)),
        explained: if total > 0.0 { 1.0 - residual / total } else { 0.0 },
        blocks,
    })
}

fn error<const K: usize>(row: &Row<K>, theta: &SVector<f64, K>) -> f64 {
    row.y - row.x.iter().zip(theta.iter()).map(|(x, t)| x * t).sum::<f64>()
}

/// Variance of the residuals times how many rows say the same.
fn effective_variance<const K: usize>(rows: &[Row<K>], theta: &SVector<f64, K>) -> f64 {
    let errors: Vec<(usize, f64)> = rows.iter().map(|row| (row.place, error(row, theta))).collect();
    (variance(&errors) * inflation(&errors)).max(1e-18)
}

fn variance(errors: &[(usize, f64)]) -> f64 {
    errors.iter().map(|(_, e)| e * e).sum::<f64>() / errors.len().max(1) as f64
}

/// 1 + 2 Σ ρ, up to where the autocorrelation is first negative: how many rows say the same.
pub(super) fn inflation(errors: &[(usize, f64)]) -> f64 {
    let power = variance(errors);
    if power <= 0.0 {
        return 1.0;
    }
    let mut factor = 1.0;
    let mut lag = 1;
    // Every lag at first, then coarser: the sum stays, the work does not.
    while lag < LONGEST_LAG.min(errors.len()) {
        let pairs = errors.iter().zip(&errors[lag..]).filter(|(a, b)| b.0 - a.0 == lag);
        let (count, sum) = pairs.fold((0usize, 0.0), |(n, s), (a, b)| (n + 1, s + a.1 * b.1));
        if count == 0 || sum <= 0.0 {
            break;
        }
        let stride = 1 + lag / 16;
        factor += 2.0 * stride as f64 * sum / count as f64 / power;
        lag += stride;
    }
    factor
}

/// Normal equations, by block.
struct MomentSums<const K: usize> {
    blocks: Vec<Normal<K>>,
    total: Normal<K>,
}

#[derive(Clone, Copy)]
struct Normal<const K: usize> {
    a: SMatrix<f64, K, K>,
    b: SVector<f64, K>,
    count: usize,
}

impl<const K: usize> Normal<K> {
    fn zero() -> Self {
        Self { a: SMatrix::zeros(), b: SVector::zeros(), count: 0 }
    }

    fn minus(&self, other: &Self) -> Self {
        Self { a: self.a - other.a, b: self.b - other.b, count: self.count - other.count }
    }
}

impl<const K: usize> MomentSums<K> {
    fn of(rows: &[Row<K>]) -> Option<Self> {
        let mut blocks: Vec<Normal<K>> = Vec::new();
        let mut current = None;
        for row in rows {
            if current != Some(row.block) {
                current = Some(row.block);
                blocks.push(Normal::zero());
            }
            let block = blocks.last_mut()?;
            let x = SVector::<f64, K>::from(row.x);
            block.a += x * x.transpose();
            block.b += x * row.y;
            block.count += 1;
        }
        let mut total = Normal::zero();
        for block in &blocks {
            total.a += block.a;
            total.b += block.b;
            total.count += block.count;
        }
        (blocks.len() >= LEAST_BLOCKS).then_some(Self { blocks, total })
    }

    /// Coefficients and their covariance.
    fn solve(
        &self,
        sums: &Normal<K>,
        prior: &[Prior; K],
        noise: f64,
    ) -> Option<(SVector<f64, K>, SMatrix<f64, K, K>)> {
        let mut a = sums.a / noise;
        let mut b = sums.b / noise;
        for (i, (mean, std)) in prior.iter().enumerate() {
            a[(i, i)] += std.powi(-2);
            b[i] += mean * std.powi(-2);
        }
        let factor = a.cholesky()?;
        Some((factor.solve(&b), factor.inverse()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand_chacha::ChaCha8Rng;
    use rand_chacha::rand_core::SeedableRng;
    use rand_distr::{Distribution, StandardNormal};

    #[test]
    fn a_random_walk_explains_another_one_only_within_its_uncertainty() {
        let mut beyond = 0;
        for seed in 0..40 {
            let mut rng = ChaCha8Rng::seed_from_u64(seed);
            let mut draw = || -> f64 { StandardNormal.sample(&mut rng) };
            let (mut x, mut y) = (0.0, 0.0);
            let rows: Vec<Row<2>> = (0..6000)
                .map(|place| {
                    // Correlated over half a second, blocks of three.
                    x += -0.02 * x + 0.2 * draw();
                    y += -0.02 * y + 0.2 * draw();
                    Row { x: [x, 1.0], y, block: place / 300, place }
                })
                .collect();
            let fit = fit(&rows, [FREE; 2]).unwrap();
            beyond += usize::from(fit.t(0).abs() > 2.5);
            assert!(!fit.is_significant(0), "{seed}: {}", fit.t(0));
        }
        // Taken as white noise, two of three would be beyond.
        assert!(beyond <= 3, "{beyond} of 40 beyond 2.5 standard deviations");
    }
}
