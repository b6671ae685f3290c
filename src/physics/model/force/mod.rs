//! The core of the car's equations: from motion to the wheels, and from their forces back to the body.
//!
//! ```text
//! velocity, steering, toe ─► WheelMotion ─► slip angles ─► tires ─► fx, fy ─► WheelMotion::accelerate ─► Acceleration
//! ```
//!
//! A wheel's rotation is integrated where wheels are simulated ([`super::Plant`]: its speed gives the slip, the tire the
//! force along), or eliminated where it is not of interest: its torque gives the force along, that the slip
//! ([`super::tire::Tire::across`], [`super::tire::Tire::slip_at`]), and its inertia is the car's ([`AddedMass`]).

mod added_mass;
#[cfg(test)]
mod reductions;
mod wheel_motion;

pub use added_mass::{AddedMass, Carried};
pub use wheel_motion::WheelMotion;
