//! From one instant to the next.

use super::{Ask, BODY_STATES, Car, EFFECT_STATES, Instant, MOST_LIVE};
use crate::model::effect::Recorded;

/// Where the car is.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct State {
    /// vx, vy, yaw rate.
    pub body: [f64; BODY_STATES],
    /// The effects' own.
    pub own: [f64; EFFECT_STATES],
    /// Courses that are estimated.
    pub live: [f64; MOST_LIVE],
}

impl Car {
    /// One step of `h` seconds by the midpoint rule, from an instant already known. Driving is smooth on
    /// this scale, and what settles faster than a step still ends where it should: of second order is enough.
    pub fn step(&self, from: &State, first: &Instant, t: f64, h: f64, ends: &Ends) -> State {
        let middle = from.advanced(&first.rate, 0.5 * h);
        let (input, before) = (ends.at(0.5), first.before());
        let there = self.instant(t + 0.5 * h, &middle, &input, &ends.rates, &before, Ask::Rates);
        from.advanced(&there.rate, h)
    }
}

/// The inputs at both ends of a step.
#[derive(Clone, Copy, Debug)]
pub struct Ends {
    /// At its beginning and its end.
    pub input: [Recorded; 2],
    /// Their rates, per second.
    pub rates: Recorded,
}

impl Ends {
    /// Inputs that go evenly from one to the other in `h` seconds.
    pub fn new(input: [Recorded; 2], h: f64) -> Self {
        let [from, to] = &input;
        let rates = Recorded {
            steering_wheel: (to.steering_wheel - from.steering_wheel) / h,
            drive_torque: (to.drive_torque - from.drive_torque) / h,
            brake_pressure: (to.brake_pressure - from.brake_pressure) / h,
        };
        Self { input, rates }
    }

    /// At a share of the way.
    pub fn at(&self, share: f64) -> Recorded {
        let [from, to] = &self.input;
        let mix = |a: f64, b: f64| a + share * (b - a);
        Recorded {
            steering_wheel: mix(from.steering_wheel, to.steering_wheel),
            drive_torque: mix(from.drive_torque, to.drive_torque),
            brake_pressure: mix(from.brake_pressure, to.brake_pressure),
        }
    }
}

impl State {
    fn advanced(&self, rate: &State, h: f64) -> Self {
        let mut next = *self;
        for (value, rate) in next.body.iter_mut().zip(rate.body) {
            *value += h * rate;
        }
        for (value, rate) in next.own.iter_mut().zip(rate.own) {
            *value += h * rate;
        }
        // The equations guard against standing still, not against going through it.
        next.body[0] = next.body[0].max(0.1);
        next
    }
}
