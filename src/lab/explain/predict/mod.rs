//! Prediction: a car is simulated along a recording, and a filter corrects it by the innovations.
//!
//! ```text
//! Recording ─► GriddedDrive (inputs on a grid, readings at their own times)
//!                └─► pass: one filter, the Trajectory of each car ─► BlockSums
//! ```

mod algebra;
pub(super) mod car;
pub(super) mod delay;
pub(super) mod drive;
mod filter;
pub(super) mod free;
pub(super) mod grid;
pub(super) mod noise;
pub(super) mod pass;
mod slide;
mod smoothing;
pub(super) mod sums;
mod trajectory;

pub(super) use algebra::FILTERED;
pub(super) use car::{ExtendedCar, Settings};
pub(super) use drive::GriddedDrive;
pub use drive::Recording;
