//! Friction from the curvature of the slip curve: the brush model as a regression (thesis 8.1).
//!
//! μ_x = θ₁ s − θ₂ s|s|/3 + θ₃ s³/27 with θ = (C, C²/μ₁, C³/μ₂²), by a random-walk Kalman filter and a
//! CUSUM detector; μ₁ = θ₁²/θ₂, μ₂ = √(θ₁³/θ₃), μ̂ = (μ₁ + μ₂)/2 (8.3). ABS brakings and forces above
//! μ̂ calibrate it (8.4, 8.5).
//!
//! With low slip only θ₁ is observable. In the thesis θ₂ and θ₃ stay then, so that μ̂ follows the
//! square of the slope. The compensation that 8.1.1 asks for is a choice of coordinates: with
//! (ln C, ln μ₁, ln μ₂) as the state, C changes and the frictions stay, and their uncertainty grows,
//! until slip is high enough to say something of them. The regression is the same.

use nalgebra::{Matrix3, Vector3, vector};

use super::config::BrushConfig;
use crate::filter::{Cusum, Gaussian, LearnedNoise};

/// Tuned: the uncertainties with the tests `calibrate` and `sim3`, the rest with `campaign`.
struct Tuning {
    /// Relative uncertainty of everything before anything is measured, and after a change of surface.
    unknown: f64,
    /// … of which the two frictions of (8.3) do not share this: a real tire is not quite a brush.
    disagreement: f64,
    /// The curve has told more than the force that set the friction once this share of its uncertainty is left.
    tells_more: f64,
    /// A force so many deviations above the curve speaks against it (by chance one in fifteen).
    doubted: f64,
    /// A logarithm moves by at most this in one step: further off, its linearization is not true.
    stride: f64,
    /// Blocks that the learned noise remembers.
    noise_memory: f64,
    /// Drift and threshold of the CUSUM, in standard deviations: one false alarm in 10⁷ white blocks.
    cusum: (f64, f64),
    /// Normalized innovations count in the CUSUM up to this.
    clip: f64,
    /// No block tells the normalized force better than this, variance.
    least_noise: f64,
}

const TUNING: Tuning = Tuning {
    unknown: 0.5,
    disagreement: 0.15,
    tells_more: 0.5,
    doubted: 1.5,
    stride: 0.3,
    noise_memory: 200.0,
    cusum: (1.0, 8.0),
    clip: 4.0,
    least_noise: 1e-8,
};

/// The regression of the driven axle, on slips whose offset is taken off.
#[derive(Clone, Debug)]
pub struct BrushEstimator {
    config: BrushConfig,
    initial_stiffness: f64,
    /// θ, or with compensation (ln C, ln μ₁, ln μ₂).
    filter: Gaussian<3>,
    cusum: Cusum,
    noise: LearnedNoise,
    informed: bool,
    /// Its standard deviation when a force above it (8.5) set the friction, until the curve tells more.
    raised: Option<f64>,
    /// Deviations by which the last force was above the curve.
    above: f64,
    /// Seconds since the last point of the curve.
    age_s: f64,
    /// What it says of the friction; worked out when the curve changes, not at each sample.
    told: Option<BrushFriction>,
}

/// What the regression says of the friction.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BrushFriction {
    /// μ̂ of (8.3c).
    pub mu: f64,
    /// Standard deviation of μ̂ if the tire were a brush: model error comes on top.
    pub std: f64,
    /// The force in use set it (8.5): a bound from below, of which the curve has not told any more since.
    pub is_bound: bool,
    /// The last slip went with more force than this curve has for it: the road may be a better one by now.
    pub is_doubted: bool,
    /// Seconds since the last point of the curve.
    pub age_s: f64,
}

impl BrushEstimator {
    /// Beyond this share of the slip at which the brush slides, (8.1) no longer holds. Physical: thesis 8.1; there
    /// the whole contact patch slides.
    const SLIP_LIMIT: f64 = 1.0;
    /// Friction outside these is no friction. Physical: wet ice, and more than any road tire.
    const MU_LIMITS: (f64, f64) = (0.03, 2.0);

    /// Starts from the slope's prior and the configured friction.
    pub fn new(initial_stiffness: f64, config: &BrushConfig) -> Self {
        let mut estimator = Self {
            config: config.clone(),
            initial_stiffness,
            filter: Gaussian::new([0.0; 3], [0.0; 3]),
            cusum: Cusum::new(TUNING.cusum.0, TUNING.cusum.1),
            noise: LearnedNoise::new(TUNING.noise_memory),
            informed: false,
            raised: None,
            above: 0.0,
            age_s: f64::INFINITY,
            told: None,
        };
        estimator.start();
        estimator
    }

