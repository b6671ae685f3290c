//! Friction from the deceleration during an ABS braking (thesis 6.1, eq. 6.2).
//!
//! While the ABS holds the wheels near their peak, the whole car decelerates with what the road gives:
//! μ = Δv/(g Δt). The speed during the braking is the accelerometer's integral where there is one
//! (the wheels slip), else the difference of the wheel speeds before and after.

use thiserror::Error;

use super::kinematics::{Car, Kinematics};
use crate::model::GRAVITY;

/// Tuned: the deviations and the pause with the test `calibrate`, the rest with no test on record.
struct Tuning {
    /// Shorter interventions say too little, s.
    shortest_s: f64,
    /// With the pedal still pressed, shorter pauses belong to the braking, s.
    longest_pause_s: f64,
    /// Slower ones are over before the pressure has built up, m/s.
    slowest: f64,
    /// Of the speed lost by the wheels, which slip at both ends, m/s.
    speed_std: f64,
    /// Of the accelerometer's mean: offset, and gravity while the car dives, m/s².
    acceleration_std: f64,
    /// How much the share of the peak that the ABS uses differs from braking to braking.
    efficiency_std: f64,
}

const TUNING: Tuning = Tuning {
    shortest_s: 0.3,
    longest_pause_s: 0.5,
    slowest: 5.0,
    speed_std: 0.5,
    acceleration_std: 0.1,
    efficiency_std: 0.02,
};

/// A finished (or long enough) ABS braking.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AbsFriction {
    /// Mean friction used.
    pub mu: f64,
    /// Its standard deviation.
    pub std: f64,
    /// Seconds since it was measured.
    pub age_s: f64,
}

/// Friction by (6.2) with what is not known of it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AbsMeasurement {
    /// Mean friction used.
    pub mu: f64,
    /// Standard deviation: of what measured the deceleration, and of how near the ABS stays to the
    /// tires' peak.
    pub std: f64,
}

/// Why an ABS braking gave no friction.
#[derive(Clone, Copy, Debug, PartialEq, Error)]
pub enum AbsProblem {
    /// Too short to say anything.
    #[error("the ABS worked for {duration_s:.2} s only")]
    TooShort {
        /// How long, s.
        duration_s: f64,
    },
    /// Neither acceleration nor wheel speeds all the time.
    #[error("acceleration or wheel speeds were missing")]
    NoDeceleration,
    /// What no road gives.
    #[error("the deceleration ({mu:.2} g) is not that of a braking")]
    Implausible {
        /// It, in g.
        mu: f64,
    },
}

/// An ABS braking that has just ended, whether or not it gave a friction.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AbsRecord {
    /// How long the ABS worked, s.
    pub duration_s: f64,
    /// Speed before it, m/s.
    pub start_speed: f64,
    /// Friction, or why there is none.
    pub outcome: Result<AbsMeasurement, AbsProblem>,
}

/// Watches for ABS interventions.
#[derive(Clone, Debug)]
pub struct AbsBraking {
    car: Car,
    braking: Option<Braking>,
    /// The braking and the wheels' speed when the ABS last stopped intervening, and for how long, s:
    /// the end, or a pause.
    paused: Option<(Braking, Option<f64>, f64)>,
    /// Speed while nothing intervenes: the start of the next braking.
    free_speed: Option<f64>,
    last: Option<AbsFriction>,
    record: Option<AbsRecord>,
}

#[derive(Clone, Copy, Debug)]
struct Braking {
    start_speed: f64,
    duration_s: f64,
    /// Integral of the measured deceleration, m/s; `None` once a sample lacked it.
    speed_lost: Option<f64>,
    /// Mean squared speed for the drag.
    speed_square: f64,
}

impl Braking {
    fn starting(start_speed: f64) -> Self {
        Self { start_speed, duration_s: 0.0, speed_lost: Some(0.0), speed_square: 0.0 }
    }

