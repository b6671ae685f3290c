//! The plain vehicle: body, four wheels and tires as one system of differential equations.
//!
//! [`Plant::respond`] is its bare right-hand side: no time, no history, no allocation. Whatever
//! acts on the car from outside (surface, loads, wind, bank, toe) comes in through [`Conditions`].

use super::body::{Acceleration, Body, External, Steer, Velocity};
use super::tire::{Contact, Tire};
use super::wheel::{self, Braking};
use super::{Vehicle, wheel::reference_speed};
use crate::Wheel;

/// What the equations integrate.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct State {
    /// The body's motion.
    pub velocity: Velocity,
    /// Angular speeds of the wheels, rad/s.
    pub wheel_speed: [f64; 4],
}

impl State {
    /// Free rolling straight ahead at `speed`, m/s.
    pub fn rolling(plant: &Plant, speed: f64) -> Self {
        Self {
            velocity: Velocity { vx: speed, vy: 0.0, yaw_rate: 0.0 },
            wheel_speed: plant.radius.map(|radius| speed / radius),
        }
    }

    /// `self + rate * h`.
    #[inline]
    pub fn advanced(&self, rate: &State, h: f64) -> Self {
        let mut wheel_speed = self.wheel_speed;
        for (speed, rate) in wheel_speed.iter_mut().zip(rate.wheel_speed) {
            *speed += h * rate;
        }
        Self {
            velocity: Velocity {
                vx: self.velocity.vx + h * rate.velocity.vx,
                vy: self.velocity.vy + h * rate.velocity.vy,
                yaw_rate: self.velocity.yaw_rate + h * rate.velocity.yaw_rate,
            },
            wheel_speed,
        }
    }

    /// All seven numbers: vx, vy, yaw rate, four wheel speeds.
    pub fn to_array(&self) -> [f64; 7] {
        let [fl, fr, rl, rr] = self.wheel_speed;
        [self.velocity.vx, self.velocity.vy, self.velocity.yaw_rate, fl, fr, rl, rr]
    }
}

/// What driver and chassis command; between two instants it is taken as linear in time.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Controls {
    /// Steering angle of the front wheels, rad.
    pub steer: f64,
    /// Drive torque at each wheel, N m.
    pub drive_torque: [f64; 4],
    /// Brake torque at each wheel, N m, zero or positive.
    pub brake_torque: [f64; 4],
}

impl Controls {
    /// At `share` (0–1) of the way from `self` to `other`.
    #[inline]
    pub fn towards(&self, other: &Controls, share: f64) -> Self {
        let mix = |from: f64, to: f64| from + share * (to - from);
        let mut mixed = Self { steer: mix(self.steer, other.steer), ..*self };
        for i in 0..4 {
            mixed.drive_torque[i] = mix(self.drive_torque[i], other.drive_torque[i]);
            mixed.brake_torque[i] = mix(self.brake_torque[i], other.brake_torque[i]);
        }
        mixed
    }
}

/// What surroundings and suspension do; constant over an integration step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Conditions {
    /// Tire and surface at each wheel.
    pub contact: [Contact; 4],
    /// Normal load of each wheel, N.
    pub load: [f64; 4],
    /// Further steering angle of each wheel, rad, to the left (toe, roll steer, rear steering).
    pub toe: [f64; 4],
    /// Forces on the body.
    pub external: External,
}

/// Everything that follows from state, controls and conditions at one instant.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Response {
    /// Derivative of the state.
    pub rate: State,
    /// The body's accelerations.
    pub acceleration: Acceleration,
    /// Slip of each wheel.
    pub slip: [f64; 4],
    /// Slip angle of each wheel as the motion gives it, rad, positive when it gives a force to the left.
    pub slip_angle: [f64; 4],
    /// Force along each wheel, N.
    pub fx: [f64; 4],
    /// Force across each wheel, N, to the left.
    pub fy: [f64; 4],
}

