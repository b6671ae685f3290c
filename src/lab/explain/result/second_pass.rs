//! What was found beside somebody's simulation, looked at again with all the rest of it in both runs.

use std::collections::BTreeMap;

use serde::Serialize;

use super::{ByChannel, Estimate};

/// A finding in the second pass. Its numbers there are those of the finding.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct SecondPass {
    /// Its numbers as they were when it was found, before what was found after it.
    pub first_parameters: BTreeMap<String, Estimate>,
    /// Names of those that moved by more than the uncertainty of both passes.
    pub moved: Vec<String>,
    /// Twice the logarithm of the odds for it, the others being there.
    pub evidence: f64,
    /// By how much held-out squared errors fall with it, the others being there, as a share of the simulation's, by channel.
    pub explained_share: ByChannel,
    /// Of what it does, how much is due to the others: root mean square of what it does beside them less what it does alone,
    /// over that of what it does beside them, by channel.
    pub interplay: ByChannel,
    /// What a model without it does wrong.
    pub without: Without,
}

/// What a model does wrong that lacks something: as numbers for a sentence.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Without {
    /// Root mean square of what it changes in the yaw rate, rad/s.
    pub yaw_rate_rms: f64,
    /// The most that it changes there, rad/s …
    pub yaw_rate_most: f64,
    /// … and when, s from the recording's start.
    pub yaw_rate_most_at: f64,
    /// The same root mean square of the lateral acceleration, m/s²; of a recording without one nothing.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub lateral_rms: Option<f64>,
    /// Hard turns of this drive: their mean lateral acceleration, m/s² …
    pub turning_mps2: f64,
    /// … and speed, m/s.
    pub turning_at_mps: f64,
    /// Side forces there that are too large without it, at the same motion and steering, as a share; by tire (`front_outer`,
    /// `front_inner`, `rear_outer`, `rear_inner`) and axle (`front`, `rear`).
    pub too_much_side_force: BTreeMap<String, f64>,
}
