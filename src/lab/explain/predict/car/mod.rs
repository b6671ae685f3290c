//! The car's equations with any effects: three states and the effects' own, wheels without delay.
//!
//! A wheel's rotation is fifty times faster than anything else in the plane, and its speed is measured;
//! so it is no state. What turns it is missing at the body: its inertia adds to the car's (methods.md
//! §2 with r ω̇ the acceleration of its contact point).

mod instant;
mod lookup;
mod step;

use crate::identify::{Parameter, Values};
use physics::model::body::{Body, Velocity};
use physics::model::effect::{Effect, MOST_STATES, Now, Readings, Recorded};
use physics::model::tire::{Brush, Contact, Linear, MagicFormula, PiecewiseLinear, Tire};
use physics::model::{GRAVITY, TireKind, Vehicle};
use physics::{Quantity, Wheel};

use lookup::Lookup;

use super::delay::{Delayed, Delays};
use super::drive::GriddedDrive;

pub use instant::{Before, Compute, Instant};
pub use step::{Inputs, State};

/// States of the body: vx, vy, yaw rate.
pub const BODY_STATES: usize = 3;

/// States of all effects together.
pub const EFFECT_STATES: usize = 3 * MOST_STATES;

/// Most courses that a filter estimates while it runs.
pub const MOST_LIVE: usize = 4;

/// What a car is made of.
#[derive(Debug)]
pub struct Settings<'a> {
    /// What does not change: tire model, driven axle.
    pub vehicle: &'a Vehicle,
    /// The numbers.
    pub values: &'a Values,
    /// Are drive and brake torques known?
    pub knows_torque: bool,
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
    body: Body,
    tire: Tire,
    lookup: Option<Lookup>,
    contact: [Contact; 4],
    load: [f64; 4],
    radius: [f64; 4],
    wheel_inertia: f64,
    steering_ratio: f64,
    /// N m per unit of drive torque, and per bar.
    torque_share: [f64; 4],
    brake_share: [f64; 4],
    driven: [bool; 4],
    knows_torque: bool,
    bend_along: f64,
    torque_delay: f64,
    slip_delay_per_mps: f64,
    steering_offset: f64,
    offset: Readings,
    delay: Readings,
    steering_delay: f64,
    effects: Vec<(Box<dyn Effect>, std::ops::Range<usize>)>,
}

