//! Method 3 of thesis 5.2.2: a Kalman filter on the bicycle model, its stiffnesses given.

use nalgebra::{Matrix2, Vector2};

use crate::estimate::kinematics::Car;
use crate::filter::Gaussian;
use crate::filter::discretize::zero_order_hold_plane;
use crate::model::Bicycle;
use crate::{Quantity, Sensors};

/// States v_y (m/s) and r (rad/s); r and a_y measured. As right as its stiffnesses.
#[derive(Clone, Debug)]
pub struct BicycleFilter {
    model: Bicycle,
    state: Option<Gaussian<2>>,
    yaw_noise: f64,
    acceleration_noise: f64,
}

impl BicycleFilter {
    /// Process noise of v_y, m/s²/√Hz, and of r, rad/s²/√Hz: wind, bank, tires not quite linear. Tuned, no test on
    /// record: the thesis does not tell its own.
    const PROCESS_NOISE: [f64; 2] = [0.1, 0.05];
    /// What is known at the first sample: v_y, m/s, as if the rear wheels did not slip, and r, rad/s. Tuned with
    /// the test `thesis_lateral`.
    const INITIAL_STD: [f64; 2] = [0.3, 0.02];

    /// `stiffness`: normalized cornering stiffness front and rear, 1/rad.
    pub fn new(car: &Car, sensors: &Sensors, stiffness: [f64; 2]) -> Self {
        Self {
            model: car.bicycle(stiffness[0], stiffness[1]),
            state: None,
            yaw_noise: sensors.noise_std(Quantity::YawRate),
            acceleration_noise: sensors.noise_std(Quantity::LateralAcceleration),
        }
    }

    /// Forgets the motion.
    pub fn reset(&mut self) {
        self.state = None;
    }

    /// Takes speed (m/s), yaw rate (rad/s), lateral acceleration (m/s²) and the road wheels' angle
    /// (rad), `elapsed_s` after the sample before; returns v_y, m/s.
    pub fn step(&mut self, speed: f64, r: f64, ay: f64, angle: f64, elapsed_s: f64) -> f64 {
        let state = self.state.get_or_insert_with(|| Gaussian::new([self.model.b * r, r], Self::INITIAL_STD));
        let (dynamics, input) = self.model.dynamics(speed);
        let (transition, integral) = zero_order_hold_plane(&dynamics, elapsed_s);
        let noise = Vector2::from(Self::PROCESS_NOISE).map(|q| q * q * elapsed_s);
        state.predict(&transition, &Matrix2::from_diagonal(&noise));
        state.mean += integral * input * angle;
        let residual = r - state.mean[1];
        state.update_component(1, residual, self.yaw_noise * self.yaw_noise);
        let (h, d) = self.model.lateral_acceleration(speed);
        let residual = ay - h.dot(&state.mean) - d * angle;
        state.update(&h, residual, self.acceleration_noise * self.acceleration_noise);
        state.mean[0]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::Vehicle;

    /// With the angle held from sample to sample, a filter that discretizes exactly has nothing to
    /// correct whatever the period: ten samples of 10 ms and one of 100 ms end at the same place. (Euler's
    /// rule would be off by more than a tenth here.)
    #[test]
    fn the_period_makes_no_difference_to_a_linear_car() {
        let car = Car::new(&Vehicle::thesis());
        let model = car.bicycle(11.5, 11.5);
        let speed = 12.0;
        let (dynamics, input) = model.dynamics(speed);
        let (h, d) = model.lateral_acceleration(speed);
        for step in [0.01_f64, 0.1] {
            let mut filter = BicycleFilter::new(&car, &Sensors::default(), [11.5; 2]);
            let per_angle = (0.1 / step).round() as usize;
            // Fine integration of the same car, independent of the discretization under test.
            let mut x = Vector2::zeros();
            filter.step(speed, 0.0, 0.0, 0.0, step);
            for i in 0..100 {
                let angle = 0.02 * f64::from(i % 7 - 3);
                for _ in 0..per_angle {
                    let fine = 1000;
                    let t = step / f64::from(fine);
                    for _ in 0..fine {
                        let half = x + (dynamics * x + input * angle) * (0.5 * t);
                        x += (dynamics * half + input * angle) * t;
                    }
                    let ay = h.dot(&x) + d * angle;
                    let vy = filter.step(speed, x[1], ay, angle, step);
                    assert!((vy - x[0]).abs() < 1e-6, "{step}: {vy} for {}", x[0]);
                }
            }
        }
    }
}
