//! The filter: samples in, motion, stiffnesses and offsets out.

use super::another_road::AnotherRoad;
use super::axle::{AxleMonitor, OtherCar, Outcome};
use super::config::CorneringConfig;
use super::doubt::{Axle, Doubt, Surprises};
use super::equation::Equation;
use super::lasting;
use super::model::{Model, SensorNoise};
use super::single_brake::SingleBrake;
use super::standstill::Standstill;
use super::state::{ANGLE_OFFSET, AY_OFFSET, FRONT, REAR, STATES, State, UNKNOWN_VY, VY, YAW_OFFSET, prior};
use super::window::{Means, Window, YawAcceleration};
use crate::estimate::belief::Belief;
use crate::estimate::kinematics::{Car, Cornering, Kinematics};
use crate::estimate::learned::{self, Learned, Trial};
use crate::estimate::motion::Known;
use crate::estimates::{Estimate, SensorOffsets};
use crate::{Quantity, Sensors};

/// Tuned: standing, creeping and blind driving with the tests `long_drives` and `faults`, what is given out with
/// `real_cars`, the rest with no test on record.
struct Tuning {
    /// Samples are averaged over this time before each update, s.
    window_s: f64,
    /// A compliance stays within these, rad.
    compliance_limits: (f64, f64),
    /// A stiffness this uncertain (relative) is not given out at all.
    unknown: f64,
    /// Relative uncertainty that a compliance has again after a change of surface.
    change_std: f64,
    /// … and after one that only later turned out to have happened.
    moved_std: f64,
    /// The bus sends less often than it is sampled: so many samples of a sensor at rest count as one.
    repeated: f64,
    /// Wheel speeds have no sign. After driving slowly it shows within this time, s, whether the car rolls backwards.
    forward_shows_s: f64,
    /// Driven blindly for so long (s), the surface may have become another one, …
    blind_s: f64,
    /// … and the stiffnesses be off by this share of themselves.
    blind_std: f64,
    /// A sample that stands for more than this share of a window ends it.
    gap: f64,
}

const TUNING: Tuning = Tuning {
    window_s: 0.4,
    compliance_limits: (1.0 / 80.0, 1.0),
    unknown: 0.25,
    change_std: 0.4,
    moved_std: 0.15,
    repeated: 4.0,
    forward_shows_s: 3.0,
    blind_s: 2.0,
    blind_std: 0.2,
    gap: 0.25,
};

/// The filter.
#[derive(Clone, Debug)]
pub struct CorneringEstimator {
    model: Model,
    /// Noise by the data sheets.
    promised: SensorNoise,
    pub(super) state: State,
    /// The state if the road has changed.
    another: AnotherRoad,
    axles: [AxleMonitor; 2],
    window: Window,
    yaw_acceleration: YawAcceleration,
    single_brake: SingleBrake,
    /// A single wheel was braked in the last window.
    is_braked: bool,
    standstill: Standstill,
    minimum_speed: f64,
    /// The lateral velocity is known: a window has ended since the car began to drive.
    running: bool,
    /// For how long the car has been fast enough, s.
    driving_s: f64,
    surprises: Surprises,
    age_s: f64,
    informed: bool,
    /// Seconds since the last sample that could be used at all, and whether there was one.
    idle_s: f64,
    seen: bool,
    /// For how long the car may have driven without usable sensors, s.
    blind_s: f64,
    /// The stiffnesses when they were last known well. The surface may have changed since.
    settled: [Option<learned::Known>; 2],
    /// What was taken up from an earlier drive is on trial.
    trial: Option<Trial<STATES>>,
    /// Errors of sensors from an earlier drive, for the first minutes.
    taken: Option<lasting::Taken>,
}

impl CorneringEstimator {
    /// Starts from the vehicle's priors.
    pub fn new(car: &Car, sensors: &Sensors, config: &CorneringConfig, minimum_speed: f64) -> Self {
        let single_brake = SingleBrake::new(car, car.radius * sensors.noise_std(Quantity::WheelSpeedFl));
        Self::at_start(Model::new(car, sensors, config), single_brake, minimum_speed)
    }

