//! From a recording's samples and estimates to pairs of slope and friction.
//!
//! The thesis's two figures differ in one thing: in 6.1 brakings were paired with whatever slope there
//! was, in 6.2 only with slopes that had settled on the surface braked on. So a braking is a pair only
//! if its slope had settled, and everything else is listed with the reason why it is none.

use thiserror::Error;

use super::Pair;
use crate::estimate::abs_braking::{AbsBraking, AbsProblem, AbsRecord};
use crate::estimate::kinematics::{Car, Kinematics};
use crate::estimates::Estimate;
use crate::model::{DrivenAxle, GRAVITY, Vehicle};
use crate::{Estimates, Micros, Quantity, Sample, Sensors, Wheel};

/// Tuned with the test `calibrate`.
struct Tuning {
    /// A slope that stays within this share of itself …
    steady: f64,
    /// … for so long has settled, s.
    settled_s: f64,
    /// An older slope may be of another surface, s.
    oldest_s: f64,
    /// A change of surface that is noticed this long after a braking was there before it, s: the car has to speed
    /// up again before the slope can tell.
    confirm_s: f64,
}

const TUNING: Tuning = Tuning { steady: 0.08, settled_s: 5.0, oldest_s: 10.0, confirm_s: 8.0 };

/// An ABS braking, and whether it makes a pair.
#[derive(Clone, Debug, PartialEq)]
pub struct Braking {
    /// When the ABS came in.
    pub time: Micros,
    /// For how long it worked, s.
    pub duration_s: f64,
    /// Speed before it, m/s.
    pub speed: f64,
    /// Friction by (6.2): value and standard deviation.
    pub mu: Option<(f64, f64)>,
    /// Slope before the brakes were touched, mean of the driven wheels, settled or not. Its standard
    /// deviation is without what the data sheet leaves open, which is the same in every pair.
    pub slope: Option<Estimate>,
    /// How rough the road was before it, m/s.
    pub roughness: Option<f64>,
    /// The surface was watched for some seconds after the braking, too, and did not change.
    pub confirmed: bool,
    /// Why it is not a pair.
    pub not_a_pair: Option<NotAPair>,
}

impl Braking {
    /// The pair, if it is one.
    pub fn pair(&self) -> Option<Pair> {
        if self.not_a_pair.is_some() { None } else { self.as_if_settled() }
    }

    /// The pair that the braking makes with whatever slope there was: the way of Fig. 6.1.
    pub fn as_if_settled(&self) -> Option<Pair> {
        let ((mu, mu_std), slope) = self.mu.zip(self.slope)?;
        let roughness = self.roughness;
        Some(Pair { slope: slope.value, slope_std: slope.std, mu, mu_std, roughness })
    }
}

/// Why a braking is not a pair.
#[derive(Clone, Copy, Debug, PartialEq, Error)]
pub enum NotAPair {
    /// It gave no friction.
    #[error("{0}")]
    NoFriction(AbsProblem),
    /// Part of the friction went sideways.
    #[error("in a curve: {share:.0} % of the friction went sideways")]
    Cornering {
        /// Lateral acceleration / (μ g), %.
        share: f64,
    },
    /// Nothing is known of the surface.
    #[error("no slope yet: drive on the surface with some torque first")]
    NoSlope,
    /// Known, but not well.
    #[error("the slope had not converged (±{relative:.0} %)")]
    NotConverged {
        /// Standard deviation / slope, %.
        relative: f64,
    },
    /// It was still moving.
    #[error("the slope had settled for {settled_s:.1} s only, {needed_s:.0} s are needed")]
    NotSettled {
        /// Since the slope last moved or the surface last changed, s.
        settled_s: f64,
        /// How long it should be.
        needed_s: f64,
    },
    /// It may be of another surface.
    #[error("the slope was {age_s:.0} s old: no torque lately")]
    TooOld {
        /// Its age, s.
        age_s: f64,
    },
    /// The slope noticed another surface right afterwards.
    #[error("the surface changed about the braking (noticed {after_s:.1} s later)")]
    SurfaceChanged {
        /// From the end of the braking to the notice, s.
        after_s: f64,
    },
}

