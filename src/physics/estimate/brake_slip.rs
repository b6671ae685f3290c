//! How far the wheels slip while braking.
//!
//! No wheel rolls freely then. The accelerometer carries the speed from before the braking on; its offset and the
//! grade were learned while the wheels still rolled, and no axle is faster than the car. This holds for some seconds.
//! It tells a wheel near its limit, which slips much further than its stiffness predicts, from one that brakes less.
//! When the ABS works one wheel is at its limit; this estimator tells whether the others are.

use super::kinematics::{Car, Kinematics};
use crate::Wheel;
use crate::estimates::Estimate;
use crate::model::GRAVITY;

/// Tuned with the test `campaign`, by ABS brakings on all surfaces.
struct Tuning {
    /// Deceleration taken for braking where the bus does not tell, m/s².
    braking: f64,
    /// How fast speed and what the accelerometer does not feel follow rolling wheels, s.
    follows_s: (f64, f64),
    /// The speed carried on is known to this, m/s, and gets worse by that, m/s².
    speed_std: (f64, f64),
    /// After a gap this long nobody knows the speed, s.
    gap_s: f64,
    /// Carried on for so long, the speed is not known any more, s.
    longest_s: f64,
    /// At its limit a wheel slips at least so many times as far as its stiffness has it.
    bent: f64,
    /// A wheel so much faster than the car is driven, brakes or not.
    spinning: f64,
    /// Slower than this, nothing is told, m/s.
    slowest: f64,
}

const TUNING: Tuning = Tuning {
    braking: 1.5,
    follows_s: (0.2, 3.0),
    speed_std: (0.03, 0.03),
    gap_s: 0.25,
    longest_s: 5.0,
    bent: 1.3,
    spinning: 1.1,
    slowest: 3.0,
};

/// The car's speed while its wheels slip, and their slips.
#[derive(Clone, Debug)]
pub struct BrakeSlip {
    car: Car,
    rolling: Option<Rolling>,
    braking_s: f64,
    slips: Option<[f64; 4]>,
    /// Friction in use at the sample.
    used: f64,
    /// For how long the ABS has worked in this braking, and for how long of it the front wheels were at their limit, s.
    abs_s: f64,
    limit_s: f64,
}

/// What is known from wheels that roll.
#[derive(Clone, Copy, Debug)]
struct Rolling {
    speed: f64,
    /// By how much the speed changes faster than the accelerometer has it, m/s².
    unfelt: f64,
}

impl BrakeSlip {
    /// For this car.
    pub fn new(car: &Car) -> Self {
        Self {
            car: car.clone(),
            rolling: None,
            braking_s: 0.0,
            slips: None,
            used: 0.0,
            abs_s: 0.0,
            limit_s: 0.0,
        }
    }

    /// Takes a sample, and the slip slopes as far as they are known.
    pub fn step(&mut self, now: &Kinematics, slopes: &[Option<Estimate>; 4]) {
        self.slips = None;
        let Some(felt) = now.longitudinal_acceleration else {
            self.rolling = None;
            return;
        };
        let (Some(speed), Some(wheels), Some(yaw_rate)) = (now.speed, now.wheels, now.yaw_rate) else {
            self.rolling = None;
            self.abs_s += if now.abs == Some(true) { now.elapsed_s } else { 0.0 };
            return;
        };
        if now.elapsed_s > TUNING.gap_s {
            self.rolling = None;
        }
        let braking = now.abs == Some(true) || now.braking.unwrap_or(felt < -TUNING.braking);
        let Some(rolling) = &mut self.rolling else {
            self.rolling = (!braking).then_some(Rolling { speed, unfelt: 0.0 });
            return;
        };
        rolling.speed += (felt + rolling.unfelt) * now.elapsed_s;
        if !braking {
            let off = speed - rolling.speed;
            let (fast_s, slow_s) = TUNING.follows_s;
            rolling.speed += off * (now.elapsed_s / fast_s).min(1.0);
            rolling.unfelt += off / fast_s * (now.elapsed_s / slow_s).min(1.0);
            (self.braking_s, self.abs_s, self.limit_s) = (0.0, 0.0, 0.0);
            return;
        }
        self.braking_s += now.elapsed_s;
        if self.braking_s > TUNING.longest_s {
            return;
        }
        // What the yaw rate adds on one side it takes on the other.
        let at_middle =
            Wheel::ALL.map(|wheel| wheels[wheel as usize] + yaw_rate * self.car.lateral_position(wheel));
        let axles = [(at_middle[0] + at_middle[1]) / 2.0, (at_middle[2] + at_middle[3]) / 2.0];
        for axle in axles {
            if axle < TUNING.spinning * rolling.speed {
                rolling.speed = rolling.speed.max(axle);
            }
        }
        if rolling.speed < TUNING.slowest {
            return;
        }
        self.slips = Some(at_middle.map(|wheel| 1.0 - wheel / rolling.speed));
        let across = now.lateral_acceleration.unwrap_or(0.0) / GRAVITY;
        self.used = self.car.longitudinal_force(felt, speed).hypot(across);
        if now.abs == Some(true) {
            self.abs_s += now.elapsed_s;
            if self.is_at_limit(slopes) == Some(true) {
                self.limit_s += now.elapsed_s;
            }
        }
    }

