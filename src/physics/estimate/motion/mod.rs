//! The lateral motion: a bank of filters on a tire that saturates, one for each friction that the road may have.
//!
//! At each sample every filter of the [`bank`] predicts the car by the measured speed and steering
//! ([`model`](super::lateral_filter::model)) and is corrected by yaw rate and lateral acceleration. How well each did
//! is its weight; their mixture is the motion, its deviation holds what they disagree about.
//!
//! Real sensors are noisier than their data sheets, and a car is no bicycle. Three things keep the filters from
//! believing too much:
//!
//! * the white part of the noise is learned from the readings ([`white_noise`]), what is left from the innovations;
//! * errors of the model repeat themselves from sample to sample, so that some samples count as one;
//! * stiffnesses tend to what the windowed estimator ([`cornering`](super::cornering)) knows of them, or to the data
//!   sheet. Left alone they would take up what delays, geometry and load transfer leave.
//!
//! The same model runs free beside the bank: it and the accelerometer are the [`witnesses`] of the yaw rate. What they
//! disagree about is no filter's business any more but a wrong sensor's. A car without an accelerometer has its motion
//! without it, and so has one whose accelerometer both others contradict. The wheels that roll freely are a witness, too
//! ([`free_axle`]). What comes late ([`lateness`]) the filters live with; tires are not learned from it.

mod bank;
mod free_axle;
mod lateness;
mod proportion;
#[cfg(all(test, feature = "simulation"))]
#[cfg(test)]
mod tests;
mod white_noise;
mod witnesses;

use self::bank::Bank;
pub use self::bank::Known;
use self::free_axle::FreeAxle;
use self::white_noise::WhiteNoise;
use self::witnesses::{Body, Witness, Witnesses};
use super::cornering::Doubt;
use super::kinematics::{Car, Kinematics};
use super::lateral_filter::hypothesis::Readings;
use super::lateral_filter::model::Inputs;
use super::lateral_filter::steering::SteeringActivity;
use crate::model::DrivenAxle;
use crate::{Quantity, Sensors};

/// Tuned: steering with the test `sim2_joint`, the rest with the tests `long_drives` and `faults`.
struct Tuning {
    /// Steering may be this much livelier (spectral density) than it seems.
    steering_margin: f64,
    /// Without a sample for this long the motion is unknown, s.
    gap_s: f64,
    /// Wheel speeds have no sign. After driving slowly it shows within this time, s, whether the car rolls backwards.
    forward_shows_s: f64,
    /// A car that a single wheel's brake turned has settled again after this time, s.
    braked_settles_s: f64,
}

const TUNING: Tuning =
    Tuning { steering_margin: 2.0, gap_s: 0.1, forward_shows_s: 3.0, braked_settles_s: 0.5 };

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

/// The filters and their witnesses. Never allocates after construction.
#[derive(Clone, Debug)]
pub struct MotionFilter {
    car: Car,
    bank: Bank,
    /// Of yaw rate and lateral acceleration.
    white: [WhiteNoise; 2],
    activity: SteeringActivity,
    /// Of a reading of the road wheel angle, rad².
    angle_variance: f64,
    before: Option<Inputs>,
    minimum_speed: f64,
    valid_std: f64,
    /// For how long the car has been fast enough and its sensors sound, s.
    driving_s: f64,
    /// Since a single wheel was last braked, s.
    unbraked_s: f64,
    witnesses: Witnesses,
    free_axle: FreeAxle,
    /// Nobody believes the accelerometer.
    is_outvoted: bool,
    motion: Option<LateralMotion>,
}

impl MotionFilter {
    /// For this car and these sensors; below `minimum_speed` (m/s) there is no motion, and sideslip is valid up to a
    /// deviation of `valid_std` (rad).
    pub fn new(car: &Car, sensors: &Sensors, minimum_speed: f64, valid_std: f64) -> Self {
        let variance = |quantity| sensors.noise_std(quantity).powi(2);
        let angle_variance = variance(Quantity::SteeringWheelAngle) / car.steering_ratio.powi(2);
        Self {
            bank: Bank::new(car),
            white: [Quantity::YawRate, Quantity::LateralAcceleration]
                .map(|quantity| WhiteNoise::new(variance(quantity))),
            activity: SteeringActivity::new(angle_variance),
            angle_variance,
            before: None,
            minimum_speed,
            valid_std,
            driving_s: 0.0,
            unbraked_s: f64::INFINITY,
            witnesses: Witnesses::new(Body::new(car)),
            free_axle: FreeAxle::new(car),
            is_outvoted: false,
            motion: None,
            car: car.clone(),
        }
    }

