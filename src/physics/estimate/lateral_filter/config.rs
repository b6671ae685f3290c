//! The filter's tuning numbers.

use serde::{Deserialize, Serialize};

/// `[estimators.lateral_filter]`. Walks are relative to the value, 1/√s; standard deviations of stiffness
/// and friction are those of their logarithm.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct LateralFilterConfig {
    /// Walk of surface and tires while nothing happens.
    pub steady_walk: f64,
    /// Walk common to stiffnesses and friction that the agile hypothesis allows: the surface.
    pub agile_surface_walk: f64,
    /// … and of each of them on its own.
    pub agile_own_walk: f64,
    /// Evidence (ln of the likelihood ratio) from which the agile hypothesis is believed: a change of surface.
    pub change_evidence: f64,
    /// What a change leaves open of the surface's common factor, on top of what the agile hypothesis knows.
    pub change_surface_std: f64,
    /// … and of each parameter's own.
    pub change_own_std: f64,
    /// Friction assumed before anything is known.
    pub initial_friction: f64,
    /// … and its standard deviation.
    pub initial_friction_std: f64,
    /// Unmodelled lateral acceleration (wind, unevenness), m/s²/√Hz.
    pub acceleration_noise: f64,
    /// Unmodelled yaw acceleration, rad/s²/√Hz.
    pub yaw_noise: f64,
    /// Steering may be this much livelier (spectral density) than it seems: smoothing that lags costs
    /// more than noise.
    pub steering_margin: f64,
    /// Offset of the road wheel angle before anything is measured, rad.
    pub steering_offset_std: f64,
    /// Offset of the yaw rate sensor before anything is measured, rad/s.
    pub yaw_rate_offset_std: f64,
    /// Offset of the lateral accelerometer before anything is measured, m/s².
    pub acceleration_offset_std: f64,
    /// Gravity's part along the road's cross slope (rms), m/s².
    pub bank_std: f64,
    /// How long a cross slope lasts, s.
    pub bank_time_s: f64,
    /// Readings that the learned noise remembers.
    pub noise_memory: f64,
    /// Mean NIS above which the filter calls itself inconsistent.
    pub inconsistent_nis: f64,
}

impl Default for LateralFilterConfig {
    /// Tuned with the test `sim2_joint`.
    fn default() -> Self {
        Self {
            steady_walk: 0.002,
            agile_surface_walk: 0.3,
            agile_own_walk: 0.03,
            change_evidence: 20.0,
            change_surface_std: 0.3,
            change_own_std: 0.03,
            initial_friction: 0.9,
            initial_friction_std: 0.3,
            acceleration_noise: 0.01,
            yaw_noise: 0.003,
            steering_margin: 2.0,
            steering_offset_std: 0.01,
            yaw_rate_offset_std: 0.01,
            acceleration_offset_std: 0.1,
            bank_std: 0.15,
            bank_time_s: 20.0,
            noise_memory: 1000.0,
            inconsistent_nis: 4.0,
        }
    }
}

/// Relative walks of the tires' parameters, variance per second.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Walk {
    /// Common to both stiffnesses and the friction: the surface.
    pub common: f64,
    /// Of each stiffness on its own.
    pub stiffness: f64,
    /// Of the friction on its own.
    pub friction: f64,
}

impl LateralFilterConfig {
    /// For simulations as the thesis has them: a flat road, no wind, nothing unmodelled.
    pub fn ideal_road() -> Self {
        Self { acceleration_noise: 0.003, yaw_noise: 0.001, bank_std: 0.02, ..Self::default() }
    }

    pub(super) fn steady(&self) -> Walk {
        let v = self.steady_walk * self.steady_walk;
        Walk { common: v, stiffness: v, friction: v }
    }

    pub(super) fn agile(&self) -> Walk {
        let own = self.agile_own_walk * self.agile_own_walk;
        Walk { common: self.agile_surface_walk * self.agile_surface_walk, stiffness: own, friction: own }
    }
}
