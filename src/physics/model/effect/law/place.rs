//! Where a law can act.

use super::Feature;
use crate::Quantity;
use crate::model::effect::Acting;

/// What of the car changes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Place {
    /// The front tires' slip angle: their wheels are turned to the left.
    FrontSlipAngle,
    /// The rear tires'.
    RearSlipAngle,
    /// The cornering stiffness of the front tires, by a share of itself.
    FrontStiffness,
    /// … of the rear tires.
    RearStiffness,
    /// … of all tires.
    Stiffness,
    /// A force on the body at its centre of gravity, to the left.
    LateralForce,
    /// A moment on the body, to the left.
    YawMoment,
    /// The yaw rate's reading.
    YawRate,
    /// The lateral accelerometer's reading.
    LateralAcceleration,
    /// The rolling radius of a wheel, by a share of itself.
    Radius(WheelPlace),
}

/// A wheel, in the order of [`crate::Wheel::ALL`].
pub type WheelPlace = u8;

/// Least share of a stiffness or radius that a law leaves. Numerical.
const LEAST_SHARE: f64 = 0.1;

impl Place {
    /// All of them.
    pub const ALL: [Self; 13] = [
        Self::FrontSlipAngle,
        Self::RearSlipAngle,
        Self::FrontStiffness,
        Self::RearStiffness,
        Self::Stiffness,
        Self::LateralForce,
        Self::YawMoment,
        Self::YawRate,
        Self::LateralAcceleration,
        Self::Radius(0),
        Self::Radius(1),
        Self::Radius(2),
        Self::Radius(3),
    ];

    /// Its name in tables and answers.
    pub const fn name(self) -> &'static str {
        match self {
            Self::FrontSlipAngle => "front slip angle",
            Self::RearSlipAngle => "rear slip angle",
            Self::FrontStiffness => "front cornering stiffness",
            Self::RearStiffness => "rear cornering stiffness",
            Self::Stiffness => "cornering stiffness of all tires",
            Self::LateralForce => "lateral force",
            Self::YawMoment => "yaw moment",
            Self::YawRate => "yaw_rate sensor",
            Self::LateralAcceleration => "lateral_acceleration sensor",
            Self::Radius(0) => "front left radius",
            Self::Radius(1) => "front right radius",
            Self::Radius(2) => "rear left radius",
            Self::Radius(_) => "rear right radius",
        }
    }

    /// Unit of what changes.
    pub const fn unit(self) -> &'static str {
        match self {
            Self::FrontSlipAngle | Self::RearSlipAngle => "rad",
            Self::FrontStiffness | Self::RearStiffness | Self::Stiffness | Self::Radius(_) => "1",
            Self::LateralForce => "N",
            Self::YawMoment => "N m",
            Self::YawRate => "rad/s",
            Self::LateralAcceleration => "m/s²",
        }
    }

    /// What an ordinary change is. Physical: about what the other effects of their ordinary size do there.
    pub(super) const fn size(self) -> f64 {
        match self {
            Self::FrontSlipAngle | Self::RearSlipAngle => 0.003,
            Self::FrontStiffness | Self::RearStiffness | Self::Stiffness => 0.1,
            Self::LateralForce => 300.0,
            Self::YawMoment => 400.0,
            Self::YawRate => 0.01,
            Self::LateralAcceleration => 0.2,
            Self::Radius(_) => 0.005,
        }
    }

    /// Does it change by such a feature? What has a side follows what has none in a car that pulls; what has none, as a
    /// stiffness, follows nothing that has one; a single wheel may follow anything.
    pub(super) fn takes(self, feature: Feature) -> bool {
        match self {
            Self::FrontStiffness | Self::RearStiffness | Self::Stiffness => !feature.has_side(),
            Self::Radius(_) => feature.is_of_radii(),
            _ => true,
        }
    }

    /// The sensor, if it is one's reading.
    pub const fn sensor(self) -> Option<Quantity> {
        match self {
            Self::YawRate => Some(Quantity::YawRate),
            Self::LateralAcceleration => Some(Quantity::LateralAcceleration),
            _ => None,
        }
    }

    /// The wheel, if it is one's radius.
    pub const fn wheel(self) -> Option<usize> {
        match self {
            Self::Radius(wheel) => Some(wheel as usize),
            _ => None,
        }
    }

    /// Changes it by so much.
    pub(super) fn change(self, by: f64, on: &mut Acting) {
        let share = (1.0 + by).max(LEAST_SHARE);
        let mut stiffness = |wheels: std::ops::Range<usize>| {
            on.contact[wheels].iter_mut().for_each(|contact| contact.stiffness_y *= share);
        };
        match self {
            Self::FrontSlipAngle => on.toe[..2].iter_mut().for_each(|toe| *toe += by),
            Self::RearSlipAngle => on.toe[2..].iter_mut().for_each(|toe| *toe += by),
            Self::FrontStiffness => stiffness(0..2),
            Self::RearStiffness => stiffness(2..4),
            Self::Stiffness => stiffness(0..4),
            Self::LateralForce => on.external.fy += by,
            Self::YawMoment => on.external.moment += by,
            Self::YawRate | Self::LateralAcceleration => {}
            Self::Radius(wheel) => on.radius[usize::from(wheel)] *= share,
        }
    }
}
