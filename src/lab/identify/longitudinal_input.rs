//! What drives the equations along the car.

use physics::Quantity;

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
}

impl LongitudinalInput {
    /// By torque where the bus has it and nothing slides, else by the driven wheels' speeds.
    pub fn usual(has: impl Fn(Quantity) -> bool, slides: bool) -> Self {
        if has(Quantity::DriveTorque) && !slides { Self::Torque } else { Self::WheelSpeeds }
    }
}
