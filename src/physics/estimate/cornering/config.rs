//! The `[estimators.cornering]` table.

use serde::{Deserialize, Serialize};

use crate::estimates::TOLD_RELATIVE_STD;

/// `[estimators.cornering]`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct CorneringConfig {
    /// Random walk of the cornering stiffnesses, relative to their value, 1/√s.
    pub stiffness_walk: f64,
    /// Unmodelled lateral acceleration (wind, unevenness), m/s²/√Hz.
    pub acceleration_noise: f64,
    /// Unmodelled slip angle (alignment, roll steer, dynamics of the tire), rad.
    pub slip_angle_noise: f64,
    /// Offset of the road wheel angle before anything is measured, rad.
    pub steering_offset_std: f64,
    /// Offset of the yaw rate sensor before anything is measured, rad/s.
    pub yaw_rate_offset_std: f64,
    /// Offset of the lateral accelerometer before anything is measured (mounting, bank), m/s².
    pub acceleration_offset_std: f64,
    /// Relative error of the speed from the wheels (worn, warm or unequal tires), on top of the
    /// wheel radius's own uncertainty.
    pub speed_scale_std: f64,
    /// Gravity's part along the road's cross slope (rms), m/s².
    pub bank_std: f64,
    /// How long a cross slope lasts, s.
    pub bank_time_s: f64,
    /// CUSUM: standard deviations forgiven at each window.
    pub cusum_drift: f64,
    /// CUSUM: standard deviations that must add up for a surface change.
    pub cusum_threshold: f64,
    /// Mean NIS above which the filter calls itself inconsistent.
    pub inconsistent_nis: f64,
    /// A stiffness counts as valid up to this relative standard deviation.
    pub valid_relative_std: f64,
    /// … and up to this age, s.
    pub valid_age_s: f64,
    /// The sideslip counts as valid up to this standard deviation, rad.
    pub valid_sideslip_std: f64,
}

impl Default for CorneringConfig {
    /// Physical are the offsets and the speed's error, as series sensors and tires have them, and the bank, as
    /// roads are built (2.5 % of cross fall). Statistical are drift and threshold of the CUSUM: with innovations
    /// that are white and normal one false alarm in 10⁹ windows, ten years and more of driving (Siegmund's formula,
    /// see [`Cusum`](crate::filter::Cusum)); and `inconsistent_nis`: no healthy filter comes near four over a
    /// hundred windows. The rest is tuned with the tests `campaign`, `long_drives` and `real_cars`.
    fn default() -> Self {
        Self {
            stiffness_walk: 0.012,
            acceleration_noise: 0.02,
            slip_angle_noise: 7e-4,
            steering_offset_std: 0.01,
            yaw_rate_offset_std: 0.01,
            acceleration_offset_std: 0.1,
            speed_scale_std: 0.01,
            bank_std: 0.25,
            bank_time_s: 20.0,
            cusum_drift: 1.0,
            cusum_threshold: 10.0,
            inconsistent_nis: 4.0,
            valid_relative_std: TOLD_RELATIVE_STD,
            valid_age_s: 60.0,
            valid_sideslip_std: 0.01,
        }
    }
}
