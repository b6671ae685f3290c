//! Mappings fitted to pairs of slope and friction, and whether the pairs support one.

use serde::Serialize;
use thiserror::Error;

use super::regression::{Point, Regression, Shape};
use super::{MappingConfig, MappingKind};
use crate::filter::student;

/// Tuned with the test `calibrate`: sets of pairs with and without a connection.
struct Tuning {
    /// The slopes have to spread over this many of their standard deviations, …
    spread_in_std: f64,
    /// … and by this share of their mean.
    relative_spread: f64,
    /// A gap between neighbouring slopes of more than this share of the range is told.
    gap: f64,
}

const TUNING: Tuning = Tuning { spread_in_std: 4.0, relative_spread: 0.15, gap: 0.4 };

/// The slope that had settled on a surface, and what an ABS braking on it gave.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Pair {
    /// Slope, mean of the driven wheels.
    pub slope: f64,
    /// Its standard deviation.
    pub slope_std: f64,
    /// Friction by (6.2).
    pub mu: f64,
    /// Its standard deviation.
    pub mu_std: f64,
    /// How rough the road was before the braking, m/s, where that is known.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub roughness: Option<f64>,
}

/// A mapping fitted.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MappingFit {
    /// Which function; `None`: the constant that the others have to beat.
    pub kind: Option<MappingKind>,
    /// The line in k or k².
    pub regression: Regression,
    /// Probability that pairs without any connection look at least this much like one (F-test against
    /// no slope). For the quadratic mapping, whose slope is its only coefficient, it says little.
    pub p_value: f64,
}

/// Why the pairs support no mapping.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum Refusal {
    /// Not enough of them.
    #[error(
        "too few pairs: {found}, and {needed} are needed; drive on each surface until the slope is \
         valid, then brake into the ABS, several times"
    )]
    TooFew {
        /// Pairs there are.
        found: usize,
        /// Pairs needed.
        needed: usize,
    },
    /// All on one surface.
    #[error(
        "the slopes are not spread enough: {low:.1} to {high:.1}, known within ±{std:.1} each; brake on \
         surfaces of different stiffness, too"
    )]
    NotSpread {
        /// Least slope.
        low: f64,
        /// Largest slope.
        high: f64,
        /// Their typical standard deviation.
        std: f64,
    },
    /// Stiffer surfaces with less friction.
    #[error(
        "friction falls with stiffness (mu = {a:.4} k + {b:.3}, p = {p_value:.3}): no property of tires; \
         look at the list for brakings on surfaces that are not alike within themselves"
    )]
    NegativeSlope {
        /// Slope.
        a: f64,
        /// Intercept.
        b: f64,
        /// Of the F-test.
        p_value: f64,
    },
    /// The constant does as well.
    #[error(
        "stiffness says too little of friction here: a line is not significantly better than the constant \
         mu = {constant:.2} (p = {p_value:.3}, needs below {needed}; R² = {r_square:.2}). These surfaces \
         are not told apart by their stiffness, or the slopes were not right"
    )]
    NoConnection {
        /// Mean friction.
        constant: f64,
        /// Of the F-test.
        p_value: f64,
        /// What it would have to be below.
        needed: f64,
        /// Of the line.
        r_square: f64,
    },
    /// Without one of the pairs nothing is left.
    #[error(
        "the mapping rests on one braking: without the pair (slope {slope:.1}, mu {mu:.2}) it is gone \
         (p = {p_value:.3}); brake again on that surface"
    )]
    RestsOnOne {
        /// The pair's slope.
        slope: f64,
        /// The pair's friction.
        mu: f64,
        /// Of the F-test without it.
        p_value: f64,
    },
}

/// Everything that was fitted, and what came of it.
#[derive(Clone, Debug)]
pub struct Calibration {
    /// Constant, linear and quadratic, as far as there are pairs enough to fit them.
    pub fits: Vec<MappingFit>,
    /// The mapping the pairs support.
    pub chosen: Result<MappingConfig, Refusal>,
    /// What to bear in mind with it.
    pub remarks: Vec<String>,
}

