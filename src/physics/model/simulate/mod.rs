//! Drives a scenario: the truth at a fixed rate, and what the sensors say of it at their own times.
//!
//! ```
//! use physics::model::{Scenario, Simulation};
//! # fn main() -> Result<(), physics::model::ScenarioError> {
//! let scenario = Scenario::parse(
//!     r#"
//!     duration_s = 1.0
//!     initial_speed_mps = 20.0
//!     [vehicle]
//!     mass_kg = 1500.0
//!     wheelbase_m = 2.7
//!     cg_to_front_m = 1.2
//!     wheel_radius_m = 0.31
//!     steering_ratio = 15.0
//!     driven_axle = "front"
//!     [sensors.yaw_rate]
//!     period_ms = 20.0
//!     noise_std = 0.003
//!     "#,
//! )?;
//! let mut simulation = Simulation::new(&scenario, scenario.seed)?;
//! let mut readings = 0;
//! while let Some(tick) = simulation.next_tick() {
//!     assert!(tick.truth.speed > 19.0);
//!     readings += tick.readings.len();
//! }
//! assert_eq!(readings, 51);
//! # Ok(())
//! # }
//! ```

mod beside;
mod commands;
mod drive;
mod driver;
mod effects;
mod given;
mod input;
mod random;
mod sensor;
mod shake;
mod surface;
mod tooth_wheel;
mod truth;

pub use beside::Added;
pub use drive::SimulatedDrive;
pub(super) use effects::OWN_STATES;
pub use given::{Given, Line};
pub use truth::{Truth, TruthWriter};

use self::beside::Lead;
use self::commands::{Commands, Known};
use self::effects::{Effects, Plain};
use self::random::{Stream, random};
use self::sensor::{History, Pending, Sensor};
use self::shake::Shake;
use self::surface::Surface;
use self::tooth_wheel::ToothWheel;
use super::effect::Felt;
use super::scenario::{Scenario, ScenarioError};
use super::tire::Contact;
use super::{Conditions, Controls, Plant, Response, State, effect, integrate};
use crate::{Micros, Quantity, Wheel};

/// What a sensor says.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Reading {
    /// When it comes, by the stamping clock; seconds from the start.
    pub time: Micros,
    /// What it is of.
    pub quantity: Quantity,
    /// SI ([`Quantity::unit`]). Drive torque in the bus's unit: axle torque /
    /// `vehicle.drive_torque_ratio`.
    pub value: f64,
}

/// One row of truth, and all readings since the last one.
#[derive(Clone, Copy, Debug)]
pub struct Tick<'a> {
    /// The plant now.
    pub truth: &'a Truth,
    /// Readings that came after the last tick and up to this one, in order of time, at the same
    /// time in the order of [`Quantity::ALL`].
    pub readings: &'a [Reading],
    /// What varies by effects, and their own states: the values of [`Simulation::effect_columns`].
    pub effects: &'a [f64],
}

/// A drive in progress. Deterministic: scenario and seed decide every bit.
#[derive(Clone, Debug)]
pub struct Simulation {
    plant: Plant,
    effects: Option<Effects>,
    effect_columns: Vec<String>,
    commands: Commands,
    steering_ratio: f64,
    drive_torque_ratio: f64,
    surface: Surface,
    /// Of a rough road, and by how much it makes each wheel turn faster now, rad/s.
    shake: Option<Shake>,
    shaken: [f64; 4],
    sensors: Vec<Sensor>,
    clock_scale: f64,

    step_us: i64,
    steps_per_tick: u32,
    last: Micros,
    started: bool,
    time: Micros,
    state: State,
    /// Somebody else's motion, where the car is led along it.
    lead: Option<Lead>,
    controls: Controls,
    /// What the road is to the tires, before any effects.
    on_road: [Contact; 4],
    /// The plant as it is now, with what effects make of it.
    car: Plant,
    /// The same of the conditions.
    conditions: Conditions,
    /// Angle of the front wheels, rad.
    steer: f64,
    response: Response,
    pose: [f64; 3],

    history: History,
    pending: Vec<Pending>,
    readings: Vec<Reading>,
    truth: Truth,
    effect_series: Vec<f64>,
}