    /// Takes a sample, the acceleration along the car (m/s²) where it is known, and what else is known of tires and
    /// sensors.
    pub fn step(&mut self, now: &Kinematics, along: Option<f64>, known: &Known) {
        self.motion = None;
        let Some(turning) = now.turning(self.minimum_speed) else {
            self.stop();
            return;
        };
        let elapsed_s = now.elapsed_s;
        self.driving_s += elapsed_s;
        self.unbraked_s = if known.is_braked { 0.0 } else { self.unbraked_s + elapsed_s };
        self.white[0].step(turning.yaw_rate);
        match turning.lateral_acceleration {
            Some(acceleration) => self.white[1].step(acceleration),
            None => self.white[1].interrupt(),
        }
        let along = along.map_or(0.0, |a| self.car.longitudinal_force(a, turning.speed));
        let longitudinal = self.car.axle_forces(along);
        let inputs = Inputs { speed: turning.speed, longitudinal, rear_angle: now.rear_angle };
        let before = self.before.replace(inputs).filter(|_| elapsed_s <= TUNING.gap_s);
        let steering = TUNING.steering_margin * self.activity.step(turning.road_angle, elapsed_s);
        let white = self.white.map(|white| white.variance());
        let noise = self.bank.noise(white, self.angle_variance, known.is_braked);
        match &before {
            Some(before) => self.bank.predict(before, &inputs, elapsed_s, &noise, steering, known),
            None => self.bank.start(&turning, known),
        }
        let (angle, yaw_rate) = (turning.road_angle, turning.yaw_rate);
        let said = Readings { angle, yaw_rate, acceleration: turning.lateral_acceleration };
        let believed = Readings { acceleration: said.acceleration.filter(|_| !self.is_outvoted), ..said };
        self.bank.update(&inputs, &believed, &noise, white, elapsed_s);
        if !self.bank.is_sound() {
            self.bank = Bank::new(&self.car);
            self.stop();
            return;
        }
        self.free_axle.step(now, turning.yaw_rate);
        self.witnesses.step(self.bank.model(), self.bank.likeliest(), &inputs, &said, white, elapsed_s);
        self.motion = Some(self.bank.motion(&inputs));
        let is_outvoted = self.witnesses.outvote_acceleration();
        if is_outvoted && !self.is_outvoted {
            // What it told until now is in everything that the filters know.
            (self.bank, self.before) = (Bank::new(&self.car), None);
        }
        self.is_outvoted = is_outvoted;
    }

    /// Nobody believes the accelerometer: the motion is known without it.
    pub fn leaves_out_acceleration(&self) -> bool {
        self.is_outvoted
    }

    /// Motion at the last sample, if the car moved and nothing was missing.
    pub fn motion(&self) -> Option<LateralMotion> {
        self.motion
    }

    /// White noise of a sample of the yaw rate (rad/s) and of the lateral acceleration (m/s²): standard deviations.
    pub fn white_noise(&self) -> [f64; 2] {
        self.white.map(|white| white.variance().sqrt())
    }

    /// The sideslip is known well enough to be acted upon.
    pub fn is_valid(&self, speed: f64) -> bool {
        (self.witnesses.doubt().is_none() || self.is_outvoted)
            && self.scaled().is_none()
            && (self.driving_s > TUNING.forward_shows_s || self.witnesses.show_forward())
            && self.unbraked_s > TUNING.braked_settles_s
            && self.motion.is_some_and(|motion| motion.lateral_velocity_std <= self.valid_std * speed)
    }

    /// Which two sensors disagree, if any do, or come at different times. The filters live with the latter, others do not.
    pub fn doubt(&self) -> Option<Doubt> {
        let left_out = self.is_outvoted.then_some("lateral_acceleration");
        let late = || {
            let by_wheels = || {
                let (by_s, lasts_s) = self.free_axle.yaw_rate_is_late()?;
                Some((["yaw_rate", "the wheels"], by_s, lasts_s))
            };
            let (sensors, by_s, lasts_s) = by_wheels().or_else(|| self.witnesses.late())?;
            Some(Doubt::Late { sensors, by_s, lasts_s, left_out })
        };
        let disagreement = self.witnesses.doubt().or_else(|| self.scaled()).map(|witness| {
            let Witness { sensors, off, of, lasts_s } = witness;
            Doubt::Disagreement { sensors, off, of, lasts_s, left_out }
        });
        disagreement.or_else(late)
    }

    /// A yaw rate that is off by a factor.
    fn scaled(&self) -> Option<Witness> {
        let (off, of, lasts_s) = self.free_axle.yaw_rate_is_scaled()?;
        Some(Witness { sensors: ["yaw_rate", "the wheels", "rad/s"], off, of, lasts_s })
    }

    /// The steering angle is doubted: nobody knows how its wheels stand.
    pub fn doubts_steering(&self) -> bool {
        self.witnesses.doubt_steering()
    }

    /// One of the wheels that roll freely comes later than the other: slips against it are none.
    pub fn late_wheel(&self) -> Option<Doubt> {
        let (by_s, lasts_s) = self.free_axle.left_wheel_is_late()?;
        let names = if self.car.driven_axle == DrivenAxle::Rear {
            ["wheel_speed_fl", "wheel_speed_fr"]
        } else {
            ["wheel_speed_rl", "wheel_speed_rr"]
        };
        let sensors = earlier_last(names, by_s);
        Some(Doubt::Late { sensors, by_s: by_s.abs(), lasts_s, left_out: None })
    }

    /// The sensors are good enough to learn tires from them.
    pub fn tells_of_tires(&self) -> bool {
        self.doubt().is_none() && !self.witnesses.are_crude()
    }

    /// A sensor failed its plausibility check: the motion is unknown.
    pub fn distrust(&mut self) {
        self.stop();
    }

    fn stop(&mut self) {
        self.before = None;
        self.driving_s = 0.0;
        self.white.iter_mut().for_each(WhiteNoise::interrupt);
        self.witnesses.stop();
        self.free_axle.stop();
        self.is_outvoted = false;
    }
}

/// The late one first: the first one comes so much later (s).
fn earlier_last([one, other]: [&'static str; 2], by_s: f64) -> [&'static str; 2] {
    if by_s > 0.0 { [one, other] } else { [other, one] }
}