impl Calibration {
    /// Fewer pairs support nothing. Tuned with the test `calibrate`.
    pub const FEWEST_PAIRS: usize = 6;
    /// By chance fewer than one in a hundred sets of unconnected pairs look connected. Statistical.
    pub const SIGNIFICANCE: f64 = 0.01;
    /// The same for the pairs with any one left out. Statistical: one in twenty.
    const SIGNIFICANCE_WITHOUT_ONE: f64 = 0.05;
    /// A criterion of Akaike lower by this is noticeably better. Statistical: models within 2 of the best are
    /// supported nearly as well (Burnham and Anderson, 2002).
    const NOTICEABLY: f64 = 2.0;

    /// Fits the mappings and chooses.
    pub fn new(pairs: &[Pair]) -> Self {
        let fits: Vec<_> = [None, Some(MappingKind::Linear), Some(MappingKind::Quadratic)]
            .into_iter()
            .filter_map(|kind| fit(pairs, kind))
            .collect();
        let chosen = choose(pairs, &fits);
        let remarks = if chosen.is_ok() { remarks(pairs) } else { Vec::new() };
        Self { fits, chosen, remarks }
    }

    /// The fit of this kind.
    pub fn fit(&self, kind: Option<MappingKind>) -> Option<&MappingFit> {
        self.fits.iter().find(|fit| fit.kind == kind)
    }
}

impl MappingFit {
    /// As a configuration.
    fn config(&self, pairs: &[Pair]) -> Option<MappingConfig> {
        let r = &self.regression;
        let (coefficients, covariance) = match self.kind? {
            MappingKind::Linear => {
                let c = r.covariance;
                (vec![r.a, r.b], vec![vec![c.aa, c.ab], vec![c.ab, c.bb]])
            }
            MappingKind::Quadratic => (vec![r.a], vec![vec![r.covariance.aa]]),
        };
        let (low, high) = range(pairs);
        Some(MappingConfig {
            kind: self.kind?,
            coefficients,
            covariance,
            residual_std: self.residual_std(),
            slope_range: [low, high],
            roughness_mps: roughness_range(pairs),
            pairs: pairs.len(),
        })
    }

    /// How far a braking's friction lies from the mapping at a known slope.
    pub fn residual_std(&self) -> f64 {
        self.regression.excess_std.hypot(self.regression.measurement_std)
    }
}

fn fit(pairs: &[Pair], kind: Option<MappingKind>) -> Option<MappingFit> {
    let point = |pair: &Pair| {
        let Pair { slope, slope_std, mu, mu_std, .. } = *pair;
        match kind {
            Some(MappingKind::Quadratic) => {
                Point { x: slope * slope, x_std: 2.0 * slope * slope_std, y: mu, y_std: mu_std }
            }
            _ => Point { x: slope, x_std: slope_std, y: mu, y_std: mu_std },
        }
    };
    let points: Vec<_> = pairs.iter().map(point).collect();
    let shape = match kind {
        None => Shape::Constant,
        Some(MappingKind::Linear) => Shape::Line,
        Some(MappingKind::Quadratic) => Shape::Proportional,
    };
    let regression = Regression::fit(&points, shape)?;
    let p_value = match kind {
        None => 1.0,
        Some(_) => student::two_sided(regression.f_statistic().sqrt(), regression.freedom()),
    };
    Some(MappingFit { kind, regression, p_value })
}

fn range(pairs: &[Pair]) -> (f64, f64) {
    pairs.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), pair| {
        (low.min(pair.slope), high.max(pair.slope))
    })
}

