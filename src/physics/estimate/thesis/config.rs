//! The tables of `[estimators]` that only the thesis's estimators read.

use serde::{Deserialize, Serialize};

use crate::estimates::LateralVelocities;

/// One of the ways to the lateral velocity.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum LateralVelocitySource {
    /// v_y = 0.
    Zero,
    /// Method 1.
    Integration,
    /// Method 2.
    Kinematic,
    /// Method 3.
    Bicycle,
    /// The joint filter.
    Joint,
}

impl LateralVelocitySource {
    /// The velocity by this way, m/s.
    pub fn of(self, velocities: &LateralVelocities) -> Option<f64> {
        match self {
            Self::Zero => velocities.zero,
            Self::Integration => velocities.integration,
            Self::Kinematic => velocities.kinematic,
            Self::Bicycle => velocities.bicycle,
            Self::Joint => velocities.joint,
        }
    }
}

/// `[estimators.joint_ekf]`: thesis (5.21).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct JointEkfConfig {
    /// Random walk of C_y, relative to its prior, 1/√s.
    pub stiffness_walk: f64,
    /// Process noise of v_y, m/s²/√Hz.
    pub lateral_noise: f64,
    /// Process noise of r, rad/s²/√Hz.
    pub yaw_noise: f64,
}

impl Default for JointEkfConfig {
    /// Tuned with the test `thesis_lateral`: the thesis does not tell its own.
    fn default() -> Self {
        Self { stiffness_walk: 0.01, lateral_noise: 0.1, yaw_noise: 0.05 }
    }
}