impl Simulation {
    /// Prepares a drive; nothing has moved yet.
    ///
    /// # Errors
    /// The scenario's values that cannot be ([`Scenario::validate`]).
    pub fn new(scenario: &Scenario, seed: u64) -> Result<Self, ScenarioError> {
        scenario.validate()?;
        let vehicle = &scenario.vehicle;
        let plant = Plant::of_scenario(scenario);
        let commands = Commands::new(scenario, seed, &plant);
        let mut surface = Surface::new(&plant.nominal.contact, &scenario.road);
        let on_road = surface.at(0.0);
        let mut effects = Effects::new(&scenario.effect, vehicle.steering_ratio.value);
        let state = match &mut effects {
            None => State::rolling(&plant, scenario.initial_speed_mps),
            Some(effects) => {
                let plain = Plain { plant: &plant, contact: &on_road };
                effects.begin(&plain, scenario.initial_speed_mps, commands.steering_wheel_angle(0.0))
            }
        };
        let step_us = i64::from(scenario.step_us);
        let step_s = step_us as f64 * 1e-6;
        let sensors = sensors(scenario, seed, &state);
        // Readings look back by their delay; interpolation and scheduling need a few rows more.
        let look_back = sensors.iter().map(Sensor::delay_s).fold(0.0, f64::max);
        let mut simulation = Self {
            commands,
            steering_ratio: vehicle.steering_ratio.value,
            drive_torque_ratio: vehicle.drive_torque_ratio.value,
            surface,
            shake: Shake::new(&scenario.road, random(seed, Stream::Shake, 0)),
            shaken: [0.0; 4],
            effects,
            effect_columns: effect::column_names(&scenario.effect),
            clock_scale: 1.0 + 1e-6 * scenario.clock.skew_ppm,
            step_us,
            steps_per_tick: scenario.truth_period_ms * 1000 / scenario.step_us,
            last: Micros::from_seconds(scenario.duration_s),
            started: false,
            time: Micros(0),
            state,
            lead: None,
            controls: Controls::default(),
            on_road,
            car: plant,
            conditions: Conditions { contact: on_road, ..plant.nominal },
            steer: 0.0,
            response: Response::default(),
            pose: [0.0; 3],
            history: History::new(step_s, look_back + 4.0 * step_s),
            pending: Vec::with_capacity(64 + 16 * sensors.len()),
            readings: Vec::with_capacity(64 + 16 * sensors.len()),
            sensors,
            truth: Truth::default(),
            effect_series: Vec::new(),
            plant,
        };
        simulation.controls = simulation.command(0.0);
        simulation.observe();
        Ok(simulation)
    }

    /// The plant that is driven, with its own wheel radii, without effects.
    pub fn plant(&self) -> &Plant {
        &self.plant
    }

    /// Names of what [`Tick::effects`] has.
    pub fn effect_columns(&self) -> &[String] {
        &self.effect_columns
    }

