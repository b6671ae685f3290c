//! The pipeline: one sample in, everything known out.

use super::abs_braking::AbsBraking;
use super::block::{Block, BlockBuilder};
use super::brake_slip::BrakeSlip;
use super::brush::BrushEstimator;
use super::config::EstimatorsConfig;
use super::cornering::{Apart, CorneringEstimator, Doubt};
use super::doubted::{Doubted, Doubts};
use super::expected::{Contradiction, Expected};
use super::friction::{Evidence, FrictionMonitor};
use super::kinematics::{Car, Heard, Kinematics};
use super::learned::Learned;
use super::mapping::{MappedFriction, Mapping, mean_slope};
use super::motion::MotionFilter;
use super::overall_slope::OverallSlope;
use super::plain_readings::{Plain, PlainReadings};
use super::roughness::Roughness;
use super::saturating::SaturatingTires;
use super::saturation::SaturationDetector;
use super::slope::SlopeEstimator;
use super::thesis::Thesis;
use super::torque_zero::TorqueZero;
use super::traction::{Traction, TractionPoint};
use crate::estimates::{Estimates, Motion, State};
use crate::filter::Fading;
use crate::model::effect::EffectConfig;
use crate::model::{DrivenAxle, Vehicle};
use crate::{Faults, Quantity, Sample, Sensors};

/// Tuned: `agreeing` with the test `long_drives`, the rest with no test on record.
struct Tuning {
    /// Several wheels and filters notice the same change: within this time it is one, s.
    one_change_s: f64,
    /// Nobody knows whether the car moved during a gap as long as this, s.
    gap_s: f64,
    /// Slips of two driven wheels that agree differ by less than this share of the larger, …
    agreeing: f64,
    /// … or by so many deviations of their noise.
    agreeing_noise: f64,
    /// More than this, m/s², is a jump of the speed and no motion. Physical: twice what road tires give.
    most_acceleration: f64,
    /// Normalized force (rms) at which the slopes are fully excited.
    full_excitation: f64,
    /// Time constant of the excitation, s.
    excitation_memory_s: f64,
}

const TUNING: Tuning = Tuning {
    one_change_s: 2.0,
    gap_s: 1.0,
    agreeing: 0.4,
    agreeing_noise: 3.0,
    most_acceleration: 20.0,
    full_excitation: 0.1,
    excitation_memory_s: 10.0,
};

/// Runs the estimators on a sample. Never allocates after construction.
#[derive(Clone, Debug)]
pub struct Pipeline {
    config: EstimatorsConfig,
    car: Car,
    sensors: Sensors,
    heard: Heard,
    /// Where the car is more than the plain one.
    plain: Option<PlainReadings>,
    /// What may be learned of it.
    expected: Expected,
    blocks: BlockBuilder,
    traction: Traction,
    torque_zero: TorqueZero,
    slope: SlopeEstimator,
    /// Where no wheel rolls freely.
    overall_slope: Option<OverallSlope>,
    roughness: Roughness,
    cornering: CorneringEstimator,
    apart: Apart,
    motion: MotionFilter,
    saturating: SaturatingTires,
    brush: BrushEstimator,
    abs: AbsBraking,
    brake_slip: BrakeSlip,
    saturation: SaturationDetector,
    friction: FrictionMonitor,
    mapping: Option<Mapping>,
    /// Where somebody asked for them.
    thesis: Option<Box<Thesis>>,
    excitation: [Excitation; 2],
    /// Longitudinal acceleration from the wheels, where no accelerometer has it.
    block_acceleration: Option<f64>,
    doubted: Doubted,
    /// Seconds since a surface change was last noticed.
    unchanged_s: f64,
    /// Seconds that the car moved, those of earlier drives included.
    driving_s: f64,
    latest: Estimates,
}

