//! What effects see of the car, and what they can change.

use crate::model::body::{Acceleration, Body, External, Steer, Velocity};
use crate::model::tire::ellipse::EllipseFactors;
use crate::model::tire::{Contact, Tire};
use crate::model::wheel;
use crate::model::{DrivenAxle, Plant};
use crate::{Quantity, Wheel};

/// What an effect may look at before the tires' forces are known.
#[derive(Clone, Copy, Debug)]
pub struct Now<'a> {
    /// Seconds from the recording's (or the simulation's) start.
    pub t: f64,
    /// The body's motion.
    pub velocity: Velocity,
    /// Acceleration of the centre of gravity forward, m/s², a moment ago: an effect that needs the
    /// forces' outcome to say what the forces are (load transfer) takes the last one.
    pub ax: f64,
    /// The same to the left, m/s².
    pub ay: f64,
    /// Lateral force of the front axle a moment ago, N.
    pub front_force: f64,
    /// It is that of this very moment, as sensors tell it: it has not to be found.
    pub is_force_measured: bool,
    /// Angle of the steering wheel, rad, as it truly is.
    pub steering_wheel: f64,
    /// Steering wheel angle / road wheel angle of the plain model.
    pub steering_ratio: f64,
    /// The plain body.
    pub body: &'a Body,
    /// Which wheels are driven.
    pub driven_axle: DrivenAxle,
    /// Static load of each wheel, N.
    pub static_load: &'a [f64; 4],
    /// Courses that a filter estimates while it runs ([`super::Course::Live`]).
    pub live: &'a [f64],
}

impl<'a> Now<'a> {
    /// Of the plain car at a time, s; no course is estimated.
    #[inline]
    pub fn new(plant: &'a Plant, steering_ratio: f64, t: f64, velocity: Velocity, before: &Before) -> Self {
        let Before { ax, ay, front_force } = *before;
        Self {
            t,
            velocity,
            ax,
            ay,
            front_force,
            is_force_measured: false,
            steering_wheel: 0.0,
            steering_ratio,
            body: &plant.body,
            driven_axle: plant.driven_axle,
            static_load: &plant.nominal.load,
            live: &[],
        }
    }
}

/// What was a moment ago, for effects that need the outcome to say what it is.
#[derive(Clone, Copy, Debug, Default)]
pub struct Before {
    ax: f64,
    ay: f64,
    front_force: f64,
}

impl Before {
    /// What is to be looked back at.
    #[inline]
    pub fn of(felt: &Felt) -> Self {
        let Felt { ax, ay, fy, .. } = felt;
        Self { ax: *ax, ay: *ay, front_force: fy[Wheel::Fl as usize] + fy[Wheel::Fr as usize] }
    }
}

/// What an effect may change; it finds the plain model's values there.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Acting {
    /// The body: mass, inertia, where the centre of gravity is, resistances.
    pub body: Body,
    /// Angle of the steering wheel as the steering gear sees it, rad.
    pub steering_wheel: f64,
    /// Steering wheel angle / road wheel angle.
    pub steering_ratio: f64,
    /// Further angle of each wheel, rad, positive to the left.
    pub toe: [f64; 4],
    /// Normal load of each wheel, N.
    pub load: [f64; 4],
    /// Tire and surface at each wheel.
    pub contact: [Contact; 4],
    /// The tires' model.
    pub tire: Tire,
    /// What forces along and across take from each other below the limit.
    pub ellipse: EllipseFactors,
    /// Rolling radius of each wheel, m.
    pub radius: [f64; 4],
    /// What each wheel's brake gives, relative to its share of the recorded braking.
    pub brake_gain: [f64; 4],
    /// Force of a brake that nobody records along each wheel, N, against its rolling.
    pub brake: [f64; 4],
    /// Forces and moment on the body that an accelerometer feels, too.
    pub external: External,
    /// Gravity in the road's plane, forward and to the left, m/s²: it moves the car and no
    /// accelerometer feels it.
    pub gravity: [f64; 2],
}

impl Acting {
    /// The plain model.
    #[inline]
    pub fn plain(plant: &Plant, steering_wheel: f64, steering_ratio: f64) -> Self {
        Self {
            body: plant.body,
            steering_wheel,
            steering_ratio,
            toe: plant.nominal.toe,
            load: plant.nominal.load,
            contact: plant.nominal.contact,
            tire: plant.tire,
            ellipse: EllipseFactors::default(),
            radius: plant.radius,
            brake_gain: [1.0; 4],
            brake: [0.0; 4],
            external: plant.nominal.external,
            gravity: [0.0; 2],
        }
    }

    /// The wheels' further angles, if there are any.
    #[inline]
    pub fn turned(&self) -> Option<[f64; 4]> {
        Some(self.toe).filter(|toe| *toe != [0.0; 4])
    }

    /// Angle of the front wheels, rad, without their toe.
    #[inline]
    pub fn steer(&self) -> f64 {
        self.steering_wheel / self.steering_ratio
    }

    /// All forces on the body that are not the tires': gravity's, too.
    #[inline]
    pub fn external(&self) -> External {
        let External { fx, fy, moment } = self.external;
        let [along, across] = self.gravity;
        External { fx: fx + self.body.mass * along, fy: fy + self.body.mass * across, moment }
    }

    /// Slip angle of the front axle's middle, rad, without toe or lag.
    pub fn front_slip_angle(&self, velocity: &Velocity) -> f64 {
        let [along, across] = self.body.front_axle_velocity(velocity, Steer::new(self.steer()));
        wheel::slip_angle(along, across)
    }
}

/// What came of it.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Felt {
    /// Specific force at the centre of gravity forward, m/s²: what an accelerometer there says.
    pub ax: f64,
    /// The same to the left, m/s².
    pub ay: f64,
    /// Yaw acceleration, rad/s².
    pub yaw_acceleration: f64,
    /// Slip angle of each wheel as the motion gives it, rad.
    pub slip_angle: [f64; 4],
    /// Force along each wheel, N.
    pub fx: [f64; 4],
    /// Force across each wheel, N.
    pub fy: [f64; 4],
}

impl Felt {
    /// Of the body's accelerations: an accelerometer does not feel gravity in the road's plane.
    #[inline]
    pub fn new(
        of: &Acceleration,
        gravity: [f64; 2],
        slip_angle: [f64; 4],
        fx: [f64; 4],
        fy: [f64; 4],
    ) -> Self {
        let (ax, ay) = (of.ax - gravity[0], of.ay - gravity[1]);
        Self { ax, ay, yaw_acceleration: of.yaw, slip_angle, fx, fy }
    }
}

/// What each sensor says, by [`Quantity`]; not-a-number: none.
pub type Readings = [f64; Quantity::COUNT];

/// What was recorded of the driver's inputs.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Recorded {
    /// Steering wheel angle, rad.
    pub steering_wheel: f64,
    /// Drive torque in the bus's unit.
    pub drive_torque: f64,
    /// Brake pressure, bar.
    pub brake_pressure: f64,
}

impl Recorded {
    /// What was recorded of a quantity, if it is one of these.
    pub fn get_mut(&mut self, quantity: Quantity) -> Option<&mut f64> {
        match quantity {
            Quantity::SteeringWheelAngle => Some(&mut self.steering_wheel),
            Quantity::DriveTorque => Some(&mut self.drive_torque),
            Quantity::BrakePressure => Some(&mut self.brake_pressure),
            _ => None,
        }
    }
}
