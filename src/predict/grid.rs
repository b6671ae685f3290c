//! The grid that inputs are put on, and the readings between its points.

use physics::Quantity;

/// Seconds between grid points. Readings within a step keep their own times; what a car does is smooth on
/// this scale. Numerical.
pub const STEP_S: f64 = 0.02;

/// Grid points in so many seconds.
pub const fn points(seconds: f64) -> usize {
    (seconds / STEP_S + 0.5) as usize
}

/// Below this speed slip angles mean nothing and wheel sensors are coarse, m/s.
/// Physical: few teeth pass a sensor in a step.
pub const SLOWEST_MPS: f64 = 3.0;

/// One reading.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Measured {
    /// It was taken in the step that begins at this grid point…
    pub step: u32,
    /// …at this share of it, above 0 and up to 1.
    pub share: f32,
    /// Its quantity.
    pub channel: u8,
    /// SI.
    pub value: f64,
}

impl Measured {
    /// When, s.
    pub fn time(&self) -> f64 {
        (f64::from(self.step) + f64::from(self.share)) * STEP_S
    }
}

/// Where no wheel is on the bus, the filter is told the speed by this; an input then, and no channel of the comparison.
pub const SPEED: Quantity = Quantity::VehicleSpeed;

/// Quantities that the filter compares.
pub const COMPARED: [Quantity; 7] = [
    Quantity::WheelSpeedFl,
    Quantity::WheelSpeedFr,
    Quantity::WheelSpeedRl,
    Quantity::WheelSpeedRr,
    Quantity::YawRate,
    Quantity::LateralAcceleration,
    Quantity::LongitudinalAcceleration,
];