    fn take(&mut self, now: &Kinematics) {
        self.duration_s += now.elapsed_s;
        let v = self.start_speed - self.speed_lost.unwrap_or(0.0);
        self.speed_square += v * v * now.elapsed_s;
        self.speed_lost = match (self.speed_lost, now.longitudinal_acceleration) {
            (Some(lost), Some(ax)) => Some(lost - ax * now.elapsed_s),
            _ => None,
        };
    }
}

impl AbsBraking {
    /// What no road gives. Physical: wet ice gives some 0.05, a racing tire on dry asphalt hardly more than 1.5.
    const LIMITS: (f64, f64) = (0.03, 1.5);

    /// For this car.
    pub fn new(car: &Car) -> Self {
        Self { car: car.clone(), braking: None, paused: None, free_speed: None, last: None, record: None }
    }

    /// Takes a sample.
    pub fn step(&mut self, now: &Kinematics) {
        self.record = None;
        if let Some(last) = &mut self.last {
            last.age_s += now.elapsed_s;
        }
        // The wheels of the faster axle are nearest to the car's speed while braking.
        let speed = now.wheels.map(|w| w.into_iter().fold(f64::MIN, f64::max));
        let active = now.abs == Some(true);
        let Some(braking) = &mut self.braking else {
            if active {
                self.braking = self.free_speed.filter(|v| *v > TUNING.slowest).map(Braking::starting);
            } else {
                self.free_speed = speed;
            }
            return;
        };
        if active {
            // After a pause: it belongs to the braking.
            self.paused = None;
        } else {
            let paused = self.paused.get_or_insert((*braking, speed, 0.0));
            paused.2 += now.elapsed_s;
            if now.braking != Some(true) || paused.2 > TUNING.longest_pause_s {
                self.finish();
                return;
            }
        }
        braking.take(now);
    }

    /// The last one, if any.
    pub fn last(&self) -> Option<AbsFriction> {
        self.last
    }

    /// For how long the one at the moment lasts, its pauses included, s.
    pub fn working_s(&self) -> Option<f64> {
        self.braking.map(|braking| braking.duration_s)
    }

    /// One was finished with this sample.
    pub fn finished(&self) -> Option<AbsMeasurement> {
        self.record.and_then(|record| record.outcome.ok())
    }

    /// The braking that ended with this sample, whatever came of it.
    pub fn record(&self) -> Option<AbsRecord> {
        self.record
    }

    fn finish(&mut self) {
        self.braking = None;
        let Some((braking, speed, ago_s)) = self.paused.take() else { return };
        self.free_speed = speed;
        let outcome = self.measure(&braking, speed);
        if let Ok(friction) = outcome {
            self.last = Some(AbsFriction { mu: friction.mu, std: friction.std, age_s: ago_s });
        }
        let Braking { duration_s, start_speed, .. } = braking;
        self.record = Some(AbsRecord { duration_s, start_speed, outcome });
    }

