//! A car that is led along somebody else's motion: what its effects add to a plain car that moves like that.

use super::{Simulation, Tick};
use crate::model::effect::Readings;
use crate::model::{Conditions, State};

/// What effects add to the plain car at one instant.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Added {
    /// Force on the body forward, N, at the centre of gravity.
    pub fx: f64,
    /// Force on the body to the left, N.
    pub fy: f64,
    /// Yaw moment, N m.
    pub moment: f64,
    /// Torque on each wheel, N m, in the direction in which it rolls.
    pub wheel_torque: [f64; 4],
}

/// Motion that somebody else says: now, and its rate of change.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Lead {
    /// When it was said, s.
    pub(super) from_s: f64,
    pub(super) state: State,
    pub(super) rate: State,
}

impl Lead {
    pub(super) fn at(&self, t: f64) -> State {
        self.state.advanced(&self.rate, t - self.from_s)
    }
}

impl Simulation {
    /// Goes on by so many steps with the motion as it is said: `state` now, and its rate per second. What drives the car are
    /// the inputs that are [given](Simulation::give); what its own forces would make of the motion is left out.
    pub fn led_along(&mut self, state: &State, rate: &State, steps: u32) -> Tick<'_> {
        self.lead = Some(Lead { from_s: self.time.seconds(), state: *state, rate: *rate });
        self.state = *state;
        if steps == 0 {
            self.evaluate();
        }
        for _ in 0..steps {
            self.step();
        }
        self.tick()
    }

    /// What must act on the plain car, with the motion and the inputs of now, for it to accelerate as this car does.
    pub fn added(&self) -> Added {
        let plain = Conditions { contact: self.on_road, ..self.plant.nominal };
        let plain = self.plant.respond(&self.state, &self.controls, &plain);
        let (own, body) = (&self.response, &self.plant.body);
        let more = |of: fn(&crate::model::body::Acceleration) -> f64| {
            of(&own.acceleration) - of(&plain.acceleration)
        };
        Added {
            fx: body.mass * more(|acceleration| acceleration.ax),
            fy: body.mass * more(|acceleration| acceleration.ay),
            moment: body.yaw_inertia * more(|acceleration| acceleration.yaw),
            wheel_torque: std::array::from_fn(|i| {
                self.plant.wheel_inertia * (own.rate.wheel_speed[i] - plain.rate.wheel_speed[i])
            }),
        }
    }

    /// What perfect sensors say now, by [`Quantity`](crate::Quantity); not a number where there is nothing to say.
    pub fn perfect_readings(&self) -> Readings {
        self.true_readings()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::body::External;
    use crate::model::simulate::{Given, Line};
    use crate::model::{Plant, Scenario};

    const CAR: &str = r#"
        duration_s = 4.0
        initial_speed_mps = 20.0
        [[effect]]
        kind = "load_transfer"
        cg_height_m = 0.6
        [[effect]]
        kind = "relaxation_length"
        length_m = 0.5
        [[effect]]
        kind = "road_bank"
        value = 0.03
        [vehicle]
        mass_kg = 1500.0
        wheelbase_m = 2.7
        cg_to_front_m = 1.2
        wheel_radius_m = 0.31
        steering_ratio = 15.0
        driven_axle = "front"
    "#;

    fn steered(t: f64) -> Given {
        let angle = |t: f64| 0.9 * (3.0 * t).sin();
        let steering_wheel_angle = Line { value: angle(t), rate: (angle(t + 1e-3) - angle(t)) * 1e3 };
        let drive_torque = Line { value: 300.0, rate: 0.0 };
        Given { steering_wheel_angle, drive_torque, ..Given::default() }
    }

    /// The car with effects, and beside it one that is led along its motion: the same forces, and with them the plain car
    /// accelerates as the car with effects.
    #[test]
    fn with_what_is_added_the_plain_car_is_the_other() {
        let scenario = Scenario::parse(CAR).unwrap();
        let mut car = Simulation::new(&scenario, 1).unwrap();
        let mut beside = Simulation::new(&scenario, 1).unwrap();
        let plant = Plant::new(&scenario.vehicle);
        let mut largest = Added::default();
        for i in 0..3000 {
            let t = f64::from(i) * 1e-3;
            let before = car.state;
            car.give(&steered(t));
            car.go_on(1);
            beside.give(&steered(t));
            let rate = |before: f64, after: f64| (after - before) * 1e3;
            let mut change = State::default();
            change.velocity.vx = rate(before.velocity.vx, car.state.velocity.vx);
            change.velocity.vy = rate(before.velocity.vy, car.state.velocity.vy);
            change.velocity.yaw_rate = rate(before.velocity.yaw_rate, car.state.velocity.yaw_rate);
            change.wheel_speed =
                std::array::from_fn(|i| rate(before.wheel_speed[i], car.state.wheel_speed[i]));
            beside.led_along(&before, &change, 1);
            let added = beside.added();
            let external = External { fx: added.fx, fy: added.fy, moment: added.moment };
            let conditions = Conditions { external, ..plant.nominal };
            let plain = plant.respond(&car.state, &car.controls, &conditions);
            let (own, plain) = (car.response.acceleration, plain.acceleration);
            assert!((own.ay - plain.ay).abs() < 1e-6, "{t}: {} {}", own.ay, plain.ay);
            assert!((own.ax - plain.ax).abs() < 1e-6, "{t}: {} {}", own.ax, plain.ax);
            assert!((own.yaw - plain.yaw).abs() < 1e-6, "{t}: {} {}", own.yaw, plain.yaw);
            largest.fy = largest.fy.max(added.fy.abs());
            largest.moment = largest.moment.max(added.moment.abs());
        }
        assert!(largest.fy > 1000.0 && largest.moment > 500.0, "{largest:?}");
    }

    #[test]
    fn a_car_without_effects_adds_nothing() {
        let mut scenario = Scenario::parse(CAR).unwrap();
        scenario.effect.clear();
        let mut beside = Simulation::new(&scenario, 1).unwrap();
        let mut state = State::rolling(beside.plant(), 15.0);
        state.velocity.yaw_rate = 0.3;
        beside.give(&steered(0.4));
        beside.led_along(&state, &State::default(), 10);
        assert_eq!(beside.state, state);
        assert_eq!(beside.added(), Added::default());
    }
}