    /// Are both front wheels, which carry most, at their limit? `None` if nobody knows.
    pub fn is_at_limit(&self, slopes: &[Option<Estimate>; 4]) -> Option<bool> {
        let (Some(slips), Some(rolling)) = (self.slips, self.rolling) else {
            return (self.abs_s > 0.0).then(|| self.was_at_limit());
        };
        // What its engine still drives is not decelerated by friction alone.
        if slips.iter().any(|slip| *slip < 1.0 - TUNING.spinning) {
            return Some(false);
        }
        let (at_first, rate) = TUNING.speed_std;
        let std = (at_first + rate * self.braking_s) / rolling.speed;
        let straight = self.used / self.front_slope(slopes);
        let least = slips[0].min(slips[1]);
        if least - std > TUNING.bent * straight {
            return Some(true);
        }
        (least + std < TUNING.bent * straight).then_some(false)
    }

    /// Was it the limit for most of the time that the ABS worked in the braking that is going on or was the last?
    pub fn was_at_limit(&self) -> bool {
        self.limit_s > 0.5 * self.abs_s
    }

    /// The front wheels' slip slope, by that of the driven ones.
    fn front_slope(&self, slopes: &[Option<Estimate>; 4]) -> f64 {
        let [front, rear] = self.car.slope_prior.map(|(value, _)| value);
        let known = Wheel::ALL.into_iter().zip(slopes).filter_map(|(wheel, slope)| {
            slope.map(|slope| slope.value / if wheel.is_front() { front } else { rear })
        });
        let (sum, count) = known.fold((0.0, 0.0), |(sum, count), share| (sum + share, count + 1.0));
        if count > 0.0 { front * sum / count } else { front }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::Vehicle;

    /// Rolls uphill, then brakes with 0.5 g, the front wheels slipping by as much; what is said at the end.
    fn brake(slips: [f64; 2], with_accelerometer: bool) -> (Option<bool>, bool) {
        let car = Car::new(&Vehicle::thesis());
        let mut brake_slip = BrakeSlip::new(&car);
        let slopes = [Some(Estimate { value: 50.0, std: 1.0, age_s: 0.0 }), None, None, None];
        // The road rises, and the accelerometer feels it.
        let (uphill, yaw_rate) = (0.4, 0.1);
        let mut speed = 25.0;
        for i in 0..2100 {
            let is_braking = i >= 2000;
            let acceleration = if is_braking { -0.5 * GRAVITY } else { 0.0 };
            speed += 0.01 * acceleration;
            let slip = |wheel: Wheel| match wheel {
                Wheel::Fl => slips[0],
                Wheel::Fr => slips[1],
                _ => 0.005,
            };
            let wheels = Wheel::ALL.map(|wheel| {
                let rolling = speed - yaw_rate * car.lateral_position(wheel);
                rolling * if is_braking { 1.0 - slip(wheel) } else { 1.0 }
            });
            let now = Kinematics {
                elapsed_s: 0.01,
                speed: Some(0.5 * (wheels[2] + wheels[3])),
                wheels: Some(wheels),
                yaw_rate: Some(yaw_rate),
                lateral_acceleration: Some(0.0),
                longitudinal_acceleration: with_accelerometer.then_some(acceleration + uphill),
                road_angle: Some(0.0),
                rear_angle: 0.0,
                axle_torque: None,
                braking: Some(is_braking),
                abs: Some(is_braking),
            };
            brake_slip.step(&now, &slopes);
        }
        (brake_slip.is_at_limit(&slopes), brake_slip.was_at_limit())
    }

    #[test]
    fn wheels_at_their_limit_slip_further_than_stiffness_has_it_and_one_alone_does_not_count() {
        // Half a g at a slope of 50 is a slip of 1 %.
        assert_eq!(brake([0.03, 0.035], true), (Some(true), true));
        assert_eq!(brake([0.03, 0.007], true), (Some(false), false));
        assert_eq!(brake([-20.0, -20.0], true), (Some(false), false));
        assert_eq!(brake([0.03, 0.035], false).0, None);
    }
}
