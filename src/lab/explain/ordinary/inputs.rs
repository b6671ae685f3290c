//! A recording as a free run takes it: speed and steering are inputs, yaw rate and lateral acceleration are compared, and
//! every third block is held out.

use std::ops::Range;

use identify::{friction_in_use, hardly_exceeded};
use physics::model::Vehicle;
use physics::{Quantity, Wheel};

use super::frozen::frozen;
use super::grid::{STEP_S, at, interpolated, mean, resampled, slope};
use super::speed::{COMPARED_MPS, speed};
use super::zero::standing;
use crate::explain::Work;
use crate::explain::{Block, Driven, Recording};

/// The held-out part is every third block of so many seconds. The contract's, and the yardstick's.
const BLOCK_S: f64 = 6.0;

/// Its grid points.
pub const BLOCK_POINTS: usize = (BLOCK_S / STEP_S) as usize;

/// Slip angles of a car that creeps mean nothing, m/s. Numerical.
const SLOWEST_MPS: f64 = 2.0;

/// Accelerations are compared as means over so many grid points: a raw inertial unit shakes with the body and the engine
/// far above what a car in the plane does. The yardstick's.
const MEAN_POINTS: usize = 20;

/// The acceleration is the slope of the speed's mean over so many points. Numerical: 0.1 s.
const SLOPE_POINTS: usize = 11;

/// What is called the most is exceeded in the rest of the time only. Statistical: of a lap a second.
const MOST_QUANTILE: f64 = 0.97;

/// Seconds at the recording's ends that are left out: delays look beyond the ends. The yardstick's.
const MARGIN_S: f64 = 1.0;

/// One recording on a grid.
#[derive(Clone, Debug)]
pub struct FreeDrive {
    /// The recording's name.
    pub name: String,
    /// What is computed with it is counted here.
    pub work: Work,
    /// Time of the first grid point, s from the recording's start.
    pub from_s: f64,
    /// Steering wheel angle as recorded, rad.
    steering: Vec<(f64, f64)>,
    /// Speed by wheels or message on a grid over all of the recording, m/s …
    speed: Vec<f64>,
    /// … and its slope, m/s².
    acceleration: Vec<f64>,
    /// Yaw rate as measured at the grid points, rad/s; not a number in gaps.
    pub yaw_rate: Vec<f64>,
    /// Lateral acceleration there as a mean, m/s²; none where the recording has none.
    pub lateral: Option<Vec<f64>>,
    /// Longitudinal acceleration likewise, m/s².
    pub longitudinal: Option<Vec<f64>>,
    /// Wheel speeds, rad/s, where they are measured.
    pub wheels: [Option<Vec<f64>>; 4],
    /// Yaw rate by the difference of the front and of the rear wheels, (ω_R − ω_L) r/track, rad/s, where both are measured.
    pub axles: [Option<Vec<f64>>; 2],
    /// Is a grid point held out?
    pub held: Vec<bool>,
    /// Is it fast enough to be compared, and steered as is known?
    pub counts: Vec<bool>,
    /// Where the steering angle has stopped, s: nobody knows how it was driven.
    pub frozen: Vec<[f64; 2]>,
    /// What the gyroscope reads while the car stands, rad/s, and by how much its zero may differ from that while it drives;
    /// none where it does not stand.
    pub zero: Option<(f64, f64)>,
}

/// What is held out of a recording.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Held {
    /// Every third block.
    EveryThird,
    /// Nothing: all of it is fitted to.
    Nothing,
    /// All of it is only predicted.
    Everything,
}

/// Why a recording cannot be run freely.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum Unusable {
    /// A required quantity is missing.
    #[error("it has no {0}")]
    Missing(&'static str),
    /// The car hardly drives.
    #[error("the car is hardly faster than 4 m/s in it")]
    Standing,
}

