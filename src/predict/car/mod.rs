//! The car's equations with any effects: three states and the effects' own, wheels without delay.
//!
//! A wheel's speed is measured, so its rotation is no state ([`physics::model::force`]).

mod instant;
mod lookup;
mod step;

use identify::{Parameter, Values, plant};
use physics::model::body::Velocity;
use physics::model::effect::{Effect, EffectList, MOST_STATES, Now, Readings, Recorded};
use physics::model::tire::Tire;
use physics::model::{Plant, TireKind, Vehicle};
use physics::{Quantity, Wheel};

use lookup::Lookup;

use super::delay::{Delayed, Delays};
use super::drive::GriddedDrive;

pub use instant::{Compute, Instant};
pub use physics::model::effect::Before;
pub(crate) use step::LEAST_MPS;
pub use step::{Inputs, Moved, Passed, State};

/// States of the body: vx, vy, yaw rate.
pub const BODY_STATES: usize = 3;

/// States of all effects together.
pub const EFFECT_STATES: usize = 3 * MOST_STATES;

/// Most courses that a filter estimates while it runs.
pub const MOST_LIVE: usize = 8;

/// What is known of the torques that drive and brake the car.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Torque {
    /// Nothing: the force along the car is a course that the filter estimates, the first of all.
    Unknown,
    /// What is recorded is what acts.
    Recorded,
    /// What is recorded acts, and what it errs by: the first course, a force for the car's mass, m/s².
    Roughly,
}

impl Torque {
    /// Is it recorded?
    pub fn is_known(self) -> bool {
        self != Self::Unknown
    }

    /// How many courses are its own.
    pub fn courses(self) -> usize {
        usize::from(self != Self::Recorded)
    }
}

/// What a car is made of.
#[derive(Debug)]
pub struct Settings<'a> {
    /// What does not change: tire model, driven axle.
    pub vehicle: &'a Vehicle,
    /// The numbers.
    pub values: &'a Values,
    /// What is known of drive and brake torques.
    pub torque: Torque,
    /// How much of the lateral curve's bend the longitudinal one has: 0 straight, 1 the same.
    pub bend_along: f64,
    /// How late sensors and torques are, s.
    pub delays: Delays,
    /// Physics beyond the plain model.
    pub effects: Vec<Box<dyn Effect>>,
}

/// A car.
#[derive(Debug)]
pub struct ExtendedCar {
    plant: Plant,
    lookup: Option<Lookup>,
    steering_ratio: f64,
    /// N m per unit of drive torque, and per bar.
    torque_share: [f64; 4],
    brake_share: [f64; 4],
    driven: [bool; 4],
    torque: Torque,
    bend_along: f64,
    torque_delay: f64,
    slip_delay_per_mps: f64,
    steering_offset: f64,
    offset: Readings,
    delay: Readings,
    steering_delay: f64,
    effects: EffectList,
}

