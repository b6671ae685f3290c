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

    /// The same in parts where something is fast.
    pub fn step_in_parts(&self, from: &State, first: &Instant, t: f64, h: f64, inputs: &Inputs) -> State {
        let parts = (self.fastest_rate(from.body[0]) * h / LARGEST_STEP).ceil();
        let parts = parts.clamp(1.0, (h / SHORTEST_PART_S).round());
        if parts == 1.0 {
            return self.step(from, first, t, h, inputs);
        }
        let h = h / parts;
        let (mut state, mut here) = (*from, *first);
        for part in 0..parts as usize {
            let share = |part: usize| part as f64 / parts;
            let inputs = inputs.part(share(part), share(part + 1));
            let t = t + part as f64 * h;
            if part > 0 {
                let (input, rate, before) = (&inputs.at[0], inputs.steering_rate, here.before());
                here = self.instant(t, &state, input, rate, &before, Compute::Rates);
            }
            state = self.step(&state, &here, t, h, &inputs);
        }
        state
    }

    /// Is a step of `h` seconds short enough at a speed for [`Self::pass`], where that knows no rate of something?
    pub fn can_pass(&self, vx: f64, h: f64) -> bool {
        self.effects.fastest_but_lags(vx) * h <= LARGEST_UNKNOWN_STEP
    }
}

/// So far a step's fastest rate may go; more needs smaller steps. Numerical: stable with the midpoint rule.
const LARGEST_STEP: f64 = 0.8;

/// No part of a step is shorter, s. Numerical.
const SHORTEST_PART_S: f64 = 1e-3;

/// So far with one instant each, if a rate is not known. Numerical: what they make of it dies out by a half at each step.
const LARGEST_UNKNOWN_STEP: f64 = 0.6;

/// What a measurement has moved at an instant: the body's states, and their rates with them.
#[derive(Clone, Copy, Debug)]
pub struct Moved {
    /// vx, vy, yaw rate.
    pub body: [f64; BODY_STATES],
    /// Their rates.
    pub rate: [f64; BODY_STATES],
}

impl Moved {
    /// Nothing was measured.
    pub const NOTHING: Self = Self { body: [0.0; BODY_STATES], rate: [0.0; BODY_STATES] };
}

/// An instant that a run has passed.
#[derive(Clone, Copy, Debug)]
pub struct Passed {
    /// Where the car was, as that instant itself has told …
    pub state: State,
    /// … where it was thought to be before …
    pub at: State,
    /// … and how the state changes there.
    pub rate: State,
}

impl ExtendedCar {
    /// From an instant that was passed, `h` seconds ago, to the one at which the car is thought to be now, and from there to the
    /// next: `passed` becomes where the car is, as what is there now has told, and `at` where it will be. Half the computing of
    /// the midpoint rule, and of second order, too: Adams' and Moulton's rule corrects, Adams' and Bashforth's predicts, both as
    /// exponential rules (Cox & Matthews, J. Comput. Phys. 176, 2002), so that it may be as fast as it likes how a state follows
    /// something. What a measurement has moved at the instant is no part of what its rate rises by over a step.
    pub fn pass(&self, passed: &mut Passed, at: &mut State, rate: &State, moved: &Moved, h: f64) {
        let speed = at.body[0];
        let mut body = |i: usize, following: &Following| {
            let then = [passed.state.body[i], passed.at.body[i], passed.rate.body[i]];
            let (now, by) = ([at.body[i], rate.body[i]], [moved.body[i], moved.rate[i]]);
            passed.at.body[i] = now[0] + by[0];
            passed.rate.body[i] = now[1] + by[1];
            [passed.state.body[i], at.body[i]] = following.passed(then, now, by);
        };
        body(0, &Following::new(0.0, h));
        for (i, rate) in self.plant.lateral_rates().into_iter().enumerate() {
            body(i + 1, &Following::new(rate / speed.max(1.0), h));
        }
        at.body[0] = at.body[0].max(LEAST_MPS);
        let mut own = |i: usize, following: &Following| {
            let then = [passed.state.own[i], passed.at.own[i], passed.rate.own[i]];
            (passed.at.own[i], passed.rate.own[i]) = (at.own[i], rate.own[i]);
            [passed.state.own[i], at.own[i]] =
                following.passed(then, [passed.at.own[i], passed.rate.own[i]], [0.0; 2]);
        };
        for (places, lag) in self.effects.lags(speed) {
            let following = Following::new(lag.unwrap_or(0.0), h);
            places.for_each(|i| own(i, &following));
        }
        (passed.state.live, passed.at.live, passed.rate.live) = (at.live, at.live, rate.live);
    }
}

/// How a state with x' = k (u − x) goes on over a step in which u rises evenly.
struct Following {
    /// 1/k, s; none where a state hardly moves in a step if nothing moves it.
    time: Option<f64>,
    /// So much of the way from x to u it goes: of that at the beginning …
    whole: f64,
    /// … and of what u rises by.
    rising: f64,
}

