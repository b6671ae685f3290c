//! Chapter 9: what limits the estimation of friction.

use super::Experiment;

/// In the order of the thesis.
pub const EXPERIMENTS: &[Experiment] = &[];
