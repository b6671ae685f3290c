//! The joint lateral filter that is published: motion, both axles' cornering stiffness, and the
//! errors of the sensors it stands on.
//!
//! The joint EKF of thesis (5.21) multiplies two unknowns, stiffness and slip angle, and is soon surer
//! of both than it can be. Here the *measured* forces are the regressors: lateral acceleration and
//! yaw acceleration give each axle's normalized force μ, and with the compliance κ = 1/k every
//! equation is linear in what is unknown:
//!
//! ```text
//! v̇_y = a_y − v_x r                                 kinematics: no tire in it
//! δ − (v_y + a r)/v_x = κ_F μ_F                       μ_F = (a_y + J ṙ/(m b))/g
//!   − (v_y − b r)/v_x = κ_R μ_R                       μ_R = (a_y − J ṙ/(m a))/g     (thesis 5.20)
//! ```
//!
//! All of it holds for means over a window as it does for an instant, if only v_y's change from one
//! window's mean to the next is integrated from every sample ([`Window`]). Windows are long, because
//! noise in a regressor pulls the compliance to zero, and what counts against it is how much the force
//! *changes* from window to window. The yaw acceleration, in gentle driving mostly noise, is shrunk to
//! its expectation for the same reason ([`YawAcceleration`]).
//!
//! Further states are the offsets of steering, accelerometer and gyro, the scales of speed and
//! steering angle, and the road's bank, which turns v_y but is no tire force. Noise is learned from the
//! innovations; a CUSUM detector per axle notices a change of surface.

mod lasting;

use nalgebra::SVector;

use super::learned::{Known, Trial};
use super::window::{Means, Path, Window, YawAcceleration};
use super::{Car, Cornering, CorneringConfig, Kinematics};
use crate::estimates::{Estimate, SensorOffsets};
use crate::filter::{Cusum, Gaussian, LearnedNoise};
use crate::model::GRAVITY;
use crate::{Quantity, Sensors};

const STATES: usize = 9;

/// Places in the state.
const VY: usize = 0;
/// Compliances of the axles, rad per unit of normalized force.
const FRONT: usize = 1;
const REAR: usize = 2;
/// Offsets: road wheel angle rad, lateral acceleration m/s², yaw rate rad/s.
const ANGLE_OFFSET: usize = 3;
const AY_OFFSET: usize = 4;
const YAW_OFFSET: usize = 5;
/// Relative errors of speed and steering angle.
const SPEED_SCALE: usize = 6;
const ANGLE_SCALE: usize = 7;
/// Gravity's part along the road's cross slope, m/s².
const BANK: usize = 8;

type Row = SVector<f64, STATES>;

/// The filter.
#[derive(Clone, Debug)]
pub struct CorneringEstimator {
    car: Car,
    config: CorneringConfig,
    noise: SensorNoise,
    state: Gaussian<STATES>,
    window: Window,
    running: bool,
    axles: [AxleMonitor; 2],
    yaw_acceleration: YawAcceleration,
    minimum_speed: f64,
    standing_s: f64,
    age_s: f64,
    informed: bool,
    /// Seconds since the last sample that could be used at all, and whether there was one.
    idle_s: f64,
    seen: bool,
    motion: Option<LateralMotion>,
    /// The stiffnesses when they were last known well. The surface may have changed since.
    settled: [Option<Known>; 2],
    /// What was taken up from an earlier drive is on trial.
    trial: Option<Trial<STATES>>,
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

/// Standard deviations of single samples.
#[derive(Clone, Copy, Debug)]
struct SensorNoise {
    yaw_rate: f64,
    acceleration: f64,
    road_angle: f64,
}

/// What a window said besides what it measured.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Said {
    Nothing,
    /// The surface changed.
    Changed,
    /// What an earlier drive learned is not true of this one.
    OtherCar,
}

/// What an axle's innovations say.
#[derive(Clone, Debug)]
struct AxleMonitor {
    noise: LearnedNoise,
    cusum: Cusum,
}

