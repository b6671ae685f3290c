//! The plain car's equations, from a number for each parameter.

use super::parameter::Parameter;
use physics::Wheel;
use physics::model::body::{Body, External};
use physics::model::tire::{Brush, Contact, Linear, MagicFormula, PiecewiseLinear, Tire};
use physics::model::{Conditions, GRAVITY, Plant, Real, TireKind, Vehicle};

/// The plain car of these numbers, with the vehicle's kind of tire and driven axle: loads at rest, no toe, nothing but the tires' forces.
pub fn plant<T: Real>(vehicle: &Vehicle, number: impl Fn(Parameter) -> T) -> Plant<T> {
    let (mass, wheelbase) = (number(Parameter::Mass), number(Parameter::Wheelbase));
    let a = number(Parameter::CgToFront);
    let b = wheelbase - a;
    let along = number(Parameter::Longitudinal) * mass * GRAVITY / 4.0;
    let friction = number(Parameter::Friction);
    let nominal = number(Parameter::WheelRadius);
    let load = Wheel::ALL.map(|wheel| {
        let lever = if wheel.is_front() { b } else { a };
        mass * 0.5 * GRAVITY * lever / wheelbase
    });
    let contact = Wheel::ALL.map(|wheel| Contact {
        stiffness_x: along / load[wheel as usize],
        stiffness_y: number(if wheel.is_front() { Parameter::LateralFront } else { Parameter::LateralRear }),
        friction_x: friction,
        friction_y: friction,
    });
    Plant {
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
        // A wheel that turns faster than it should seems to slip: its radius is smaller.
        radius: Wheel::ALL.map(|wheel| nominal / (number(Parameter::slip_offset(wheel)) + 1.0)),
        wheel_inertia: number(Parameter::WheelInertia),
        driven_axle: vehicle.driven_axle,
        nominal: Conditions { contact, load, toe: [T::constant(0.0); 4], external: External::none() },
    }
}