/// Mean slope of the driven wheels, all of which have to have one. `scale_std` is the relative
/// uncertainty that all slopes of the car share ([`Car::slope_scale_std`]); it is taken out.
pub fn mean_slope(slopes: &[Option<Estimate>; 4], driven: DrivenAxle, scale_std: f64) -> Option<Estimate> {
    let mut count = 0.0;
    let mut mean = Estimate { value: 0.0, std: 0.0, age_s: 0.0 };
    for wheel in Wheel::ALL.into_iter().filter(|&wheel| driven.drives(wheel)) {
        let slope = slopes[wheel as usize]?;
        count += 1.0;
        mean.value += slope.value;
        // Both wheels share the noise of the force: nothing is gained by averaging.
        let shared = scale_std * slope.value;
        mean.std += (slope.std * slope.std - shared * shared).max(0.0).sqrt();
        mean.age_s = mean.age_s.max(slope.age_s);
    }
    (count > 0.0).then(|| Estimate { value: mean.value / count, std: mean.std / count, ..mean })
}

/// Finds ABS brakings in a drive, sample by sample.
#[derive(Clone, Debug)]
pub struct PairFinder {
    car: Car,
    scale_std: f64,
    abs: AbsBraking,
    /// Time into the drive, s: gaps of the recording count as they are.
    now_s: f64,
    /// Where the slope has stayed near, and since when.
    anchor: Option<(f64, f64)>,
    changes: u32,
    changed_s: f64,
    /// The slope when the brakes were last free.
    free: Free,
    lateral: Lateral,
    started: Option<Micros>,
    brakings: Vec<Braking>,
    /// When the braking that is last in the list ended, until it is confirmed.
    unconfirmed_s: Option<f64>,
}

#[derive(Clone, Copy, Debug, Default)]
struct Free {
    slope: Option<Estimate>,
    valid: bool,
    roughness: Option<f64>,
    settled_s: f64,
    changes: u32,
}

/// Mean square of the lateral acceleration.
#[derive(Clone, Copy, Debug, Default)]
struct Lateral {
    square: f64,
    seconds: f64,
}

impl PairFinder {
    /// Lateral acceleration / (μ g) that takes 4 % off the longitudinal friction. Physical: on a circle of friction
    /// √(1 − 0.28²) = 0.96 is left.
    const SIDEWAYS: f64 = 0.28;

    /// For this car and what its bus has.
    pub fn new(vehicle: &Vehicle, sensors: &Sensors) -> Self {
        let car = Car::new(vehicle);
        Self {
            scale_std: car.slope_scale_std(sensors.has(Quantity::DriveTorque)),
            abs: AbsBraking::new(&car),
            car,
            now_s: 0.0,
            anchor: None,
            changes: 0,
            changed_s: f64::NEG_INFINITY,
            free: Free::default(),
            lateral: Lateral::default(),
            started: None,
            brakings: Vec::new(),
            unconfirmed_s: None,
        }
    }

    /// Takes a sample and what the pipeline knew after it.
    pub fn step(&mut self, sample: &Sample, estimates: &Estimates) {
        let now = Kinematics::new(sample, &self.car);
        self.now_s += now.elapsed_s.max(0.0);
        self.watch_surface(estimates);
        self.abs.step(&now);
        if let Some(record) = self.abs.record() {
            let braking = self.judge(record, sample.time);
            self.unconfirmed_s = braking.not_a_pair.is_none().then_some(self.now_s);
            self.brakings.push(braking);
        }
        match now.abs {
            Some(true) => {
                if self.started.is_none() {
                    self.started = Some(sample.time);
                    self.lateral = Lateral::default();
                    // A braking soon after the last one: that one is not confirmed any more.
                    self.unconfirmed_s = None;
                }
                let lateral = now.lateral_acceleration.unwrap_or(0.0);
                self.lateral.square += lateral * lateral * now.elapsed_s;
                self.lateral.seconds += now.elapsed_s;
            }
            _ if now.braking != Some(true) => self.free = self.known(estimates),
            _ => {}
        }
        if self.abs.working_s().is_none() {
            self.started = None;
        }
    }

