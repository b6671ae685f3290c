//! Friction from the curvature of the slip curve: the brush model as a regression (thesis 8.1).
//!
//! μ_x = θ₁ s − θ₂ s|s|/3 + θ₃ s³/27 with θ = (C, C²/μ, C³/μ²), by a random-walk Kalman filter and a
//! CUSUM detector; μ₁ = θ₁²/θ₂, μ₂ = √(θ₁³/θ₃), μ̂ = (μ₁ + μ₂)/2 (8.3). ABS brakings and forces above
//! μ̂ calibrate it (8.4, 8.5).

use nalgebra::{Vector3, vector};

use super::BrushConfig;
use crate::filter::{Cusum, Gaussian, LearnedNoise};

/// The regression of the driven axle, on slips whose offset is taken off.
#[derive(Clone, Debug)]
pub struct BrushEstimator {
    config: BrushConfig,
    initial_stiffness: f64,
    filter: Gaussian<3>,
    cusum: Cusum,
    noise: LearnedNoise,
    informed: bool,
}

/// What the regression says of the friction.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BrushFriction {
    /// μ̂ of (8.3c).
    pub mu: f64,
    /// Standard deviation of μ̂ if the tire were a brush: model error comes on top.
    pub std: f64,
}

impl BrushEstimator {
    /// Beyond this share of the slip at which the brush slides, (8.1) no longer holds.
    const SLIP_LIMIT: f64 = 1.0;
    /// Friction outside these is no friction.
    const MU_LIMITS: (f64, f64) = (0.03, 2.0);

    /// Starts from the slope's prior and the configured friction.
    pub fn new(initial_stiffness: f64, config: &BrushConfig) -> Self {
        Self {
            config: config.clone(),
            initial_stiffness,
            filter: Self::initial(initial_stiffness, config.initial_mu),
            cusum: Cusum::new(1.0, 8.0),
            noise: LearnedNoise::new(200.0),
            informed: false,
        }
    }

    fn initial(stiffness: f64, mu: f64) -> Gaussian<3> {
        let theta = parameters(stiffness, mu);
        Gaussian::new(theta.into(), [0.5 * theta[0], theta[1], 2.0 * theta[2]])
    }

    /// Takes the driven axle's slip (offset taken off), its uncertainty, and normalized force.
    pub fn step(&mut self, slip: f64, slip_std: f64, mu: f64, mu_std: f64, elapsed_s: f64) {
        let theta = self.filter.mean;
        if slip.abs() > Self::SLIP_LIMIT * 3.0 * self.friction_of(&theta) / theta[0].max(1.0) {
            return;
        }
        for i in 0..3 {
            let walk = self.config.walk * theta[i];
            self.filter.inflate(i, walk * walk * elapsed_s);
        }
        let h = vector![slip, -slip * slip.abs() / 3.0, slip.powi(3) / 27.0];
        let promised = mu_std * mu_std + (theta[0] * slip_std).powi(2) + 1e-8;
        let residual = mu - h.dot(&theta);
        let variance = self.noise.variance(promised);
        let expected = self.filter.innovation(&h, residual, variance);
        self.noise.learn(&expected, promised);
        self.filter.update(&h, residual, variance * self.noise.redundancy());
        self.informed = true;
        let evidence = expected.normalized().clamp(-4.0, 4.0) * mu.signum();
        if self.cusum.step(evidence).is_some() {
            self.surface_changed();
        }
        if let Some(friction) = self.friction()
            && mu.abs() > friction.mu
        {
            self.calibrate(mu.abs());
        }
        if !self.filter.is_sound() || self.filter.mean[0] <= 0.0 {
            self.filter = Self::initial(self.initial_stiffness, self.config.initial_mu);
            self.informed = false;
        }
    }

    /// The curvature is set to that of a known friction (8.4, 8.5).
    pub fn calibrate(&mut self, mu: f64) {
        if (Self::MU_LIMITS.0..=Self::MU_LIMITS.1).contains(&mu) {
            let theta = parameters(self.filter.mean[0], mu);
            self.filter.mean[1] = theta[1];
            self.filter.mean[2] = theta[2];
        }
    }

    /// The surface changed: slope and curvature may be anything near.
    pub fn surface_changed(&mut self) {
        for i in 0..3 {
            let std = 0.5 * self.filter.mean[i];
            self.filter.inflate(i, std * std);
        }
        self.cusum.reset();
    }

    /// The friction, once measured; `None` if the regression's curvature is no friction's.
    pub fn friction(&self) -> Option<BrushFriction> {
        let theta = self.filter.mean;
        if !self.informed || theta.min() <= 0.0 {
            return None;
        }
        let mu1 = theta[0] * theta[0] / theta[1];
        let mu2 = (theta[0].powi(3) / theta[2]).sqrt();
        let mu = 0.5 * (mu1 + mu2);
        let gradient =
            vector![mu1 / theta[0] + 0.75 * mu2 / theta[0], -0.5 * mu1 / theta[1], -0.25 * mu2 / theta[2]];
        let variance = gradient.dot(&(self.filter.covariance * gradient));
        (Self::MU_LIMITS.0..=Self::MU_LIMITS.1)
            .contains(&mu)
            .then(|| BrushFriction { mu, std: variance.max(0.0).sqrt() })
    }

    fn friction_of(&self, theta: &Vector3<f64>) -> f64 {
        if theta[1] > 0.0 { theta[0] * theta[0] / theta[1] } else { self.config.initial_mu }
    }
}

/// θ = (C, C²/μ, C³/μ²) (8.2c).
fn parameters(stiffness: f64, mu: f64) -> Vector3<f64> {
    vector![stiffness, stiffness * stiffness / mu, stiffness.powi(3) / (mu * mu)]
}

#[cfg(test)]
mod tests {
    use super::*;

    fn brush(slip: f64, stiffness: f64, mu: f64) -> f64 {
        let theta = parameters(stiffness, mu);
        theta.dot(&vector![slip, -slip * slip.abs() / 3.0, slip.powi(3) / 27.0])
    }

    #[test]
    fn a_curve_driven_up_to_its_limit_gives_its_friction() {
        let mut estimator = BrushEstimator::new(30.0, &BrushConfig::default());
        for i in 0..4000 {
            let slip = 0.04 * (f64::from(i) * 0.05).sin();
            estimator.step(slip, 1e-4, brush(slip, 40.0, 0.6), 0.003, 0.25);
        }
        let friction = estimator.friction().unwrap();
        assert!((friction.mu - 0.6).abs() < 0.05, "{friction:?}");
    }

    #[test]
    fn calibration_sets_the_friction_and_keeps_the_slope() {
        let mut estimator = BrushEstimator::new(30.0, &BrushConfig::default());
        estimator.step(0.001, 1e-4, 0.03, 0.01, 0.25);
        estimator.calibrate(0.3);
        assert!((estimator.friction().unwrap().mu - 0.3).abs() < 1e-9);
        estimator.calibrate(f64::NAN);
        assert!((estimator.friction().unwrap().mu - 0.3).abs() < 1e-9);
    }
}