impl ExtendedCar {
    /// From its numbers and effects.
    pub fn new(settings: Settings<'_>) -> Self {
        let Settings { vehicle, values, knows_torque, bend_along, delays, effects } = settings;
        let get = |parameter| values.get(parameter);
        let (mass, a) = (get(Parameter::Mass), get(Parameter::CgToFront));
        let wheelbase = get(Parameter::Wheelbase);
        let b = wheelbase - a;
        let load = Wheel::ALL.map(|w| 0.5 * mass * GRAVITY * if w.is_front() { b } else { a } / wheelbase);
        let radius = get(Parameter::WheelRadius);
        let along = get(Parameter::Longitudinal) * mass * GRAVITY / 4.0;
        let friction =
            if vehicle.tire == TireKind::Linear { f64::INFINITY } else { get(Parameter::Friction) };
        let contact = Wheel::ALL.map(|w| Contact {
            stiffness_x: along / load[w as usize],
            stiffness_y: get(if w.is_front() { Parameter::LateralFront } else { Parameter::LateralRear }),
            friction_x: friction,
            friction_y: friction,
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
        for (quantity, by) in effects.iter().filter_map(|effect| effect.delay()) {
            match quantity {
                Quantity::SteeringWheelAngle => steering_delay += by,
                _ => delay[quantity as usize] += by,
            }
        }
        let mut first = 0;
        let effects = effects.into_iter().map(|effect| {
            let own = first..first + effect.states();
            first = own.end;
            (effect, own)
        });
        let tire = match vehicle.tire {
            TireKind::Linear => Tire::Linear(Linear),
            TireKind::Piecewise => Tire::PiecewiseLinear(PiecewiseLinear),
            TireKind::Brush => Tire::Brush(Brush),
            TireKind::MagicFormula => Tire::MagicFormula(MagicFormula {
                shape: get(Parameter::MagicShape),
                curvature: get(Parameter::MagicCurvature),
            }),
        };
        Self {
            body: Body {
                mass,
                yaw_inertia: get(Parameter::YawInertia),
                a,
                b,
                half_track_front: 0.5 * get(Parameter::TrackFront),
                half_track_rear: 0.5 * get(Parameter::TrackRear),
                drag: get(Parameter::Drag),
                rolling_resistance: get(Parameter::RollingResistance),
            },
            lookup: match tire {
                Tire::MagicFormula(formula) => Some(Lookup::new(formula)),
                _ => None,
            },
            tire,
            contact,
            load,
            radius: [
                Parameter::SlipOffsetFl,
                Parameter::SlipOffsetFr,
                Parameter::SlipOffsetRl,
                Parameter::SlipOffsetRr,
            ]
            .map(|offset| radius / (1.0 + get(offset))),
            wheel_inertia: get(Parameter::WheelInertia),
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
            knows_torque,
            bend_along,
            torque_delay: delays[Delayed::Torque as usize],
            slip_delay_per_mps: get(Parameter::WheelInertia) / (radius * radius * along),
            steering_offset: get(Parameter::SteeringOffset),
            offset,
            delay,
            steering_delay,
            effects: effects.collect(),
        }
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
        self.knows_torque
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
        // The last thing that happened to a reading is undone first.
        for (effect, _) in self.effects.iter().rev() {
            effect.undo(t, &mut recorded);
        }
        recorded
    }

    /// Rolling free at a speed, m/s.
    pub fn rolling(&self, t: f64, speed: f64, yaw_rate: f64, input: &Recorded) -> State {
        let mut state = State { body: [speed, 0.0, yaw_rate], ..State::default() };
        let now = self.now(t, &state, input, &Before::default());
        let mut own = [0.0; EFFECT_STATES];
        for (effect, place) in &self.effects {
            effect.begin(&now, &mut own[place.clone()]);
        }
        state.own = own;
        state
    }

    /// The same with the effects' own states where they would settle: what the filter takes for their
    /// answer to a small change, for it does not correct them.
    pub fn settled(&self, t: f64, state: &State, input: &Recorded, before: &Before) -> State {
        let mut settled = *state;
        let now = self.now(t, state, input, before);
        for (effect, place) in &self.effects {
            effect.begin(&now, &mut settled.own[place.clone()]);
        }
        settled
    }

    fn now<'a>(&'a self, t: f64, state: &'a State, input: &Recorded, before: &Before) -> Now<'a> {
        let [vx, vy, yaw_rate] = state.body;
        Now {
            t,
            velocity: Velocity { vx, vy, yaw_rate },
            ax: before.ax,
            ay: before.ay,
            front_force: before.front_force,
            steering_wheel: input.steering_wheel,
            steering_ratio: self.steering_ratio,
            body: &self.body,
            static_load: &self.load,
            live: &state.live,
        }
    }

    /// An upper bound of the fastest rate in the plane at a speed, 1/s.
    pub fn fastest_rate(&self, vx: f64) -> f64 {
        let lateral = |axle: usize| 2.0 * self.contact[2 * axle].stiffness_y * self.load[2 * axle];
        let (front, rear) = (lateral(0), lateral(1));
        let body = &self.body;
        let yaw = (body.a * body.a * front + body.b * body.b * rear) / body.yaw_inertia;
        let of_body = ((front + rear) / body.mass + yaw) / vx.max(1.0);
        self.effects.iter().map(|(effect, _)| effect.fastest_rate(vx)).fold(of_body, f64::max)
    }
}
