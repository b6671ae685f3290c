//! The plain car's numbers, each of which may be searched for.

use super::parameter::{Parameter, Values};
use crate::model::body::Body;
use crate::model::tire::{Brush, Contact, Linear, MagicFormula, PiecewiseLinear, Tire};
use crate::model::{GRAVITY, Real, TireKind, Vehicle};
use crate::{Quantity, Wheel};

/// Body, tires and sensors' offsets, with derivatives by whatever is free.
#[derive(Clone, Copy, Debug)]
pub(super) struct Car<T> {
    pub(super) body: Body<T>,
    pub(super) tire: Tire<T>,
    /// Front, rear.
    pub(super) contact: [Contact<T>; 2],
    /// Load of a front and of a rear wheel, N.
    pub(super) load: [T; 2],
    /// Rolling radius of each wheel, m.
    pub(super) radius: [T; 4],
    /// Wheel inertia / radius², kg.
    pub(super) wheel_mass: T,
    pub(super) steering_ratio: T,
    /// Torque at each wheel per unit of drive torque.
    pub(super) drive_share: [T; 4],
    /// Brake torque at each wheel per bar.
    pub(super) brake_per_bar: [T; 4],
    pub(super) driven: [bool; 4],
    pub(super) yaw_rate_offset: T,
    pub(super) lateral_offset: T,
    pub(super) longitudinal_offset: T,
    pub(super) steering_offset: T,
}

impl<T: Real> Car<T> {
    /// From a number for each parameter; what is no number (driven axle, kind of tire) is the vehicle's.
    pub(super) fn new(vehicle: &Vehicle, number: impl Fn(Parameter) -> T) -> Self {
        let mass = number(Parameter::Mass);
        let wheelbase = number(Parameter::Wheelbase);
        let a = number(Parameter::CgToFront);
        let b = wheelbase - a;
        let weight = mass * GRAVITY;
        let load = [weight * b / wheelbase / 2.0, weight * a / wheelbase / 2.0];
        let friction = number(Parameter::Friction);
        let contact = |lateral: Parameter, load: T| Contact {
            stiffness_x: number(Parameter::Longitudinal) * weight / load / 4.0,
            stiffness_y: number(lateral),
            friction_x: friction,
            friction_y: friction,
        };
        let nominal = number(Parameter::WheelRadius);
        // A wheel that turns faster than it should seems to slip: its radius is smaller.
        let radius = Wheel::ALL.map(|wheel| nominal / (number(Parameter::slip_offset(wheel)) + 1.0));
        let driven = Wheel::ALL.map(|wheel| vehicle.driven_axle.drives(wheel));
        let count = driven.iter().filter(|driven| **driven).count() as f64;
        let ratio = number(Parameter::DriveTorqueRatio);
        let or_none = |value: T| if value.value().is_nan() { T::constant(0.0) } else { value };
        Self {
            body: Body {
                mass,
                yaw_inertia: number(Parameter::YawInertia),
                a,
                b,
                half_track_front: number(Parameter::TrackFront) / 2.0,
                half_track_rear: number(Parameter::TrackRear) / 2.0,
                drag: number(Parameter::Drag),
                rolling_resistance: number(Parameter::RollingResistance),
            },
            tire: match vehicle.tire {
                TireKind::Linear => Tire::Linear(Linear),
                TireKind::Piecewise => Tire::PiecewiseLinear(PiecewiseLinear),
                TireKind::Brush => Tire::Brush(Brush),
                TireKind::MagicFormula => Tire::MagicFormula(MagicFormula {
                    shape: number(Parameter::MagicShape),
                    curvature: number(Parameter::MagicCurvature),
                }),
            },
            contact: [contact(Parameter::LateralFront, load[0]), contact(Parameter::LateralRear, load[1])],
            load,
            radius,
            wheel_mass: number(Parameter::WheelInertia) / (nominal * nominal),
            steering_ratio: number(Parameter::SteeringRatio),
            drive_share: driven.map(|driven| if driven { ratio / count } else { T::constant(0.0) }),
            brake_per_bar: Wheel::ALL.map(|wheel| {
                let front = wheel.is_front();
                or_none(number(if front { Parameter::BrakePerBarFront } else { Parameter::BrakePerBarRear }))
            }),
            driven,
            yaw_rate_offset: number(Parameter::YawRateOffset),
            lateral_offset: number(Parameter::LateralAccelerationOffset),
            longitudinal_offset: number(Parameter::LongitudinalAccelerationOffset),
            steering_offset: number(Parameter::SteeringOffset),
        }
    }
}

impl Car<f64> {
    /// Without derivatives.
    pub(super) fn plain(vehicle: &Vehicle, values: &Values) -> Self {
        Self::new(vehicle, |parameter| values.get(parameter))
    }

    /// An upper bound of the fastest rate in the plane at a speed, 1/s: sideslip and yaw on their tires,
    /// and the body on driven wheels whose speed is given.
    pub(super) fn fastest_rate(&self, vx: f64) -> f64 {
        let lateral = |axle: usize| 2.0 * self.contact[axle].stiffness_y * self.load[axle];
        let (front, rear) = (lateral(0), lateral(1));
        let body = &self.body;
        let sideways = (front + rear) / body.mass;
        let yaw = (body.a * body.a * front + body.b * body.b * rear) / body.yaw_inertia;
        let along = 4.0 * self.contact[0].stiffness_x * self.load[0] / body.mass;
        (sideways.max(along) + yaw) / vx.max(1.0)
    }
}

/// How the longitudinal forces get into the equations.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Drive {
    /// From drive torque and brake pressure; all wheel speeds are outputs.
    Torque,
    /// From the driven wheels' measured speeds; the undriven ones' are outputs.
    WheelSpeeds,
    /// From the slips of all wheels, measured beforehand (thesis 5.26); the speed is an output.
    Slips,
}

impl Drive {
    /// By torque where the bus has it, else by the driven wheels' speeds.
    pub fn usual(has: impl Fn(Quantity) -> bool) -> Self {
        if has(Quantity::DriveTorque) { Self::Torque } else { Self::WheelSpeeds }
    }
}
