//! The joint lateral filter that is published: motion, both axles' cornering stiffness, and the
//! offsets of the three sensors it stands on.
//!
//! Beyond thesis (5.21): front and rear stiffness apart, sensor offsets as states (a hundredth of a
//! radian of steering offset would otherwise go into the stiffness), noise learned from the
//! innovations, a change detector, and a linear-range guard: above `linear_up_to_mps2` the tire is no
//! longer linear and teaches less and less. All tires are linear here.

use nalgebra::{Matrix2, SMatrix, SVector, Vector2, vector};

use super::{Car, CorneringConfig, Kinematics};
use crate::estimates::{Estimate, SensorOffsets};
use crate::filter::discretize::zero_order_hold;
use crate::filter::{Cusum, Gaussian, LearnedNoise};
use crate::model::GRAVITY;
use crate::{Quantity, Sensors};

type State = Gaussian<7>;

/// Places in the state: v_y m/s, r rad/s, normalized stiffnesses 1/rad, offsets in SI.
const VY: usize = 0;
const YAW: usize = 1;
const FRONT: usize = 2;
const REAR: usize = 3;
const ANGLE_OFFSET: usize = 4;
const AY_OFFSET: usize = 5;
const YAW_OFFSET: usize = 6;

/// The filter.
#[derive(Clone, Debug)]
pub struct CorneringEstimator {
    car: Car,
    config: CorneringConfig,
    state: State,
    yaw_variance: f64,
    acceleration_variance: f64,
    angle_variance: f64,
    yaw_noise: LearnedNoise,
    acceleration_noise: LearnedNoise,
    change: ChangeDetector,
    minimum_speed: f64,
    running: bool,
    standing_s: f64,
    age_s: f64,
    informed: bool,
    /// Seconds since the last sample that could be used at all, and whether there was one.
    idle_s: f64,
    seen: bool,
    motion: Option<LateralMotion>,
}

/// What the filter knows of the motion.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LateralMotion {
    /// Lateral velocity at the centre of gravity, m/s.
    pub lateral_velocity: f64,
    /// Its standard deviation, m/s.
    pub lateral_velocity_std: f64,
    /// Slip angles front and rear, rad, offsets taken off.
    pub slip_angles: [f64; 2],
}

/// Lateral forces at the present state: accelerations of each axle and their sensitivities.
struct Forces {
    /// Slip angles front and rear.
    alpha: [f64; 2],
    /// Axle load / mass, m/s².
    load: [f64; 2],
    /// Yaw acceleration per normalized axle force, rad/s².
    yaw_lever: f64,
}

impl CorneringEstimator {
    /// Samples that the learned noise remembers.
    const NOISE_MEMORY: f64 = 1000.0;
    /// Stiffness stays within these, 1/rad.
    const STIFFNESS_LIMITS: (f64, f64) = (1.0, 80.0);
    /// Lateral acceleration from which a sample tells something of the stiffness, m/s².
    const INFORMATIVE: f64 = 0.5;
    /// Relative uncertainty that a stiffness has again after a change of surface.
    const CHANGE_STD: f64 = 0.4;
    /// All wheels slower than this, for [`Self::STANDING_AFTER`]: the car stands, m/s.
    const STANDING_BELOW: f64 = 0.1;
    const STANDING_AFTER: f64 = 0.5;

    /// Starts from the vehicle's priors.
    pub fn new(car: &Car, sensors: &Sensors, config: &CorneringConfig, minimum_speed: f64) -> Self {
        let [front, rear] = car.cornering_prior;
        let prior_std = |(value, std): (f64, f64)| std.max(0.05 * value);
        let state = Gaussian::new(
            [0.0, 0.0, front.0, rear.0, 0.0, 0.0, 0.0],
            [
                0.3,
                0.05,
                prior_std(front),
                prior_std(rear),
                config.steering_offset_std,
                config.acceleration_offset_std,
                config.yaw_rate_offset_std,
            ],
        );
        let variance = |quantity| sensors.noise_std(quantity).powi(2);
        Self {
            state,
            yaw_variance: variance(Quantity::YawRate),
            acceleration_variance: variance(Quantity::LateralAcceleration),
            angle_variance: variance(Quantity::SteeringWheelAngle)
                / (car.steering_ratio * car.steering_ratio),
            yaw_noise: LearnedNoise::new(Self::NOISE_MEMORY),
            acceleration_noise: LearnedNoise::new(Self::NOISE_MEMORY),
            change: ChangeDetector::default(),
            minimum_speed,
            running: false,
            standing_s: 0.0,
            age_s: 0.0,
            informed: false,
            idle_s: 0.0,
            seen: false,
            motion: None,
            car: car.clone(),
            config: config.clone(),
        }
    }