    /// Goes on by one truth period; the first call returns the start itself. `None` at the end.
    pub fn next_tick(&mut self) -> Option<Tick<'_>> {
        if self.started {
            let tick = i64::from(self.steps_per_tick) * self.step_us;
            if self.time + Micros(tick) > self.last {
                return None;
            }
            for _ in 0..self.steps_per_tick {
                self.step();
            }
        }
        self.started = true;
        Some(self.tick())
    }

    /// What is now, and the readings since the last time it was asked.
    fn tick(&mut self) -> Tick<'_> {
        self.deliver();
        self.truth = self.row();
        if let Some(effects) = &self.effects {
            effects.series(self.time.seconds(), &mut self.effect_series);
        }
        Tick { truth: &self.truth, readings: &self.readings, effects: &self.effect_series }
    }

    /// One integration step.
    fn step(&mut self) {
        let h = self.step_us as f64 * 1e-6;
        let start = self.time.seconds();
        let next = self.time + Micros(self.step_us);
        let t = next.seconds();
        let controls = self.command(t);
        let before = self.state;
        let after = match &mut self.effects {
            None => integrate::advance(&self.plant, &before, &self.controls, &controls, &self.conditions, h),
            Some(effects) => {
                let plain = Plain { plant: &self.plant, contact: &self.on_road };
                effects.advance(&plain, start, h, &before, [&self.controls, &controls])
            }
        };
        self.state = after.settled();
        if let Some(lead) = &self.lead {
            self.state = lead.at(t);
        }
        self.controls = controls;
        self.time = next;
        self.follow(&before, h);
        self.on_road = self.surface.at(t);
        if let Some(shake) = &mut self.shake {
            let faster = shake.step(t, h);
            self.shaken = std::array::from_fn(|i| faster[i] / self.plant.radius[i]);
        }
        let turned = std::array::from_fn(|i| {
            h * (0.5 * (before.wheel_speed[i] + self.state.wheel_speed[i]) + self.shaken[i])
        });
        for sensor in &mut self.sensors {
            sensor.turn(t, h, &turned);
        }
        self.observe();
    }

    /// What is commanded at `t`, to the state as it is known.
    fn command(&mut self, t: f64) -> Controls {
        let h = self.step_us as f64 * 1e-6;
        let Self { state, response, plant, car, conditions, .. } = self;
        self.commands.at(t, h, &Known { state, response, plant, car, conditions })
    }

    /// Heading and place, from the velocities at both ends of the step.
    fn follow(&mut self, before: &State, h: f64) {
        let [x, y, heading] = &mut self.pose;
        let (from, to) = (before.velocity, self.state.velocity);
        let turned = 0.5 * h * (from.yaw_rate + to.yaw_rate);
        let (sin, cos) = (*heading + 0.5 * turned).sin_cos();
        let (vx, vy) = (0.5 * (from.vx + to.vx), 0.5 * (from.vy + to.vy));
        *x += h * (vx * cos - vy * sin);
        *y += h * (vx * sin + vy * cos);
        *heading += turned;
    }

    /// Evaluates the new state: what an accelerometer feels of it, where effects make that another thing.
    fn evaluate(&mut self) -> Option<Felt> {
        let t = self.time.seconds();
        let plain = Plain { plant: &self.plant, contact: &self.on_road };
        match &mut self.effects {
            None => {
                self.conditions.contact = self.on_road;
                self.steer = self.controls.steer;
                self.response = self.plant.respond(&self.state, &self.controls, &self.conditions);
                None
            }
            Some(effects) => {
                let (shaped, outcome) = effects.observe(&plain, t, &self.state, &self.controls);
                (self.car, self.conditions, self.steer) = (shaped.plant, shaped.conditions, shaped.steer);
                self.response = outcome.response;
                Some(outcome.felt)
            }
        }
    }

    /// Evaluates the new state and lets the sensors look at it.
    fn observe(&mut self) {
        let t = self.time.seconds();
        let felt = self.evaluate();
        let plain = Plain { plant: &self.plant, contact: &self.on_road };
        let mut row = self.true_readings();
        if let (Some(effects), Some(felt)) = (&self.effects, felt) {
            row[Quantity::LongitudinalAcceleration as usize] = felt.ax;
            row[Quantity::LateralAcceleration as usize] = felt.ay;
            // Effects change what the units make of the pulses, not the pulses.
            for (quantity, speed) in self.sensors.iter().filter_map(|sensor| sensor.pulses(t)) {
                row[quantity as usize] = speed;
            }
            effects.sense(&plain, t, &self.state, &felt, &mut row);
        }
        self.history.push(row);
        for sensor in &mut self.sensors {
            sensor.take(t, &self.history, &mut self.pending);
        }
    }

    /// What perfect sensors at the centre of gravity say, by [`Quantity`].
    fn true_readings(&self) -> [f64; Quantity::COUNT] {
        let [fl, fr, rl, rr] = std::array::from_fn(|i| self.state.wheel_speed[i] + self.shaken[i]);
        let brake: f64 = self.controls.brake_torque.iter().sum();
        [
            fl,
            fr,
            rl,
            rr,
            self.state.velocity.yaw_rate,
            self.response.acceleration.ay,
            self.controls.steer * self.steering_ratio,
            self.response.acceleration.ax,
            self.controls.drive_torque.iter().sum::<f64>() / self.drive_torque_ratio,
            brake,
            self.commands.pressure_bar,
            self.state.velocity.vx,
            f64::from(u8::from(self.brake_active(brake))),
            f64::from(u8::from(self.commands.abs_active)),
        ]
    }

    fn brake_active(&self, brake_nm: f64) -> bool {
        self.commands.abs_active || brake_nm > 0.0
    }

    /// Moves the readings that have come into `readings`.
    fn deliver(&mut self) {
        self.readings.clear();
        let now = self.time;
        self.readings.extend(self.pending.iter().filter(|p| p.due <= now).map(|p| p.reading));
        self.pending.retain(|pending| pending.due > now);
        self.readings.sort_unstable_by_key(|reading| (reading.time, reading.quantity));
    }

    /// The truth now.
    fn row(&self) -> Truth {
        let Self { state, response, conditions, controls, .. } = self;
        let velocity = state.velocity;
        let contact = &conditions.contact;
        let load = &conditions.load;
        let weighted = |wheels: &[usize], value: &dyn Fn(usize) -> f64| {
            let total: f64 = wheels.iter().map(|i| load[*i]).sum();
            wheels.iter().map(|i| load[*i] * value(*i)).sum::<f64>() / total
        };
        let friction = |i: usize| contact[i].friction_x;
        let cornering = |i: usize| contact[i].stiffness_y;
        let used = |i: usize| response.fx[i].hypot(response.fy[i]) / load[i];
        let brake: f64 = controls.brake_torque.iter().sum();
        let offset = |wheel: Wheel| {
            if !self.commands.drives(wheel) {
                return f64::NAN;
            }
            let (own, other) = (wheel as usize, wheel.same_side() as usize);
            self.car.radius[other] / self.car.radius[own] - 1.0
        };
        Truth {
            time: Micros::from_seconds(self.time.seconds() * self.clock_scale),
            speed: velocity.vx.hypot(velocity.vy).copysign(velocity.vx),
            slope: std::array::from_fn(|i| contact[i].stiffness_x * (load[i] / self.plant.nominal.load[i])),
            slip_offset: Wheel::ALL.map(offset),
            lateral_velocity: velocity.vy,
            sideslip: if velocity.vx == 0.0 { 0.0 } else { (velocity.vy / velocity.vx).atan() },
            slip_angle_front: 0.5 * (response.slip_angle[0] + response.slip_angle[1]),
            slip_angle_rear: 0.5 * (response.slip_angle[2] + response.slip_angle[3]),
            cornering_front: weighted(&[0, 1], &cornering),
            cornering_rear: weighted(&[2, 3], &cornering),
            mu_max: weighted(&[0, 1, 2, 3], &friction),
            mu_used: (0..4).map(used).fold(0.0, f64::max),
            mu_max_left: weighted(&[0, 2], &friction),
            mu_max_right: weighted(&[1, 3], &friction),
            friction: std::array::from_fn(friction),
            longitudinal_velocity: velocity.vx,
            yaw_rate: velocity.yaw_rate,
            longitudinal_acceleration: response.acceleration.ax,
            lateral_acceleration: response.acceleration.ay,
            x: self.pose[0],
            y: self.pose[1],
            heading: self.pose[2],
            steering_wheel_angle: controls.steer * self.steering_ratio,
            steer: self.steer,
            drive_torque: controls.drive_torque.iter().sum(),
            brake_torque: brake,
            brake_pressure: self.commands.pressure_bar,
            brake_active: f64::from(u8::from(self.brake_active(brake))),
            abs_active: f64::from(u8::from(self.commands.abs_active)),
            wheel_speed: state.wheel_speed,
            slip: response.slip,
            fx: response.fx,
            fy: response.fy,
            fz: *load,
        }
    }
}

