//! Chapter 7: what the surface does to the slope.

use super::Experiment;

/// In the order of the thesis.
pub const EXPERIMENTS: &[Experiment] = &[];