/// Of the smoothest and the roughest road, where all are known.
fn roughness_range(pairs: &[Pair]) -> Option<[f64; 2]> {
    pairs.iter().try_fold([f64::INFINITY, 0.0], |[low, high], pair| {
        pair.roughness.map(|roughness| [f64::min(low, roughness), f64::max(high, roughness)])
    })
}

fn choose(pairs: &[Pair], fits: &[MappingFit]) -> Result<MappingConfig, Refusal> {
    let too_few = Refusal::TooFew { found: pairs.len(), needed: Calibration::FEWEST_PAIRS };
    if pairs.len() < Calibration::FEWEST_PAIRS {
        return Err(too_few);
    }
    let n = pairs.len() as f64;
    let (low, high) = range(pairs);
    let std = (pairs.iter().map(|pair| pair.slope_std * pair.slope_std).sum::<f64>() / n).sqrt();
    let mean = pairs.iter().map(|pair| pair.slope).sum::<f64>() / n;
    let needed = (TUNING.spread_in_std * std).max(TUNING.relative_spread * mean);
    let spread = high - low;
    if spread.is_nan() || spread < needed {
        return Err(Refusal::NotSpread { low, high, std });
    }
    let [constant, linear, quadratic] = fits else { return Err(too_few) };
    let line = &linear.regression;
    let significant = linear.p_value < Calibration::SIGNIFICANCE
        && line.aicc + Calibration::NOTICEABLY < constant.regression.aicc;
    if !significant {
        return Err(Refusal::NoConnection {
            constant: constant.regression.b,
            p_value: linear.p_value,
            needed: Calibration::SIGNIFICANCE,
            r_square: line.r_square,
        });
    }
    if line.a <= 0.0 {
        return Err(Refusal::NegativeSlope { a: line.a, b: line.b, p_value: linear.p_value });
    }
    for left_out in 0..pairs.len() {
        let mut others = pairs.to_vec();
        let pair = others.remove(left_out);
        let p_value = fit(&others, Some(MappingKind::Linear)).map_or(1.0, |fit| fit.p_value);
        if p_value > Calibration::SIGNIFICANCE_WITHOUT_ONE {
            return Err(Refusal::RestsOnOne { slope: pair.slope, mu: pair.mu, p_value });
        }
    }
    let best =
        if quadratic.regression.aicc + Calibration::NOTICEABLY < line.aicc { quadratic } else { linear };
    best.config(pairs).ok_or(too_few)
}