    /// Takes a sample; returns whether the cornering stiffness jumped.
    pub fn step(&mut self, now: &Kinematics) -> bool {
        self.age_s += now.elapsed_s;
        self.idle_s += now.elapsed_s;
        self.motion = None;
        self.watch_standstill(now);
        let moving = now.speed.filter(|speed| *speed >= self.minimum_speed);
        let (Some(speed), Some(r), Some(ay), Some(angle)) =
            (moving, now.yaw_rate, now.lateral_acceleration, now.road_angle)
        else {
            self.running = false;
            self.walk(now.elapsed_s);
            return false;
        };
        if !self.running {
            self.restart(r);
        }
        (self.idle_s, self.seen) = (0.0, true);
        self.predict(speed, angle, now.elapsed_s);
        self.measure_yaw_rate(r);
        let changed = self.measure_acceleration(speed, angle, ay, now.elapsed_s);
        self.keep_sound();
        if ay.abs() > Self::INFORMATIVE {
            self.age_s = 0.0;
            self.informed = true;
        }
        let forces = self.forces(speed, angle);
        self.motion = Some(LateralMotion {
            lateral_velocity: self.state.mean[VY],
            lateral_velocity_std: self.state.std(VY),
            slip_angles: forces.alpha,
        });
        if changed {
            self.surface_changed();
        }
        changed
    }

    /// Motion at the last sample, if the car moved and nothing was missing.
    pub fn motion(&self) -> Option<LateralMotion> {
        self.motion
    }

    /// Normalized cornering stiffness front and rear, 1/rad.
    pub fn stiffness(&self) -> [Option<Estimate>; 2] {
        [FRONT, REAR].map(|i| {
            self.informed.then(|| Estimate {
                value: self.state.mean[i],
                std: self.state.std(i),
                age_s: self.age_s,
            })
        })
    }

    /// Offsets of the sensors, with the same age as the motion's information.
    pub fn offsets(&self) -> SensorOffsets {
        let estimate = |i| {
            let (value, std) = (self.state.mean[i], self.state.std(i));
            self.seen.then_some(Estimate { value, std, age_s: self.idle_s })
        };
        SensorOffsets {
            road_angle: estimate(ANGLE_OFFSET),
            lateral_acceleration: estimate(AY_OFFSET),
            yaw_rate: estimate(YAW_OFFSET),
        }
    }

    /// Both stiffnesses are known well, and lately, and the filter agrees with itself.
    pub fn is_valid(&self) -> bool {
        let config = &self.config;
        self.is_consistent()
            && self.stiffness().iter().all(|stiffness| {
                stiffness.is_some_and(|c| {
                    c.std <= config.valid_relative_std * c.value && c.age_s <= config.valid_age_s
                })
            })
    }

    /// The sideslip is known well enough to be acted upon.
    pub fn is_motion_valid(&self, speed: f64) -> bool {
        self.is_consistent()
            && self.motion.is_some_and(|m| m.lateral_velocity_std <= self.config.valid_sideslip_std * speed)
    }

    /// Innovations are about as large as the filter believes, and the noise it had to assume for
    /// that is still a sensor's.
    pub fn is_consistent(&self) -> bool {
        [&self.yaw_noise, &self.acceleration_noise]
            .into_iter()
            .all(|noise| noise.nis() < self.config.inconsistent_nis && noise.scale() < Self::NOISE_MEMORY)
    }

    /// The surface changed, as this filter or another noticed: the stiffness may be anything near.
    pub fn surface_changed(&mut self) {
        for i in [FRONT, REAR] {
            let std = Self::CHANGE_STD * self.state.mean[i];
            self.state.inflate(i, std * std);
        }
    }

