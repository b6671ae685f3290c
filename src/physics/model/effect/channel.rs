//! What an effect of the sensors is of.

use std::fmt;
use std::str::FromStr;

use super::law::Law;
use crate::Quantity;

/// One quantity, two that are taken for each other, or what a law is of.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Channel {
    /// One.
    One(Quantity),
    /// Two, the first one in the order of [`Quantity::ALL`] first.
    Pair(Quantity, Quantity),
    /// A law: what changes with what.
    Law(Law),
}

/// What can be late, wrong in scale or zero.
pub(super) const MEASURED: &[Channel] = &[
    Channel::One(Quantity::YawRate),
    Channel::One(Quantity::LateralAcceleration),
    Channel::One(Quantity::LongitudinalAcceleration),
    Channel::One(Quantity::SteeringWheelAngle),
    Channel::One(Quantity::WheelSpeedFl),
    Channel::One(Quantity::WheelSpeedFr),
    Channel::One(Quantity::WheelSpeedRl),
    Channel::One(Quantity::WheelSpeedRr),
    Channel::One(Quantity::DriveTorque),
    Channel::One(Quantity::BrakePressure),
];

/// The four wheels.
pub(super) const WHEELS: &[Quantity] =
    &[Quantity::WheelSpeedFl, Quantity::WheelSpeedFr, Quantity::WheelSpeedRl, Quantity::WheelSpeedRr];

/// What is measured of drive and brake torque.
pub(super) const TORQUES: &[Quantity] = &[Quantity::DriveTorque, Quantity::BrakePressure];

impl Channel {
    /// The quantity, if it is one.
    pub const fn quantity(self) -> Option<Quantity> {
        match self {
            Self::One(quantity) => Some(quantity),
            Self::Pair(..) | Self::Law(_) => None,
        }
    }

    /// All that it is of.
    pub fn quantities(self) -> impl Iterator<Item = Quantity> {
        let (first, second) = match self {
            Self::One(quantity) => (Some(quantity), None),
            Self::Pair(first, second) => (Some(first), Some(second)),
            Self::Law(law) => (law.place.sensor(), None),
        };
        [first, second].into_iter().flatten()
    }

    /// The unit, and a slowly varying error that such a sensor of series production may have.
    ///
    /// Drive torque is in the bus's unit, which may be of the engine or of the axle: the size suits both
    /// within a small factor.
    pub fn usual_error(self) -> Option<(&'static str, f64)> {
        let quantity = match self {
            Self::One(quantity) => quantity,
            Self::Pair(..) => return None,
            Self::Law(law) => return Some(law.usual()),
        };
        let size = match quantity {
            Quantity::WheelSpeedFl
            | Quantity::WheelSpeedFr
            | Quantity::WheelSpeedRl
            | Quantity::WheelSpeedRr => 0.3,
            Quantity::YawRate => 0.01,
            Quantity::LateralAcceleration | Quantity::LongitudinalAcceleration => 0.2,
            Quantity::SteeringWheelAngle => 0.05,
            Quantity::DriveTorque | Quantity::BrakeTorque => 40.0,
            Quantity::BrakePressure => 2.0,
            Quantity::VehicleSpeed => 0.2,
            Quantity::BrakeActive | Quantity::AbsActive => return None,
        };
        Some((quantity.unit(), size))
    }
}

impl From<Quantity> for Channel {
    fn from(quantity: Quantity) -> Self {
        Self::One(quantity)
    }
}

impl fmt::Display for Channel {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::One(quantity) => quantity.fmt(f),
            Self::Pair(first, second) => write!(f, "{first}/{second}"),
            Self::Law(law) => law.fmt(f),
        }
    }
}

impl FromStr for Channel {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        if let Some((place, feature)) = text.split_once(": ") {
            return Law::named(place, feature).map(Self::Law).map_err(|(_, reason)| reason);
        }
        let Some((first, second)) = text.split_once('/') else { return text.parse().map(Self::One) };
        let (first, second) = (first.parse::<Quantity>()?, second.parse::<Quantity>()?);
        if first == second {
            return Err(format!("`{text}` names the same quantity twice"));
        }
        Ok(Self::Pair(first.min(second), first.max(second)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_come_back() {
        for text in ["yaw_rate", "wheel_speed_fl/wheel_speed_fr", "front slip angle: r/v"] {
            let channel: Channel = text.parse().unwrap();
            assert_eq!(channel.to_string(), text);
        }
        let swapped: Channel = "wheel_speed_rr/wheel_speed_fl".parse().unwrap();
        assert_eq!(swapped.to_string(), "wheel_speed_fl/wheel_speed_rr", "one name for each pair");
        assert!("yaw_rate/yaw_rate".parse::<Channel>().is_err());
        assert!("yaw_rate/speed".parse::<Channel>().is_err());
    }
}
