//! The vehicle: its parameters, body, wheels and tires, and their simulation.

mod bicycle;
mod vehicle;

pub use bicycle::Bicycle;
pub use vehicle::{DrivenAxle, GRAVITY, TireKind, Uncertain, Vehicle, VehicleError};