    /// Standing still, the yaw rate sensor shows its offset.
    fn watch_standstill(&mut self, now: &Kinematics) {
        let Some(wheels) = now.wheels else { return };
        if wheels.iter().any(|wheel| wheel.abs() > Self::STANDING_BELOW) {
            self.standing_s = 0.0;
            return;
        }
        self.standing_s += now.elapsed_s;
        if let Some(r) = now.yaw_rate
            && self.standing_s > Self::STANDING_AFTER
        {
            let mut h = SVector::<f64, 7>::zeros();
            h[YAW_OFFSET] = 1.0;
            // The motion is not part of it: drop its correlations before the update.
            self.restart(0.0);
            self.running = false;
            self.state.update(&h, r - self.state.mean[YAW_OFFSET], self.yaw_variance);
        }
    }

    /// The motion is unknown again; stiffness and offsets are kept.
    fn restart(&mut self, r: f64) {
        for i in [VY, YAW] {
            self.state.covariance.row_mut(i).fill(0.0);
            self.state.covariance.column_mut(i).fill(0.0);
        }
        let yaw_rate = r - self.state.mean[YAW_OFFSET];
        self.state.mean[VY] = self.car.b * yaw_rate;
        self.state.mean[YAW] = yaw_rate;
        self.state.covariance[(VY, VY)] = 0.3 * 0.3;
        self.state.covariance[(YAW, YAW)] = 0.05 * 0.05;
        self.running = true;
    }

    fn forces(&self, speed: f64, angle: f64) -> Forces {
        let car = &self.car;
        let x = &self.state.mean;
        let wheelbase = car.wheelbase();
        Forces {
            alpha: car.slip_angles(speed, x[VY], x[YAW], angle - x[ANGLE_OFFSET]),
            load: [GRAVITY * car.b / wheelbase, GRAVITY * car.a / wheelbase],
            yaw_lever: car.mass * GRAVITY * car.a * car.b / (wheelbase * car.yaw_inertia),
        }
    }

    /// Rosenbrock–Euler step of the motion, with the exact discretization of its linearization.
    fn predict(&mut self, speed: f64, angle: f64, elapsed_s: f64) {
        let forces = self.forces(speed, angle);
        let Forces { alpha, load, yaw_lever } = forces;
        let (front, rear) = (self.state.mean[FRONT], self.state.mean[REAR]);
        let (pf, pr) = (load[0] * front, load[1] * rear);
        let (a, b) = (self.car.a, self.car.b);
        let jacobian = Matrix2::new(
            -(pf + pr) / speed,
            -speed - (a * pf - b * pr) / speed,
            -yaw_lever * (front - rear) / speed,
            -yaw_lever * (a * front + b * rear) / speed,
        );
        let rates = Vector2::new(
            -speed * self.state.mean[YAW] + pf * alpha[0] + pr * alpha[1],
            yaw_lever * (front * alpha[0] - rear * alpha[1]),
        );
        let (motion, integral) = zero_order_hold(&jacobian, elapsed_s);
        let by_angle = vector![pf, yaw_lever * front];
        let mut transition = SMatrix::<f64, 7, 7>::identity();
        transition.fixed_view_mut::<2, 2>(0, 0).copy_from(&motion);
        let columns = [
            (FRONT, vector![load[0] * alpha[0], yaw_lever * alpha[0]]),
            (REAR, vector![load[1] * alpha[1], -yaw_lever * alpha[1]]),
            (ANGLE_OFFSET, -by_angle),
        ];
        for (column, sensitivity) in columns {
            transition.fixed_view_mut::<2, 1>(0, column).copy_from(&(integral * sensitivity));
        }
        let step = integral * rates;
        self.state.mean[VY] += step[0];
        self.state.mean[YAW] += step[1];
        let config = &self.config;
        let by_steering_noise = integral * by_angle;
        let mut noise = SMatrix::<f64, 7, 7>::zeros();
        noise
            .fixed_view_mut::<2, 2>(0, 0)
            .copy_from(&(by_steering_noise * by_steering_noise.transpose() * self.angle_variance));
        noise[(VY, VY)] += config.acceleration_noise.powi(2) * elapsed_s;
        noise[(YAW, YAW)] += config.yaw_acceleration_noise.powi(2) * elapsed_s;
        self.state.predict_covariance(&transition, &noise);
        self.walk(elapsed_s);
    }