impl Pipeline {
    /// For this vehicle and these sensors: the estimators that something published stands on.
    pub fn new(vehicle: &Vehicle, sensors: &Sensors, config: &EstimatorsConfig) -> Self {
        let car = Car::new(vehicle);
        let slow = config.minimum_speed_mps;
        let driven = usize::from(car.driven_axle == DrivenAxle::Rear);
        Self {
            blocks: BlockBuilder::new(config.slope.block_s),
            traction: Traction::new(&car, sensors, &config.slope, slow),
            torque_zero: TorqueZero::default(),
            slope: SlopeEstimator::new(&car, sensors, &config.slope),
            overall_slope: (car.driven_axle == DrivenAxle::All)
                .then(|| OverallSlope::new(&car, sensors, &config.slope, slow)),
            roughness: Roughness::new(car.radius * sensors.noise_std(Quantity::WheelSpeedFl)),
            cornering: CorneringEstimator::new(&car, sensors, &config.cornering, slow),
            apart: Apart::default(),
            motion: MotionFilter::new(&car, sensors, slow, config.cornering.valid_sideslip_std),
            saturating: SaturatingTires::new(&car, slow),
            brush: BrushEstimator::new(car.slope_prior[driven].0, &config.brush),
            abs: AbsBraking::new(&car),
            brake_slip: BrakeSlip::new(&car),
            saturation: SaturationDetector::new(&car, sensors),
            friction: FrictionMonitor::new(&car, &config.friction),
            mapping: config.mapping.as_ref().and_then(Mapping::new),
            thesis: None,
            excitation: [Excitation::NONE; 2],
            block_acceleration: None,
            doubted: Doubted::default(),
            unchanged_s: f64::INFINITY,
            driving_s: 0.0,
            latest: Estimates::default(),
            config: config.clone(),
            sensors: *sensors,
            heard: Heard::default(),
            plain: None,
            expected: Expected::new(&car, config),
            car,
        }
    }

    /// The same with the thesis's estimators beside them, for [`Estimates::thesis`]. To be called before the
    /// first sample.
    #[must_use]
    pub fn with_thesis(mut self) -> Self {
        self.thesis = Some(Box::new(Thesis::new(&self.car, &self.sensors, &self.config)));
        self
    }

    /// The same for a car with these effects: what [`PlainReadings`] can take out of the readings is taken out. To be called
    /// before the first sample.
    #[must_use]
    pub fn with_effects(mut self, vehicle: &Vehicle, effects: &[EffectConfig]) -> Self {
        self.plain = PlainReadings::new(vehicle, effects);
        self
    }

    /// Starts from what an earlier drive learned of this car, with wider deviations. To be called before the first
    /// sample. Nothing of it is given out before this drive has measured the same quantity, and what the first
    /// readings contradict is forgotten.
    ///
    /// What contradicts the car's table is not taken; the first such number is returned.
    pub fn restore(&mut self, learned: &Learned) -> Option<Contradiction> {
        let (learned, contradiction) = &self.expected.agreeing(learned);
        self.slope.restore(learned);
        if let Some(overall) = &mut self.overall_slope {
            overall.restore(learned);
        }
        self.cornering.restore(learned);
        self.driving_s = learned.driving_s;
        *contradiction
    }

    /// What the estimators know that outlives the drive; never friction, and nothing that contradicts the car's table.
    /// Some hundred operations and no allocation: it may be asked for between any two samples.
    pub fn learned(&self) -> Learned {
        self.expected.agreeing(&self.all_learned()).0
    }

    /// The same, and in the place of what contradicts what was known before this drive.
    pub fn learned_or(&self, before: &Learned) -> Learned {
        self.expected.agreeing_or(&self.all_learned(), before)
    }

    /// The first number that was learned and contradicts the car's table.
    pub fn contradiction(&self) -> Option<Contradiction> {
        self.expected.agreeing(&self.all_learned()).1
    }

    fn all_learned(&self) -> Learned {
        let mut learned = Learned { time: self.latest.time, driving_s: self.driving_s, ..Learned::default() };
        self.slope.learn(&mut learned);
        if let Some(overall) = &self.overall_slope {
            overall.learn(&mut learned);
        }
        self.cornering.learn(&mut learned);
        learned.plausible()
    }

    /// Seconds that the car moved, those of the drives before included.
    pub fn driving_s(&self) -> f64 {
        self.driving_s
    }

