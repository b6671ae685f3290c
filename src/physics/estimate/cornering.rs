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
//! Tires bend: near their limit they slip further than κ μ, by a factor that depends on how much of the friction is
//! in use. What is believed of the friction says how far on average, and how far that may be off ([`bend`]). And
//! tires slide: an axle whose slip angle its force does not account for at all is left out, and v_y goes on by its
//! kinematics alone ([`sliding`]). How far an axle is bent beyond doubt bounds the friction ([`bound`]).
//!
//! Further states are the offsets of steering, accelerometer and gyro, the scales of speed and
//! steering angle, and the road's bank, which turns v_y but is no tire force. Noise is learned from the
//! innovations; a CUSUM detector per axle notices a change of surface.

mod bend;
mod bound;
mod doubt;
mod lasting;
mod measure;
mod single_brake;
mod sliding;
mod standstill;

use nalgebra::SVector;

use self::bend::Bend;
pub use self::doubt::{Axle, Doubt};
use self::single_brake::SingleBrake;
pub use self::sliding::LateralLimit;
use self::sliding::Sliding;
use self::standstill::Standstill;

use super::belief::Belief;
use super::learned::{Known, Trial};
use super::window::{Means, Window, YawAcceleration};
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
    single_brake: SingleBrake,
    tires: Bend,
    limit: Option<LateralLimit>,
    yaw_acceleration: YawAcceleration,
    minimum_speed: f64,
    /// What no data take away of a stiffness's deviation, relative.
    systematic_std: [f64; 2],
    standstill: Standstill,
    /// For how long the car has been fast enough, s.
    driving_s: f64,
    /// Rises by two with each window that surprises, falls by one with each that does not.
    surprise: u32,
    /// What surprised last.
    surprised_by: Doubt,
    age_s: f64,
    informed: bool,
    /// Seconds since the last sample that could be used at all, and whether there was one.
    idle_s: f64,
    seen: bool,
    /// For how long the car has been driving, or may have, with sensors that told nothing of it, s.
    blind_s: f64,
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
    /// What the filter did not expect.
    Surprise,
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
    sliding: Sliding,
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
    const MODEL_STD: f64 = 0.06;
    /// A stiffness this uncertain (relative) is not given out at all.
    const UNKNOWN: f64 = 0.25;
    /// Relative uncertainty that a compliance has again after a change of surface.
    const CHANGE_STD: f64 = 0.4;
    /// Correlation of both stiffnesses' walks: it is the same surface.
    const WALKS_TOGETHER: f64 = 0.8;
    /// A stiffness of which nothing was learned for long is no less known than this, relative.
    const UNKNOWN_STD: f64 = 0.5;
    /// Normalized innovations count in the CUSUM up to this.
    const ALARM_CLIP: f64 = 4.0;
    /// Errors of sensors move by this share of what they may be at all, 1/√s: a tenth in an hour.
    const ERRORS_WALK: f64 = 0.1 / 60.0;
    /// A bus sends less often than it is sampled: so many samples of a sensor that rests are worth one.
    const REPEATED: f64 = 4.0;
    /// After driving so slowly that it may be backwards, where wheel speeds have no sign, that shows within this, s.
    const FORWARD_SHOWS_S: f64 = 3.0;
    /// A window surprises with a normalized innovation (squared) beyond this …
    const SURPRISING: f64 = 16.0;
    /// … and is doubted until two have not; more than three such count as three.
    const DOUBTFUL: u32 = 2;
    const MOST_SURPRISED: u32 = 6;
    /// By so much (rad) no tire has confirmed that the sideslip changed since the last window: that is a spin, or a
    /// sensor that lies.
    const UNSEEN: f64 = 0.05;
    /// Driven blindly for so long (s), the surface may have become another one, and the stiffnesses be off by that
    /// share of themselves.
    const BLIND_S: f64 = 2.0;
    const BLIND_STD: f64 = 0.2;
    /// Lateral velocity of which nothing is known yet, m/s.
    const UNKNOWN_VY: f64 = 0.5;

    /// Starts from the vehicle's priors.
    pub fn new(car: &Car, sensors: &Sensors, config: &CorneringConfig, minimum_speed: f64) -> Self {
        let axle = AxleMonitor {
            noise: LearnedNoise::new(Self::NOISE_MEMORY),
            cusum: Cusum::new(config.cusum_drift, config.cusum_threshold),
            sliding: Sliding::default(),
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
            single_brake: SingleBrake::new(car, car.radius * sensors.noise_std(Quantity::WheelSpeedFl)),
            tires: Bend::new(),
            limit: None,
            yaw_acceleration: YawAcceleration::default(),
            minimum_speed,
            systematic_std: car.cornering_scale_std.map(|std| Self::MODEL_STD.hypot(std)),
            standstill: Standstill::default(),
            driving_s: 0.0,
            surprise: 0,
            surprised_by: Doubt::Sensors,
            age_s: 0.0,
            informed: false,
            idle_s: 0.0,
            seen: false,
            blind_s: 0.0,
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

    /// Takes a sample; returns whether the cornering stiffness jumped. `longitudinal` is the acceleration along the
    /// car, where it is known, and `belief` what is believed of the friction.
    pub fn step(&mut self, now: &Kinematics, longitudinal: Option<f64>, belief: &Belief) -> bool {
        self.age_s += now.elapsed_s;
        self.idle_s += now.elapsed_s;
        self.motion = None;
        self.limit = None;
        self.watch_standstill(now);
        let Some(Cornering { speed, yaw_rate: r, lateral_acceleration: ay, road_angle: angle }) =
            now.cornering(self.minimum_speed)
        else {
            self.driving_s = 0.0;
            let is_slow = now.speed.is_some_and(|speed| speed < self.minimum_speed);
            self.blind_s += if is_slow || !self.seen { 0.0 } else { now.elapsed_s };
            self.stop(now.elapsed_s);
            return false;
        };
        self.driving_s += now.elapsed_s;
        if now.elapsed_s > 0.25 * Self::WINDOW_S {
            self.blind_s += now.elapsed_s;
            self.stop(now.elapsed_s);
        }
        (self.idle_s, self.seen) = (0.0, true);
        let along = longitudinal.map_or(0.0, |a| self.car.longitudinal_force(a, speed));
        let sample =
            Means { speed, yaw_rate: r, acceleration: ay, angle, along, samples: 1.0, ..Means::default() };
        self.single_brake.add(now, along);
        let mut changed = false;
        if let Some(mut means) = self.window.step(&sample, now.elapsed_s) {
            self.yaw_acceleration.shrink(&mut means);
            if std::mem::take(&mut self.blind_s) > Self::BLIND_S {
                self.open(Self::BLIND_STD);
            }
            changed = self.update(&means, belief);
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

    /// Friction, at a sample by which an axle was found to slide.
    pub fn limit(&self) -> Option<LateralLimit> {
        self.limit.map(|limit| LateralLimit { is_sure: limit.is_sure && self.is_consistent(), ..limit })
    }

    /// Normalized cornering stiffness front and rear, 1/rad.
    pub fn stiffness(&self) -> [Option<Estimate>; 2] {
        [FRONT, REAR].map(|i| {
            let compliance = self.state.mean[i];
            let relative = self.state.std(i) / compliance;
            let systematic = self.systematic_std[i - FRONT];
            let relative = (relative * relative + systematic * systematic).sqrt();
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

    /// Both of these stiffnesses, which are its own, are known well, and lately, and the filter agrees with itself.
    pub fn are_valid(&self, stiffness: &[Option<Estimate>; 2]) -> bool {
        let config = &self.config;
        self.is_consistent()
            && stiffness.iter().all(|stiffness| {
                stiffness.is_some_and(|c| {
                    c.std <= config.valid_relative_std * c.value && c.age_s <= config.valid_age_s
                })
            })
    }

    /// The sideslip is known well enough to be acted upon.
    pub fn is_motion_valid(&self, speed: f64) -> bool {
        self.is_consistent()
            && self.driving_s > Self::FORWARD_SHOWS_S
            && self.motion.is_some_and(|m| {
                let unseen = (m.lateral_velocity - self.state.mean[VY]).abs();
                m.lateral_velocity_std <= self.config.valid_sideslip_std * speed
                    && unseen < Self::UNSEEN * speed
            })
    }

    /// Nothing speaks against what it says.
    pub fn is_consistent(&self) -> bool {
        self.doubt().is_none()
    }

    /// A sensor lies, as its plausibility has it: the motion is anything, and is doubted for a while afterwards; who knows
    /// what was learned from it.
    pub fn distrust(&mut self) {
        self.stop(0.0);
        self.blind_s = f64::INFINITY;
        (self.surprise, self.surprised_by) = (Self::MOST_SURPRISED, Doubt::Sensors);
    }

    /// The surface changed, as this filter or another noticed: the stiffness may be anything near.
    pub fn surface_changed(&mut self) {
        self.open(Self::CHANGE_STD);
    }

    /// The stiffnesses may be off by this share of themselves.
    fn open(&mut self, relative_std: f64) {
        for i in [FRONT, REAR] {
            let std = relative_std * self.state.mean[i];
            self.state.inflate(i, std * std);
        }
        for axle in &mut self.axles {
            axle.cusum.reset();
        }
    }

    /// Standing still, the yaw rate sensor shows its offset.
    fn watch_standstill(&mut self, now: &Kinematics) {
        if let Some((yaw_rate, samples)) = self.standstill.step(now) {
            let variance = Self::REPEATED * self.noise.yaw_rate.powi(2) / samples;
            self.state.update_component(YAW_OFFSET, yaw_rate - self.state.mean[YAW_OFFSET], variance);
        }
    }

    /// The motion is not known for a while; stiffness and sensor errors are kept.
    fn stop(&mut self, elapsed_s: f64) {
        self.window = Window::new(Self::WINDOW_S);
        self.single_brake.stop();
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

    /// From the last window's middle to this one's, then both axles' equations.
    fn update(&mut self, now: &Means, belief: &Belief) -> bool {
        if self.running {
            self.predict(now);
        } else {
            let r = now.yaw_rate - self.state.mean[YAW_OFFSET];
            let vy = self.car.steady_lateral_velocity(now.speed, r, now.acceleration);
            self.forget(VY, vy, Self::UNKNOWN_VY);
        }
        let (mut changed, mut surprised) = (false, false);
        let is_braked = self.single_brake.end(now.speed, now.path.time);
        if is_braked && self.driving_s > Self::FORWARD_SHOWS_S {
            return false;
        }
        let mut equation = self.equation(FRONT, now, belief);
        self.limit = self.bent_limit([&equation, &self.equation(REAR, now, belief)], belief);
        for axle in [FRONT, REAR] {
            if axle == REAR {
                // By the state that the front axle has corrected.
                equation = self.equation(REAR, now, belief);
            }
            match self.measure(&equation, now, belief) {
                Said::Nothing => {}
                Said::Surprise => surprised = true,
                Said::Changed => changed = true,
                Said::OtherCar => {
                    self.start_afresh();
                    return false;
                }
            }
        }
        self.surprise = if surprised { self.surprise + 2 } else { self.surprise.saturating_sub(1) };
        self.surprise = self.surprise.min(Self::MOST_SURPRISED);
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

    /// Numbers got out of hand: better to know nothing than to go on with them.
    fn start_again(&mut self) {
        let (noise, single_brake) = (self.noise, self.single_brake.clone());
        *self = Self::new(&self.car, &Sensors::default(), &self.config, self.minimum_speed);
        (self.noise, self.single_brake) = (noise, single_brake);
    }
}

#[cfg(test)]
mod tests;
