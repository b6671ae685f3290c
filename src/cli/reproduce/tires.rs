//! Chapter 4: tire models.

use super::Experiment;

/// In the order of the thesis.
pub const EXPERIMENTS: &[Experiment] = &[];