fn remarks(pairs: &[Pair]) -> Vec<String> {
    let (low, high) = range(pairs);
    let mut slopes: Vec<f64> = pairs.iter().map(|pair| pair.slope).collect();
    slopes.sort_by(f64::total_cmp);
    let gap =
        slopes.windows(2).map(|pair| (pair[0], pair[1])).max_by(|a, b| (a.1 - a.0).total_cmp(&(b.1 - b.0)));
    gap.filter(|(from, to)| to - from > TUNING.gap * (high - low))
        .map(|(from, to)| {
            format!(
                "no pair between slopes {from:.0} and {to:.0}: in between the mapping is a guess that no \
                 braking has checked"
            )
        })
        .into_iter()
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::estimate::mapping::Mapping;
    use crate::estimates::Estimate;
    use rand::SeedableRng;
    use rand_chacha::ChaCha8Rng;
    use rand_distr::{Distribution, Normal, Uniform};

    fn pair(slope: f64, mu: f64) -> Pair {
        Pair { slope, slope_std: 1.0, mu, mu_std: 0.02, roughness: None }
    }

    #[test]
    fn the_quadratic_coefficient_is_that_of_the_thesis() {
        // Without errors in the slope and with equal ones in μ: a = Σk²μ/Σk⁴ (6.10).
        let pairs: Vec<_> = [(20.0, 0.05), (50.0, 0.24), (70.0, 0.5), (100.0, 0.99)]
            .map(|(slope, mu)| Pair { slope_std: 0.0, ..pair(slope, mu) })
            .to_vec();
        let top: f64 = pairs.iter().map(|p| p.slope.powi(2) * p.mu).sum();
        let bottom: f64 = pairs.iter().map(|p| p.slope.powi(4)).sum();
        let fit = fit(&pairs, Some(MappingKind::Quadratic)).unwrap();
        assert!((fit.regression.a - top / bottom).abs() < 1e-9 * top / bottom);
    }

    #[test]
    fn a_connection_is_found_and_a_parabola_told_from_a_line() {
        let slopes = [40.0, 45.0, 52.0, 60.0, 71.0, 80.0, 88.0, 95.0];
        let scatter = [0.01, -0.015, 0.005, 0.01, -0.01, 0.012, -0.008, 0.0];
        let make = |f: &dyn Fn(f64) -> f64| -> Vec<Pair> {
            slopes.iter().zip(scatter).map(|(&k, e)| pair(k, f(k) + e)).collect()
        };
        let chosen = Calibration::new(&make(&|k| 0.006 * k + 0.3)).chosen.unwrap();
        assert_eq!(chosen.kind, MappingKind::Linear);
        assert!((chosen.coefficients[0] - 0.006).abs() < 0.001, "{chosen:?}");
        assert_eq!((chosen.slope_range, chosen.pairs), ([40.0, 95.0], 8));
        assert_eq!(chosen.roughness_mps, None);
        let mut smooth = make(&|k| 0.006 * k + 0.3);
        for (i, pair) in smooth.iter_mut().enumerate() {
            pair.roughness = Some(0.01 + 0.002 * i as f64);
        }
        assert_eq!(Calibration::new(&smooth).chosen.unwrap().roughness_mps, Some([0.01, 0.024]));
        assert_eq!(chosen.problem(), None);
        let chosen = Calibration::new(&make(&|k| 1.1e-4 * k * k)).chosen.unwrap();
        assert_eq!(chosen.kind, MappingKind::Quadratic);
        assert_eq!(chosen.problem(), None);
    }

    #[test]
    fn what_the_pairs_do_not_support_is_refused_with_the_reason() {
        let refused = |pairs: &[Pair]| Calibration::new(pairs).chosen.unwrap_err();
        let up = |n: i32| -> Vec<Pair> {
            (0..n).map(|i| pair(40.0 + 8.0 * f64::from(i), 0.4 + 0.06 * f64::from(i))).collect()
        };
        assert!(matches!(refused(&[]), Refusal::TooFew { found: 0, needed: 6 }));
        assert!(matches!(refused(&up(5)), Refusal::TooFew { found: 5, .. }));
        let one_surface: Vec<_> = (0..8).map(|i| pair(90.0 + 0.3 * f64::from(i), 0.9)).collect();
        assert!(matches!(refused(&one_surface), Refusal::NotSpread { .. }));
        let down: Vec<_> = up(8).into_iter().map(|p| Pair { mu: 1.2 - p.mu, ..p }).collect();
        assert!(matches!(refused(&down), Refusal::NegativeSlope { .. }));
        let unconnected: Vec<_> = [0.3, 0.9, 0.5, 0.8, 0.2, 0.7, 0.4, 0.6]
            .iter()
            .enumerate()
            .map(|(i, &mu)| pair(20.0 + 5.0 * i as f64, mu))
            .collect();
        assert!(matches!(refused(&unconnected), Refusal::NoConnection { .. }));
        let mut one_braking: Vec<_> =
            (0..7).map(|i| pair(94.0 + 0.3 * f64::from(i), 0.9 + 0.01 * f64::from(i % 3))).collect();
        one_braking.push(pair(50.0, 0.5));
        let reason = refused(&one_braking);
        assert!(matches!(reason, Refusal::RestsOnOne { slope, .. } if slope == 50.0), "{reason}");
    }

    #[test]
    fn a_gap_between_the_slopes_is_told() {
        let pairs: Vec<_> = (0..8)
            .map(|i| {
                let gravel = i % 2 == 0;
                pair(if gravel { 50.0 } else { 95.0 } + f64::from(i), if gravel { 0.6 } else { 0.95 })
            })
            .collect();
        let calibration = Calibration::new(&pairs);
        assert!(calibration.chosen.is_ok() && calibration.remarks[0].contains("between slopes 56 and 96"));
    }

    /// Pairs of surfaces whose friction is `law` of their slope, but for a scatter.
    fn surfaces(rng: &mut ChaCha8Rng, n: usize, law: impl Fn(f64) -> f64, scatter: f64) -> Vec<(Pair, f64)> {
        let slopes = Uniform::new(40.0, 100.0).unwrap();
        let (scatter, mu_error) = (Normal::new(0.0, scatter).unwrap(), Normal::new(0.0, 0.02).unwrap());
        let slope_error = Normal::new(0.0, 3.0).unwrap();
        (0..n)
            .map(|_| {
                let k = slopes.sample(rng);
                let mu = law(k) + scatter.sample(rng) + mu_error.sample(rng);
                let pair = Pair { slope_std: 3.0, ..pair(k + slope_error.sample(rng), mu) };
                (pair, k)
            })
            .collect()
    }

    #[test]
    fn the_interval_covers_what_the_next_braking_measures() {
        let mut rng = ChaCha8Rng::seed_from_u64(6);
        let (mut inside, mut asked) = (0.0, 0.0);
        for _ in 0..400 {
            let rows = surfaces(&mut rng, 13, |k| 0.006 * k + 0.3, 0.05);
            let pairs: Vec<_> = rows.iter().map(|(pair, _)| *pair).collect();
            let fit = fit(&pairs[..12], Some(MappingKind::Linear)).unwrap();
            let mapping = Mapping::new(&fit.config(&pairs[..12]).unwrap()).unwrap();
            let next = pairs[12];
            let slope = Estimate { value: next.slope, std: next.slope_std, age_s: 0.0 };
            let (low, high) = range(&pairs[..12]);
            if (low..=high).contains(&next.slope) {
                let mapped = mapping.at(slope).unwrap();
                asked += 1.0;
                inside += f64::from(u8::from((mapped.low..=mapped.high).contains(&next.mu)));
            }
        }
        let coverage = inside / asked;
        assert!(asked > 250.0 && (0.92..=0.98).contains(&coverage), "{coverage} of {asked}");
    }

    #[test]
    fn the_slope_is_not_diluted_by_the_errors_of_the_regressor() {
        let mut rng = ChaCha8Rng::seed_from_u64(7);
        let mean = (0..200)
            .map(|_| {
                let pairs: Vec<_> = surfaces(&mut rng, 12, |k| 0.006 * k + 0.3, 0.0)
                    .into_iter()
                    // Errors as large as half of the spread: ordinary least squares loses a fifth.
                    .map(|(pair, k)| Pair { slope: k + 3.0 * (pair.slope - k), slope_std: 9.0, ..pair })
                    .collect();
                fit(&pairs, Some(MappingKind::Linear)).unwrap().regression.a
            })
            .sum::<f64>()
            / 200.0;
        assert!((mean / 0.006 - 1.0).abs() < 0.05, "{mean}");
    }

    #[test]
    fn unconnected_pairs_are_hardly_ever_mapped() {
        let mut rng = ChaCha8Rng::seed_from_u64(8);
        let mapped = (0..1000)
            .filter(|_| {
                let pairs: Vec<_> =
                    surfaces(&mut rng, 10, |_| 0.6, 0.2).into_iter().map(|(pair, _)| pair).collect();
                Calibration::new(&pairs).chosen.is_ok()
            })
            .count();
        // Half of the significance, as falling lines are refused, too.
        assert!(mapped <= 12, "{mapped} of 1000");
    }
}
