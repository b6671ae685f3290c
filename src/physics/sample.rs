//! The hinge between the bus and the physics: every measured quantity at one instant, in SI units.

use std::fmt;
use std::str::FromStr;

use crate::{Faults, Micros};

/// One of the four wheels.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Wheel {
    /// Front left.
    Fl,
    /// Front right.
    Fr,
    /// Rear left.
    Rl,
    /// Rear right.
    Rr,
}

impl Wheel {
    /// All four, in the order every array of four follows.
    pub const ALL: [Wheel; 4] = [Wheel::Fl, Wheel::Fr, Wheel::Rl, Wheel::Rr];

    /// On the front axle?
    pub const fn is_front(self) -> bool {
        matches!(self, Wheel::Fl | Wheel::Fr)
    }

    /// On the left side?
    pub const fn is_left(self) -> bool {
        matches!(self, Wheel::Fl | Wheel::Rl)
    }

    /// The wheel of the other axle on the same side.
    pub const fn same_side(self) -> Wheel {
        match self {
            Wheel::Fl => Wheel::Rl,
            Wheel::Fr => Wheel::Rr,
            Wheel::Rl => Wheel::Fl,
            Wheel::Rr => Wheel::Fr,
        }
    }

    /// `fl`, `fr`, `rl` or `rr`.
    pub const fn name(self) -> &'static str {
        match self {
            Wheel::Fl => "fl",
            Wheel::Fr => "fr",
            Wheel::Rl => "rl",
            Wheel::Rr => "rr",
        }
    }
}

/// A quantity gripd can take from the bus. The discriminant is its place in a [`Sample`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[repr(usize)]
pub enum Quantity {
    /// Front left wheel's angular speed, rad/s.
    WheelSpeedFl,
    /// Front right wheel's angular speed, rad/s.
    WheelSpeedFr,
    /// Rear left wheel's angular speed, rad/s.
    WheelSpeedRl,
    /// Rear right wheel's angular speed, rad/s.
    WheelSpeedRr,
    /// Yaw rate, rad/s, positive to the left.
    YawRate,
    /// Lateral acceleration, m/s², positive to the left.
    LateralAcceleration,
    /// Steering wheel angle, rad, positive to the left.
    SteeringWheelAngle,
    /// Longitudinal acceleration, m/s², positive forward.
    LongitudinalAcceleration,
    /// Drive torque as the bus has it, N m (times `drive_torque_ratio`: axle torque).
    DriveTorque,
    /// Brake torque of all wheels, N m, positive when braking.
    BrakeTorque,
    /// Brake pressure, bar: the one exception to SI, because `brake_torque_per_bar_…` is given so.
    BrakePressure,
    /// Vehicle speed as another unit computed it, m/s.
    VehicleSpeed,
    /// Brake pedal or brake light: 1 when braking, else 0.
    BrakeActive,
    /// ABS intervention: 1 while active, else 0.
    AbsActive,
}

impl Quantity {
    /// How many there are.
    pub const COUNT: usize = 14;

    /// All of them, in their order in a [`Sample`].
    pub const ALL: [Quantity; Self::COUNT] = [
        Quantity::WheelSpeedFl,
        Quantity::WheelSpeedFr,
        Quantity::WheelSpeedRl,
        Quantity::WheelSpeedRr,
        Quantity::YawRate,
        Quantity::LateralAcceleration,
        Quantity::SteeringWheelAngle,
        Quantity::LongitudinalAcceleration,
        Quantity::DriveTorque,
        Quantity::BrakeTorque,
        Quantity::BrakePressure,
        Quantity::VehicleSpeed,
        Quantity::BrakeActive,
        Quantity::AbsActive,
    ];

    /// A wheel's speed.
    pub const fn wheel_speed(wheel: Wheel) -> Self {
        match wheel {
            Wheel::Fl => Self::WheelSpeedFl,
            Wheel::Fr => Self::WheelSpeedFr,
            Wheel::Rl => Self::WheelSpeedRl,
            Wheel::Rr => Self::WheelSpeedRr,
        }
    }

    /// The wheel, if this is a wheel's speed.
    pub const fn wheel(self) -> Option<Wheel> {
        match self {
            Self::WheelSpeedFl => Some(Wheel::Fl),
            Self::WheelSpeedFr => Some(Wheel::Fr),
            Self::WheelSpeedRl => Some(Wheel::Rl),
            Self::WheelSpeedRr => Some(Wheel::Rr),
            _ => None,
        }
    }

    /// Is it required by itself? One that [tells the speed](Self::tells_speed) is required beside these; all others are
    /// optional.
    pub const fn is_required(self) -> bool {
        matches!(self, Self::YawRate | Self::SteeringWheelAngle)
    }