/// What comes between the car's motion and its tires' forces: nothing ([`Plainly`]), or what effects make
/// of it. The plain equations are compiled without it.
pub(super) trait Between {
    /// The slip angles that the tires answer to, rad, from those of the motion.
    fn answered(&self, slip_angle: [f64; 4]) -> [f64; 4];

    /// Force along and across / normal load.
    fn force(&self, tire: &Tire, contact: &Contact, slip: f64, slip_angle: f64) -> [f64; 2];
}

/// Nothing comes between.
struct Plainly;

impl Between for Plainly {
    #[inline(always)]
    fn answered(&self, slip_angle: [f64; 4]) -> [f64; 4] {
        slip_angle
    }

    #[inline(always)]
    fn force(&self, tire: &Tire, contact: &Contact, slip: f64, slip_angle: f64) -> [f64; 2] {
        tire.combined(contact, slip, slip_angle)
    }
}

/// The plain vehicle's equations with their numbers.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Plant {
    /// The body.
    pub body: Body,
    /// The tire model, the same at all wheels.
    pub tire: Tire,
    /// Rolling radius of each wheel, m.
    pub radius: [f64; 4],
    /// Inertia of each wheel, kg m².
    pub wheel_inertia: f64,
    /// Tire, surface and loads of the vehicle as given: no wind, no toe, static loads.
    pub nominal: Conditions,
}

impl Plant {
    /// From the vehicle's parameters; all wheels with the nominal radius.
    pub fn new(vehicle: &Vehicle) -> Self {
        let wheel = |wheel: Wheel| {
            let load = vehicle.static_wheel_load(wheel.is_front());
            let contact = Contact {
                stiffness_x: vehicle.wheel_longitudinal_stiffness() / load,
                stiffness_y: vehicle.wheel_cornering_stiffness(wheel.is_front()) / load,
                friction_x: vehicle.friction.value,
                friction_y: vehicle.friction.value,
            };
            (contact, load)
        };
        let wheels = Wheel::ALL.map(wheel);
        Self {
            body: Body::new(vehicle),
            tire: Tire::new(vehicle),
            radius: [vehicle.wheel_radius_m.value; 4],
            wheel_inertia: vehicle.wheel_inertia_kgm2.value,
            nominal: Conditions {
                contact: wheels.map(|(contact, _)| contact),
                load: wheels.map(|(_, load)| load),
                toe: [0.0; 4],
                external: External::default(),
            },
        }
    }

    /// Slips, forces, accelerations and the derivative of the state. Brakes act against each
    /// wheel's rotation, or hold it.
    pub fn respond(&self, state: &State, controls: &Controls, conditions: &Conditions) -> Response {
        self.respond_through(state, controls, conditions, &Plainly)
    }

    /// [`Self::respond`] with something between motion and forces.
    pub(super) fn respond_through(
        &self,
        state: &State,
        controls: &Controls,
        conditions: &Conditions,
        between: &impl Between,
    ) -> Response {
        let mut response = self.forces(state, controls, conditions, between);
        for i in 0..4 {
            let other = controls.drive_torque[i] - self.radius[i] * response.fx[i];
            let brake = controls.brake_torque[i];
            let braking = Braking::of(state.wheel_speed[i], brake, other);
            response.rate.wheel_speed[i] = braking.acceleration(other, brake, self.wheel_inertia);
        }
        response
    }

    /// The derivative of the state with brakes that act as told, for the stages of one step.
    #[inline]
    pub fn rate(
        &self,
        state: &State,
        controls: &Controls,
        conditions: &Conditions,
        braking: &[Braking; 4],
    ) -> State {
        self.braked(state, controls, conditions, braking, &Plainly).rate
    }

    /// Everything with brakes that act as told and something between motion and forces.
    #[inline]
    pub(super) fn braked(
        &self,
        state: &State,
        controls: &Controls,
        conditions: &Conditions,
        braking: &[Braking; 4],
        between: &impl Between,
    ) -> Response {
        let mut response = self.forces(state, controls, conditions, between);
        for (i, braking) in braking.iter().enumerate() {
            let other = controls.drive_torque[i] - self.radius[i] * response.fx[i];
            response.rate.wheel_speed[i] =
                braking.acceleration(other, controls.brake_torque[i], self.wheel_inertia);
        }
        response
    }

