//! Section 5.2.1: the longitudinal slip slope.

use super::Experiment;

/// In the order of the thesis.
pub const EXPERIMENTS: &[Experiment] = &[];
