//! The vehicle: its parameters, body, wheels and tires, and their simulation.

mod vehicle;

pub use vehicle::{DrivenAxle, GRAVITY, TireKind, Uncertain, Vehicle, VehicleError};
