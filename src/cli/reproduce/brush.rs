//! Section 8.1: friction by the brush model.

use super::Experiment;

/// In the order of the thesis.
pub const EXPERIMENTS: &[Experiment] = &[];