    /// Random walks of what changes on its own.
    fn walk(&mut self, elapsed_s: f64) {
        for i in [FRONT, REAR] {
            let walk = self.config.stiffness_walk * self.state.mean[i];
            self.state.inflate(i, walk * walk * elapsed_s);
        }
        self.state.inflate(AY_OFFSET, self.config.acceleration_offset_walk.powi(2) * elapsed_s);
        // Bank is bounded: so is what has not been seen of it.
        let limit = self.config.acceleration_offset_std.powi(2);
        if self.state.covariance[(AY_OFFSET, AY_OFFSET)] > limit {
            let shrink = (limit / self.state.covariance[(AY_OFFSET, AY_OFFSET)]).sqrt();
            self.state.covariance.row_mut(AY_OFFSET).scale_mut(shrink);
            self.state.covariance.column_mut(AY_OFFSET).scale_mut(shrink);
        }
    }

    fn measure_yaw_rate(&mut self, r: f64) {
        let mut h = SVector::<f64, 7>::zeros();
        h[YAW] = 1.0;
        h[YAW_OFFSET] = 1.0;
        let residual = r - self.state.mean[YAW] - self.state.mean[YAW_OFFSET];
        let variance = self.yaw_noise.variance(self.yaw_variance);
        let expected = self.state.innovation(&h, residual, variance);
        self.yaw_noise.learn(&expected, self.yaw_variance);
        self.state.update(&h, residual, variance * self.yaw_noise.redundancy());
    }

    fn measure_acceleration(&mut self, speed: f64, angle: f64, ay: f64, elapsed_s: f64) -> bool {
        let Forces { alpha, load, .. } = self.forces(speed, angle);
        let x = &self.state.mean;
        let (pf, pr) = (load[0] * x[FRONT], load[1] * x[REAR]);
        let mut h = SVector::<f64, 7>::zeros();
        h[VY] = -(pf + pr) / speed;
        h[YAW] = -(self.car.a * pf - self.car.b * pr) / speed;
        h[FRONT] = load[0] * alpha[0];
        h[REAR] = load[1] * alpha[1];
        h[ANGLE_OFFSET] = -pf;
        h[AY_OFFSET] = 1.0;
        let residual = ay - pf * alpha[0] - pr * alpha[1] - x[AY_OFFSET];
        let promised = self.acceleration_variance + pf * pf * self.angle_variance;
        let excess = (ay.abs() - self.config.linear_up_to_mps2).max(0.0);
        let nonlinear = 1.0 + 100.0 * excess * excess;
        let variance = self.acceleration_noise.variance(promised) * nonlinear;
        let expected = self.state.innovation(&h, residual, variance);
        if excess == 0.0 {
            self.acceleration_noise.learn(&expected, promised);
        }
        self.state.update(&h, residual, variance * self.acceleration_noise.redundancy());
        let redundancy = self.acceleration_noise.redundancy();
        self.change.step(expected.normalized(), redundancy, ay, elapsed_s)
    }

    fn keep_sound(&mut self) {
        for i in [FRONT, REAR] {
            self.state.mean[i] = self.state.mean[i].clamp(Self::STIFFNESS_LIMITS.0, Self::STIFFNESS_LIMITS.1);
        }
        if !self.state.is_sound() {
            let sensors_noise = (self.yaw_variance, self.acceleration_variance, self.angle_variance);
            *self = Self::new(&self.car, &Sensors::default(), &self.config, self.minimum_speed);
            (self.yaw_variance, self.acceleration_variance, self.angle_variance) = sensors_noise;
        }
    }
}

/// CUSUM on tenths of a second of lateral-acceleration innovations, signed by the acceleration: a
/// softer axle gives less than predicted in whichever direction.
#[derive(Clone, Debug)]
struct ChangeDetector {
    cusum: Cusum,
    sum: f64,
    count: f64,
    time_s: f64,
}

impl Default for ChangeDetector {
    fn default() -> Self {
        Self { cusum: Cusum::new(1.0, 10.0), sum: 0.0, count: 0.0, time_s: 0.0 }
    }
}

impl ChangeDetector {
    const WINDOW_S: f64 = 0.1;
    const CLIP: f64 = 4.0;

