//! Section 8.2: one wheel with the Dahl model.

use super::Experiment;

/// In the order of the thesis.
pub const EXPERIMENTS: &[Experiment] = &[];