impl Plant {
    /// A scenario's, with the wheels' own radii.
    fn of_scenario(scenario: &Scenario) -> Self {
        let mut plant = Self::new(&scenario.vehicle);
        for (radius, difference) in plant.radius.iter_mut().zip(scenario.radius_difference.to_array()) {
            *radius *= 1.0 + difference;
        }
        plant
    }
}

/// The sensors of a scenario. Tooth wheels have been turning at the first speed for a while.
fn sensors(scenario: &Scenario, seed: u64, state: &State) -> Vec<Sensor> {
    let sensor = |quantity: Quantity| {
        let config = scenario.sensors.get(quantity)?;
        let tooth_wheel = quantity.wheel().zip(config.tooth_wheel.as_ref()).map(|(wheel, config)| {
            let index = wheel as usize;
            let mut tooth_wheel = ToothWheel::new(config, &mut random(seed, Stream::Teeth, index as u64));
            for ms in -1000..0 {
                tooth_wheel.turn(f64::from(ms + 1) * 1e-3, 1e-3, 1e-3 * state.wheel_speed[index]);
            }
            tooth_wheel
        });
        let travels_with = (config.period_ms * 1000.0) as u64 * 1_000_003 + (config.phase_ms * 1000.0) as u64;
        let mut config = config.clone();
        config.delay_ms += 1e3 * scenario.delay_by_effects(quantity);
        Some(Sensor::new(
            quantity,
            config,
            scenario.clock,
            tooth_wheel.map(|wheel| (wheel, !scenario.effect.is_empty())),
            random(seed, Stream::Noise, quantity as u64),
            random(seed, Stream::Jitter, travels_with),
        ))
    };
    Quantity::ALL.into_iter().filter_map(sensor).collect()
}
