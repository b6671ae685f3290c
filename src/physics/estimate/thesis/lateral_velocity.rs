//! Lateral velocity without a joint filter: zero, and methods 1–3 of thesis 5.2.2, side by side.
//!
//! Methods 1 and 2 are kept because the thesis has them and because they show, beside the others,
//! why they are not published: the first drifts, the second is told that r v_y = 0 (methods.md §7).

use super::bicycle_filter::BicycleFilter;
use super::kinematic_observer::{KinematicObserver, SpeedDerivative};
use crate::Sensors;
use crate::estimate::kinematics::{Car, Kinematics};
use crate::estimates::LateralVelocities;

/// All of the simple ways, run side by side.
#[derive(Clone, Debug)]
pub struct LateralVelocityEstimator {
    bicycle: BicycleFilter,
    kinematic: KinematicObserver,
    acceleration: SpeedDerivative,
    integrated: Option<f64>,
    minimum_speed: f64,
}

impl LateralVelocityEstimator {
    /// With the vehicle's own stiffnesses for method 3; below `minimum_speed` (m/s) nothing is estimated.
    pub fn new(car: &Car, sensors: &Sensors, minimum_speed: f64) -> Self {
        let stiffness = car.cornering_prior.map(|(value, _)| value);
        Self {
            bicycle: BicycleFilter::new(car, sensors, stiffness),
            kinematic: KinematicObserver::new(sensors),
            acceleration: SpeedDerivative::default(),
            integrated: None,
            minimum_speed,
        }
    }

    /// Takes a sample. What a method needs and does not get makes it start again.
    pub fn step(&mut self, now: &Kinematics) -> LateralVelocities {
        let moving = now.speed.filter(|speed| *speed >= self.minimum_speed);
        let (Some(speed), Some(r), Some(ay)) = (moving, now.yaw_rate, now.lateral_acceleration) else {
            self.integrated = None;
            self.acceleration.reset();
            self.kinematic.reset();
            self.bicycle.reset();
            return LateralVelocities::default();
        };
        let integrated = self.integrated.unwrap_or(0.0) + now.elapsed_s * (ay - speed * r);
        self.integrated = Some(integrated);
        let ax = self.acceleration.step(speed, now.elapsed_s);
        LateralVelocities {
            zero: Some(0.0),
            integration: Some(integrated),
            kinematic: Some(self.kinematic.step(speed, r, [ax, ay], now.elapsed_s)),
            bicycle: now.road_angle.map(|angle| self.bicycle.step(speed, r, ay, angle, now.elapsed_s)),
            joint: None,
        }
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::Vector2;

    use super::*;
    use crate::filter::discretize::zero_order_hold;
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
                rear_angle: 0.0,
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