    /// All brakings of the drive.
    pub fn finish(self) -> Vec<Braking> {
        self.brakings
    }

    fn watch_surface(&mut self, estimates: &Estimates) {
        if estimates.surface_changes != self.changes {
            self.changes = estimates.surface_changes;
            self.changed_s = self.now_s;
            self.anchor = None;
        }
        let slope = mean_slope(&estimates.slope, self.car.driven_axle, self.scale_std);
        match (slope, self.anchor) {
            (Some(slope), Some((value, _))) if (slope.value - value).abs() <= TUNING.steady * value => {}
            (Some(slope), _) => self.anchor = Some((slope.value, self.now_s)),
            (None, _) => self.anchor = None,
        }
        let Some(ended_s) = self.unconfirmed_s else { return };
        let after_s = self.now_s - ended_s;
        let Some(braking) = self.brakings.last_mut() else { return };
        if self.changed_s > ended_s {
            braking.not_a_pair = Some(NotAPair::SurfaceChanged { after_s });
            self.unconfirmed_s = None;
        } else if after_s >= TUNING.confirm_s {
            braking.confirmed = true;
            self.unconfirmed_s = None;
        }
    }

    fn known(&self, estimates: &Estimates) -> Free {
        Free {
            slope: mean_slope(&estimates.slope, self.car.driven_axle, self.scale_std),
            valid: estimates.slope_valid,
            // While braking nobody knows it; just afterwards, that of before counts.
            roughness: estimates.roughness.map(|roughness| roughness.value).or(self.free.roughness),
            settled_s: self.anchor.map_or(0.0, |(_, since)| self.now_s - since.max(self.changed_s)),
            changes: self.changes,
        }
    }

    fn judge(&self, record: AbsRecord, now: Micros) -> Braking {
        let slope = self.free.slope;
        let mu = record.outcome.ok().map(|friction| (friction.mu, friction.std));
        Braking {
            time: self.started.unwrap_or(now),
            duration_s: record.duration_s,
            speed: record.start_speed,
            mu,
            slope,
            roughness: self.free.roughness,
            confirmed: false,
            not_a_pair: self.objection(&record),
        }
    }

    fn objection(&self, record: &AbsRecord) -> Option<NotAPair> {
        let mu = match record.outcome {
            Ok(friction) => friction.mu,
            Err(problem) => return Some(NotAPair::NoFriction(problem)),
        };
        let sideways = (self.lateral.square / self.lateral.seconds.max(1e-3)).sqrt() / (mu * GRAVITY);
        if sideways > Self::SIDEWAYS {
            return Some(NotAPair::Cornering { share: 100.0 * sideways });
        }
        let Some(slope) = self.free.slope else { return Some(NotAPair::NoSlope) };
        if slope.age_s > TUNING.oldest_s {
            return Some(NotAPair::TooOld { age_s: slope.age_s });
        }
        if !self.free.valid {
            return Some(NotAPair::NotConverged { relative: 100.0 * slope.std / slope.value });
        }
        if self.free.settled_s < TUNING.settled_s {
            let settled_s = self.free.settled_s;
            return Some(NotAPair::NotSettled { settled_s, needed_s: TUNING.settled_s });
        }
        (self.changes != self.free.changes).then_some(NotAPair::SurfaceChanged { after_s: 0.0 })
    }
}

#[cfg(test)]
mod tests;