    fn start(&mut self) {
        self.informed = false;
        self.raised = None;
        let theta = parameters(self.initial_stiffness, self.config.initial_mu);
        if self.config.compensate {
            self.filter = Gaussian::new(logarithms(&theta).into(), [0.0; 3]);
            self.filter.covariance = Self::relative_covariance(TUNING.unknown, TUNING.unknown);
        } else {
            self.filter = Gaussian::new(theta.into(), [0.5 * theta[0], theta[1], 2.0 * theta[2]]);
        }
    }

    /// Of (ln C, ln μ₁, ln μ₂): the frictions are almost one.
    fn relative_covariance(stiffness: f64, friction: f64) -> Matrix3<f64> {
        let (c, shared, own) =
            (stiffness.powi(2), friction.powi(2), (TUNING.disagreement * friction).powi(2));
        Matrix3::new(c, 0.0, 0.0, 0.0, shared + own, shared, 0.0, shared, shared + own)
    }

    /// θ.
    fn theta(&self) -> Vector3<f64> {
        if !self.config.compensate {
            return self.filter.mean;
        }
        let [c, mu1, mu2] = [0, 1, 2].map(|i| self.filter.mean[i].exp());
        vector![c, c * c / mu1, c.powi(3) / (mu2 * mu2)]
    }

    /// ∂θ/∂state, transposed: what turns a sensitivity to θ into one to the state.
    fn to_state(&self, theta: &Vector3<f64>) -> Matrix3<f64> {
        if self.config.compensate { logarithmic_jacobian(theta).transpose() } else { Matrix3::identity() }
    }

    /// Time passes.
    pub fn age(&mut self, elapsed_s: f64) {
        self.age_s += elapsed_s;
    }

    /// Takes the driven axle's slip (offset taken off), its uncertainty, and normalized force.
    pub fn step(&mut self, slip: f64, slip_std: f64, mu: f64, mu_std: f64, elapsed_s: f64) {
        // (8.5), noise of the force allowed for.
        if self.config.calibrate
            && let Some(friction) = self.told
            && mu.abs() - mu_std > friction.mu
        {
            self.calibrate(mu.abs(), mu_std.hypot(friction.std));
            self.raised = self.told.map(|friction| friction.std);
        }
        let theta = self.theta();
        self.walk(&theta, elapsed_s);
        if slip.abs() <= Self::SLIP_LIMIT * 3.0 * self.friction_of(&theta) / theta[0].max(1.0) {
            self.regress(&theta, slip, slip_std, mu, mu_std);
        }
        if !self.filter.is_sound() || self.theta()[0].is_nan() || self.theta()[0] <= 0.0 {
            self.start();
        }
        self.told = self.curve_friction();
    }

    fn walk(&mut self, theta: &Vector3<f64>, elapsed_s: f64) {
        let step = elapsed_s.max(0.0).sqrt();
        let walk = self.config.walk * step;
        if self.config.compensate {
            // Nothing is less known than after a change of surface.
            let known = self.filter.covariance[(1, 1)] < 2.0 * TUNING.unknown * TUNING.unknown;
            let friction_walk = if known { self.config.friction_walk * step } else { 0.0 };
            self.filter.covariance += Self::relative_covariance(walk, friction_walk);
        } else {
            for i in 0..3 {
                self.filter.inflate(i, (theta[i] * walk).powi(2));
            }
        }
    }

    fn regress(&mut self, theta: &Vector3<f64>, slip: f64, slip_std: f64, mu: f64, mu_std: f64) {
        let regressor = vector![slip, -slip * slip.abs() / 3.0, slip.powi(3) / 27.0];
        let h = self.to_state(theta) * regressor;
        let promised = mu_std * mu_std + (theta[0] * slip_std).powi(2) + TUNING.least_noise;
        let residual = mu - regressor.dot(theta);
        let variance = self.noise.variance(promised);
        let expected = self.filter.innovation(&h, residual, variance);
        self.noise.learn(&expected, promised);
        self.above = expected.normalized() * mu.signum();
        let before = self.filter.mean;
        self.filter.update(&h, residual, variance * self.noise.redundancy());
        if self.config.compensate {
            let stride = (self.filter.mean - before).amax();
            if stride > TUNING.stride {
                self.filter.mean = before + (self.filter.mean - before) * (TUNING.stride / stride);
            }
        }
        self.informed = true;
        self.age_s = 0.0;
        if let Some((raised, friction)) = self.raised.zip(self.curve_friction())
            && friction.std < TUNING.tells_more * raised
        {
            self.raised = None;
        }
        let evidence = expected.normalized().clamp(-TUNING.clip, TUNING.clip) * mu.signum();
        if self.cusum.step(evidence).is_some() {
            self.surface_changed();
        }
    }