    fn measure(&self, braking: &Braking, speed: Option<f64>) -> Result<AbsMeasurement, AbsProblem> {
        let duration_s = braking.duration_s;
        if duration_s < TUNING.shortest_s {
            return Err(AbsProblem::TooShort { duration_s });
        }
        let by_wheels = speed.map(|end| (braking.start_speed - end, TUNING.speed_std));
        let by_accelerometer = braking.speed_lost.map(|lost| (lost, TUNING.acceleration_std * duration_s));
        let (lost, lost_std) = by_accelerometer.or(by_wheels).ok_or(AbsProblem::NoDeceleration)?;
        // The tires gave all of it but the drag and the rolling resistance.
        let drag = self.car.drag * braking.speed_square / duration_s / self.car.mass;
        let mu = (lost / duration_s - drag) / GRAVITY - self.car.rolling_resistance;
        if !(Self::LIMITS.0..=Self::LIMITS.1).contains(&mu) {
            return Err(AbsProblem::Implausible { mu: lost / duration_s / GRAVITY });
        }
        let std = (lost_std / duration_s / GRAVITY).hypot(TUNING.efficiency_std * mu);
        Ok(AbsMeasurement { mu, std })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::Vehicle;

    fn brake(with_accelerometer: bool) -> Option<AbsFriction> {
        let mut car = Car::new(&Vehicle::thesis());
        car.drag = 0.0;
        let mut abs = AbsBraking::new(&car);
        let mu = 0.42;
        for i in 0..400 {
            let t = f64::from(i) * 0.01;
            let active = (1.0..3.0).contains(&t);
            let speed = 25.0 - mu * GRAVITY * (t - 1.0).clamp(0.0, 2.0);
            let now = Kinematics {
                elapsed_s: 0.01,
                speed: Some(speed),
                wheels: Some([if active { 0.9 } else { 1.0 } * speed; 4]),
                yaw_rate: Some(0.0),
                lateral_acceleration: Some(0.0),
                longitudinal_acceleration: with_accelerometer.then_some(if active {
                    -mu * GRAVITY
                } else {
                    0.0
                }),
                road_angle: Some(0.0),
                rear_angle: 0.0,
                axle_torque: None,
                braking: Some(active),
                abs: Some(active),
            };
            abs.step(&now);
        }
        abs.last()
    }

    /// ABS and pedal as given for each sample, at 0.5 g while the ABS works and 0.4 g in pauses.
    fn intervene(samples: impl Iterator<Item = (bool, bool)>) -> Vec<AbsRecord> {
        let mut car = Car::new(&Vehicle::thesis());
        car.drag = 0.0;
        let mut abs = AbsBraking::new(&car);
        let mut speed = 25.0;
        let mut records = Vec::new();
        for (active, pedal) in samples {
            let deceleration = if active { 0.5 } else { 0.4 * f64::from(u8::from(pedal)) } * GRAVITY;
            speed -= 0.01 * deceleration;
            abs.step(&Kinematics {
                elapsed_s: 0.01,
                speed: Some(speed),
                wheels: Some([speed; 4]),
                yaw_rate: Some(0.0),
                lateral_acceleration: Some(0.0),
                longitudinal_acceleration: Some(-deceleration),
                road_angle: Some(0.0),
                rear_angle: 0.0,
                axle_torque: None,
                braking: Some(pedal),
                abs: Some(active),
            });
            records.extend(abs.record());
        }
        records
    }

    #[test]
    fn a_pause_with_the_pedal_pressed_belongs_to_the_braking_and_a_long_one_ends_it() {
        let pause = |length: usize| {
            let off = |n: usize, pedal: bool| std::iter::repeat_n((false, pedal), n);
            let on = std::iter::repeat_n((true, true), 100);
            intervene(
                off(50, false).chain(on.clone()).chain(off(length, true)).chain(on).chain(off(50, false)),
            )
        };
        let short = pause(20);
        assert_eq!(short.len(), 1);
        let mu = short[0].outcome.unwrap().mu;
        assert!((mu - (200.0 * 0.5 + 20.0 * 0.4) / 220.0).abs() < 0.005, "{mu}");
        let long = pause(80);
        assert_eq!(long.len(), 2);
        assert!(long.iter().all(|record| (record.outcome.unwrap().mu - 0.5).abs() < 0.005), "{long:?}");
    }

    #[test]
    fn a_braking_that_gives_no_friction_says_why() {
        let off = std::iter::repeat_n((false, false), 50);
        let on = |n: usize| std::iter::repeat_n((true, true), n);
        let records = intervene(off.clone().chain(on(20)).chain(off));
        let [AbsRecord { outcome: Err(AbsProblem::TooShort { .. }), .. }] = records[..] else {
            panic!("{records:?}")
        };
    }

    #[test]
    fn two_seconds_of_abs_give_the_friction_either_way() {
        for with_accelerometer in [true, false] {
            let friction = brake(with_accelerometer).unwrap();
            assert!((friction.mu - 0.42).abs() < 0.01, "{friction:?}");
            assert!((friction.age_s - 1.0).abs() < 0.05);
        }
    }
}
