//! Where recording and physics disagree, and why.
//!
//! ```text
//! Recording ─► GriddedDrive ─┐
//! [vehicle] ─► Model ─┴─► fit (the plain model) ─► naming (scan, refit) ─► select ─► locate, proof ─► Explanation
//!                              └ predict: one filter, many cars side by side      └ correction: what nobody named
//! ```
//!
//! Before any physics is blamed, the measurement [`chain`] is looked at. Then the plain model is fitted with
//! all its uncertain numbers free, by the likelihood of its predictions: a filter holds it to the recording
//! as tightly as sensors and equations allow, both learnt from the data, so that what the model misses is
//! noise of the equations, and not forgotten. Every candidate effect is scored after all that the ordinary
//! numbers could explain has been taken out, the best are fitted with everything else, and the one that the
//! data make most probable is taken; then the next, until nothing is left that held-out data confirm.

mod answer;
#[cfg(test)]
mod bench;
mod candidates;
mod case;
pub mod chain;
mod conclusion;
mod correction;
mod course;
mod excerpt;
mod exogenous;
mod explanation;
mod finding;
mod fit;
mod learn;
mod locate;
mod long_recording;
mod model;
mod naming;
mod patches;
mod predict;
mod proof;
mod result;
mod select;
mod signs_and_swaps;
mod smooth;
mod split;
mod tuning;
mod verdict;

pub use case::{Answer, Case};
pub use model::{Chosen, Model};
pub use predict::Recording;
pub use result::{
    Block, ByChannel, CourseEstimate, Estimate, Explanation, Finding, Missing, Models, Parts, Ranked, Trace,
    Verdict, Where,
};
