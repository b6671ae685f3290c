//! The vehicle: its parameters, body, wheels and tires, and their simulation.
//!
//! ```text
//! Scenario ─► Simulation ─► Truth, Readings          Plant: body + 4 wheels + tires, bare equations
//!                 └─► integrate::advance(Plant, State, Controls, Conditions)
//! ```

mod bicycle;
pub mod body;
mod dual;
pub mod effect;
pub mod force;
pub mod friction;
pub mod integrate;
mod one_wheel;
pub mod plant;
mod real;
#[cfg(feature = "simulation")]
pub mod scenario;
#[cfg(feature = "simulation")]
pub mod simulate;
pub mod tire;
mod vehicle;
pub mod wheel;

pub use bicycle::Bicycle;
pub use dual::Dual;
pub use one_wheel::{OneWheel, OneWheelState};
pub use plant::{Conditions, Controls, Plant, Response, State};
pub use real::Real;
#[cfg(feature = "simulation")]
pub use scenario::{Piece, Scenario, ScenarioError};
#[cfg(feature = "simulation")]
pub use simulate::{Added, Given, Line, Reading, Simulation, Tick, Truth, TruthWriter};
pub use vehicle::{DrivenAxle, GRAVITY, TireFiles, TireKind, Uncertain, Vehicle, VehicleError};
