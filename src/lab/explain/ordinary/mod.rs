//! The ordinary car: a model fitted to recordings by free runs with the measured speed as an input.
//!
//! ```text
//! Recording ─► FreeDrive (inputs on a grid, what is compared) ─► run (one car, one drive) ─► fit ─► FreeFit
//! ```
//!
//! A free run knows steering and speed only. So what it says on driving that was held out shows how well a model
//! predicts, and errors along the road do not spoil what is said across it. Each recording has its own offsets, delays
//! and scale of the speed; the car is common to all.

mod along;
mod answer;
mod axles;
mod bend;
mod beyond;
mod choice;
pub mod conceal;
mod damped;
mod drives;
mod fit;
mod fitted_number;
mod frozen;
mod grid;
mod inputs;
mod leave_out;
mod numbers;
mod problem;
mod remaining;
mod road;
mod robust;
mod run;
mod scores;
mod simulated;
mod speed;
mod tires;
mod zero;

pub(super) use along::Along;
pub(super) use answer::FittedCars;
pub use answer::{Asked, Ordinary, could_tell};
pub(super) use bend::Bent;
pub use beyond::{
    Bar, Beyond, History, MOST_TIMES_ORDINARY, OverDrives, Power, Powers, Since, likely_courses,
};
pub use fitted_number::Number;
pub(super) use grid::resampled_every;
pub use remaining::Remaining;
pub(super) use robust::deviation;
pub use scores::FreeTrace;
pub use simulated::{Incomparable, Simulated};
pub use speed::speed_of;
pub use tires::{AxleForce, AxleTires, TireCurve};
pub(super) use zero::zero_wanders;