    /// The way each brake acts at the start of a step.
    #[inline]
    pub fn braking(&self, state: &State, controls: &Controls, conditions: &Conditions) -> [Braking; 4] {
        self.braking_through(state, controls, conditions, &Plainly)
    }

    /// [`Self::braking`] with something between motion and forces.
    #[inline]
    pub(super) fn braking_through(
        &self,
        state: &State,
        controls: &Controls,
        conditions: &Conditions,
        between: &impl Between,
    ) -> [Braking; 4] {
        let stands = |i: usize| state.wheel_speed[i] == 0.0 && controls.brake_torque[i] > 0.0;
        if !(0..4).any(stands) {
            return state.wheel_speed.map(|speed| Braking::Against(speed.signum()));
        }
        let fx = self.forces(state, controls, conditions, between).fx;
        std::array::from_fn(|i| {
            let other = controls.drive_torque[i] - self.radius[i] * fx[i];
            Braking::of(state.wheel_speed[i], controls.brake_torque[i], other)
        })
    }

    /// Everything but the wheels' accelerations.
    #[inline]
    fn forces(
        &self,
        state: &State,
        controls: &Controls,
        conditions: &Conditions,
        between: &impl Between,
    ) -> Response {
        let velocity = &state.velocity;
        let steer = Steer::new(controls.steer);
        let along = self.body.contact_speeds(velocity, steer);
        // Both wheels of an axle share the slip angle of its middle (thesis 4.9).
        let [front_along, front_across] = self.body.front_axle_velocity(velocity, steer);
        let [rear_along, rear_across] = self.body.rear_axle_velocity(velocity);
        let front = wheel::slip_angle(front_along, front_across);
        let rear = wheel::slip_angle(rear_along, rear_across);
        let toe = &conditions.toe;
        let slip_angle = [front + toe[0], front + toe[1], rear + toe[2], rear + toe[3]];
        let answered = between.answered(slip_angle);
        let across = [front_across, front_across, rear_across, rear_across];
        let mut response = Response { slip_angle, ..Response::default() };
        let (mut on_body_x, mut on_body_y) = ([0.0; 4], [0.0; 4]);
        for i in 0..4 {
            let [along, _] = wheel::turned([along[i], across[i]], toe[i]);
            response.slip[i] = wheel::slip(self.radius[i] * state.wheel_speed[i], along);
            let contact = &conditions.contact[i];
            let [x, y] = between.force(&self.tire, contact, response.slip[i], answered[i]);
            response.fx[i] = x * conditions.load[i];
            response.fy[i] = y * conditions.load[i];
            [on_body_x[i], on_body_y[i]] = wheel::turned([response.fx[i], response.fy[i]], -toe[i]);
        }
        response.acceleration =
            self.body.accelerate(velocity, steer, &on_body_x, &on_body_y, &conditions.external);
        response.rate.velocity = Velocity {
            vx: response.acceleration.vx_rate,
            vy: response.acceleration.vy_rate,
            yaw_rate: response.acceleration.yaw,
        };
        response
    }

    /// An upper bound of the fastest rate of the system, 1/s: wheel against ground,
    /// k N r² / (J v) of the wheel plus 4 k N / (m v) of the body. Thousands at low speed.
    #[inline]
    pub fn fastest_rate(&self, velocity: &Velocity, conditions: &Conditions) -> f64 {
        let slowest = velocity.vx.abs()
            - velocity.yaw_rate.abs() * self.body.half_track_front.max(self.body.half_track_rear);
        let stiffest = (0..4)
            .map(|i| {
                let stiffness = conditions.contact[i].stiffness_x * conditions.load[i];
                stiffness * (self.radius[i] * self.radius[i] / self.wheel_inertia + 4.0 / self.body.mass)
            })
            .fold(0.0, f64::max);
        stiffest / reference_speed(slowest.max(0.0))
    }
}
