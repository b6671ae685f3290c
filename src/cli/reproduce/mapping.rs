//! Chapter 6: from stiffness to friction.

use super::Experiment;

/// In the order of the thesis.
pub const EXPERIMENTS: &[Experiment] = &[];
