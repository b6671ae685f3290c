//! The plain vehicle: body, four wheels and tires as one system of differential equations.
//!
//! [`Plant::respond`] is its bare right-hand side: no time, no history, no allocation. Whatever
//! acts on the car from outside (surface, loads, wind, bank, toe) comes in through [`Conditions`].

use super::body::{Acceleration, Body, External, Steer, Velocity};
use super::force::WheelMotion;
use super::tire::{Contact, Tire};
use super::wheel::{self, Braking};
use super::{DrivenAxle, Real, Vehicle, wheel::reference_speed};
use crate::Wheel;

/// Speeds below it are none, m/s and rad/s. Their cubes, in the tire's force, are still ordinary numbers.
#[cfg(feature = "simulation")]
const AT_REST: f64 = 1e-30;

/// What the equations integrate.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct State<T = f64> {
    /// The body's motion.
    pub velocity: Velocity<T>,
    /// Angular speeds of the wheels, rad/s.
    pub wheel_speed: [T; 4],
}

impl State {
    /// Free rolling straight ahead at `speed`, m/s.
    pub fn rolling(plant: &Plant, speed: f64) -> Self {
        Self {
            velocity: Velocity { vx: speed, vy: 0.0, yaw_rate: 0.0 },
            wheel_speed: plant.radius.map(|radius| speed / radius),
        }
    }

    /// The same with what has died away set to zero. A car that stops comes ever closer to rest and never
    /// gets there; with numbers near the smallest there are a processor takes fifty times as long.
    #[cfg(feature = "simulation")]
    pub(super) fn settled(self) -> Self {
        let settle = |speed: f64| if speed.abs() < AT_REST { 0.0 } else { speed };
        Self {
            velocity: Velocity {
                vx: settle(self.velocity.vx),
                vy: settle(self.velocity.vy),
                yaw_rate: settle(self.velocity.yaw_rate),
            },
            wheel_speed: self.wheel_speed.map(settle),
        }
    }
}

impl<T: Real> State<T> {
    /// `self + rate * h`.
    #[inline(always)]
    pub fn advanced(&self, rate: &Self, h: f64) -> Self {
        let mut wheel_speed = self.wheel_speed;
        for (i, speed) in wheel_speed.iter_mut().enumerate() {
            *speed += rate.wheel_speed[i] * h;
        }
        Self {
            velocity: Velocity {
                vx: self.velocity.vx + rate.velocity.vx * h,
                vy: self.velocity.vy + rate.velocity.vy * h,
                yaw_rate: self.velocity.yaw_rate + rate.velocity.yaw_rate * h,
            },
            wheel_speed,
        }
    }

    /// All seven numbers: vx, vy, yaw rate, four wheel speeds.
    pub fn to_array(&self) -> [T; 7] {
        let [fl, fr, rl, rr] = self.wheel_speed;
        [self.velocity.vx, self.velocity.vy, self.velocity.yaw_rate, fl, fr, rl, rr]
    }
}

/// What driver and chassis command; between two instants it is taken as linear in time.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Controls<T = f64> {
    /// Steering angle of the front wheels, rad.
    pub steer: T,
    /// Drive torque at each wheel, N m.
    pub drive_torque: [T; 4],
    /// Brake torque at each wheel, N m, zero or positive.
    pub brake_torque: [T; 4],
}

impl<T: Real> Controls<T> {
    /// At `share` (0–1) of the way from `self` to `other`.
    #[inline(always)]
    pub fn towards(&self, other: &Self, share: f64) -> Self {
        let mix = |from: T, to: T| from + (to - from) * share;
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
pub struct Conditions<T = f64> {
    /// Tire and surface at each wheel.
    pub contact: [Contact<T>; 4],
    /// Normal load of each wheel, N.
    pub load: [T; 4],
    /// Further steering angle of each wheel, rad, to the left (toe, roll steer, rear steering).
    pub toe: [T; 4],
    /// Forces on the body.
    pub external: External<T>,
}

/// Everything that follows from state, controls and conditions at one instant.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Response<T = f64> {
    /// Derivative of the state.
    pub rate: State<T>,
    /// The body's accelerations.
    pub acceleration: Acceleration<T>,
    /// Slip of each wheel.
    pub slip: [T; 4],
    /// Slip angle of each wheel as the motion gives it, rad, positive when it gives a force to the left.
    pub slip_angle: [T; 4],
    /// Force along each wheel, N.
    pub fx: [T; 4],
    /// Force across each wheel, N, to the left.
    pub fy: [T; 4],
}

/// What comes between the car's motion and its tires' forces: nothing ([`Plainly`]), or what effects make
/// of it. The plain equations are compiled without it.
pub(super) trait Between<T = f64> {
    /// The slip angles that the tires answer to, rad, from those of the motion.
    fn answered(&self, slip_angle: [T; 4]) -> [T; 4];

    /// Force along and across / normal load.
    fn force(&self, tire: &Tire<T>, contact: &Contact<T>, slip: T, slip_angle: T) -> [T; 2];
}

/// Nothing comes between.
pub(super) struct Plainly;

impl<T: Real> Between<T> for Plainly {
    #[inline(always)]
    fn answered(&self, slip_angle: [T; 4]) -> [T; 4] {
        slip_angle
    }