    fn step(&mut self, normalized: f64, redundancy: f64, ay: f64, elapsed_s: f64) -> bool {
        self.time_s += elapsed_s;
        if normalized.is_finite() && ay.abs() > CorneringEstimator::INFORMATIVE {
            self.sum += normalized * ay.signum();
            self.count += 1.0;
        }
        if self.time_s < Self::WINDOW_S {
            return false;
        }
        let mean = if self.count > 0.0 { self.sum / (self.count * redundancy).sqrt() } else { 0.0 };
        (self.sum, self.count, self.time_s) = (0.0, 0.0, 0.0);
        self.cusum.step(mean.clamp(-Self::CLIP, Self::CLIP)).is_some()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::Vehicle;

    const OFFSETS: [f64; 3] = [0.004, -0.08, 0.006];

    /// A linear car with front and rear stiffness 14 and 9, driven through random-looking steering
    /// with offset sensors; returns its last true lateral velocity.
    fn drive(estimator: &mut CorneringEstimator, car: &Car, amplitude: f64, seconds: f64) -> f64 {
        let model = car.bicycle(14.0, 9.0);
        let (speed, step) = (22.0, 0.01);
        let mut x = Vector2::zeros();
        for i in 0..(seconds / step) as usize {
            let t = i as f64 * step;
            let angle = amplitude * ((1.3 * t).sin() + 0.6 * (3.7 * t).sin() + 0.4 * (7.0 * t).sin());
            let (a, b) = model.dynamics(speed);
            let (f, gamma) = zero_order_hold(&a, step);
            x = f * x + gamma * b * angle;
            let (h, d) = model.lateral_acceleration(speed);
            let noise = [(i * 7919 % 101) as f64 - 50.0, (i * 104_729 % 103) as f64 - 51.0].map(|n| n / 29.0);
            let now = Kinematics {
                elapsed_s: step,
                speed: Some(speed),
                wheels: Some([speed; 4]),
                yaw_rate: Some(x[1] + OFFSETS[2] + 0.003 * noise[0]),
                lateral_acceleration: Some(h.dot(&x) + d * angle + OFFSETS[1] + 0.07 * noise[1]),
                longitudinal_acceleration: None,
                road_angle: Some(angle + OFFSETS[0]),
                axle_torque: None,
                braking: None,
                abs: None,
            };
            estimator.step(&now);
        }
        x[0]
    }

    fn estimator() -> (CorneringEstimator, Car) {
        let mut vehicle = Vehicle::thesis();
        vehicle.lateral_stiffness_front = crate::model::Uncertain { value: 12.0, std: 3.0 };
        vehicle.lateral_stiffness_rear = vehicle.lateral_stiffness_front;
        vehicle.steering_ratio.value = 16.0;
        let car = Car::new(&vehicle);
        (CorneringEstimator::new(&car, &Sensors::default(), &CorneringConfig::default(), 4.0), car)
    }

    #[test]
    fn both_stiffnesses_and_all_offsets_are_found_when_excited() {
        let (mut estimator, car) = estimator();
        let vy = drive(&mut estimator, &car, 0.012, 120.0);
        for (stiffness, truth) in estimator.stiffness().into_iter().zip([14.0, 9.0]) {
            let c = stiffness.unwrap();
            assert!((c.value - truth).abs() < 3.0 * c.std && c.std < 0.1 * truth, "{c:?} for {truth}");
        }
        assert!(estimator.is_valid() && estimator.is_motion_valid(22.0));
        let motion = estimator.motion().unwrap();
        assert!((motion.lateral_velocity - vy).abs() < 0.1, "{motion:?} for {vy}");
        let found = estimator.offsets();
        for (offset, truth) in
            [found.road_angle, found.lateral_acceleration, found.yaw_rate].into_iter().zip(OFFSETS)
        {
            let offset = offset.unwrap();
            assert!((offset.value - truth).abs() < 4.0 * offset.std, "{offset:?} for {truth}");
        }
    }

    #[test]
    fn driving_straight_the_stiffness_is_not_valid() {
        let (mut estimator, car) = estimator();
        drive(&mut estimator, &car, 0.0, 60.0);
        assert_eq!(estimator.stiffness(), [None; 2]);
        assert!(!estimator.is_valid());
    }
}
