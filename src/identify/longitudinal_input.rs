//! What drives the equations along the car.

use physics::model::Vehicle;
use physics::{Quantity, Wheel};

/// How the longitudinal forces get into the equations.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum LongitudinalInput {
    /// From drive torque and brake pressure; all wheel speeds are outputs. Not where tires slide: there a
    /// wheel's slip is hardly a function of its torque, and stiffnesses come out too low.
    Torque,
    /// From the driven wheels' measured speeds; the undriven ones' are outputs.
    WheelSpeeds,
    /// From the slips of all wheels, measured beforehand (thesis 5.26); the speed is an output.
    Slips,
    /// From the measured speed: the car moves along as was measured, and its tires give what that takes. All there
    /// is without torque and the driven wheels' speeds; nothing along the car is an output.
    Speed,
}

impl LongitudinalInput {
    /// By torque where the bus has it and nothing slides, else by the driven wheels' speeds, else by the car's.
    pub fn usual(vehicle: &Vehicle, has: impl Fn(Quantity) -> bool, slides: bool) -> Self {
        let mut driven = Wheel::ALL.into_iter().filter(|wheel| vehicle.driven_axle.drives(*wheel));
        if has(Quantity::DriveTorque) && !slides {
            Self::Torque
        } else if driven.all(|wheel| has(Quantity::wheel_speed(wheel))) {
            Self::WheelSpeeds
        } else {
            Self::Speed
        }
    }

    /// Is the acceleration along the car an input rather than an output? Its noise is that of a measured speed.
    pub(super) fn prescribes_acceleration(self) -> bool {
        matches!(self, Self::WheelSpeeds | Self::Speed)
    }
}
