//! A mapping at work: from the slope now to the friction with its interval.

use serde::{Deserialize, Serialize};

use super::regression::Covariance;
use crate::estimates::Estimate;
use crate::filter::student;

/// Which function of the slope.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum MappingKind {
    /// μ = a k + b (thesis 6.5).
    Linear,
    /// μ = a k² (thesis 6.7).
    Quadratic,
}

impl MappingKind {
    /// How many coefficients it has.
    pub const fn coefficients(self) -> usize {
        match self {
            Self::Linear => 2,
            Self::Quadratic => 1,
        }
    }
}

/// `[estimators.mapping]`, as `gripd calibrate` writes it. It holds for the car, its tires, and roads
/// like those it was calibrated on.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct MappingConfig {
    /// Which function of the slope k.
    pub kind: MappingKind,
    /// Linear: a and b; quadratic: a.
    pub coefficients: Vec<f64>,
    /// Their covariance, row by row.
    pub covariance: Vec<Vec<f64>>,
    /// How far a braking's friction lies from the mapping, standard deviation.
    pub residual_std: f64,
    /// Least and largest slope it was calibrated on. There is no mapping beyond.
    pub slope_range: [f64; 2],
    /// Roughness of its smoothest and its roughest road, m/s, where that was known: a road clearly smoother or
    /// rougher is none like those.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub roughness_mps: Option<[f64; 2]>,
    /// Number of pairs it stands on: few pairs make wide intervals.
    pub pairs: usize,
}

impl MappingConfig {
    /// The first value that cannot be: its key and what would be accepted.
    pub fn problem(&self) -> Option<(&'static str, &'static str)> {
        let p = self.kind.coefficients();
        let covariance = self.covariance.iter().map(Vec::len).collect::<Vec<_>>() == vec![p; p]
            && self.covariance.iter().flatten().all(|c| c.is_finite())
            && (0..p).all(|i| self.covariance[i][i] >= 0.0)
            && (p == 1 || {
                let c = &self.covariance;
                let both = c[0][0] * c[1][1];
                c[0][1] == c[1][0] && c[0][1] * c[0][1] <= both * (1.0 + 1e-9)
            });
        let [low, high] = self.slope_range;
        let checks = [
            (
                "mapping.coefficients",
                self.coefficients.len() == p && self.coefficients.iter().all(|c| c.is_finite()),
                "must be [a, b] of μ = a k + b where the kind is linear, [a] of μ = a k² where it is quadratic",
            ),
            (
                "mapping.covariance",
                covariance,
                "must be the coefficients' covariance: a row for each, symmetric, with no negative variance",
            ),
            (
                "mapping.residual_std",
                self.residual_std.is_finite() && self.residual_std > 0.0,
                "must be positive",
            ),
            (
                "mapping.slope_range",
                low.is_finite() && high.is_finite() && low > 0.0 && low < high,
                "must be the least and the largest slope, both positive",
            ),
            (
                "mapping.roughness_mps",
                self.roughness_mps.is_none_or(|[low, high]| low >= 0.0 && low <= high && high.is_finite()),
                "must be the least and the largest roughness, none negative",
            ),
            ("mapping.pairs", self.pairs > p, "must be more than the coefficients"),
        ];
        checks.into_iter().find(|(_, good, _)| !good).map(|(key, _, reason)| (key, reason))
    }
}

/// Friction by the mapping.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MappedFriction {
    /// Best value.
    pub mu: f64,
    /// 95 % interval of what an ABS braking would measure now; not below zero.
    pub low: f64,
    /// Its upper end.
    pub high: f64,
}

/// A mapping, ready to be evaluated.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Mapping {
    kind: MappingKind,
    a: f64,
    b: f64,
    covariance: Covariance,
    residual_variance: f64,
    range: [f64; 2],
    roughness: Option<[f64; 2]>,
    /// Half-width of the 95 % interval in standard deviations.
    quantile: f64,
}

impl Mapping {
    /// Roads that were braked on are like others up to this factor in roughness, and so much beyond it, m/s. Tuned
    /// with the test `calibrate`.
    const ALIKE: (f64, f64) = (1.5, 0.01);

    /// From a checked configuration; `None` where [`MappingConfig::problem`] finds one.
    pub fn new(config: &MappingConfig) -> Option<Self> {
        if config.problem().is_some() {
            return None;
        }
        let (a, b, covariance) = match (config.coefficients.as_slice(), config.covariance.as_slice()) {
            ([a, b], [first, second]) => (*a, *b, Covariance { aa: first[0], ab: first[1], bb: second[1] }),
            ([a], [row]) => (*a, 0.0, Covariance { aa: row[0], ..Covariance::default() }),
            _ => return None,
        };
        let freedom = config.pairs as f64 - config.kind.coefficients() as f64;
        Some(Self {
            kind: config.kind,
            a,
            b,
            covariance,
            residual_variance: config.residual_std * config.residual_std,
            range: config.slope_range,
            roughness: config.roughness_mps,
            quantile: student::quantile(0.95, freedom),
        })
    }

    /// Is a road of this roughness like those of the calibration (thesis 3.4.1)? Gravel is soft and rough, snow and
    /// ice are soft and smooth: one mapping for both would take gravel for ice. What is not known speaks for it.
    pub fn holds_on(&self, roughness: Option<Estimate>) -> bool {
        let (Some([low, high]), Some(now)) = (self.roughness, roughness) else { return true };
        let (factor, beyond) = Self::ALIKE;
        let (least, most) = now.ci95();
        most >= low / factor - beyond && least <= high * factor + beyond
    }

