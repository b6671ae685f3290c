//! The plain car's numbers, each of which may be searched for.

use super::longitudinal_input::LongitudinalInput;
use super::parameter::{Parameter, Values};
use super::plant::plant;
use physics::Wheel;
use physics::model::force::AddedMass;
use physics::model::{Plant, Real, Vehicle};

/// Body, tires and sensors' offsets, with derivatives by whatever is free.
#[derive(Clone, Copy, Debug)]
pub(super) struct PlainCar<T> {
    pub(super) plant: Plant<T>,
    /// Is the force at an axle's wheels the same and from outside: torque, or none at all?
    pub(super) from_outside: [bool; 2],
    /// What wheels whose force comes from outside add to the car's mass.
    pub(super) added_mass: AddedMass<T>,
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
        let plant = plant(vehicle, &number);
        let nominal = number(Parameter::WheelRadius);
        let driven = [Wheel::Fl, Wheel::Rl].map(|wheel| vehicle.driven_axle.drives(wheel));
        let count = if driven == [true; 2] { 4.0 } else { 2.0 };
        let or_none = |value: T| if value.value().is_nan() { zero } else { value };
        let per_bar = [Parameter::BrakePerBarFront, Parameter::BrakePerBarRear];
        let share = |axle: usize, torque: T| torque / (nominal * plant.nominal.load[2 * axle]);
        let torque = number(Parameter::DriveTorqueRatio) / count;
        let from_outside = driven.map(|driven| match drive {
            LongitudinalInput::Torque | LongitudinalInput::Speed => true,
            LongitudinalInput::WheelSpeeds => !driven,
            LongitudinalInput::Slips => false,
        });
        let wheel_mass = plant.wheel_inertia / (nominal * nominal);
        let added = [0, 0, 1, 1].map(|axle| if from_outside[axle] { wheel_mass } else { zero });
        Self {
            plant,
            from_outside,
            added_mass: AddedMass::new(&plant.body, added),
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
        let [sideways, yaw] = self.plant.lateral_rates();
        let Plant { body, nominal, .. } = &self.plant;
        let along = 4.0 * nominal.contact[0].stiffness_x * nominal.load[0] / body.mass;
        (sideways.max(along) + yaw) / vx.max(1.0)
    }
}
