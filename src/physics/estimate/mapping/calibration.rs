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
mod tests;