    /// Takes a sample; what is returned holds until the next one.
    pub fn step(&mut self, sample: &Sample) -> &Estimates {
        self.heard.hear(sample);
        let plain = self.plain(sample);
        let sample = &plain.sample;
        let said =
            Kinematics { rear_angle: plain.rear_angle, ..Kinematics::of(sample, &self.car, self.heard) };
        let (mut now, mut heard) = (said, self.heard);
        if self.motion.leaves_out_acceleration() {
            now.lateral_acceleration = None;
            heard = heard.without(Quantity::LateralAcceleration);
        }
        self.latest.time = sample.time;
        self.latest.faults = sample.faults;
        self.latest.state = self.state(sample);
        self.unchanged_s += now.elapsed_s;
        if now.elapsed_s < TUNING.gap_s && self.drives(&now) {
            self.driving_s += now.elapsed_s;
        }
        self.abs.step(&now);
        self.longitudinal(&now.along(sample, &self.car, heard));
        self.lateral(&now, &said);
        self.slip_of_motion(plain.answered);
        self.use_of_friction(&Self::surely_used(&now.turned(heard), &said));
        if let Some(thesis) = &mut self.thesis {
            self.latest.thesis = thesis.step(&now, self.latest.motion.lateral_velocity);
        }
        self.latest.excitation_long = self.excitation[0].level(TUNING.full_excitation);
        self.latest.excitation_lat = self.excitation[1].level(TUNING.full_excitation);
        if self.doubt().is_some() {
            self.latest.faults |= Faults::INCONSISTENT;
        }
        if sample.faults.intersects(Faults::MOTION_MISMATCH | Faults::STUCK) {
            self.believe_nothing();
        }
        &self.latest
    }

    /// The sample as the plain car would have it.
    fn plain(&mut self, sample: &Sample) -> Plain {
        match &mut self.plain {
            Some(readings) => readings.step(sample, self.heard, self.latest.motion.lateral_velocity),
            None => Plain::of(sample),
        }
    }

    /// The slip angles of the motion, where the tires answer to others.
    fn slip_of_motion(&mut self, [front, rear]: [f64; 2]) {
        let motion = &mut self.latest.motion;
        motion.slip_angle_front = motion.slip_angle_front.map(|angle| angle - front);
        motion.slip_angle_rear = motion.slip_angle_rear.map(|angle| angle - rear);
    }

    /// The latest estimates.
    pub fn latest(&self) -> &Estimates {
        &self.latest
    }

    /// Which sensors contradict each other at the moment; [`Faults::INCONSISTENT`] tells that some do.
    pub fn doubt(&self) -> Option<Doubt> {
        let apart = || {
            let (by, lasts_s) = self.apart.doubt()?;
            Some(Doubt::Apart { factor: by.exp(), lasts_s })
        };
        self.motion.doubt().or_else(|| self.doubt_of_slip()).or_else(apart)
    }

    /// … of those that tell slip and force.
    fn doubt_of_slip(&self) -> Option<Doubt> {
        self.motion.late_wheel().or_else(|| self.torque_zero.doubt())
    }

    /// Frames lost before they could be used, as the bus counts them.
    pub fn set_dropped_frames(&mut self, count: u64) {
        self.latest.dropped_frames = count;
    }

    /// Sensors contradict each other: one of them is wrong, and every estimate may be.
    fn believe_nothing(&mut self) {
        self.cornering.distrust();
        self.motion.distrust();
        self.saturating.stop();
        self.friction.surface_changed();
        let latest = &mut self.latest;
        (latest.slope_valid, latest.cornering_valid) = (false, false);
        (latest.motion.valid, latest.friction.valid) = (false, false);
    }

    fn state(&self, sample: &Sample) -> State {
        if sample.is_empty() {
            return State::NoInput;
        }
        let doubtful = Faults::WHEEL_MISMATCH | Faults::MOTION_MISMATCH | Faults::STUCK;
        let is_usual =
            sample.has_all(Quantity::basic(self.sensors.configured())) && !sample.faults.intersects(doubtful);
        if is_usual { State::Running } else { State::Degraded }
    }

