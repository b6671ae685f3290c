//! The vehicle: its parameters, body, wheels and tires, and their simulation.

pub mod body;
pub mod integrate;
pub mod plant;
pub mod scenario;
pub mod tire;
mod vehicle;
pub mod wheel;

pub use plant::{Conditions, Controls, Plant, Response, State};
pub use vehicle::{DrivenAxle, GRAVITY, TireKind, Uncertain, Vehicle, VehicleError};