    #[inline(always)]
    fn force(&self, tire: &Tire<T>, contact: &Contact<T>, slip: T, slip_angle: T) -> [T; 2] {
        tire.combined(contact, slip, slip_angle)
    }
}

/// The plain vehicle's equations with their numbers.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Plant<T = f64> {
    /// The body.
    pub body: Body<T>,
    /// The tire model, the same at all wheels.
    pub tire: Tire<T>,
    /// Rolling radius of each wheel, m.
    pub radius: [T; 4],
    /// Inertia of each wheel, kg m².
    pub wheel_inertia: T,
    /// Which wheels are driven.
    pub driven_axle: DrivenAxle,
    /// Tire, surface and loads of the vehicle as given: no wind, no toe, static loads.
    pub nominal: Conditions<T>,
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
            driven_axle: vehicle.driven_axle,
            nominal: Conditions {
                contact: wheels.map(|(contact, _)| contact),
                load: wheels.map(|(_, load)| load),
                toe: [0.0; 4],
                external: External::default(),
            },
        }
    }
}

impl<T: Real> Plant<T> {
    /// Slips, forces, accelerations and the derivative of the state. Brakes act against each
    /// wheel's rotation, or hold it.
    pub fn respond(
        &self,
        state: &State<T>,
        controls: &Controls<T>,
        conditions: &Conditions<T>,
    ) -> Response<T> {
        self.respond_through(state, controls, conditions, &Plainly)
    }

    /// [`Self::respond`] with something between motion and forces.
    pub(super) fn respond_through(
        &self,
        state: &State<T>,
        controls: &Controls<T>,
        conditions: &Conditions<T>,
        between: &impl Between<T>,
    ) -> Response<T> {
        let response = self.forces(state, controls, conditions, between);
        let brake = |i: usize, other| Braking::of(state.wheel_speed[i], controls.brake_torque[i], other);
        self.turning(response, controls, brake)
    }

    /// The same with brakes that act as told, for the stages of one step.
    #[inline(always)]
    pub(super) fn braked(
        &self,
        state: &State<T>,
        controls: &Controls<T>,
        conditions: &Conditions<T>,
        braking: &[Braking<T>; 4],
        between: &impl Between<T>,
    ) -> Response<T> {
        let response = self.forces(state, controls, conditions, between);
        self.turning(response, controls, |i, _| braking[i])
    }

    /// With the wheels' accelerations; the brake of a wheel acts as it is told for the torque of all else.
    #[inline(always)]
    fn turning(
        &self,
        mut response: Response<T>,
        controls: &Controls<T>,
        braking: impl Fn(usize, T) -> Braking<T>,
    ) -> Response<T> {
        for i in 0..4 {
            let other = controls.drive_torque[i] - self.radius[i] * response.fx[i];
            response.rate.wheel_speed[i] =
                braking(i, other).acceleration(other, controls.brake_torque[i], self.wheel_inertia);
        }
        response
    }

    /// The way each brake acts at the start of a step.
    #[inline(always)]
    pub(super) fn braking(
        &self,
        state: &State<T>,
        controls: &Controls<T>,
        conditions: &Conditions<T>,
        between: &impl Between<T>,
    ) -> [Braking<T>; 4] {
        let zero = T::constant(0.0);
        let stands = |i: usize| state.wheel_speed[i].is_zero() && zero.is_below(controls.brake_torque[i]);
        if !(0..4).any(stands) {
            let mut braking = [Braking::turning(zero); 4];
            for (i, brake) in braking.iter_mut().enumerate() {
                *brake = Braking::turning(state.wheel_speed[i]);
            }
            return braking;
        }
        let fx = self.forces(state, controls, conditions, between).fx;
        std::array::from_fn(|i| {
            let other = controls.drive_torque[i] - self.radius[i] * fx[i];
            Braking::of(state.wheel_speed[i], controls.brake_torque[i], other)
        })
    }

    /// Everything but the wheels' accelerations.
    #[inline(always)]
    fn forces(
        &self,
        state: &State<T>,
        controls: &Controls<T>,
        conditions: &Conditions<T>,
        between: &impl Between<T>,
    ) -> Response<T> {
        let steer = Steer::new(controls.steer);
        let motion = WheelMotion::new(&self.body, state.velocity, steer, Some(conditions.toe));
        let answered = between.answered(motion.slip_angle);
        let none = [T::constant(0.0); 4];
        let (mut slip, mut fx, mut fy) = (none, none, none);
        for i in 0..4 {
            slip[i] = wheel::slip(self.radius[i] * state.wheel_speed[i], motion.along[i]);
            let contact = &conditions.contact[i];
            let [x, y] = between.force(&self.tire, contact, slip[i], answered[i]);
            fx[i] = x * conditions.load[i];
            fy[i] = y * conditions.load[i];
        }
        let acceleration = motion.accelerate(&self.body, &fx, &fy, &conditions.external);
        let velocity =
            Velocity { vx: acceleration.vx_rate, vy: acceleration.vy_rate, yaw_rate: acceleration.yaw };
        let rate = State { velocity, wheel_speed: none };
        Response { rate, acceleration, slip, slip_angle: motion.slip_angle, fx, fy }
    }
}

impl Plant {
    /// Rates of sideslip and of yaw on their tires, each times the speed, m/s².
    pub fn lateral_rates(&self) -> [f64; 2] {
        let Self { body, nominal, .. } = self;
        let axle = |i: usize| 2.0 * nominal.contact[i].stiffness_y * nominal.load[i];
        let (front, rear) = (axle(0), axle(2));
        let yaw = (body.a * body.a * front + body.b * body.b * rear) / body.yaw_inertia;
        [(front + rear) / body.mass, yaw]
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
