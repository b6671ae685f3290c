//! Answers as people read them: text, JSON and pages.

mod clocks;
pub mod explain;
pub mod identify;
pub mod ordinary;
pub mod plot;
