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
    /// over that of what it does beside them, by channel; 1 at most.
    pub interplay: ByChannel,
    /// What a model without it does wrong.
    pub without: Without,
}

/// What a model does wrong that lacks something: as numbers for a sentence.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Without {
    /// By how much its yaw rate is off; none where the car slides off the road without the finding.
    pub yaw_rate: Option<OffBy>,
    /// Hard turns of this drive: their mean lateral acceleration, m/s² …
    pub turning_mps2: f64,
    /// … and speed, m/s.
    pub turning_at_mps: f64,
    /// Side forces there that are too large without it, at the same motion and steering, as a share; by tire (`front_outer`,
    /// `front_inner`, `rear_outer`, `rear_inner`) and axle (`front`, `rear`).
    pub too_much_side_force: BTreeMap<String, f64>,
}

/// By how much a yaw rate is off.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct OffBy {
    /// Root mean square, rad/s.
    pub rms: f64,
    /// The most, rad/s …
    pub most: f64,
    /// … and when, s from the recording's start.
    pub most_at_s: f64,
}