    fn at_start(model: Model, single_brake: SingleBrake, minimum_speed: f64) -> Self {
        let axle = AxleMonitor::new(&model.config);
        let state = prior(&model.car, &model.config);
        Self {
            state,
            another: AnotherRoad::unlikely(&state),
            axles: [axle.clone(), axle],
            window: Window::new(TUNING.window_s),
            yaw_acceleration: YawAcceleration::default(),
            single_brake,
            is_braked: false,
            standstill: Standstill::default(),
            minimum_speed,
            running: false,
            driving_s: 0.0,
            surprises: Surprises::NONE,
            age_s: 0.0,
            informed: false,
            idle_s: 0.0,
            seen: false,
            blind_s: 0.0,
            settled: [None; 2],
            trial: None,
            taken: None,
            promised: model.noise,
            model,
        }
    }

    /// Starts from what an earlier drive learned, less sure of it. Before the first sample only.
    pub fn restore(&mut self, learned: &Learned) {
        self.state = lasting::restored(learned, &self.model);
        self.another = AnotherRoad::unlikely(&self.state);
        self.settled = learned.cornering;
        self.taken = Some(lasting::Taken::new(&self.state));
        self.trial = Some(Trial::new(prior(&self.model.car, &self.model.config), lasting::TRIAL));
    }

    /// Puts into `learned` what outlives the drive; motion and bank do not.
    pub fn learn(&self, learned: &mut Learned) {
        learned.cornering = self.settled;
        if self.seen || self.trial.is_some() {
            lasting::learn_errors(&self.state, learned);
        }
    }

    /// Takes a sample; returns whether the cornering stiffness jumped. `longitudinal` is the acceleration along the
    /// car, where it is known, and `belief` what is believed of the friction.
    pub fn step(&mut self, now: &Kinematics, longitudinal: Option<f64>, belief: &Belief) -> bool {
        self.age_s += now.elapsed_s;
        self.idle_s += now.elapsed_s;
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
        if now.elapsed_s > TUNING.gap * TUNING.window_s {
            self.blind_s += now.elapsed_s;
            self.stop(now.elapsed_s);
        }
        (self.idle_s, self.seen) = (0.0, true);
        let along = longitudinal.map_or(0.0, |a| self.model.car.longitudinal_force(a, speed));
        let rear_angle = now.rear_angle;
        let sample = Means {
            speed,
            yaw_rate: r,
            acceleration: ay,
            angle,
            rear_angle,
            along,
            samples: 1.0,
            ..Means::default()
        };
        self.single_brake.add(now, along);
        let mut changed = false;
        if let Some(mut means) = self.window.step(&sample, now.elapsed_s) {
            self.yaw_acceleration.shrink(&mut means);
            if std::mem::take(&mut self.blind_s) > TUNING.blind_s {
                self.open(TUNING.blind_std);
            }
            changed = self.update(&means, belief);
            self.running = true;
        }
        changed
    }

    /// The noise of single readings as it turned out: yaw rate (rad/s) and lateral acceleration (m/s²). Less than the
    /// data sheets promise is not believed: noise repeats itself.
    pub fn set_noise(&mut self, [yaw_rate, acceleration]: [f64; 2]) {
        let noise = &mut self.model.noise;
        noise.yaw_rate = yaw_rate.max(self.promised.yaw_rate);
        noise.acceleration = acceleration.max(self.promised.acceleration);
    }

    /// Noise of single readings as it is believed: yaw rate (rad/s) and lateral acceleration (m/s²).
    pub fn noise(&self) -> [f64; 2] {
        [self.model.noise.yaw_rate, self.model.noise.acceleration]
    }