impl Following {
    fn new(rate: f64, h: f64) -> Self {
        let z = rate * h;
        if z < SLOW {
            return Self { time: None, whole: h, rising: 0.5 * h };
        }
        let whole = 1.0 - (-z).exp();
        Self { time: Some(1.0 / rate), whole, rising: 1.0 - whole / z }
    }

    /// Where a state is and will be, by where it was, where it was thought to be, and its rate there; by where it is thought to
    /// be now, and its rate; and by how much a measurement moves both.
    #[inline]
    fn passed(
        &self,
        [x, then, its_rate]: [f64; 3],
        [now, rate]: [f64; 2],
        [by, faster]: [f64; 2],
    ) -> [f64; 2] {
        let Some(time) = self.time else {
            let rises = self.rising * (rate - its_rate);
            let is = x + self.whole * its_rate + rises + by;
            return [is, is + self.whole * (rate + faster) + rises];
        };
        let (was, u) = (then + time * its_rate, now + time * rate);
        let rises = self.rising * (u - was);
        let is = x + self.whole * (was - x) + rises + by;
        [is, is + self.whole * (u + by + time * faster - is) + rises]
    }
}

/// What goes less of its way in a step has no rate of its own: that stands in a denominator. Numerical.
const SLOW: f64 = 1e-3;

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

/// The equations guard against standing still, not against going through it.
pub(crate) const LEAST_MPS: f64 = 0.1;

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
        next.body[0] = next.body[0].max(LEAST_MPS);
        next
    }
}

#[cfg(test)]
mod tests {
    use super::super::{Settings, Torque};
    use super::*;
    use crate::delay::Delays;
    use identify::Values;
    use physics::model::Vehicle;
    use physics::model::effect::{Course, Effect, Setting, named};

    fn bare(effects: Vec<Box<dyn Effect>>) -> ExtendedCar {
        let vehicle = Vehicle::thesis();
        ExtendedCar::new(Settings {
            vehicle: &vehicle,
            values: &Values::of(&vehicle),
            torque: Torque::Unknown,
            bend_along: 1.0,
            delays: Delays::default(),
            effects,
        })
    }

    /// GIVEN a lag of 12.5 ms behind a ramp, from anywhere WHEN it is stepped by 10 ms THEN it is where it should be.
    #[test]
    fn a_lag_is_exact_behind_a_ramp() {
        let kind = named("steering_lag").unwrap();
        let lag = kind.effect(&Setting { values: &[0.0125], channel: None, course: &Course::None });
        let car = bare(vec![lag]);
        let ramp = |step: i32| 0.3 * 0.01 * f64::from(step);
        // What is left of the beginning, and a ramp that is 12.5 ms late.
        let exact = |step: i32| (-0.8 * f64::from(step)).exp() + ramp(step) - 0.3 * 0.0125;
        let state = |own: f64| {
            let mut state = State { body: [10.0, 0.0, 0.0], ..State::default() };
            state.own[0] = own;
            state
        };
        let rate = |step: i32, state: &State| {
            let mut rate = State::default();
            rate.own[0] = (ramp(step) - state.own[0]) / 0.0125;
            rate
        };
        let first = state(exact(-1));
        let (mut passed, mut at) =
            (Passed { state: first, at: first, rate: rate(-1, &first) }, state(exact(0)));
        for step in 0..20 {
            let its_rate = rate(step, &at);
            car.pass(&mut passed, &mut at, &its_rate, &Moved::NOTHING, 0.01);
            assert!((passed.state.own[0] - exact(step)).abs() < 1e-12, "{step}: {}", passed.state.own[0]);
            assert!((at.own[0] - exact(step + 1)).abs() < 1e-12, "{step}: {}", at.own[0]);
        }
    }

    /// GIVEN what swings by itself, its rate known or not WHEN the steps are halved THEN the error after a second is a quarter.
    #[test]
    fn it_is_of_second_order() {
        for known in [0.0, 20.0] {
            let error = |steps: i32| {
                let h = 1.0 / f64::from(steps);
                let following = Following::new(known, h);
                // Place and speed of x'' = −64 x.
                let rate = |at: [f64; 2]| [at[1], -64.0 * at[0]];
                let exact = |t: f64| [(8.0 * t).sin(), 8.0 * (8.0 * t).cos()];
                let (mut was, mut at) = (exact(-h), exact(0.0));
                let mut before = (was, rate(was));
                for _ in 0..steps {
                    let rate = rate(at);
                    let both = [0, 1].map(|i| {
                        following.passed([was[i], before.0[i], before.1[i]], [at[i], rate[i]], [0.0; 2])
                    });
                    before = (at, rate);
                    (was, at) = (both.map(|[is, _]| is), both.map(|[_, next]| next));
                }
                let there = exact(1.0);
                (at[0] - there[0]).hypot((at[1] - there[1]) / 8.0)
            };
            let (coarse, fine) = (error(100), error(200));
            assert!(coarse < 0.01 && coarse > 3.5 * fine, "{known}: {coarse} {fine}");
        }
    }
}
