//! Lateral velocity without a joint filter: zero, and methods 1–3 of thesis 5.2.2.
//!
//! Methods 1 and 2 are kept because the thesis has them and because they show, beside the others,
//! why they are not published: the first drifts, the second is told that r v_y = 0 (methods.md §7).

use nalgebra::{Matrix2, Vector2, vector};

use super::{Car, Kinematics};
use crate::estimates::LateralVelocities;
use crate::filter::Gaussian;
use crate::filter::discretize::zero_order_hold;
use crate::model::Bicycle;
use crate::{Quantity, Sensors};

/// All of the simple ways, run side by side.
#[derive(Clone, Debug)]
pub struct LateralVelocityEstimator {
    bicycle: BicycleFilter,
    kinematic: KinematicObserver,
    integrated: Option<f64>,
    minimum_speed: f64,
}

impl LateralVelocityEstimator {
    /// With the vehicle's own stiffnesses for method 3.
    pub fn new(car: &Car, sensors: &Sensors, minimum_speed: f64) -> Self {
        Self {
            bicycle: BicycleFilter::new(car, sensors),
            kinematic: KinematicObserver::new(sensors),
            integrated: None,
            minimum_speed,
        }
    }

    /// Takes a sample. What a method needs and does not get makes it start again.
    pub fn step(&mut self, now: &Kinematics) -> LateralVelocities {
        let moving = now.speed.filter(|speed| *speed >= self.minimum_speed);
        let (Some(speed), Some(r), Some(ay)) = (moving, now.yaw_rate, now.lateral_acceleration) else {
            self.integrated = None;
            self.kinematic.reset();
            self.bicycle.reset();
            return LateralVelocities::default();
        };
        let integrated = self.integrated.unwrap_or(0.0) + now.elapsed_s * (ay - speed * r);
        self.integrated = Some(integrated);
        LateralVelocities {
            zero: Some(0.0),
            integration: Some(integrated),
            kinematic: Some(self.kinematic.step(speed, r, ay, now.elapsed_s)),
            bicycle: now.road_angle.map(|angle| self.bicycle.step(speed, r, ay, angle, now.elapsed_s)),
            joint: None,
        }
    }
}

/// Method 2: x = (v_x, v_y) turning with the car, v_x measured, a_x ≈ Δv_x/T (thesis 5.13).
#[derive(Clone, Debug)]
struct KinematicObserver {
    state: Option<Gaussian<2>>,
    previous_speed: f64,
    acceleration_noise: f64,
    speed_noise: f64,
}

impl KinematicObserver {
    fn new(sensors: &Sensors) -> Self {
        Self {
            state: None,
            previous_speed: 0.0,
            acceleration_noise: sensors.noise_std(Quantity::LateralAcceleration),
            speed_noise: 0.02,
        }
    }

    fn reset(&mut self) {
        self.state = None;
    }

    fn step(&mut self, speed: f64, r: f64, ay: f64, elapsed_s: f64) -> f64 {
        let state = self.state.get_or_insert_with(|| {
            self.previous_speed = speed;
            Gaussian::new([speed, 0.0], [0.1, 0.5])
        });
        let ax = if elapsed_s > 0.0 { (speed - self.previous_speed) / elapsed_s } else { 0.0 };
        self.previous_speed = speed;
        let (transition, integral) = zero_order_hold(&Matrix2::new(0.0, r, -r, 0.0), elapsed_s);
        let noise = self.acceleration_noise * elapsed_s;
        state.predict(&transition, &Matrix2::from_diagonal_element(noise * noise));
        state.mean += integral * vector![ax, ay];
        let residual = speed - state.mean[0];
        state.update(&vector![1.0, 0.0], residual, self.speed_noise * self.speed_noise);
        state.mean[1]
    }
}

/// Method 3: the bicycle model with given stiffnesses; r and a_y measured.
#[derive(Clone, Debug)]
struct BicycleFilter {
    model: Bicycle,
    state: Option<Gaussian<2>>,
    yaw_noise: f64,
    acceleration_noise: f64,
}

impl BicycleFilter {
    /// Process noise of v_y, m/s²/√Hz, and of r, rad/s²/√Hz: wind, bank, tires not quite linear.
    const PROCESS_NOISE: [f64; 2] = [0.1, 0.05];

    fn new(car: &Car, sensors: &Sensors) -> Self {
        let model = car.bicycle(car.cornering_prior[0].0, car.cornering_prior[1].0);
        Self {
            model,
            state: None,
            yaw_noise: sensors.noise_std(Quantity::YawRate),
            acceleration_noise: sensors.noise_std(Quantity::LateralAcceleration),
        }
    }

    fn reset(&mut self) {
        self.state = None;
    }

    fn step(&mut self, speed: f64, r: f64, ay: f64, angle: f64, elapsed_s: f64) -> f64 {
        let state = self.state.get_or_insert_with(|| Gaussian::new([self.model.b * r, r], [0.3, 0.02]));
        let (dynamics, input) = self.model.dynamics(speed);
        let (transition, integral) = zero_order_hold(&dynamics, elapsed_s);
        let noise = Vector2::from(Self::PROCESS_NOISE).map(|q| q * q * elapsed_s);
        state.predict(&transition, &Matrix2::from_diagonal(&noise));
        state.mean += integral * input * angle;
        let residual = r - state.mean[1];
        state.update(&vector![0.0, 1.0], residual, self.yaw_noise * self.yaw_noise);
        let (h, d) = self.model.lateral_acceleration(speed);
        let residual = ay - h.dot(&state.mean) - d * angle;
        state.update(&h, residual, self.acceleration_noise * self.acceleration_noise);
        state.mean[0]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::{GRAVITY, Vehicle};

    /// Sim1-like steering with a linear car; returns the largest error of each method.
    fn errors(offset: f64) -> [f64; 3] {
        let car = Car::new(&Vehicle::thesis());
        let model = car.bicycle(11.5, 11.5);
        let mut estimator = LateralVelocityEstimator::new(&car, &Sensors::default(), 4.0);
        let (speed, step) = (20.0, 0.01);
        let mut x = Vector2::zeros();
        let mut worst = [0.0_f64; 3];
        for i in 0..10_000 {
            let angle = 0.01 * (i as f64 * step * 3.0).sin();
            let (a, b) = model.dynamics(speed);
            let (f, gamma) = zero_order_hold(&a, step);
            x = f * x + gamma * b * angle;
            let (h, d) = model.lateral_acceleration(speed);
            let now = Kinematics {
                elapsed_s: step,
                speed: Some(speed),
                wheels: Some([speed; 4]),
                yaw_rate: Some(x[1]),
                lateral_acceleration: Some(h.dot(&x) + d * angle + offset),
                longitudinal_acceleration: None,
                road_angle: Some(angle),
                axle_torque: None,
                braking: None,
                abs: None,
            };
            let got = estimator.step(&now);
            let all = [got.integration, got.kinematic, got.bicycle];
            for (worst, got) in worst.iter_mut().zip(all) {
                *worst = worst.max((got.unwrap() - x[0]).abs());
            }
        }
        worst
    }

    #[test]
    fn the_integration_drifts_with_an_offset_and_the_bicycle_does_not() {
        let [integration, _, bicycle] = errors(0.005 * GRAVITY);
        assert!(integration > 1.0, "{integration}");
        assert!(bicycle < 0.05, "{bicycle}");
    }

    #[test]
    fn the_bicycle_with_the_right_stiffness_is_exact_without_noise() {
        let [_, _, bicycle] = errors(0.0);
        assert!(bicycle < 0.005, "{bicycle}");
    }
}
