//! Every figure and claim of the thesis, carried out again.
//!
//! Each section's file lists its [`Experiment`]s; adding one means one line in that list.

pub mod abs_tests;
mod brush;
mod dahl;
mod experiment;
mod friction;
mod identification;
mod joint_filter;
mod lateral;
mod limits;
mod limits_scatter;
mod mapping;
mod numeric;
pub mod page;
pub mod sim2_grid;
mod sim3;
mod slip_slope;
mod surface;
pub mod table;
mod tires;

pub use experiment::{Claim, Done, Experiment, ExperimentError, Outcome, Picture, Verdict};
pub use sim3::noticed;

use physics::model::scenario::thesis::{SIM1, SIM2, SIM3, SIM3_LIMIT};
use physics::model::simulate::SimulatedDrive;

/// A section of the thesis.
#[derive(Clone, Copy)]
pub struct Section {
    /// What it is about.
    pub title: &'static str,
    /// Its experiments, in order.
    pub experiments: &'static [Experiment],
}

/// In the order of the thesis.
pub const SECTIONS: &[Section] = &[
    Section { title: "Friction (chapter 3)", experiments: friction::EXPERIMENTS },
    Section { title: "Tires (chapter 4)", experiments: tires::EXPERIMENTS },
    Section { title: "Longitudinal stiffness (5.2.1)", experiments: slip_slope::EXPERIMENTS },
    Section { title: "Lateral velocity and stiffness (5.2.2, 5.3.1)", experiments: lateral::EXPERIMENTS },
    Section { title: "A joint filter that has the tire's limit", experiments: joint_filter::EXPERIMENTS },
    Section { title: "Identification off line (5.3.2)", experiments: identification::EXPERIMENTS },
    Section { title: "From stiffness to friction (chapter 6)", experiments: mapping::EXPERIMENTS },
    Section { title: "The surface (chapter 7)", experiments: surface::EXPERIMENTS },
    Section { title: "Friction by the brush model (8.1)", experiments: brush::EXPERIMENTS },
    Section { title: "Friction by the Dahl model (8.2)", experiments: dahl::EXPERIMENTS },
    Section { title: "Limits (chapter 9)", experiments: limits::EXPERIMENTS },
];

/// Every experiment, in the order of the thesis.
pub fn experiments() -> impl Iterator<Item = Experiment> {
    SECTIONS.iter().flat_map(|section| section.experiments).copied()
}
