//! The car simulated beside a recording, and held to it as tightly as the noise allows.
//!
//! ```text
//! Recording ─► GriddedDrive (inputs on a grid, readings at their own times)
//!                └─► Pass: one filter, many cars (Trajectory) side by side ─► BlockSums by block
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
