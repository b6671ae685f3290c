//! Lateral slip slope per axle by regression (thesis 5.2.2, eq. 5.20): α = μ_y/k + e.
//!
//! It stands on a lateral velocity from elsewhere and is as good as that one: with method 3 it returns
//! the stiffness method 3 was given.

use nalgebra::vector;

use crate::estimate::kinematics::{Car, Cornering, Kinematics};
use crate::estimates::Estimate;
use crate::filter::{Cusum, Gaussian, LearnedNoise};
use crate::model::GRAVITY;

/// Tuned: windows and noise with the test `thesis_lateral`, the rest with no test on record.
struct Tuning {
    /// Samples are put together over this time, s.
    window_s: f64,
    /// Noise of a window's slip angle, rad: wheel alignment, steering resolution, v_y.
    angle_std: f64,
    /// It is learned, up to this, rad: what is more is no noise, but another slope or a wrong v_y.
    worst_angle_std: f64,
    /// Less normalized force than this says nothing.
    informative: f64,
    /// Random walk of 1/k relative to its value, 1/√s.
    walk: f64,
    /// On a change 1/k may be off by this share of itself.
    change_std: f64,
    /// Windows that the learned noise remembers.
    noise_memory: f64,
    /// A slope is at first uncertain by this share of itself at least.
    least_prior_std: f64,
    /// Drift and threshold of the CUSUM, in standard deviations: one false alarm in 10⁷ white windows.
    cusum: (f64, f64),
    /// Normalized innovations count in the CUSUM up to this.
    clip: f64,
}

const TUNING: Tuning = Tuning {
    window_s: 0.5,
    angle_std: 0.003,
    worst_angle_std: 0.01,
    informative: 0.03,
    walk: 0.01,
    change_std: 0.5,
    noise_memory: 50.0,
    least_prior_std: 0.3,
    cusum: (1.0, 8.0),
    clip: 4.0,
};

/// One axle's regression of slip angle on normalized lateral force.
#[derive(Clone, Debug)]
struct AxleSlope {
    /// 1/k, rad.
    filter: Gaussian<1>,
    cusum: Cusum,
    noise: LearnedNoise,
    window: Window,
    age_s: f64,
    informed: bool,
}

/// Sums over a window. What is wrong with a slip angle (v_y, the yaw acceleration that (5.20) leaves
/// out, alignment) lasts for many samples; so a window of them counts as one measurement.
#[derive(Clone, Copy, Debug, Default)]
struct Window {
    /// Time with enough force, s.
    time_s: f64,
    /// ∫ μ² dt and ∫ μ α dt.
    square: f64,
    product: f64,
}

/// Both axles' regressions.
#[derive(Clone, Debug)]
pub struct LateralSlopeEstimator {
    axles: [AxleSlope; 2],
    car: Car,
    minimum_speed: f64,
}

impl LateralSlopeEstimator {
    /// Starts from the vehicle's priors.
    pub fn new(car: &Car, minimum_speed: f64) -> Self {
        let axles = car.cornering_prior.map(|(value, std)| AxleSlope {
            filter: Gaussian::new([1.0 / value], [std.max(TUNING.least_prior_std * value) / (value * value)]),
            cusum: Cusum::new(TUNING.cusum.0, TUNING.cusum.1),
            noise: LearnedNoise::new(TUNING.noise_memory),
            window: Window::default(),
            age_s: 0.0,
            informed: false,
        });
        Self { axles, car: car.clone(), minimum_speed }
    }

    /// Takes a sample and the lateral velocity to stand on.
    pub fn step(&mut self, now: &Kinematics, lateral_velocity: Option<f64>) {
        for axle in &mut self.axles {
            axle.age_s += now.elapsed_s;
        }
        let Some((cornering, vy)) = now.cornering(self.minimum_speed).zip(lateral_velocity) else { return };
        let Cornering { speed, yaw_rate: r, lateral_acceleration: ay, road_angle: angle } = cornering;
        let mu = ay / GRAVITY;
        if mu.abs() < TUNING.informative {
            return;
        }
        let alpha = self.car.slip_angles(speed, vy, r, [angle, now.rear_angle]);
        for (axle, alpha) in self.axles.iter_mut().zip(alpha) {
            axle.step(alpha, mu, now.elapsed_s);
        }
    }

    /// Slopes front and rear, 1/rad.
    pub fn slopes(&self) -> [Option<Estimate>; 2] {
        self.axles.each_ref().map(AxleSlope::slope)
    }
}

impl AxleSlope {
    fn step(&mut self, alpha: f64, mu: f64, elapsed_s: f64) {
        let window = &mut self.window;
        window.time_s += elapsed_s;
        window.square += mu * mu * elapsed_s;
        window.product += mu * alpha * elapsed_s;
        if window.time_s >= TUNING.window_s {
            let window = std::mem::take(window);
            self.update(&window);
        }
    }

    /// The window's own least-squares compliance is a measurement of the compliance.
    fn update(&mut self, window: &Window) {
        let walk = TUNING.walk * self.filter.mean[0];
        self.filter.inflate(0, walk * walk * window.time_s);
        let mean_square = window.square / window.time_s;
        let promised = TUNING.angle_std.powi(2) / mean_square;
        let worst = TUNING.worst_angle_std.powi(2) / mean_square;
        let noise = self.noise.variance(promised).min(worst);
        let residual = window.product / window.square - self.filter.mean[0];
        let h = vector![1.0];
        let expected = self.filter.innovation(&h, residual, noise);
        self.filter.update(&h, residual, noise * self.noise.redundancy());
        self.noise.learn(&expected, promised);
        self.age_s = 0.0;
        self.informed = true;
        let evidence = expected.normalized() / self.noise.redundancy().sqrt();
        if self.cusum.step(evidence.clamp(-TUNING.clip, TUNING.clip)).is_some() {
            let std = TUNING.change_std * self.filter.mean[0];
            self.filter.inflate(0, std * std);
        }
    }

    fn slope(&self) -> Option<Estimate> {
        let compliance = self.filter.mean[0];
        let relative = self.filter.std(0) / compliance;
        (self.informed && compliance > 0.0 && relative < 0.5).then(|| Estimate {
            value: 1.0 / compliance,
            std: relative / compliance,
            age_s: self.age_s,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::Vehicle;

    #[test]
    fn with_the_true_lateral_velocity_the_true_slope_comes_out() {
        let car = Car::new(&Vehicle::thesis());
        let mut estimator = LateralSlopeEstimator::new(&car, 4.0);
        let (speed, slope) = (20.0, 9.0);
        for i in 0..5000 {
            let ay = 2.0 * (i as f64 * 0.01).sin();
            let alpha = ay / GRAVITY / slope;
            let r = ay / speed;
            let vy = car.b * r - speed * alpha.tan();
            let now = Kinematics {
                elapsed_s: 0.01,
                speed: Some(speed),
                wheels: Some([speed; 4]),
                yaw_rate: Some(r),
                lateral_acceleration: Some(ay),
                longitudinal_acceleration: None,
                road_angle: Some(alpha + ((vy + car.a * r) / speed).atan()),
                rear_angle: 0.0,
                axle_torque: None,
                braking: None,
                abs: None,
            };
            estimator.step(&now, Some(vy));
        }
        for slope_estimate in estimator.slopes() {
            let estimate = slope_estimate.unwrap();
            assert!((estimate.value - slope).abs() < 0.1 && estimate.std < 1.0, "{estimate:?}");
        }
    }
}
