//! The joint EKF of thesis (5.21): v_y, r and one cornering stiffness C_y for all four wheels.
//!
//! Kept as the thesis has it, for comparison. With a = b and equal stiffnesses the steady-state
//! response does not depend on C_y, so only transients teach it (methods.md §7); the filter that is
//! published is [`crate::estimate::cornering`].

use nalgebra::{Vector3, matrix, vector};

use super::config::JointEkfConfig;
use crate::estimate::kinematics::{Car, Cornering, Kinematics};
use crate::estimates::Estimate;
use crate::filter::Gaussian;
use crate::filter::discretize::zero_order_hold_plane;
use crate::model::{Bicycle, GRAVITY};
use crate::{Quantity, Sensors};

/// States v_y (m/s), r (rad/s) and C_y, the last normalized by m g / 4 (1/rad).
#[derive(Clone, Debug)]
pub struct JointEkf {
    car: Car,
    config: JointEkfConfig,
    state: Gaussian<3>,
    prior: (f64, f64),
    yaw_variance: f64,
    acceleration_variance: f64,
    minimum_speed: f64,
    running: bool,
    age_s: f64,
    informed: bool,
}

impl JointEkf {
    /// A slope has to stay physical for the linearization to make sense, 1/rad. Physical: softer and stiffer than
    /// any tire.
    const SLOPE_LIMITS: (f64, f64) = (0.5, 100.0);
    /// Below this lateral acceleration nothing is learned of C_y, m/s². Tuned, no test on record.
    const INFORMATIVE: f64 = 0.3;

    /// Standard deviations of v_y (m/s) and r (rad/s) of which nothing is known yet. Tuned, no test on record.
    const UNKNOWN_MOTION: [f64; 2] = [0.3, 0.05];
    /// No data sheet knows the stiffness better than this, relative. Tuned, no test on record.
    const LEAST_PRIOR_STD: f64 = 0.1;

    /// Starts from the mean of the vehicle's front and rear priors.
    pub fn new(car: &Car, sensors: &Sensors, config: &JointEkfConfig, minimum_speed: f64) -> Self {
        let [front, rear] = car.cornering_prior;
        let value = 0.5 * (front.0 + rear.0);
        let prior = (value, front.1.max(rear.1).max(Self::LEAST_PRIOR_STD * value));
        let [vy_std, yaw_std] = Self::UNKNOWN_MOTION;
        let variance = |quantity| sensors.noise_std(quantity).powi(2);
        Self {
            car: car.clone(),
            config: config.clone(),
            state: Gaussian::new([0.0, 0.0, prior.0], [vy_std, yaw_std, prior.1]),
            prior,
            yaw_variance: variance(Quantity::YawRate),
            acceleration_variance: variance(Quantity::LateralAcceleration),
            minimum_speed,
            running: false,
            age_s: 0.0,
            informed: false,
        }
    }

    /// Takes a sample.
    pub fn step(&mut self, now: &Kinematics) {
        self.age_s += now.elapsed_s;
        let Some(Cornering { speed, yaw_rate: r, lateral_acceleration: ay, road_angle: angle }) =
            now.cornering(self.minimum_speed)
        else {
            self.running = false;
            return;
        };
        if !self.running {
            self.restart(r);
        }
        self.predict(speed, angle, now.elapsed_s);
        let residual = r - self.state.mean[1];
        self.state.update_component(1, residual, self.yaw_variance);
        let (predicted, h) = self.lateral_acceleration(speed, angle);
        self.state.update(&h, ay - predicted, self.acceleration_variance);
        self.state.mean[2] = self.state.mean[2].clamp(Self::SLOPE_LIMITS.0, Self::SLOPE_LIMITS.1);
        if ay.abs() > Self::INFORMATIVE {
            self.age_s = 0.0;
            self.informed = true;
        }
        if !self.state.is_sound() {
            let [vy_std, yaw_std] = Self::UNKNOWN_MOTION;
            self.state = Gaussian::new([0.0, r, self.prior.0], [vy_std, yaw_std, self.prior.1]);
        }
    }

    /// The stiffness, once something was learned of it.
    pub fn stiffness(&self) -> Option<Estimate> {
        self.informed.then(|| Estimate {
            value: self.state.mean[2],
            std: self.state.std(2),
            age_s: self.age_s,
        })
    }

    /// Lateral velocity, m/s, while the car moves.
    pub fn lateral_velocity(&self) -> Option<f64> {
        self.running.then(|| self.state.mean[0])
    }

    /// After standing still the motion is unknown, the stiffness is not.
    fn restart(&mut self, r: f64) {
        let variance = self.state.covariance[(2, 2)];
        let stiffness = self.state.mean[2];
        let [vy_std, yaw_std] = Self::UNKNOWN_MOTION;
        self.state = Gaussian::new([self.car.b * r, r, stiffness], [vy_std, yaw_std, 0.0]);
        self.state.covariance[(2, 2)] = variance;
        self.running = true;
    }

    /// Discretized linearization (thesis 2.17–2.22).
    fn predict(&mut self, speed: f64, angle: f64, elapsed_s: f64) {
        let stiffness = self.state.mean[2];
        let (dynamics, input) = self.bicycle(stiffness).dynamics(speed);
        let motion = vector![self.state.mean[0], self.state.mean[1]];
        let rates = dynamics * motion + input * angle;
        // Every force is proportional to C_y: its derivative is the force per stiffness.
        let inertial = vector![-speed * motion[1], 0.0];
        // C_y stays: it only acts on the motion, as an input that is held does.
        let (turned, integral) = zero_order_hold_plane(&dynamics, elapsed_s);
        let by_stiffness = integral * (rates - inertial) / stiffness;
        let transition = matrix![
            turned.m11, turned.m12, by_stiffness[0];
            turned.m21, turned.m22, by_stiffness[1]];
        let moved = motion + integral * rates;
        (self.state.mean[0], self.state.mean[1]) = (moved[0], moved[1]);
        let config = &self.config;
        let noise = [config.lateral_noise, config.yaw_noise, config.stiffness_walk * self.prior.0]
            .map(|q| q * q * elapsed_s);
        self.state.predict_covariance_of_moving(&transition, &noise);
    }

    fn lateral_acceleration(&self, speed: f64, angle: f64) -> (f64, Vector3<f64>) {
        let (h, d) = self.bicycle(self.state.mean[2]).lateral_acceleration(speed);
        let predicted = h[0] * self.state.mean[0] + h[1] * self.state.mean[1] + d * angle;
        (predicted, vector![h[0], h[1], predicted / self.state.mean[2]])
    }

    /// C_F = C_R: the same stiffness per wheel at both axles, whatever their loads.
    fn bicycle(&self, normalized: f64) -> Bicycle {
        let axle = 0.5 * normalized * self.car.mass * GRAVITY;
        Bicycle { front: axle, rear: axle, ..self.car.bicycle(1.0, 1.0) }
    }
}
