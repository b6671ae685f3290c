//! From stiffness to friction (thesis ch. 6): surfaces on which a tire is softer are often more
//! slippery. How much so depends on car and tires, and is learned from ABS brakings.
//!
//! [`PairFinder`] finds ABS brakings and the slope that had settled before each; [`Calibration`]
//! fits mappings to the pairs and refuses what they do not support; [`Mapping`] is the result at work.

mod calibration;
mod pairs;
mod published;
mod regression;

pub use calibration::{Calibration, MappingFit, Pair, Refusal};
pub use pairs::{Braking, NotAPair, PairFinder, mean_slope};

pub use super::abs_braking::AbsProblem;
pub use published::{MappedFriction, Mapping, MappingConfig, MappingKind};
pub use regression::{Covariance, Point, Regression, Shape};
