//! What a child is to do: the protocol between it and its parent.

use std::path::PathBuf;

use serde::{Deserialize, Serialize};

use super::description::Kind;

/// Runs of one FMU over the same inputs.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Job {
    /// FMI 3.0, not 2.0.
    pub is_three: bool,
    /// The library.
    pub library: PathBuf,
    /// The folder of the resources.
    pub resources: PathBuf,
    /// What the library wants to hear.
    pub token: String,
    /// The instance's name.
    pub name: String,
    /// Length of a step, s.
    pub step_s: f64,
    /// Steps of a run.
    pub steps: usize,
    /// How inputs go over a step.
    pub course: Course,
    /// What drives it.
    pub inputs: Vec<Line>,
    /// What is asked of it, at the start and after each step.
    pub outputs: Vec<(Kind, u32)>,
    /// The runs: what is set before each.
    pub runs: Vec<Run>,
}

/// How inputs go over a step.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Course {
    /// They are given with their rates, and go in straight lines.
    Rates,
    /// They hold what they are given: the middle between the step's ends.
    Hold,
    /// They are given for the step's end, and go there in straight lines.
    ToTheEnd,
}

/// One run.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub struct Run {
    /// Parameters.
    pub set: Vec<Value>,
}

/// A variable and a value.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Value {
    /// Its type.
    pub kind: Kind,
    /// The variable.
    pub reference: u32,
    /// The value; a switch is on where it is not zero.
    pub value: f64,
}

/// An input over time.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Line {
    /// Its type.
    pub kind: Kind,
    /// The variable.
    pub reference: u32,
    /// Its value at the start and at the end of each step.
    pub values: Vec<f64>,
}

/// Name of the file with the job, in the folder of the child.
pub(super) const JOB_FILE: &str = "job.json";
/// Rows of outputs, one run after the other: 8 bytes for each number, the lowest first.
pub(super) const ROWS_FILE: &str = "rows";
/// Why it failed.
pub(super) const REASON_FILE: &str = "reason";