impl CorneringEstimator {
    /// Samples are averaged over this time before each update, s.
    const WINDOW_S: f64 = 0.4;
    /// Windows that the learned noise remembers.
    const NOISE_MEMORY: f64 = 100.0;
    /// Learned noise this many times (variance) the promised one is no longer a sensor's.
    const NOISE_LIMIT: f64 = 100.0;
    /// A compliance stays within these, rad.
    const COMPLIANCE_LIMITS: (f64, f64) = (1.0 / 80.0, 1.0);
    /// Lateral acceleration from which a window tells something of the stiffness, m/s².
    const INFORMATIVE: f64 = 0.4;
    /// Up to this relative uncertainty a stiffness is known well enough to notice its change.
    const SETTLED: f64 = 0.15;
    /// What the equations leave out (timing of the sensors, relaxation, load transfer), relative: no
    /// amount of data takes it away.
    const MODEL_STD: f64 = 0.03;
    /// A stiffness this uncertain (relative) is not given out at all.
    const UNKNOWN: f64 = 0.25;
    /// Relative uncertainty that a compliance has again after a change of surface.
    const CHANGE_STD: f64 = 0.4;
    /// Normalized innovations count in the CUSUM up to this.
    const ALARM_CLIP: f64 = 4.0;
    /// All wheels slower than this, for [`Self::STANDING_AFTER`]: the car stands, m/s.
    const STANDING_BELOW: f64 = 0.1;
    const STANDING_AFTER: f64 = 0.5;
    /// Lateral velocity of which nothing is known yet, m/s.
    const UNKNOWN_VY: f64 = 0.5;

    /// Starts from the vehicle's priors.
    pub fn new(car: &Car, sensors: &Sensors, config: &CorneringConfig, minimum_speed: f64) -> Self {
        let axle = AxleMonitor {
            noise: LearnedNoise::new(Self::NOISE_MEMORY),
            cusum: Cusum::new(config.cusum_drift, config.cusum_threshold),
        };
        Self {
            noise: SensorNoise {
                yaw_rate: sensors.noise_std(Quantity::YawRate),
                acceleration: sensors.noise_std(Quantity::LateralAcceleration),
                road_angle: sensors.noise_std(Quantity::SteeringWheelAngle) / car.steering_ratio,
            },
            state: Self::prior(car, config),
            window: Window::new(Self::WINDOW_S),
            running: false,
            axles: [axle.clone(), axle],
            yaw_acceleration: YawAcceleration::default(),
            minimum_speed,
            standing_s: 0.0,
            age_s: 0.0,
            informed: false,
            idle_s: 0.0,
            seen: false,
            motion: None,
            settled: [None; 2],
            trial: None,
            car: car.clone(),
            config: config.clone(),
        }
    }

    /// What is known before anything is measured.
    fn prior(car: &Car, config: &CorneringConfig) -> Gaussian<STATES> {
        let mut mean = [0.0; STATES];
        let mut std = [0.0; STATES];
        for (i, (value, deviation)) in [FRONT, REAR].into_iter().zip(car.cornering_prior) {
            mean[i] = 1.0 / value;
            std[i] = (deviation / value).max(0.05) / value;
        }
        std[VY] = Self::UNKNOWN_VY;
        std[ANGLE_OFFSET] = config.steering_offset_std;
        std[AY_OFFSET] = config.acceleration_offset_std;
        std[YAW_OFFSET] = config.yaw_rate_offset_std;
        std[SPEED_SCALE] = config.speed_scale_std.hypot(car.radius_relative_std);
        std[ANGLE_SCALE] = car.steering_ratio_relative_std;
        std[BANK] = config.bank_std;
        Gaussian::new(mean, std)
    }

