//! Does a filter keep what it promises? The statistics over a whole drive, with their bounds.
//!
//! [`super::InnovationMonitor`] watches the same while driving, with forgetting and without bounds.

use super::Innovation;

/// Normalized innovations of a stretch: their mean square (NIS), their mean, and the correlation from one
/// to the next.
///
/// For a consistent filter the NIS summed over n scalar innovations is χ² distributed with n degrees of
/// freedom, and innovations are independent and without mean; so there are bounds for all three.
///
/// ```
/// use physics::filter::{Consistency, Innovation};
///
/// let mut consistency = Consistency::default();
/// for i in 0..400 {
///     // Twice as large as the filter expects, with alternating sign.
///     let residual = if i % 2 == 0 { 2.0 } else { -2.0 };
///     consistency.step(&Innovation { residual, variance: 1.0 });
/// }
/// assert_eq!(consistency.nis(), 4.0);
/// assert!(!consistency.nis_bounds(1.96).contains(&consistency.nis()));
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Consistency {
    count: u64,
    sum: f64,
    squares: f64,
    products: f64,
    previous: f64,
}

impl Consistency {
    /// Takes one innovation. What is not finite does not count.
    pub fn step(&mut self, innovation: &Innovation) {
        let value = innovation.normalized();
        if !value.is_finite() {
            return;
        }
        self.count += 1;
        self.sum += value;
        self.squares += value * value;
        self.products += value * self.previous;
        self.previous = value;
    }

    /// How many innovations.
    pub fn count(&self) -> u64 {
        self.count
    }

    /// Mean normalized innovation squared; 1 when consistent, above it when the filter believes itself
    /// too much. Not a number before the first innovation.
    pub fn nis(&self) -> f64 {
        self.squares / self.count as f64
    }

    /// Between what the NIS of a consistent filter lies, with the probability that a normal variable lies
    /// within ± `deviations` (1.96: 95 %). By Wilson and Hilferty's cube root, within 1 % from ten
    /// innovations on.
    pub fn nis_bounds(&self, deviations: f64) -> std::ops::RangeInclusive<f64> {
        let spread = 2.0 / (9.0 * self.count as f64);
        let quantile = |z: f64| (1.0 - spread + z * spread.sqrt()).max(0.0).powi(3);
        quantile(-deviations)..=quantile(deviations)
    }

    /// Mean normalized innovation: what the filter is biased by, in standard deviations of one
    /// measurement. A consistent one stays within deviations/√n of zero.
    pub fn bias(&self) -> f64 {
        self.sum / self.count as f64
    }

    /// Correlation from one innovation to the next. A consistent filter's stays within deviations/√n of
    /// zero.
    pub fn correlation(&self) -> f64 {
        if self.squares > 0.0 { self.products / self.squares } else { 0.0 }
    }

    /// Are NIS, bias and correlation all within their bounds?
    pub fn holds(&self, deviations: f64) -> bool {
        let limit = deviations / (self.count as f64).sqrt();
        self.nis_bounds(deviations).contains(&self.nis())
            && self.bias().abs() <= limit
            && self.correlation().abs() <= limit
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::SeedableRng;
    use rand_distr::{Distribution, StandardNormal};

    fn fed(seed: u64, count: usize, mut residual: impl FnMut(f64) -> f64) -> Consistency {
        let mut random = rand_chacha::ChaCha8Rng::seed_from_u64(seed);
        let mut consistency = Consistency::default();
        for _ in 0..count {
            let white: f64 = StandardNormal.sample(&mut random);
            consistency.step(&Innovation { residual: residual(white), variance: 1.0 });
        }
        consistency
    }

    /// Tables of χ²: 2.5 % and 97.5 % of 10 degrees are 3.247 and 20.483, of 100 74.222 and 129.561.
    #[test]
    fn the_bounds_are_those_of_the_tables() {
        for (count, low, high) in [(10, 3.247, 20.483), (100, 74.222, 129.561)] {
            let bounds = fed(1, count, |white| white).nis_bounds(1.959_964);
            let degrees = count as f64;
            assert!((bounds.start() * degrees / low - 1.0).abs() < 0.01, "{count}: {bounds:?}");
            assert!((bounds.end() * degrees / high - 1.0).abs() < 0.01, "{count}: {bounds:?}");
        }
    }

    #[test]
    fn a_consistent_filter_is_within_its_bounds_as_often_as_promised() {
        let inside = |test: &dyn Fn(&Consistency) -> bool| {
            (0..1000).filter(|seed| test(&fed(*seed, 50, |white| white))).count()
        };
        let nis = inside(&|it| it.nis_bounds(1.96).contains(&it.nis()));
        assert!((930..=970).contains(&nis), "{nis} of 1000");
        let bias = inside(&|it| it.bias().abs() < 1.96 / 50f64.sqrt());
        assert!((930..=970).contains(&bias), "{bias} of 1000");
        let correlation = inside(&|it| it.correlation().abs() < 1.96 / 50f64.sqrt());
        assert!((930..=975).contains(&correlation), "{correlation} of 1000");
    }

    #[test]
    fn too_sure_too_modest_biased_and_repeating_filters_are_found_out() {
        assert!(fed(2, 2000, |white| white).holds(3.0));
        assert!(!fed(2, 2000, |white| 1.2 * white).holds(3.0));
        assert!(!fed(2, 2000, |white| 0.8 * white).holds(3.0));
        assert!(!fed(2, 2000, |white| 0.98 * white + 0.2).holds(3.0));
        let mut last = 0.0;
        let coloured = fed(2, 2000, |white| {
            last = 0.3 * last + (1.0_f64 - 0.09).sqrt() * white;
            last
        });
        assert!(coloured.nis_bounds(3.0).contains(&coloured.nis()) && !coloured.holds(3.0));
    }
}