    /// The curvature is set to that of a known friction (8.4, 8.5), known to `std`.
    pub fn calibrate(&mut self, mu: f64, std: f64) {
        if !(Self::MU_LIMITS.0..=Self::MU_LIMITS.1).contains(&mu) || !self.config.calibrate {
            return;
        }
        self.raised = None;
        let theta = self.theta();
        let stiffness_std =
            if self.config.compensate { self.filter.std(0) } else { self.filter.std(0) / theta[0] };
        let calibrated = parameters(theta[0], mu);
        // What is known of the slope stays; it tells nothing of this friction.
        let covariance = Self::relative_covariance(stiffness_std, std / mu);
        if self.config.compensate {
            self.filter.mean = logarithms(&calibrated);
            self.filter.covariance = covariance;
        } else {
            let jacobian = logarithmic_jacobian(&calibrated);
            self.filter.mean = calibrated;
            self.filter.covariance = jacobian * covariance * jacobian.transpose();
        }
        self.told = self.curve_friction();
    }

    /// The surface changed: slope and curvature may be anything near.
    pub fn surface_changed(&mut self) {
        self.raised = None;
        if self.config.compensate {
            self.filter.covariance += Self::relative_covariance(TUNING.unknown, TUNING.unknown);
        } else {
            for i in 0..3 {
                let std = TUNING.unknown * self.filter.mean[i];
                self.filter.inflate(i, std * std);
            }
        }
        self.cusum.reset();
        self.told = self.curve_friction();
    }

    /// The friction, once measured; `None` if the regression's curvature is no friction's.
    pub fn friction(&self) -> Option<BrushFriction> {
        self.told.map(|told| BrushFriction { age_s: self.age_s, ..told })
    }

    fn curve_friction(&self) -> Option<BrushFriction> {
        let theta = self.theta();
        if !self.informed || theta.min() <= 0.0 {
            return None;
        }
        let mu1 = theta[0] * theta[0] / theta[1];
        let mu2 = (theta[0].powi(3) / theta[2]).sqrt();
        let mu = 0.5 * (mu1 + mu2);
        let by_theta =
            vector![mu1 / theta[0] + 0.75 * mu2 / theta[0], -0.5 * mu1 / theta[1], -0.25 * mu2 / theta[2]];
        let gradient = self.to_state(&theta) * by_theta;
        let variance = gradient.dot(&(self.filter.covariance * gradient));
        (Self::MU_LIMITS.0..=Self::MU_LIMITS.1).contains(&mu).then(|| BrushFriction {
            mu,
            std: variance.max(0.0).sqrt(),
            is_bound: self.raised.is_some(),
            is_doubted: self.above > TUNING.doubted,
            age_s: self.age_s,
        })
    }

    fn friction_of(&self, theta: &Vector3<f64>) -> f64 {
        if theta[1] > 0.0 { theta[0] * theta[0] / theta[1] } else { self.config.initial_mu }
    }
}

/// θ = (C, C²/μ, C³/μ²) (8.2c).
fn parameters(stiffness: f64, mu: f64) -> Vector3<f64> {
    vector![stiffness, stiffness * stiffness / mu, stiffness.powi(3) / (mu * mu)]
}

/// (ln C, ln μ₁, ln μ₂) of a positive θ.
fn logarithms(theta: &Vector3<f64>) -> Vector3<f64> {
    let [c, two, three] = [theta[0].ln(), theta[1].ln(), theta[2].ln()];
    vector![c, 2.0 * c - two, 1.5 * c - 0.5 * three]
}

/// ∂θ/∂(ln C, ln μ₁, ln μ₂).
fn logarithmic_jacobian(theta: &Vector3<f64>) -> Matrix3<f64> {
    Matrix3::new(theta[0], 0.0, 0.0, 2.0 * theta[1], -theta[1], 0.0, 3.0 * theta[2], 0.0, -2.0 * theta[2])
}

#[cfg(test)]
mod tests {
    use super::*;

    fn brush(slip: f64, stiffness: f64, mu: f64) -> f64 {
        let theta = parameters(stiffness, mu);
        theta.dot(&vector![slip, -slip * slip.abs() / 3.0, slip.powi(3) / 27.0])
    }

    fn estimator(compensate: bool) -> BrushEstimator {
        BrushEstimator::new(30.0, &BrushConfig { compensate, ..BrushConfig::default() })
    }

