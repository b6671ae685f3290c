//! One integration step.

use super::{BODY_STATES, Compute, EFFECT_STATES, ExtendedCar, Instant, MOST_LIVE};
use physics::model::effect::Recorded;

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

impl ExtendedCar {
    /// One step of `h` seconds by the midpoint rule, from an instant already known. Driving is smooth on
    /// this scale, and what settles faster than a step still ends where it should: of second order is enough.
    pub fn step(&self, from: &State, first: &Instant, t: f64, h: f64, inputs: &Inputs) -> State {
        let middle = from.advanced(&first.rate, 0.5 * h);
        let (input, before) = (&inputs.at[1], first.before());
        let there = self.instant(t + 0.5 * h, &middle, input, inputs.steering_rate, &before, Compute::Rates);
        from.advanced(&there.rate, h)
    }
}

/// One step of `h` seconds by Adams' and Bashforth's rule of second order, from the rates now and a step before: half the
/// computing of the midpoint rule, where nothing is fast.
pub fn step_by_rates(from: &State, now: &State, before: &State, h: f64) -> State {
    let mut rate = *now;
    let all = rate.body.iter_mut().zip(&before.body).chain(rate.own.iter_mut().zip(&before.own));
    all.for_each(|(rate, before)| *rate += 0.5 * (*rate - before));
    from.advanced(&rate, h)
}

/// The inputs over a step.
#[derive(Clone, Copy, Debug)]
pub struct Inputs {
    /// At its beginning, in its middle, and at its end.
    pub at: [Recorded; 3],
    /// How fast the steering wheel turns over the step, rad/s.
    pub steering_rate: f64,
}

impl Inputs {
    /// Of a step of `h` seconds.
    pub fn new(at: [Recorded; 3], h: f64) -> Self {
        let [from, _, to] = &at;
        let steering_rate = (to.steering_wheel - from.steering_wheel) / h;
        Self { at, steering_rate }
    }

    /// Over a part of the step, between two shares of it.
    pub fn part(&self, from: f64, to: f64) -> Self {
        Self { at: [from, 0.5 * (from + to), to].map(|share| self.between(share)), ..*self }
    }

    fn between(&self, share: f64) -> Recorded {
        let half = if share < 0.5 { 0 } else { 1 };
        let (from, to) = (&self.at[half], &self.at[half + 1]);
        let mix = |a: f64, b: f64| a + (2.0 * share - half as f64) * (b - a);
        Recorded {
            steering_wheel: mix(from.steering_wheel, to.steering_wheel),
            drive_torque: mix(from.drive_torque, to.drive_torque),
            brake_pressure: mix(from.brake_pressure, to.brake_pressure),
        }
    }
}

/// States that differ by less are the same, in their units. Numerical: a million times less than a sensor tells.
const NEAR: f64 = 1e-9;

impl State {
    /// Is it where another one is?
    pub fn is_near(&self, other: &Self) -> bool {
        let is_near = |(a, b): (&f64, &f64)| (a - b).abs() < NEAR;
        self.body.iter().zip(&other.body).all(is_near) && self.own.iter().zip(&other.own).all(is_near)
    }

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

#[cfg(test)]
mod tests {
    use super::*;

    /// GIVEN what dies out in 50 ms WHEN it is stepped by 10 ms THEN it is where it should be to a per cent of its beginning.
    #[test]
    fn two_rates_are_of_second_order() {
        let of = |value: f64| State { body: [1.0, value, 0.0], ..State::default() };
        let rate = |state: &State| State { body: [0.0, -20.0 * state.body[1], 0.0], ..State::default() };
        let exact = |step: i32| (-0.2 * f64::from(step)).exp();
        let (mut state, mut before) = (of(exact(0)), rate(&of(exact(-1))));
        for step in 1..20 {
            let now = rate(&state);
            state = step_by_rates(&state, &now, &before, 0.01);
            before = now;
            assert!((state.body[1] - exact(step)).abs() < 0.01, "{step}: {}", state.body[1]);
        }
        assert_eq!(state.body[0], 1.0);
    }
}