    fn longitudinal(&mut self, now: &Kinematics) {
        self.slope.age(now.elapsed_s);
        self.roughness.age(now.elapsed_s);
        self.brush.age(now.elapsed_s);
        let (offsets, slopes) = (&self.latest.slip_offset, &self.latest.slope);
        self.saturation.step(now, &self.traction, offsets, slopes, &self.config.slope);
        if let Some(block) = self.blocks.step(now) {
            self.block_acceleration = Some(block.acceleration);
            let points = self.points(&block);
            // Slips of a spinning wheel are no points of a straight line.
            if !self.saturation.is_spinning() && self.slope.step(&points, block.duration_s) {
                self.on_surface_change();
                self.cornering.surface_changed();
            }
            self.curve(&block, &points);
            if block.braking != Some(true) && !self.saturation.is_spinning() {
                self.roughness.step(&block);
            }
        }
        self.latest.roughness = self.roughness.estimate();
        self.latest.slip_offset = self.slope.offsets();
        let are_valid = if let Some(overall) = &mut self.overall_slope {
            let changed = overall.step(now);
            self.latest.slope = overall.slopes();
            let is_valid = overall.is_valid();
            if changed {
                self.on_surface_change();
                self.cornering.surface_changed();
            }
            is_valid
        } else {
            self.latest.slope = self.slope.slopes();
            self.slope.are_valid(&self.latest.slope)
        };
        self.latest.slope_valid = now.speed.is_some()
            && are_valid
            && self.doubt_of_slip().is_none()
            && !self.motion.doubts_steering();
    }

    /// Slips and forces, where the forces can be told.
    fn points(&mut self, block: &Block) -> [Option<TractionPoint>; 4] {
        if let Some((difference, felt)) = self.traction.torque_and_acceleration(block)
            && self.torque_zero.step(difference, felt, block.duration_s)
        {
            self.slope = SlopeEstimator::new(&self.car, &self.sensors, &self.config.slope);
        }
        if self.torque_zero.doubt().is_some() { [None; 4] } else { self.traction.points(block) }
    }

    /// The brush regression on the mean of the driven wheels, if these agree. A wheel braked alone or on another
    /// surface would mix two curves into one that no road has.
    fn curve(&mut self, block: &Block, points: &[Option<TractionPoint>; 4]) {
        let offsets = self.slope.offsets();
        let mut count = 0.0;
        let (mut slip, mut mu, mut slip_variance, mut mu_variance) = (0.0, 0.0, 0.0, 0.0);
        let (mut least, mut most) = (f64::INFINITY, f64::NEG_INFINITY);
        for (point, offset) in points.iter().zip(offsets) {
            let (Some(point), Some(offset)) = (point, offset) else { continue };
            count += 1.0;
            let slipping = point.slip - offset.value;
            (least, most) = (least.min(slipping), most.max(slipping));
            slip += slipping;
            mu += point.mu;
            slip_variance += point.slip_std * point.slip_std + offset.std * offset.std;
            mu_variance += point.mu_std * point.mu_std;
        }
        if count == 0.0 {
            let felt = block.longitudinal_acceleration.filter(|_| self.overall_slope.is_some());
            let used = felt.map_or(0.0, |felt| self.car.longitudinal_force(felt, block.speed));
            self.excitation[0].step(used, block.duration_s);
            return;
        }
        self.excitation[0].step(mu / count, block.duration_s);
        let agrees = most - least
            < TUNING.agreeing * least.abs().max(most.abs()) + TUNING.agreeing_noise * slip_variance.sqrt();
        if !agrees {
            return;
        }
        let std = |variance: f64| variance.sqrt() / count;
        self.brush.step(slip / count, std(slip_variance), mu / count, std(mu_variance), block.duration_s);
    }

    /// `said`: with an accelerometer that nobody believes.
    fn lateral(&mut self, now: &Kinematics, said: &Kinematics) {
        self.cornering.set_noise(self.motion.white_noise());
        if self.cornering.step(now, self.acceleration(now), self.friction.belief()) {
            self.on_surface_change();
        }
        let known = self.cornering.known(!self.motion.leaves_out_acceleration());
        self.motion.step(said, self.acceleration(now), &known);
        let (along, motion) = (self.acceleration(now), self.motion.motion());
        self.saturating.step(now, along, motion, &known, self.cornering.noise());
        let doubts = Doubts { any: self.motion.doubt().is_some(), steering: self.motion.doubts_steering() };
        if self.doubted.step(doubts, self.drives(now), now.elapsed_s) {
            self.cornering.doubt_ends();
        }
        let motion = self.motion.motion();
        let lateral_velocity = motion.map(|m| m.lateral_velocity);
        let lateral = now.lateral_acceleration.unwrap_or(0.0) / crate::model::GRAVITY;
        self.excitation[1].step(if motion.is_some() { lateral } else { 0.0 }, now.elapsed_s);
        self.latest.motion = Motion {
            speed: now.speed,
            lateral_velocity,
            sideslip: now.speed.zip(lateral_velocity).map(|(vx, vy)| (vy / vx).atan()),
            slip_angle_front: motion.map(|m| m.slip_angles[0]),
            slip_angle_rear: motion.map(|m| m.slip_angles[1]),
            valid: now.speed.is_some_and(|speed| self.motion.is_valid(speed)),
        };
        self.latest.cornering = self.cornering.stiffness();
        self.latest.offsets = self.cornering.offsets();
        let are_good = self.motion.tells_of_tires() && self.cornering.are_valid(&self.latest.cornering);
        self.apart.step(&self.latest.cornering, are_good, now.speed.unwrap_or(0.0), now.elapsed_s);
        self.latest.cornering_valid = are_good && self.apart.doubt().is_none();
    }

