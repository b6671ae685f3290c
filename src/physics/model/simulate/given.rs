//! A drive whose inputs come from outside, step by step: as part of another program's simulation.

use super::effects::Effects;
use super::sensor::Sensor;
use super::surface::Surface;
use super::{Simulation, Tick, sensors};
use crate::model::scenario::{Scenario, ScenarioError};
use crate::model::{Plant, effect};

/// An input as it is given: its value now, and its rate of change until the next one is given.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Line {
    /// Now, in the unit of the input.
    pub value: f64,
    /// Per second.
    pub rate: f64,
}

/// All inputs of a car.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Given {
    /// Angle at the steering wheel, rad.
    pub steering_wheel_angle: Line,
    /// Drive torque of all driven wheels together, N m; added to that of the driver who holds the speed.
    pub drive_torque: Line,
    /// Brake torque of all wheels together, N m; added to the driver's and the pressure's.
    pub brake_torque: Line,
    /// Brake pressure, bar; without effect where the vehicle has no torque per bar.
    pub brake_pressure: Line,
    /// The speed that the driver holds, m/s; without effect where the scenario has no driver.
    pub speed: Line,
}

impl Simulation {
    /// From now on these inputs are all that is commanded: the scenario's own no longer count. Each may jump.
    pub fn give(&mut self, given: &Given) {
        let t = self.time.seconds();
        self.commands.give(t, given);
        self.controls = self.commands.again(t);
    }

