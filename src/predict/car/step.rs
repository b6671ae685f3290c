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
    /// From an instant that was passed, `h` seconds ago, to the next one: where the car is, as what is there now has told, and
    /// where it will be. Half the computing of the midpoint rule, and of second order, too: Adams' and Moulton's rule corrects,
    /// Adams' and Bashforth's predicts, both as exponential rules (Cox & Matthews, J. Comput. Phys. 176, 2002), so that it
    /// may be as fast as it likes how a state follows something.
    pub fn pass(&self, before: &Passed, at: &State, rate: &State, h: f64) -> (Passed, State) {
        let mut here = Passed { state: *at, at: *at, rate: *rate };
        let mut next = *at;
        let mut body = |i: usize, following: &Following| {
            let then = [before.state.body[i], before.at.body[i], before.rate.body[i]];
            [here.state.body[i], next.body[i]] = following.passed(then, [at.body[i], rate.body[i]]);
        };
        body(0, &Following::new(0.0, h));
        for (i, rate) in self.plant.lateral_rates().into_iter().enumerate() {
            body(i + 1, &Following::new(rate / at.body[0].max(1.0), h));
        }
        next.body[0] = next.body[0].max(SLOWEST_MPS);
        let mut own = |i: usize, following: &Following| {
            let then = [before.state.own[i], before.at.own[i], before.rate.own[i]];
            [here.state.own[i], next.own[i]] = following.passed(then, [at.own[i], rate.own[i]]);
        };
        for (places, lag) in self.effects.lags(at.body[0]) {
            let following = Following::new(lag.unwrap_or(0.0), h);
            places.for_each(|i| own(i, &following));
        }
        (here, next)
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
        let whole = -(-z).exp_m1();
        Self { time: Some(1.0 / rate), whole, rising: 1.0 - whole / z }
    }

    /// Where a state is and will be, by where it was, where it was thought to be, and its rate there; and where it is thought to
    /// be now, and its rate.
    #[inline]
    fn passed(&self, [x, then, its_rate]: [f64; 3], [now, rate]: [f64; 2]) -> [f64; 2] {
        let Some(time) = self.time else {
            let rises = self.rising * (rate - its_rate);
            let is = x + self.whole * its_rate + rises;
            return [is, is + self.whole * rate + rises];
        };
        let (was, u) = (then + time * its_rate, now + time * rate);
        let rises = self.rising * (u - was);
        let is = x + self.whole * (was - x) + rises;
        [is, is + self.whole * (u - is) + rises]
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
const SLOWEST_MPS: f64 = 0.1;

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
        next.body[0] = next.body[0].max(SLOWEST_MPS);
        next
    }
}

#[cfg(test)]
mod tests {
    use super::super::Settings;
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
            knows_torque: false,
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
            let (here, next) = car.pass(&passed, &at, &rate(step, &at), 0.01);
            assert!((here.state.own[0] - exact(step)).abs() < 1e-12, "{step}: {}", here.state.own[0]);
            assert!((next.own[0] - exact(step + 1)).abs() < 1e-12, "{step}: {}", next.own[0]);
            (passed, at) = (here, next);
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
                    let both = [0, 1]
                        .map(|i| following.passed([was[i], before.0[i], before.1[i]], [at[i], rate[i]]));
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