    /// Friction at a slope. Where the slope lies outside the calibrated range by more than its own
    /// 95 % interval there is none; just outside, the nearest calibrated slope counts.
    pub fn at(&self, slope: Estimate) -> Option<MappedFriction> {
        let (lowest, highest) = slope.ci95();
        let [from, to] = self.range;
        // Written so that what is not a number fails.
        if !(highest >= from && lowest <= to) {
            return None;
        }
        let k = slope.value.clamp(from, to);
        let (x, slope_of_mu) = match self.kind {
            MappingKind::Linear => (k, self.a),
            MappingKind::Quadratic => (k * k, 2.0 * self.a * k),
        };
        let Covariance { aa, ab, bb } = self.covariance;
        let variance =
            x * x * aa + 2.0 * x * ab + bb + self.residual_variance + (slope_of_mu * slope.std).powi(2);
        let half = self.quantile * variance.max(0.0).sqrt();
        let mu = self.a * x + self.b;
        (mu > 0.0 && half.is_finite()).then_some(MappedFriction {
            mu,
            low: (mu - half).max(0.0),
            high: mu + half,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn linear() -> MappingConfig {
        MappingConfig {
            kind: MappingKind::Linear,
            coefficients: vec![0.008, 0.2],
            covariance: vec![vec![1e-6, -7e-5], vec![-7e-5, 5.2e-3]],
            residual_std: 0.04,
            slope_range: [45.0, 100.0],
            roughness_mps: None,
            pairs: 12,
        }
    }

    fn slope(value: f64, std: f64) -> Estimate {
        Estimate { value, std, age_s: 0.0 }
    }

    #[test]
    fn the_interval_holds_every_uncertainty() {
        let mapping = Mapping::new(&linear()).unwrap();
        let friction = mapping.at(slope(80.0, 3.0)).unwrap();
        // 6400e-6 − 160·7e-5 + 5.2e-3 + 1.6e-3 + (0.008·3)² = 0.002576; t(10) = 2.2281.
        assert!((friction.mu - 0.84).abs() < 1e-12);
        assert!((friction.high - friction.mu - 2.2281 * 0.002576_f64.sqrt()).abs() < 1e-4, "{friction:?}");
        let quadratic = MappingConfig {
            kind: MappingKind::Quadratic,
            coefficients: vec![1e-4],
            covariance: vec![vec![1e-12]],
            ..linear()
        };
        let friction = Mapping::new(&quadratic).unwrap().at(slope(80.0, 3.0)).unwrap();
        // 6400²e-12 + 1.6e-3 + (0.016·3)² = 0.00394496; t(11) = 2.2010.
        assert!((friction.mu - 0.64).abs() < 1e-12);
        assert!((friction.mu - friction.low - 2.2010 * 0.003_944_96_f64.sqrt()).abs() < 1e-4);
    }

    #[test]
    fn there_is_no_mapping_outside_the_calibrated_range() {
        let mapping = Mapping::new(&linear()).unwrap();
        assert_eq!(mapping.at(slope(30.0, 3.0)), None);
        assert_eq!(mapping.at(slope(120.0, 3.0)), None);
        assert_eq!(mapping.at(slope(f64::NAN, 3.0)), None);
        // A little outside, within the slope's own uncertainty: the edge counts.
        assert_eq!(mapping.at(slope(102.0, 3.0)).unwrap().mu, mapping.at(slope(100.0, 3.0)).unwrap().mu);
    }

    #[test]
    fn it_holds_on_roads_as_rough_as_those_of_the_calibration() {
        let unknown = Mapping::new(&linear()).unwrap();
        let smooth = Mapping::new(&MappingConfig { roughness_mps: Some([0.005, 0.03]), ..linear() }).unwrap();
        let rough = Mapping::new(&MappingConfig { roughness_mps: Some([0.08, 0.12]), ..linear() }).unwrap();
        let on = |mapping: &Mapping| {
            [0.0, 0.04, 0.1, 0.3].map(|roughness| mapping.holds_on(Some(slope(roughness, 0.005))))
        };
        assert_eq!(on(&unknown), [true; 4]);
        assert_eq!(on(&smooth), [true, true, false, false]);
        assert_eq!(on(&rough), [false, true, true, false]);
        assert!(smooth.holds_on(None));
        // Nobody knows well enough whether it is one.
        assert!(smooth.holds_on(Some(slope(0.1, 0.05))));
    }

    #[test]
    fn tables_that_cannot_be_are_refused_by_key() {
        assert_eq!(linear().problem(), None);
        let broken = [
            ("mapping.coefficients", MappingConfig { coefficients: vec![0.01], ..linear() }),
            ("mapping.covariance", MappingConfig { covariance: vec![vec![1e-6]], ..linear() }),
            (
                "mapping.covariance",
                MappingConfig { covariance: vec![vec![1e-6, 1.0], vec![1.0, 1e-3]], ..linear() },
            ),
            ("mapping.residual_std", MappingConfig { residual_std: 0.0, ..linear() }),
            ("mapping.slope_range", MappingConfig { slope_range: [90.0, 50.0], ..linear() }),
            ("mapping.roughness_mps", MappingConfig { roughness_mps: Some([0.2, 0.1]), ..linear() }),
            ("mapping.pairs", MappingConfig { pairs: 2, ..linear() }),
        ];
        for (key, config) in broken {
            assert_eq!(config.problem().map(|(key, _)| key), Some(key));
            assert_eq!(Mapping::new(&config), None);
        }
    }
}
