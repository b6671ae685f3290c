//! The car simulated beside a recording, and held to it as tightly as the noise allows.
//!
//! ```text
//! Recording ─► Drive (inputs on a grid, readings at their own times)
//!                └─► Pass: one filter, many cars (Lane) side by side ─► Sums by block
//! ```

mod algebra;
pub(super) mod car;
pub(super) mod drive;
mod filter;
pub(super) mod free;
pub(super) mod grid;
mod lane;
pub(super) mod late;
pub(super) mod noise;
pub(super) mod pass;
mod slide;
mod smoothing;
pub(super) mod sums;

pub(super) use algebra::FILTERED;
pub(super) use car::{Car, Settings};
pub(super) use drive::Drive;
pub use drive::Recording;
