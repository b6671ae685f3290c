//! The plain car's numbers, each of which may be searched for.

use super::longitudinal_input::LongitudinalInput;
use super::parameter::{Parameter, Values};
use physics::Wheel;
use physics::model::body::Body;
use physics::model::tire::{Brush, Contact, Linear, MagicFormula, PiecewiseLinear, Tire};
use physics::model::{GRAVITY, Real, TireKind, Vehicle};

/// Body, tires and sensors' offsets, with derivatives by whatever is free.
#[derive(Clone, Copy, Debug)]
pub(super) struct PlainCar<T> {
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
    /// Half of each axle's track, m.
    pub(super) half_track: [T; 2],
    /// Is the force at an axle's wheels the same and from outside: torque, or none at all?
    pub(super) from_outside: [bool; 2],
    /// What wheels whose force comes from outside add to the mass, kg: all of them, those in front.
    pub(super) added_mass: [T; 2],
    /// Yaw inertia / (yaw inertia with that of these wheels at half a track from the middle).
    pub(super) yaw_share: T,
    pub(super) steering_ratio: T,
    /// Which axles are driven.
    pub(super) driven: [bool; 2],
    /// Force / load of each axle's wheels per unit of drive torque.
    pub(super) drive_share: [T; 2],
    /// And per bar of brake pressure.
    pub(super) brake_share: [T; 2],
    pub(super) yaw_rate_offset: T,
    pub(super) lateral_offset: T,
    pub(super) longitudinal_offset: T,
    pub(super) steering_offset: T,
}

impl<T: Real> PlainCar<T> {
    /// From a number for each parameter; what is no number (driven axle, kind of tire) is the vehicle's.
    pub(super) fn new(vehicle: &Vehicle, drive: LongitudinalInput, number: impl Fn(Parameter) -> T) -> Self {
        let zero = T::constant(0.0);
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
        let driven = [Wheel::Fl, Wheel::Rl].map(|wheel| vehicle.driven_axle.drives(wheel));
        let count = if driven == [true; 2] { 4.0 } else { 2.0 };
        let or_none = |value: T| if value.value().is_nan() { zero } else { value };
        let per_bar = [Parameter::BrakePerBarFront, Parameter::BrakePerBarRear];
        let share = |axle: usize, torque: T| torque / (nominal * load[axle]);
        let torque = number(Parameter::DriveTorqueRatio) / count;
        let from_outside = driven.map(|driven| match drive {
            LongitudinalInput::Torque | LongitudinalInput::Speed => true,
            LongitudinalInput::WheelSpeeds => !driven,
            LongitudinalInput::Slips => false,
        });
        let half_track = [number(Parameter::TrackFront) / 2.0, number(Parameter::TrackRear) / 2.0];
        let wheel_mass = number(Parameter::WheelInertia) / (nominal * nominal);
        let mut added_mass = [zero; 2];
        let mut added_inertia = zero;
        for axle in [0, 1] {
            if from_outside[axle] {
                added_mass[0] += wheel_mass * 2.0;
                added_inertia += wheel_mass * half_track[axle] * half_track[axle] * 2.0;
            }
        }
        if from_outside[0] {
            added_mass[1] = wheel_mass * 2.0;
        }
        let yaw_inertia = number(Parameter::YawInertia);
        Self {
            body: Body {
                mass,
                yaw_inertia,
                a,
                b,
                half_track_front: half_track[0],
                half_track_rear: half_track[1],
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
            wheel_mass,
            half_track,
            from_outside,
            added_mass,
            yaw_share: yaw_inertia / (yaw_inertia + added_inertia),
            steering_ratio: number(Parameter::SteeringRatio),
            driven,
            drive_share: [0, 1].map(|axle| if driven[axle] { share(axle, torque) } else { zero }),
            brake_share: [0, 1].map(|axle| share(axle, or_none(number(per_bar[axle])))),
            yaw_rate_offset: number(Parameter::YawRateOffset),
            lateral_offset: number(Parameter::LateralAccelerationOffset),
            longitudinal_offset: number(Parameter::LongitudinalAccelerationOffset),
            steering_offset: number(Parameter::SteeringOffset),
        }
    }
}

impl PlainCar<f64> {
    /// Without derivatives.
    pub(super) fn plain(vehicle: &Vehicle, drive: LongitudinalInput, values: &Values) -> Self {
        Self::new(vehicle, drive, |parameter| values.get(parameter))
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