    /// Does it tell how fast the car goes?
    pub const fn tells_speed(self) -> bool {
        self.wheel().is_some() || matches!(self, Self::VehicleSpeed)
    }

    /// What has to be among a car's quantities and is not, each as its alternatives: one of them will do.
    pub fn lacking(has: impl Fn(Self) -> bool) -> Vec<Vec<Self>> {
        let mut lacking: Vec<_> =
            Self::ALL.into_iter().filter(|q| q.is_required() && !has(*q)).map(|q| vec![q]).collect();
        let speeds: Vec<_> = Self::ALL.into_iter().filter(|q| q.tells_speed()).collect();
        if !speeds.iter().any(|q| has(*q)) {
            lacking.push(speeds);
        }
        lacking
    }

    /// As a bit.
    pub const fn bit(self) -> u16 {
        1 << self as u16
    }

    /// Of quantities (as bits) those that the estimators stand on: wheels, yaw rate, lateral acceleration and steering;
    /// the vehicle's speed, where no wheel tells it.
    pub const fn basic(of: u16) -> u16 {
        let (mut wheels, mut place) = (0, 0);
        while place < 4 {
            wheels |= Self::ALL[place].bit();
            place += 1;
        }
        let others = Self::YawRate.bit() | Self::LateralAcceleration.bit() | Self::SteeringWheelAngle.bit();
        let speed = if of & wheels == 0 { Self::VehicleSpeed.bit() } else { 0 };
        of & (wheels | others | speed)
    }

    /// The key in `[signals]` and the column in `--samples`.
    pub const fn name(self) -> &'static str {
        match self {
            Self::WheelSpeedFl => "wheel_speed_fl",
            Self::WheelSpeedFr => "wheel_speed_fr",
            Self::WheelSpeedRl => "wheel_speed_rl",
            Self::WheelSpeedRr => "wheel_speed_rr",
            Self::YawRate => "yaw_rate",
            Self::LateralAcceleration => "lateral_acceleration",
            Self::SteeringWheelAngle => "steering_wheel_angle",
            Self::LongitudinalAcceleration => "longitudinal_acceleration",
            Self::DriveTorque => "drive_torque",
            Self::BrakeTorque => "brake_torque",
            Self::BrakePressure => "brake_pressure",
            Self::VehicleSpeed => "vehicle_speed",
            Self::BrakeActive => "brake_active",
            Self::AbsActive => "abs_active",
        }
    }

    /// The unit inside the program.
    pub const fn unit(self) -> &'static str {
        match self {
            Self::WheelSpeedFl | Self::WheelSpeedFr | Self::WheelSpeedRl | Self::WheelSpeedRr => "rad/s",
            Self::YawRate => "rad/s",
            Self::LateralAcceleration | Self::LongitudinalAcceleration => "m/s²",
            Self::SteeringWheelAngle => "rad",
            Self::DriveTorque | Self::BrakeTorque => "N m",
            Self::BrakePressure => "bar",
            Self::VehicleSpeed => "m/s",
            Self::BrakeActive | Self::AbsActive => "0/1",
        }
    }
}

impl fmt::Display for Quantity {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

impl FromStr for Quantity {
    type Err = String;
    fn from_str(text: &str) -> Result<Self, String> {
        Self::ALL.into_iter().find(|q| q.name() == text).ok_or_else(|| {
            let names: Vec<_> = Self::ALL.iter().map(|q| q.name()).collect();
            format!("unknown quantity `{text}`; known are {}", names.join(", "))
        })
    }
}

/// The vehicle at one instant of the uniform time grid.
///
/// A quantity that is not configured, timed out, invalid or implausible is absent: there is no stale
/// value to be mistaken for a fresh one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sample {
    /// The instant, a multiple of the sample period.
    pub time: Micros,
    /// Seconds since the previous sample; more than the sample period after a gap in the recording.
    pub elapsed_s: f64,
    /// What went wrong with the inputs since the previous sample.
    pub faults: Faults,
    values: [f64; Quantity::COUNT],
    present: u16,
}

impl Sample {
    /// A sample without any value.
    pub fn empty(time: Micros, elapsed_s: f64) -> Self {
        Self { time, elapsed_s, faults: Faults::empty(), values: [0.0; Quantity::COUNT], present: 0 }
    }

    /// The value in SI units ([`Quantity::unit`]), if it is known at this instant.
    #[inline]
    pub fn get(&self, quantity: Quantity) -> Option<f64> {
        let index = quantity as usize;
        if self.present & (1 << index) != 0 { Some(self.values[index]) } else { None }
    }

    /// Sets a value; one that is not finite counts as absent.
    #[inline]
    pub fn set(&mut self, quantity: Quantity, value: f64) {
        let index = quantity as usize;
        if value.is_finite() {
            self.values[index] = value;
            self.present |= 1 << index;
        } else {
            self.clear(quantity);
        }
    }

