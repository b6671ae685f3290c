//! How late sensors and torques usually are. Each reading is sampled, averaged and filtered before its frame goes
//! out, so a few milliseconds are ordinary.

use physics::Quantity;

/// Something that is late by an ordinary number.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Delayed {
    /// The wheel speeds of the front axle.
    FrontWheels,
    /// The wheel speeds of the rear axle.
    RearWheels,
    /// Drive and brake torque, from their frame to the road.
    Torque,
    /// The yaw rate.
    YawRate,
    /// The lateral acceleration.
    LateralAcceleration,
    /// The longitudinal acceleration.
    LongitudinalAcceleration,
    /// The steering wheel angle.
    Steering,
}

/// Delays, s, in the order of [`Delayed::ALL`].
pub type Delays = [f64; Delayed::ALL.len()];

impl Delayed {
    /// All of them.
    pub const ALL: [Self; 7] = [
        Self::FrontWheels,
        Self::RearWheels,
        Self::Torque,
        Self::YawRate,
        Self::LateralAcceleration,
        Self::LongitudinalAcceleration,
        Self::Steering,
    ];

    /// As it is called in an answer.
    pub fn name(self) -> &'static str {
        match self {
            Self::FrontWheels => "wheel_speed_front_delay_s",
            Self::RearWheels => "wheel_speed_rear_delay_s",
            Self::Torque => "torque_delay_s",
            Self::YawRate => "yaw_rate_delay_s",
            Self::LateralAcceleration => "lateral_acceleration_delay_s",
            Self::LongitudinalAcceleration => "longitudinal_acceleration_delay_s",
            Self::Steering => "steering_wheel_angle_delay_s",
        }
    }

    /// A quantity by which one sees whether it is on the bus.
    pub fn quantity(self) -> Quantity {
        match self {
            Self::FrontWheels => Quantity::WheelSpeedFl,
            Self::RearWheels => Quantity::WheelSpeedRl,
            Self::Torque => Quantity::DriveTorque,
            Self::YawRate => Quantity::YawRate,
            Self::LateralAcceleration => Quantity::LateralAcceleration,
            Self::LongitudinalAcceleration => Quantity::LongitudinalAcceleration,
            Self::Steering => Quantity::SteeringWheelAngle,
        }
    }

    /// Mean and standard deviation of what is thought of it, s: tooth wheels are read over some
    /// milliseconds, a gyroscope hardly.
    pub fn prior(self) -> (f64, f64) {
        match self {
            Self::FrontWheels | Self::RearWheels => (0.005, 0.005),
            Self::Torque => (0.0, 0.005),
            _ => (0.0, 0.004),
        }
    }

    /// The delays that are thought most probable.
    pub fn usual() -> Delays {
        Self::ALL.map(|late| late.prior().0)
    }
}
