//! Answers as people read them: text, JSON and pages.

pub mod axles;
mod clocks;
pub mod explain;
pub mod identify;
pub mod ordinary;
pub mod plot;