    /// Takes a sample; returns whether the cornering stiffness jumped.
    pub fn step(&mut self, now: &Kinematics) -> bool {
        self.age_s += now.elapsed_s;
        self.idle_s += now.elapsed_s;
        self.motion = None;
        self.watch_standstill(now);
        let Some(Cornering { speed, yaw_rate: r, lateral_acceleration: ay, road_angle: angle }) =
            now.cornering(self.minimum_speed)
        else {
            self.stop(now.elapsed_s);
            return false;
        };
        if now.elapsed_s > 0.25 * Self::WINDOW_S {
            self.stop(now.elapsed_s);
        }
        (self.idle_s, self.seen) = (0.0, true);
        let sample = Means { speed, yaw_rate: r, acceleration: ay, angle, samples: 1.0, ..Means::default() };
        let mut changed = false;
        if let Some(mut means) = self.window.step(&sample, now.elapsed_s) {
            self.yaw_acceleration.shrink(&mut means);
            changed = self.update(&means);
            self.running = true;
        }
        if self.running {
            self.motion = Some(self.motion_at(&sample));
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
            let compliance = self.state.mean[i];
            let relative = self.state.std(i) / compliance;
            let systematic = Self::MODEL_STD.hypot(self.car.cornering_scale_std[i - FRONT]);
            let relative = relative.hypot(systematic);
            (self.informed && relative < Self::UNKNOWN).then(|| Estimate {
                value: 1.0 / compliance,
                std: relative / compliance,
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
        self.axles.iter().all(|axle| {
            axle.noise.nis() < self.config.inconsistent_nis && axle.noise.scale() < Self::NOISE_LIMIT
        })
    }

    /// The surface changed, as this filter or another noticed: the stiffness may be anything near.
    pub fn surface_changed(&mut self) {
        for i in [FRONT, REAR] {
            let std = Self::CHANGE_STD * self.state.mean[i];
            self.state.inflate(i, std * std);
        }
        for axle in &mut self.axles {
            axle.cusum.reset();
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
            let mut h = Row::zeros();
            h[YAW_OFFSET] = 1.0;
            self.state.update(&h, r - self.state.mean[YAW_OFFSET], self.noise.yaw_rate.powi(2));
        }
    }

    /// The motion is not known for a while; stiffness and sensor errors are kept.
    fn stop(&mut self, elapsed_s: f64) {
        self.window = Window::new(Self::WINDOW_S);
        if std::mem::take(&mut self.running) {
            self.forget(VY, 0.0, Self::UNKNOWN_VY);
        }
        self.walk(elapsed_s);
    }

    /// A component is unknown again, and unrelated to the others.
    fn forget(&mut self, i: usize, mean: f64, std: f64) {
        self.state.covariance.row_mut(i).fill(0.0);
        self.state.covariance.column_mut(i).fill(0.0);
        self.state.mean[i] = mean;
        self.state.covariance[(i, i)] = std * std;
    }

    /// Random walks of what changes on its own, and the bank, which comes and goes.
    fn walk(&mut self, elapsed_s: f64) {
        let config = &self.config;
        for i in [FRONT, REAR] {
            let walk = config.stiffness_walk * self.state.mean[i];
            self.state.inflate(i, walk * walk * elapsed_s);
        }
        let kept = (-elapsed_s / config.bank_time_s).exp();
        self.state.mean[BANK] *= kept;
        self.state.covariance.row_mut(BANK).scale_mut(kept);
        self.state.covariance.column_mut(BANK).scale_mut(kept);
        self.state.inflate(BANK, config.bank_std.powi(2) * (1.0 - kept * kept));
    }

    /// From the last window's middle to this one's, then both axles' equations.
    fn update(&mut self, now: &Means) -> bool {
        if self.running {
            self.predict(now);
        } else {
            let r = now.yaw_rate - self.state.mean[YAW_OFFSET];
            let vy = self.car.steady_lateral_velocity(now.speed, r, now.acceleration);
            self.forget(VY, vy, Self::UNKNOWN_VY);
        }
        let mut changed = false;
        for axle in [FRONT, REAR] {
            match self.measure(axle, now) {
                Said::Nothing => {}
                Said::Changed => changed = true,
                Said::OtherCar => {
                    self.start_afresh();
                    return false;
                }
            }
        }
        for i in [FRONT, REAR] {
            let (low, high) = Self::COMPLIANCE_LIMITS;
            self.state.mean[i] = self.state.mean[i].clamp(low, high);
        }
        if !self.state.is_sound() {
            self.start_again();
        }
        if now.acceleration.abs() > Self::INFORMATIVE {
            self.age_s = 0.0;
            self.informed = true;
            self.settle();
        }
        if changed {
            self.surface_changed();
        }
        changed
    }

    /// v̇_y = a_y − v_x r from window to window, with the sensors' errors and the bank taken off.
    fn predict(&mut self, now: &Means) {
        let path = now.path;
        let x = &self.state.mean;
        let turned = path.turned - x[YAW_OFFSET] * path.distance;
        self.state.mean[VY] += self.along(&path);
        let mut transition = nalgebra::SMatrix::<f64, STATES, STATES>::identity();
        transition[(VY, AY_OFFSET)] = -path.time;
        transition[(VY, BANK)] = -path.time;
        transition[(VY, YAW_OFFSET)] = path.distance;
        transition[(VY, SPEED_SCALE)] = -turned;
        let white =
            self.noise.acceleration.hypot(now.speed * self.noise.yaw_rate) * path.time / now.samples.sqrt();
        let unmodelled = self.config.acceleration_noise * path.time.sqrt();
        let mut noise = nalgebra::SMatrix::<f64, STATES, STATES>::zeros();
        noise[(VY, VY)] = white * white + unmodelled * unmodelled;
        self.state.predict_covariance(&transition, &noise);
        self.walk(path.time);
    }

    /// Change of v_y along a path, m/s.
    fn along(&self, path: &Path) -> f64 {
        let x = &self.state.mean;
        let turned = path.turned - x[YAW_OFFSET] * path.distance;
        path.pushed - (x[AY_OFFSET] + x[BANK]) * path.time - (1.0 + x[SPEED_SCALE]) * turned
    }

    /// One axle's equation: what the slip angle is by the motion, less what it is by the force.
    fn measure(&mut self, axle: usize, now: &Means) -> Said {
        let car = &self.car;
        let x = &self.state.mean;
        let front = axle == FRONT;
        // Along the car to the axle, and how its inertia turns yaw acceleration into axle force.
        let lever = if front { car.a } else { -car.b };
        let turning = car.yaw_inertia / (car.mass * if front { car.b } else { -car.a });
        let force = (now.acceleration - x[AY_OFFSET] + turning * now.yaw_acceleration) / GRAVITY;
        let speed = now.speed * (1.0 + x[SPEED_SCALE]);
        let along = (x[VY] + lever * (now.yaw_rate - x[YAW_OFFSET])) / speed;
        let steered = if front { now.angle * (1.0 + x[ANGLE_SCALE]) - x[ANGLE_OFFSET] } else { 0.0 };
        let compliance = x[axle];
        let residual = -(steered - along.atan() - compliance * force);
        let mut h = Row::zeros();
        h[VY] = -1.0 / speed;
        h[axle] = -force;
        h[AY_OFFSET] = compliance / GRAVITY;
        h[YAW_OFFSET] = lever / speed;
        h[SPEED_SCALE] = along;
        if front {
            h[ANGLE_OFFSET] = -1.0;
            h[ANGLE_SCALE] = now.angle;
        }
        let promised = self.promised_variance(axle, compliance, turning, lever / speed, now);
        let excess = (now.acceleration.abs() - self.config.linear_up_to_mps2).max(0.0);
        let nonlinear = 1.0 + 100.0 * excess * excess;
        let monitor = &mut self.axles[axle - FRONT];
        let variance = monitor.noise.variance(promised) * nonlinear;
        let expected = self.state.innovation(&h, residual, variance);
        match self.trial.as_mut().map(|trial| trial.step(&expected, variance)) {
            Some(Some(true)) => return Said::OtherCar,
            Some(None) => self.trial = None,
            _ => {}
        }
        if excess == 0.0 {
            monitor.noise.learn(&expected, promised);
        }
        let redundancy = monitor.noise.redundancy();
        let settled = self.state.std(axle) < Self::SETTLED * compliance;
        self.state.update(&h, residual, variance * redundancy);
        // Steered fast to and fro, sensors a few milliseconds apart disagree in ways that look like softness.
        let steady = now.acceleration.abs() > now.acceleration_spread;
        if force.abs() * GRAVITY < Self::INFORMATIVE || !settled || !steady {
            return Said::Nothing;
        }
        let evidence = expected.normalized() * force.signum() / redundancy.sqrt();
        match monitor.cusum.step(evidence.clamp(-Self::ALARM_CLIP, Self::ALARM_CLIP)) {
            Some(_) => Said::Changed,
            None => Said::Nothing,
        }
    }

    /// Noise of an axle's equation as the sensors' data sheets promise it, rad².
    fn promised_variance(&self, axle: usize, compliance: f64, turning: f64, lever: f64, now: &Means) -> f64 {
        let averaged = 1.0 / now.samples.sqrt();
        let force = (self.noise.acceleration * averaged).hypot(turning * now.yaw_acceleration_std) / GRAVITY;
        let mut variance = (compliance * force).powi(2) + (lever * self.noise.yaw_rate * averaged).powi(2);
        if axle == FRONT {
            variance += (self.noise.road_angle * averaged).powi(2);
        }
        variance + self.config.slip_angle_noise.powi(2)
    }

    /// The motion now, brought forward from the last window's mean.
    fn motion_at(&self, now: &Means) -> LateralMotion {
        let x = &self.state.mean;
        let vy = x[VY] + self.along(&self.window.path);
        let r = now.yaw_rate - x[YAW_OFFSET];
        let angle = now.angle * (1.0 + x[ANGLE_SCALE]) - x[ANGLE_OFFSET];
        LateralMotion {
            lateral_velocity: vy,
            lateral_velocity_std: self.state.std(VY),
            slip_angles: self.car.slip_angles(now.speed * (1.0 + x[SPEED_SCALE]), vy, r, angle),
        }
    }

    /// Numbers got out of hand: better to know nothing than to go on with them.
    fn start_again(&mut self) {
        let noise = self.noise;
        *self = Self::new(&self.car, &Sensors::default(), &self.config, self.minimum_speed);
        self.noise = noise;
    }
}

#[cfg(test)]
mod tests;