    /// Drives with forces of up to `use_of` the friction; returns what is known at the end.
    fn drive(estimator: &mut BrushEstimator, stiffness: f64, mu: f64, use_of: f64) -> BrushFriction {
        // Slip at which the curve gives that share of μ: 1 − (1 − C s/3μ)³.
        let slip = 3.0 * mu / stiffness * (1.0 - (1.0 - use_of).cbrt());
        for i in 0..2000 {
            let slip = slip * (f64::from(i) * 0.05).sin();
            let noise = 0.003 * (f64::from(i * 7919 % 13) - 6.0) / 3.74;
            estimator.step(slip, 1e-4, brush(slip, stiffness, mu) + noise, 0.003, 0.25);
        }
        estimator.friction().unwrap()
    }

    #[test]
    fn a_curve_driven_up_to_its_limit_gives_its_friction_in_either_coordinates() {
        for compensate in [false, true] {
            let friction = drive(&mut estimator(compensate), 40.0, 0.6, 0.9);
            assert!((friction.mu - 0.6).abs() < 0.05, "{compensate}: {friction:?}");
            assert!((friction.mu - 0.6).abs() < 3.0 * friction.std, "{compensate}: {friction:?}");
        }
    }

    #[test]
    fn with_low_slip_only_the_thesis_s_friction_follows_the_slope_and_the_compensated_one_stays() {
        let follows = |compensate: bool| {
            let mut estimator = estimator(compensate);
            let known = drive(&mut estimator, 90.0, 0.9, 0.9);
            // Softer, and as much friction as before; 5 % of it are used.
            (known, drive(&mut estimator, 50.0, 0.9, 0.05))
        };
        let (before, thesis) = follows(false);
        assert!(thesis.mu < 0.7 * before.mu, "{before:?} {thesis:?}");
        let (before, compensated) = follows(true);
        assert!((before.mu - 0.9).abs() < 0.08, "{before:?}");
        assert!((compensated.mu - before.mu).abs() < 0.1, "{before:?} {compensated:?}");
        // It is not known any more, and that is said.
        assert!(compensated.std > 3.0 * before.std && compensated.std > 0.2, "{compensated:?}");
    }

    #[test]
    fn high_slip_brings_the_compensated_friction_down_to_the_new_one() {
        let mut estimator = estimator(true);
        drive(&mut estimator, 90.0, 0.9, 0.9);
        let friction = drive(&mut estimator, 50.0, 0.5, 0.9);
        assert!((friction.mu - 0.5).abs() < 0.05, "{friction:?}");
    }

    #[test]
    fn an_abs_braking_sets_the_friction_with_its_uncertainty_and_keeps_the_slope() {
        for compensate in [false, true] {
            let mut estimator = estimator(compensate);
            estimator.step(0.001, 1e-4, 0.03, 0.01, 0.25);
            let slope = estimator.theta()[0];
            estimator.calibrate(0.3, 0.02);
            let friction = estimator.friction().unwrap();
            assert!((friction.mu - 0.3).abs() < 1e-9 && (friction.std - 0.02).abs() < 0.001, "{friction:?}");
            assert!((estimator.theta()[0] - slope).abs() < 1e-9);
            estimator.calibrate(f64::NAN, 0.02);
            assert!((estimator.friction().unwrap().mu - 0.3).abs() < 1e-9);
        }
    }

    #[test]
    fn a_force_above_the_friction_raises_it_to_that_force() {
        for compensate in [false, true] {
            let mut estimator = estimator(compensate);
            drive(&mut estimator, 40.0, 0.6, 0.3);
            estimator.calibrate(0.2, 0.02);
            estimator.step(0.012, 1e-4, brush(0.012, 40.0, 0.6), 0.003, 0.25);
            let raised = estimator.friction().unwrap();
            assert!(raised.mu > brush(0.012, 40.0, 0.6) - 0.02, "{compensate}: {raised:?}");
        }
        let config = BrushConfig { calibrate: false, ..BrushConfig::default() };
        let mut uncalibrated = BrushEstimator::new(30.0, &config);
        uncalibrated.step(0.001, 1e-4, 0.03, 0.01, 0.25);
        let before = uncalibrated.friction();
        uncalibrated.calibrate(0.3, 0.02);
        assert_eq!(uncalibrated.friction(), before);
    }

    #[test]
    fn a_step_of_both_slope_and_friction_leaves_the_filter_sound() {
        let mut estimator = estimator(true);
        for i in 0..20_000 {
            let slippery = i / 500 % 2 == 0;
            let (stiffness, mu) = if slippery { (20.0, 0.15) } else { (120.0, 1.0) };
            let slip = 0.02 * (f64::from(i) * 0.3).sin();
            estimator.step(slip, 1e-4, brush(slip.clamp(-0.0225, 0.0225), stiffness, mu), 0.003, 0.25);
            assert!(estimator.filter.is_sound());
        }
        assert!(estimator.friction().is_some_and(|f| f.std.is_finite()));
    }
}
