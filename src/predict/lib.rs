//! Prediction: a car is simulated along a recording, and a filter corrects it by the innovations.
//!
//! ```text
//! Recording ─► GriddedDrive (inputs on a grid, readings at their own times)
//!                └─► pass: one filter, the Trajectory of each car ─► BlockSums
//! ```

mod algebra;
pub mod car;
pub mod delay;
pub mod drive;
mod filter;
pub mod free;
pub mod grid;
pub mod noise;
pub mod pass;
mod slide;
mod smoothing;
pub mod sums;
mod trajectory;
mod work;

pub use algebra::FILTERED;
pub use car::{ExtendedCar, Settings, Torque};
pub use drive::{GriddedDrive, Recording, Why};
pub use work::Work;
