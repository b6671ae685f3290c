//! `gripd reproduce`: every figure and claim of the thesis, carried out again.
//!
//! Each section's file lists its [`Experiment`]s; adding one means one line in that list.

mod brush;
mod dahl;
mod drive;
mod experiment;
mod friction;
mod identification;
mod joint_filter;
mod lateral;
mod limits;
mod mapping;
pub mod sim2_grid;
mod slip_slope;
mod surface;
mod tires;

pub use drive::{Drive, SIM1, SIM2, SIM3};
pub use experiment::{Claim, Experiment, ExperimentError, Outcome, Picture, Verdict};

/// Every experiment, in the order of the thesis.
pub fn experiments() -> Vec<Experiment> {
    let chapters = [
        friction::EXPERIMENTS,
        tires::EXPERIMENTS,
        slip_slope::EXPERIMENTS,
        lateral::EXPERIMENTS,
        joint_filter::EXPERIMENTS,
        identification::EXPERIMENTS,
        mapping::EXPERIMENTS,
        surface::EXPERIMENTS,
        brush::EXPERIMENTS,
        dahl::EXPERIMENTS,
        limits::EXPERIMENTS,
    ];
    chapters.concat()
}
