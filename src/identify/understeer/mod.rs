//! The understeer gradient of a drive: how much more steering a faster curve of the same radius takes.
//!
//! Steady cornering of any car whose slip angles grow with the lateral acceleration has
//! δ = L r / v + K a_y: the geometry of the curve, and what the tires want beyond it. K is the gradient (ISO 4138).
//! It is found by a straight line through all moments at which the drive was nearly steady.

mod fit;
mod moments;

pub use fit::{Gradient, Untold, gradient};
pub use moments::{Instant, Moment, moments};

use physics::model::{GRAVITY, Uncertain, Vehicle};

/// The gradient (rad per m/s²) of a car whose axles have these cornering stiffnesses (per static load, 1/rad).
pub fn of_stiffness(front: Uncertain, rear: Uncertain) -> Uncertain {
    let value = (1.0 / front.value - 1.0 / rear.value) / GRAVITY;
    let part = |axle: Uncertain| axle.std / (axle.value * axle.value * GRAVITY);
    Uncertain { value, std: part(front).hypot(part(rear)) }
}

/// The configured car's.
pub fn of_vehicle(vehicle: &Vehicle) -> Uncertain {
    of_stiffness(vehicle.lateral_stiffness_front, vehicle.lateral_stiffness_rear)
}