impl FreeDrive {
    /// Of a recording of this vehicle; of a longer one those `most_s` seconds in which it turns most.
    ///
    /// # Errors
    /// If yaw rate, steering or speed is missing, or the car hardly moves.
    pub fn new(recording: &Recording, vehicle: &Vehicle, held: Held, most_s: f64) -> Result<Self, Unusable> {
        let track = |quantity: Quantity| -> Result<&[(f64, f64)], Unusable> {
            let track = &recording.tracks[quantity as usize];
            if recording.has(quantity) { Ok(track) } else { Err(Unusable::Missing(quantity.name())) }
        };
        let (yaw, steering) = (track(Quantity::YawRate)?, track(Quantity::SteeringWheelAngle)?);
        let all = (recording.seconds() / STEP_S) as usize + 1;
        let speed =
            speed(recording, vehicle, all).ok_or(Unusable::Missing("wheel speed or vehicle_speed"))?;
        let frozen = frozen(steering, &resampled(yaw, 0.0, all), &speed);
        let acceleration = slope(&mean(&mean(&speed, 5), SLOPE_POINTS));
        let (first, last) = (yaw[0].0 + MARGIN_S, yaw[yaw.len() - 1].0 - MARGIN_S);
        let count = ((last - first) / STEP_S).max(0.0) as usize;
        let moving = |i: &usize| at(&speed, first + *i as f64 * STEP_S) > COMPARED_MPS;
        let begin = (0..count).find(moving).ok_or(Unusable::Standing)?;
        let end = (0..count).rev().find(moving).ok_or(Unusable::Standing)?;
        if end - begin < (2.0 * BLOCK_S / STEP_S) as usize {
            return Err(Unusable::Standing);
        }
        let turning = resampled(yaw, first + begin as f64 * STEP_S, end - begin);
        let (from, points) = liveliest_of(&turning, (most_s / STEP_S) as usize);
        let from_s = first + (begin + from) as f64 * STEP_S;
        let time = |i: usize| from_s + i as f64 * STEP_S;
        let Compared { yaw_rate, lateral, longitudinal, wheels, axles } =
            Compared::of(recording, vehicle, from_s, points);
        Ok(Self {
            name: recording.name.clone(),
            work: recording.work.clone(),
            from_s,
            steering: steering.to_vec(),
            yaw_rate,
            lateral,
            longitudinal,
            wheels,
            axles,
            held: (0..points)
                .map(|i| match held {
                    Held::EveryThird => (i / BLOCK_POINTS) % 3 == 2,
                    Held::Nothing => false,
                    Held::Everything => true,
                })
                .collect(),
            counts: (0..points)
                .map(|i| at(&speed, time(i)) > COMPARED_MPS && !is_within(&frozen, time(i)))
                .collect(),
            frozen,
            zero: standing(yaw, &speed),
            speed,
            acceleration,
        })
    }

    /// Those `most_s` seconds of it in which it turns most.
    pub fn liveliest(&self, most_s: f64) -> Self {
        let (from, points) = liveliest_of(&self.yaw_rate, (most_s / STEP_S) as usize);
        let cut = |values: &Vec<f64>| values[from..from + points].to_vec();
        Self {
            name: self.name.clone(),
            work: self.work.clone(),
            from_s: self.time(from),
            steering: self.steering.clone(),
            frozen: self.frozen.clone(),
            zero: self.zero,
            speed: self.speed.clone(),
            acceleration: self.acceleration.clone(),
            yaw_rate: cut(&self.yaw_rate),
            lateral: self.lateral.as_ref().map(cut),
            longitudinal: self.longitudinal.as_ref().map(cut),
            wheels: self.wheels.each_ref().map(|wheel| wheel.as_ref().map(cut)),
            axles: self.axles.each_ref().map(|axle| axle.as_ref().map(cut)),
            held: self.held[from..from + points].to_vec(),
            counts: self.counts[from..from + points].to_vec(),
        }
    }

    /// Its grid points.
    pub fn points(&self) -> usize {
        self.yaw_rate.len()
    }

    /// Time of a grid point, s from the recording's start.
    pub fn time(&self, i: usize) -> f64 {
        self.from_s + i as f64 * STEP_S
    }

    /// Every so manyth grid point of how it was driven.
    pub fn driven_every(&self, points: usize) -> Driven {
        let steering = self.steered(0.0, 0..self.points());
        let row = |i: usize| [self.time(i), at(&self.speed, self.time(i)), steering[2 * i]];
        let rows = (0..self.points()).step_by(points).map(row).collect();
        Driven { recording: self.name.clone(), rows }
    }

    /// Stretches that are held out or not.
    pub fn blocks(&self) -> Vec<Block> {
        let end = |i: usize| self.time(i + 1);
        let mut blocks: Vec<Block> = Vec::new();
        for (i, held) in self.held.iter().enumerate() {
            match blocks.last_mut().filter(|last| last.is_holdout == *held) {
                Some(last) => last.t[1] = end(i),
                None => blocks.push(Block {
                    recording: self.name.clone(),
                    t: [self.time(i), end(i)],
                    t_utc: None,
                    is_holdout: *held,
                }),
            }
        }
        blocks
    }

    /// The friction that was used in what is fitted to, but for the few hardest moments.
    pub fn used_friction(&self) -> Option<f64> {
        let yaw_rate = mean(&self.yaw_rate, MEAN_POINTS);
        let used = |i: usize| {
            let turning = at(&self.speed, self.time(i)) * yaw_rate[i];
            let felt = self.lateral.as_ref().map_or(f64::NAN, |lateral| lateral[i]);
            friction_in_use(turning, felt, at(&self.acceleration, self.time(i)))
        };
        self.most(used)
    }

    /// The speed that is hardly exceeded in what is fitted to, m/s.
    pub fn fastest(&self) -> Option<f64> {
        self.most(|i| at(&self.speed, self.time(i)))
    }

