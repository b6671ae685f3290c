//! The road: what the surface does to the tires, over time.

use serde::{Deserialize, Serialize};

use super::{Problem, finite, positive};

/// A stretch of road, from `from_s` until the next one begins.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Stretch {
    /// When it begins, s.
    #[serde(default)]
    pub from_s: f64,
    /// Time over which the surface goes over into this one, s.
    #[serde(default)]
    pub transition_s: f64,
    /// What it is, for plots and reports.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub name: String,
    /// Both sides, where `left` and `right` do not say otherwise.
    #[serde(flatten)]
    pub both: SurfaceToml,
    /// The left wheels' side.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub left: Option<Side>,
    /// The right wheels' side.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub right: Option<Side>,
}