impl ExtendedCar {
    /// From its numbers and effects.
    pub fn new(settings: Settings<'_>) -> Self {
        let Settings { vehicle, values, torque, bend_along, delays, effects } = settings;
        let get = |parameter| values.get(parameter);
        let plant = plant(vehicle, |parameter| match (parameter, vehicle.tire) {
            // There is no limit to what such a tire transmits.
            (Parameter::Friction, TireKind::Linear) => f64::INFINITY,
            _ => get(parameter),
        });
        let driven = Wheel::ALL.map(|w| vehicle.driven_axle.drives(w));
        let count = driven.iter().filter(|driven| **driven).count() as f64;
        let share = get(Parameter::DriveTorqueRatio) / count;
        let or_zero = |value: f64| if value.is_nan() { 0.0 } else { value };
        let mut offset = [0.0; Quantity::COUNT];
        offset[Quantity::YawRate as usize] = get(Parameter::YawRateOffset);
        offset[Quantity::LateralAcceleration as usize] = get(Parameter::LateralAccelerationOffset);
        offset[Quantity::LongitudinalAcceleration as usize] = get(Parameter::LongitudinalAccelerationOffset);
        let mut delay = [0.0; Quantity::COUNT];
        for w in Wheel::ALL {
            let axle = if w.is_front() { Delayed::FrontWheels } else { Delayed::RearWheels };
            delay[Quantity::wheel_speed(w) as usize] = delays[axle as usize];
        }
        for late in [Delayed::YawRate, Delayed::LateralAcceleration, Delayed::LongitudinalAcceleration] {
            delay[late.quantity() as usize] = delays[late as usize];
        }
        let mut steering_delay = delays[Delayed::Steering as usize];
        let effects = EffectList::new(effects);
        for (quantity, by) in effects.delays() {
            match quantity {
                Quantity::SteeringWheelAngle => steering_delay += by,
                _ => delay[quantity as usize] += by,
            }
        }
        // In which a wheel's slip builds up, J v/(r² C_x).
        let nominal = get(Parameter::WheelRadius);
        let along = plant.nominal.contact[0].stiffness_x * plant.nominal.load[0];
        Self {
            lookup: match plant.tire {
                Tire::MagicFormula(formula) => Some(Lookup::new(formula)),
                _ => None,
            },
            slip_delay_per_mps: plant.wheel_inertia / (nominal * nominal * along),
            plant,
            steering_ratio: get(Parameter::SteeringRatio),
            torque_share: driven.map(|driven| if driven { share } else { 0.0 }),
            brake_share: Wheel::ALL.map(|w| {
                or_zero(get(if w.is_front() {
                    Parameter::BrakePerBarFront
                } else {
                    Parameter::BrakePerBarRear
                }))
            }),
            driven,
            torque,
            bend_along,
            torque_delay: delays[Delayed::Torque as usize],
            steering_offset: get(Parameter::SteeringOffset),
            offset,
            delay,
            steering_delay,
            effects,
        }
    }

    /// How many states its effects have.
    pub fn own_states(&self) -> usize {
        self.effects.states()
    }

    /// How late a sensor is, s.
    pub fn delay(&self, channel: usize) -> f64 {
        self.delay[channel]
    }

    /// How late the steering wheel's sensor is, s.
    pub fn steering_delay(&self) -> f64 {
        self.steering_delay
    }

    /// Are drive and brake torques known?
    pub fn knows_torque(&self) -> bool {
        self.torque.is_known()
    }

    /// The inputs that act at a time of a drive, s. A torque takes time to become a force: that of its frame,
    /// and that in which the wheel's slip builds up, J v/(r² C_x).
    pub fn input(&self, drive: &GriddedDrive, t: f64) -> Recorded {
        let slip_delay = self.slip_delay_per_mps * drive.speed_at(t);
        self.undo(t, drive.acting(t, self.steering_delay, self.torque_delay + slip_delay))
    }

    /// What was, from what was recorded.
    pub fn undo(&self, t: f64, mut recorded: Recorded) -> Recorded {
        recorded.steering_wheel -= self.steering_offset;
        self.effects.undo(t, &mut recorded);
        recorded
    }

    /// Rolling free at a speed, m/s.
    pub fn rolling(&self, t: f64, speed: f64, yaw_rate: f64, input: &Recorded) -> State {
        let state = State { body: [speed, 0.0, yaw_rate], ..State::default() };
        self.settled(t, &state, input, &Before::default())
    }

    /// The same with the effects' own states where they would settle: what the filter takes for their
    /// answer to a small change, for it does not correct them.
    pub fn settled(&self, t: f64, state: &State, input: &Recorded, before: &Before) -> State {
        let mut settled = *state;
        self.effects.begin(&self.now(t, state, input, before), &mut settled.own);
        settled
    }

    fn now<'a>(&'a self, t: f64, state: &'a State, input: &Recorded, before: &Before) -> Now<'a> {
        let [vx, vy, yaw_rate] = state.body;
        let velocity = Velocity { vx, vy, yaw_rate };
        let plain = Now::new(&self.plant, self.steering_ratio, t, velocity, before);
        Now { steering_wheel: input.steering_wheel, live: &state.live, ..plain }
    }

    /// An upper bound of the fastest rate in the plane at a speed, 1/s.
    fn fastest_rate(&self, vx: f64) -> f64 {
        let [sideways, yaw] = self.plant.lateral_rates();
        ((sideways + yaw) / vx.max(1.0)).max(self.effects.fastest_rate(vx))
    }

    /// Do states of it follow the steering wheel? [`Self::pass`] thinks that it goes on turning as it did in the last step.
    pub fn follows_steering(&self) -> bool {
        self.effects.follows_steering()
    }
}