    /// All that is known of tires and sensors at the moment, by earlier drives, too. What is hardly known of a tire is
    /// left to the data sheet; all is, where the accelerometer is not `believed`.
    pub fn known(&self, believed: bool) -> Known {
        let fresh = (!believed).then(|| prior(&self.model.car, &self.model.config));
        let estimate = |i: usize| {
            let known = || self.another.beside(&self.state, i);
            let (value, std) = fresh.as_ref().map_or_else(known, |fresh| (fresh.mean[i], fresh.std(i)));
            Estimate { value, std, age_s: self.age_s }
        };
        Known {
            stiffness: [FRONT, REAR].map(|i| {
                let Estimate { value, std, age_s } = estimate(i);
                let is_known = believed && std < TUNING.unknown * value;
                is_known.then_some(Estimate { value: 1.0 / value, std: std / (value * value), age_s })
            }),
            offsets: [ANGLE_OFFSET, AY_OFFSET, YAW_OFFSET].map(estimate),
            is_braked: believed && self.is_braked,
        }
    }

    /// Normalized cornering stiffness front and rear, 1/rad.
    pub fn stiffness(&self) -> [Option<Estimate>; 2] {
        [FRONT, REAR].map(|i| {
            let (compliance, std) = self.another.beside(&self.state, i);
            let relative = std / compliance;
            let systematic = self.model.systematic_std[i - FRONT];
            let relative = (relative * relative + systematic * systematic).sqrt();
            (self.informed && relative < TUNING.unknown).then(|| Estimate {
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

    /// Both of these stiffnesses, its own, are known well and lately, and the filter is consistent.
    pub fn are_valid(&self, stiffness: &[Option<Estimate>; 2]) -> bool {
        let config = &self.model.config;
        self.is_consistent()
            && stiffness.iter().all(|stiffness| {
                stiffness.is_some_and(|c| {
                    c.std <= config.valid_relative_std * c.value && c.age_s <= config.valid_age_s
                })
            })
    }

    /// There is no doubt.
    pub fn is_consistent(&self) -> bool {
        self.doubt().is_none()
    }

    /// The first reason not to believe what it says: innovations are not about as large as the filter believes, on
    /// the whole or lately, or the noise it had to assume for that is no sensor's.
    pub fn doubt(&self) -> Option<Doubt> {
        let axles = || [Axle::Front, Axle::Rear].into_iter().zip(&self.axles);
        let of_axles = || axles().find_map(|(axle, monitor)| monitor.doubt(axle, &self.model.config));
        self.surprises.doubt().or_else(of_axles)
    }

    /// A sensor failed its plausibility check: the motion is unknown, and what was learned from it is doubted for a
    /// while.
    pub fn distrust(&mut self) {
        self.stop(0.0);
        self.blind_s = f64::INFINITY;
        self.surprises = Surprises::CONTRADICTION;
    }

    /// This estimator or another noticed a change of surface: the stiffnesses are open again.
    pub fn surface_changed(&mut self) {
        self.open(TUNING.change_std);
    }

    /// A sensor was doubted, and is not any more: what was learned of it meanwhile is open.
    pub fn doubt_ends(&mut self) {
        self.open(TUNING.change_std);
        let prior = prior(&self.model.car, &self.model.config);
        for state in self.states() {
            for i in [ANGLE_OFFSET, AY_OFFSET, YAW_OFFSET] {
                state.inflate(i, prior.covariance[(i, i)]);
            }
        }
    }

    /// The stiffnesses may be off by this share of themselves.
    fn open(&mut self, relative_std: f64) {
        for i in [FRONT, REAR] {
            let std = relative_std * self.state.mean[i];
            self.state.inflate(i, std * std);
        }
        self.another = AnotherRoad::unlikely(&self.state);
        self.axles.iter_mut().for_each(AxleMonitor::forget_evidence);
    }

    /// Standing still, the yaw rate sensor shows its offset.
    fn watch_standstill(&mut self, now: &Kinematics) {
        if let Some((yaw_rate, samples)) = self.standstill.step(now) {
            let variance = TUNING.repeated * self.model.noise.yaw_rate.powi(2) / samples;
            for state in self.states() {
                state.update_component(YAW_OFFSET, yaw_rate - state.mean[YAW_OFFSET], variance);
            }
        }
    }

    /// The motion is not known for a while; stiffness and sensor errors are kept.
    fn stop(&mut self, elapsed_s: f64) {
        self.window = Window::new(TUNING.window_s);
        self.single_brake.stop();
        let is_over = std::mem::take(&mut self.running);
        let Self { model, state, another, .. } = self;
        for state in [state, &mut another.state] {
            if is_over {
                state.forget(VY, 0.0, UNKNOWN_VY);
            }
            model.walk(state, elapsed_s, model.ordinary_walk());
        }
    }

    /// By both hypotheses.
    fn states(&mut self) -> [&mut State; 2] {
        [&mut self.state, &mut self.another.state]
    }

    /// From the last window's middle to this one's, then both axles' equations.
    fn update(&mut self, now: &Means, belief: &Belief) -> bool {
        if self.running {
            let is_sliding = self.axles.iter().any(AxleMonitor::is_sliding);
            self.model.predict(&mut self.state, now, is_sliding, self.model.ordinary_walk());
            self.model.predict(&mut self.another.state, now, is_sliding, AnotherRoad::WALK);
            self.another.wait(now.path.time);
        } else {
            let r = now.yaw_rate - self.state.mean[YAW_OFFSET];
            let vy = self.model.car.steady_lateral_velocity(now.speed, r, now.acceleration);
            for state in self.states() {
                state.forget(VY, vy, UNKNOWN_VY);
            }
        }
        self.is_braked = self.single_brake.end(now.speed, now.path.time);
        if self.is_braked && self.driving_s > TUNING.forward_shows_s {
            return false;
        }
        let Ok(changed) = self.measure(now, belief) else {
            self.start_afresh();
            return false;
        };
        let contradicted = self.taken.as_mut().map(|taken| taken.step(&self.state, now.path.time));
        match contradicted {
            Some(Some(true)) => {
                self.start_afresh();
                return false;
            }
            Some(None) => self.taken = None,
            _ => {}
        }
        let (low, high) = TUNING.compliance_limits;
        for state in self.states() {
            for i in [FRONT, REAR] {
                state.mean[i] = state.mean[i].clamp(low, high);
            }
        }
        if !(self.state.is_sound() && self.another.state.is_sound()) {
            self.start_again();
        }
        if now.acceleration.abs() > AxleMonitor::INFORMATIVE {
            self.age_s = 0.0;
            self.informed = true;
            lasting::settle(&self.state, self.model.config.valid_relative_std, &mut self.settled);
        }
        if changed {
            self.surface_changed();
        }
        changed
    }

    /// Both axles' measurement updates; returns whether a stiffness jumped.
    fn measure(&mut self, now: &Means, belief: &Belief) -> Result<bool, OtherCar> {
        let (mut changed, mut surprised) = (false, false);
        let Self { model, state, another, axles, trial, .. } = self;
        // What speaks for another road.
        let mut more = 0.0;
        let mut outcomes = [Outcome::default(); 2];
        for ((axle, monitor), outcome) in [FRONT, REAR].into_iter().zip(axles).zip(&mut outcomes) {
            // The rear one's by the state that the front axle has corrected.
            let equation = Equation::new(axle, now, state, model, belief);
            *outcome = monitor.update(&equation, now, state, trial, belief)?;
            if let Some((variance, same)) = outcome.weight {
                let equation = Equation::new(axle, now, &another.state, model, belief);
                more += another.update(&equation, variance) - same;
            }
        }
        if another.weigh(more) {
            *state = another.state;
            for i in [FRONT, REAR] {
                state.inflate(i, (TUNING.moved_std * state.mean[i]).powi(2));
            }
        }
        for outcome in outcomes {
            changed |= outcome.surface_changed;
            if let Some(surprise) = outcome.surprise {
                self.surprises.by(surprise);
                surprised |= !outcome.surface_changed;
            }
        }
        self.surprises.end_window(surprised);
        Ok(changed)
    }

    /// Readings contradict an earlier drive's numbers (another load or sensor, perhaps): starts as if there were
    /// none.
    fn start_afresh(&mut self) {
        let idle = (self.idle_s, self.seen);
        self.start_again();
        (self.idle_s, self.seen) = idle;
    }

    /// The state is not sound any more: starts from the priors.
    fn start_again(&mut self) {
        let promised = self.promised;
        *self = Self::at_start(self.model.clone(), self.single_brake.clone(), self.minimum_speed);
        self.promised = promised;
    }
}
