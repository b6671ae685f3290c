//! Answers as people read them: text, JSON and pages.

pub mod axles;
mod beside;
mod clocks;
pub mod explain;
mod handling;
pub mod identify;
pub mod ordinary;
pub mod plot;
mod track;

/// A recording without its folders.
fn file_name(path: &str) -> &str {
    path.rsplit('/').next().unwrap_or(path)
}