    /// What is exceeded in a small share of the time only, of what is fitted to.
    fn most(&self, of: impl Fn(usize) -> f64) -> Option<f64> {
        let counts = |i: &usize| self.counts[*i] && !self.held[*i];
        hardly_exceeded((0..self.points()).filter(counts).map(of), MOST_QUANTILE)
    }

    /// Speed, m/s, and acceleration, m/s², at a time, from a record that is so late and so much too small.
    pub fn driven(&self, t: f64, delay: f64, scale: f64) -> (f64, f64) {
        let t = t + delay;
        ((scale * at(&self.speed, t)).max(SLOWEST_MPS), scale * at(&self.acceleration, t))
    }

    /// Steering wheel angle at some grid points and in the middle between them, rad, from a record that is so late.
    pub fn steered(&self, delay: f64, points: Range<usize>) -> Vec<f64> {
        let half = 0.5 * STEP_S;
        let time = |i: usize| self.from_s + delay + i as f64 * half;
        let after = self.steering.partition_point(|(t, _)| *t < time(2 * points.start));
        let mut cursor = after.min(self.steering.len().saturating_sub(1)).max(1);
        (2 * points.start..2 * points.end + 2)
            .map(|i| interpolated(&self.steering, &mut cursor, time(i)).0)
            .collect()
    }
}

/// What is compared of a record at grid points.
pub struct Compared {
    /// See [`FreeDrive::yaw_rate`].
    pub yaw_rate: Vec<f64>,
    /// See [`FreeDrive::lateral`].
    pub lateral: Option<Vec<f64>>,
    /// See [`FreeDrive::longitudinal`].
    pub longitudinal: Option<Vec<f64>>,
    /// See [`FreeDrive::wheels`].
    pub wheels: [Option<Vec<f64>>; 4],
    /// See [`FreeDrive::axles`].
    pub axles: [Option<Vec<f64>>; 2],
}

impl Compared {
    /// Of a record, at so many points from a time on.
    pub fn of(recording: &Recording, vehicle: &Vehicle, from_s: f64, points: usize) -> Self {
        let track = |quantity: Quantity| {
            recording.has(quantity).then(|| recording.tracks[quantity as usize].as_slice())
        };
        let acceleration = |quantity: Quantity| {
            let margin = MEAN_POINTS;
            let raw = resampled(track(quantity)?, from_s - margin as f64 * STEP_S, points + 2 * margin);
            Some(mean(&raw, MEAN_POINTS)[margin..margin + points].to_vec())
        };
        let wheels =
            Wheel::ALL.map(|wheel| Some(resampled(track(Quantity::wheel_speed(wheel))?, from_s, points)));
        let axles = std::array::from_fn(|axle| {
            let [left, right] = [&wheels[2 * axle], &wheels[2 * axle + 1]].map(Option::as_ref);
            Some(turning(vehicle, axle, left?, right?))
        });
        Self {
            yaw_rate: resampled(&recording.tracks[Quantity::YawRate as usize], from_s, points),
            lateral: acceleration(Quantity::LateralAcceleration),
            longitudinal: acceleration(Quantity::LongitudinalAcceleration),
            wheels,
            axles,
        }
    }
}

/// The stretch of at most so many points in which a car turns most: its first point and its length.
fn liveliest_of(turning: &[f64], most: usize) -> (usize, usize) {
    if turning.len() <= most {
        return (0, turning.len());
    }
    let square = |i: usize| if turning[i].is_finite() { turning[i] * turning[i] } else { 0.0 };
    let mut sum: f64 = (0..most).map(square).sum();
    let mut best = (sum, 0);
    for from in 1..=turning.len() - most {
        sum += square(from + most - 1) - square(from - 1);
        if sum > best.0 {
            best = (sum, from);
        }
    }
    (best.1, most)
}

/// Yaw rate by the speeds of an axle's wheels, rad/s.
pub fn turning(vehicle: &Vehicle, axle: usize, left: &[f64], right: &[f64]) -> Vec<f64> {
    let track = [vehicle.track_front_m, vehicle.track_rear_m][axle].value;
    let per_speed = vehicle.wheel_radius_m.value / track;
    left.iter().zip(right).map(|(left, right)| (right - left) * per_speed).collect()
}

/// Means as the accelerations are compared.
pub fn compared_mean(values: &[f64]) -> Vec<f64> {
    mean(values, MEAN_POINTS)
}

/// Is a time in one of these stretches, or shortly after it, when the run still goes where that has led it?
fn is_within(stretches: &[[f64; 2]], t: f64) -> bool {
    stretches.iter().any(|[from, to]| (*from..to + MARGIN_S).contains(&t))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_held_out_does_not_say_what_was_used() {
        let (vehicle, recording) = crate::explain::bench::recorded("");
        let used = |held| FreeDrive::new(&recording, &vehicle, held, 600.0).unwrap().used_friction();
        let all = used(Held::Nothing).unwrap();
        assert!(0.2 < all && all < vehicle.friction.value, "{all}");
        assert_eq!(used(Held::Everything), None);
    }
}
