//! Sensors that share a cause: one of them, or the four wheels.

use super::relations::Relation;
use super::series::Series;
use physics::{Quantity, Wheel};

/// A sensor, or those of the four wheels together, whose scale or delay may be wrong.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum SensorGroup {
    Wheels,
    Yaw,
    Lateral,
    Steering,
    Longitudinal,
}

impl SensorGroup {
    pub(super) const ALL: [Self; 5] =
        [Self::Wheels, Self::Yaw, Self::Lateral, Self::Steering, Self::Longitudinal];

    fn name(self) -> &'static str {
        match self {
            Self::Wheels => "wheel_speed",
            Self::Yaw => Quantity::YawRate.name(),
            Self::Lateral => Quantity::LateralAcceleration.name(),
            Self::Steering => Quantity::SteeringWheelAngle.name(),
            Self::Longitudinal => Quantity::LongitudinalAcceleration.name(),
        }
    }

    fn quantities(self) -> Vec<Quantity> {
        match self {
            Self::Wheels => Wheel::ALL.map(Quantity::wheel_speed).to_vec(),
            Self::Yaw => vec![Quantity::YawRate],
            Self::Lateral => vec![Quantity::LateralAcceleration],
            Self::Steering => vec![Quantity::SteeringWheelAngle],
            Self::Longitudinal => vec![Quantity::LongitudinalAcceleration],
        }
    }

    /// Body roll, pitch, tires and roads make scales look off by less than this (logarithmic).
    pub(super) fn explained_by_physics(self) -> f64 {
        match self {
            // Understeer and a steering ratio that varies with the angle.
            Self::Steering => 0.8,
            _ => 0.25,
        }
    }

    /// By which power of this group's factor a relation's slope grows.
    pub(super) fn power(self, relation: Relation) -> f64 {
        let own = match relation {
            Relation::RearWheels | Relation::FrontWheels => Self::Wheels,
            Relation::Lateral => Self::Lateral,
            Relation::Steering => Self::Steering,
            Relation::Longitudinal => Self::Longitudinal,
        };
        let mut power = f64::from(u8::from(self == own));
        match (self, relation) {
            (Self::Yaw, Relation::Longitudinal) => {}
            (Self::Yaw, _) => power -= 1.0,
            (Self::Wheels, Relation::Lateral | Relation::Longitudinal) => power -= 1.0,
            // Speed multiplies the steering angle there.
            (Self::Wheels, Relation::Steering) => power += 1.0,
            _ => {}
        }
        power
    }
}

impl Series {
    /// What a group is called. Where no wheel tells the speed, the vehicle's speed stands for the wheels.
    pub(super) fn name(&self, group: SensorGroup) -> &'static str {
        match group {
            SensorGroup::Wheels if !self.is_by_wheels() => Quantity::VehicleSpeed.name(),
            _ => group.name(),
        }
    }

    /// The quantities of a group.
    pub(super) fn quantities(&self, group: SensorGroup) -> Vec<Quantity> {
        match group {
            SensorGroup::Wheels if !self.is_by_wheels() => vec![Quantity::VehicleSpeed],
            _ => group.quantities(),
        }
    }
}