    /// Goes on by so many steps of the scenario's `step_us`, beyond its end if need be.
    pub fn go_on(&mut self, steps: u32) -> Tick<'_> {
        for _ in 0..steps {
            self.step();
        }
        self.tick()
    }

    /// Seconds since the start.
    pub fn seconds(&self) -> f64 {
        self.time.seconds()
    }

    /// Goes on with other numbers of the same car: with a vehicle and effects of the same kinds in the same order,
    /// sensors of the same quantities, and the same step. The motion stays as it is.
    ///
    /// # Errors
    /// The scenario's values that cannot be; then nothing has changed.
    pub fn retune(&mut self, scenario: &Scenario) -> Result<(), ScenarioError> {
        scenario.validate()?;
        let plant = Plant::of_scenario(scenario);
        let vehicle = &scenario.vehicle;
        self.commands.retune(scenario, &plant);
        self.steering_ratio = vehicle.steering_ratio.value;
        self.drive_torque_ratio = vehicle.drive_torque_ratio.value;
        self.surface = Surface::new(&plant.nominal.contact, &scenario.road);
        self.on_road = self.surface.at(self.time.seconds());
        let effects = Effects::new(&scenario.effect, vehicle.steering_ratio.value);
        self.effects = effects.map(|new| match &self.effects {
            Some(old) => new.going_on_from(old),
            None => new,
        });
        self.effect_columns = effect::column_names(&scenario.effect);
        self.plant = plant;
        // Delays may be others; what has been read has been read.
        let fresh = sensors(scenario, 0, &self.state);
        for (sensor, new) in self.sensors.iter_mut().zip(&fresh) {
            sensor.delayed_as(new);
        }
        let look_back = fresh.iter().map(Sensor::delay_s).fold(0.0, f64::max);
        self.history.reach_back(look_back);
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Quantity;
    use crate::model::effect::EffectConfig;

    const WEAVING: &str = r#"
        duration_s = 4.0
        initial_speed_mps = 20.0
        truth_period_ms = 10
        steering_wheel_angle = [{ kind = "sine", amplitude = 0.6, frequency_hz = 0.7 }]
        drive_torque = [{ kind = "ramp", from_s = 0.5, to_s = 1.5, value = 400.0 }]
        [[effect]]
        kind = "relaxation_length"
        length_m = 0.5
        [[effect]]
        kind = "sensor_delay"
        channel = "yaw_rate"
        delay_s = 0.02
        [sensors.yaw_rate]
        period_ms = 1.0
        [vehicle]
        mass_kg = 1500.0
        wheelbase_m = 2.7
        cg_to_front_m = 1.2
        wheel_radius_m = 0.31
        steering_ratio = 15.0
        driven_axle = "front"
    "#;

    fn weaving() -> Scenario {
        Scenario::parse(WEAVING).unwrap()
    }

    /// Straight from the value at the start of a period to that at its end, by what the scenario's own drive says of its
    /// inputs.
    fn followed(scenario: &Scenario) -> (Vec<[f64; 3]>, Vec<[f64; 3]>) {
        let mut own = Simulation::new(scenario, 1).unwrap();
        let (mut expected, mut inputs) = (vec![], vec![]);
        while let Some(tick) = own.next_tick() {
            let truth = tick.truth;
            expected.push([truth.yaw_rate, truth.lateral_velocity, truth.wheel_speed[1]]);
            inputs.push([truth.time.seconds(), truth.steering_wheel_angle, truth.drive_torque]);
        }
        let mut bare = scenario.clone();
        (bare.steering_wheel_angle, bare.drive_torque) = (vec![], vec![]);
        let mut given = Simulation::new(&bare, 1).unwrap();
        let mut found = vec![expected[0]];
        for pair in inputs.windows(2) {
            let line = |i: usize| Line {
                value: pair[0][i],
                rate: (pair[1][i] - pair[0][i]) / (pair[1][0] - pair[0][0]),
            };
            given.give(&Given { steering_wheel_angle: line(1), drive_torque: line(2), ..Given::default() });
            let truth = given.go_on(1).truth;
            found.push([truth.yaw_rate, truth.lateral_velocity, truth.wheel_speed[1]]);
        }
        (found, expected)
    }

    #[test]
    fn given_its_own_inputs_it_drives_as_by_itself() {
        let mut scenario = weaving();
        scenario.truth_period_ms = 1;
        let (found, expected) = followed(&scenario);
        assert_eq!(found.len(), 4001);
        let apart = found.iter().flatten().zip(expected.iter().flatten());
        let most = apart.map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        assert!(most < 1e-10, "{most}");
    }

    #[test]
    fn other_numbers_on_the_way_are_those_of_a_car_that_has_them() {
        let mut heavy = weaving();
        heavy.vehicle.mass_kg.value = 1800.0;
        let mut changed = Simulation::new(&weaving(), 1).unwrap();
        changed.retune(&heavy).unwrap();
        let mut fresh = Simulation::new(&heavy, 1).unwrap();
        let steer = Line { value: 0.4, rate: 0.0 };
        for simulation in [&mut changed, &mut fresh] {
            simulation.give(&Given { steering_wheel_angle: steer, ..Given::default() });
            simulation.go_on(2000);
        }
        let rows = [&changed, &fresh].map(|simulation| simulation.state.velocity);
        assert!((rows[0].yaw_rate - rows[1].yaw_rate).abs() < 1e-12, "{rows:?}");
        // Half-way it goes on from where it is.
        let before = changed.state;
        changed.retune(&weaving()).unwrap();
        assert_eq!(changed.state, before);
        let mut wrong = weaving();
        wrong.vehicle.mass_kg.value = -1.0;
        assert!(changed.retune(&wrong).is_err());
        assert_eq!(changed.plant, *Simulation::new(&weaving(), 1).unwrap().plant());
    }

    #[test]
    fn a_delay_that_grows_is_one_at_once() {
        let mut late = weaving();
        let delay = &late.effect[1];
        let numbers = vec![crate::model::Uncertain::known(0.3)];
        late.effect[1] =
            EffectConfig::new(delay.kind(), delay.channel(), numbers, delay.course().clone()).unwrap();
        let mut simulation = Simulation::new(&weaving(), 1).unwrap();
        let rate = Line { value: 0.0, rate: 0.1 };
        simulation.give(&Given { steering_wheel_angle: rate, ..Given::default() });
        let mut truths = vec![];
        let mut said = 0.0;
        for step in 1..=1500 {
            if step == 500 {
                simulation.retune(&late).unwrap();
            }
            let tick = simulation.go_on(1);
            truths.push(tick.truth.yaw_rate);
            let of_yaw_rate = |reading: &&crate::model::Reading| reading.quantity == Quantity::YawRate;
            said = tick.readings.iter().rev().find(of_yaw_rate).unwrap().value;
        }
        assert!((said - truths[1499 - 300]).abs() < 1e-9, "{said} {}", truths[1499 - 300]);
    }
}