    /// Of an accelerometer that is left out and of turning, the one that says less: a car that spins turns faster than it
    /// is pushed across, and an offset is not used.
    fn surely_used(now: &Kinematics, said: &Kinematics) -> Kinematics {
        let mut used = *now;
        if let (Some(turning), Some(said)) = (now.lateral_acceleration, said.lateral_acceleration) {
            used.lateral_acceleration = Some(if said.abs() < turning.abs() { said } else { turning });
        }
        used
    }

    fn use_of_friction(&mut self, now: &Kinematics) {
        let ended = self.abs.finished().filter(|_| self.brake_slip.was_at_limit());
        if let Some(friction) = ended {
            self.brush.calibrate(friction.mu, friction.std);
        }
        self.brake_slip.step(now, &self.latest.slope);
        let is_spoiled = self.doubted.has_spoiled_the_curve(self.saturating.slides());
        let evidence = Evidence {
            brush: self.brush.friction(),
            abs: self.abs.last(),
            abs_working_s: self.abs.working_s(),
            brakes_at_limit: self.brake_slip.is_at_limit(&self.latest.slope),
            limit: self.saturation.friction(),
            curve: self.saturating.likelihood().filter(|_| !is_spoiled),
            map: self.mapped(),
        };
        self.latest.friction = self.friction.step(now, self.acceleration(now), evidence);
    }

    fn drives(&self, now: &Kinematics) -> bool {
        now.speed.is_some_and(|speed| speed >= self.config.minimum_speed_mps)
    }

    /// Longitudinal acceleration, measured or from the wheels.
    fn acceleration(&self, now: &Kinematics) -> Option<f64> {
        if self.heard.has(Quantity::LongitudinalAcceleration) {
            now.longitudinal_acceleration
        } else {
            self.block_acceleration.filter(|acceleration| acceleration.abs() < TUNING.most_acceleration)
        }
    }

    /// Friction by the calibrated mapping, where there is one and the slope is known.
    fn mapped(&self) -> Option<MappedFriction> {
        let mapping = self.mapping.as_ref().filter(|_| self.latest.slope_valid)?;
        if !mapping.holds_on(self.latest.roughness) {
            return None;
        }
        let scale_std = self.car.slope_scale_std(self.sensors.has(Quantity::DriveTorque));
        mapping.at(mean_slope(&self.latest.slope, self.car.driven_axle, scale_std)?)
    }

    fn on_surface_change(&mut self) {
        if self.unchanged_s > TUNING.one_change_s {
            self.latest.surface_changes = self.latest.surface_changes.saturating_add(1);
        }
        self.unchanged_s = 0.0;
        self.saturating.surface_changed();
        self.friction.surface_changed();
        self.brush.surface_changed();
    }
}

/// Running rms of a normalized force.
#[derive(Clone, Copy, Debug)]
struct Excitation {
    square: f64,
    fading: Fading,
}

impl Excitation {
    const NONE: Self = Self { square: 0.0, fading: Fading::over(TUNING.excitation_memory_s) };

    fn step(&mut self, mu: f64, elapsed_s: f64) {
        self.fading.smooth(&mut self.square, mu * mu, elapsed_s);
    }

    fn level(&self, full: f64) -> f64 {
        (self.square.sqrt() / full).min(1.0)
    }
}