    /// Makes a value absent.
    #[inline]
    pub fn clear(&mut self, quantity: Quantity) {
        self.present &= !(1 << (quantity as usize));
    }

    /// All four wheel speeds, rad/s, in the order of [`Wheel::ALL`]; `None` if one is missing.
    pub fn wheel_speeds(&self) -> Option<[f64; 4]> {
        Some([
            self.get(Quantity::WheelSpeedFl)?,
            self.get(Quantity::WheelSpeedFr)?,
            self.get(Quantity::WheelSpeedRl)?,
            self.get(Quantity::WheelSpeedRr)?,
        ])
    }

    /// Are these (as bits) all known?
    #[inline]
    pub fn has_all(&self, quantities: u16) -> bool {
        self.present & quantities == quantities
    }

    /// What is known, as bits.
    #[inline]
    pub fn present(&self) -> u16 {
        self.present
    }

    /// No quantity is known.
    pub fn is_empty(&self) -> bool {
        self.present == 0
    }
}

/// What is known of the measurements before the first one: which quantities are configured, and the
/// standard deviation of each one's noise.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sensors {
    noise_std: [f64; Quantity::COUNT],
    configured: u16,
}

impl Default for Sensors {
    /// Nothing configured; noise as series-production ESP sensors have it.
    fn default() -> Self {
        let mut noise_std = [0.0; Quantity::COUNT];
        for quantity in Quantity::ALL {
            noise_std[quantity as usize] = match quantity {
                Quantity::WheelSpeedFl
                | Quantity::WheelSpeedFr
                | Quantity::WheelSpeedRl
                | Quantity::WheelSpeedRr => 0.05,
                Quantity::YawRate => 0.003,
                Quantity::LateralAcceleration | Quantity::LongitudinalAcceleration => 0.07,
                Quantity::SteeringWheelAngle => 0.002,
                Quantity::DriveTorque | Quantity::BrakeTorque => 10.0,
                Quantity::BrakePressure => 0.2,
                Quantity::VehicleSpeed => 0.05,
                Quantity::BrakeActive | Quantity::AbsActive => 0.0,
            };
        }
        Self { noise_std, configured: 0 }
    }
}

impl Sensors {
    /// Marks a quantity as configured, with its noise if that was given.
    pub fn add(&mut self, quantity: Quantity, noise_std: Option<f64>) {
        self.configured |= 1 << (quantity as usize);
        if let Some(std) = noise_std {
            self.noise_std[quantity as usize] = std;
        }
    }

    /// Takes a quantity out: it is configured, and never had a value.
    pub fn remove(&mut self, quantity: Quantity) {
        self.configured &= !quantity.bit();
    }

    /// What is configured, as bits.
    pub fn configured(&self) -> u16 {
        self.configured
    }

    /// Is it on this bus at all?
    pub fn has(&self, quantity: Quantity) -> bool {
        self.configured & (1 << (quantity as usize)) != 0
    }

    /// Standard deviation of the measurement noise, in the quantity's unit.
    pub fn noise_std(&self, quantity: Quantity) -> f64 {
        self.noise_std[quantity as usize]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_and_places_agree() {
        for (index, quantity) in Quantity::ALL.into_iter().enumerate() {
            assert_eq!(quantity as usize, index);
            assert_eq!(quantity.name().parse::<Quantity>(), Ok(quantity));
        }
        assert!("speed".parse::<Quantity>().is_err());
    }

    #[test]
    fn yaw_rate_steering_and_some_speed_are_enough() {
        let lacking = |has: &[Quantity]| Quantity::lacking(|q| has.contains(&q)).len();
        let (yaw, steering) = (Quantity::YawRate, Quantity::SteeringWheelAngle);
        assert_eq!(lacking(&[]), 3);
        assert_eq!(lacking(&[yaw, steering]), 1);
        for speed in Quantity::ALL.into_iter().filter(|q| q.tells_speed()) {
            assert_eq!(lacking(&[yaw, steering, speed]), 0);
            let bits = yaw.bit() | steering.bit() | speed.bit();
            assert_eq!(Quantity::basic(bits), bits);
        }
        assert_eq!(Quantity::basic(u16::MAX).count_ones(), 7);
    }

    #[test]
    fn what_is_not_finite_is_absent() {
        let mut sample = Sample::empty(Micros(0), 0.01);
        sample.set(Quantity::YawRate, 0.1);
        assert_eq!(sample.get(Quantity::YawRate), Some(0.1));
        sample.set(Quantity::YawRate, f64::NAN);
        assert_eq!(sample.get(Quantity::YawRate), None);
        assert!(sample.is_empty());
    }
}
