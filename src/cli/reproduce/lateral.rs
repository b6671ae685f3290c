//! Section 5.2.2 and 5.3.1: lateral velocity, slip angles and stiffness on line.

use super::Experiment;

/// In the order of the thesis.
pub const EXPERIMENTS: &[Experiment] = &[];
