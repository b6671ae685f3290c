//! The driver who holds a speed, and the anti-lock brake.

use serde::{Deserialize, Serialize};

use super::{Piece, Problem, positive};

/// `[driver]`: holds a speed with drive torque and brakes. Without it only the inputs act; while
/// `brake_pressure` or `brake_torque` of the scenario brakes, the driver gives no gas.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct DriverConfig {
    /// The speed wanted, m/s: pieces that are summed. Below zero counts as zero.
    pub speed_mps: Vec<Piece>,
    /// Acceleration per speed error, 1/s.
    #[serde(default = "default_gain")]
    pub gain_per_s: f64,
    /// Time in which the integral part does as much as the proportional one, s.
    #[serde(default = "default_integral_time")]
    pub integral_time_s: f64,
    /// Largest acceleration asked for, m/s².
    #[serde(default = "default_acceleration")]
    pub acceleration_max_mps2: f64,
    /// Largest deceleration asked for, m/s².
    #[serde(default = "default_deceleration")]
    pub deceleration_max_mps2: f64,
    /// Deceleration that the engine's drag gives before the brakes are used, m/s².
    #[serde(default = "default_engine_brake")]
    pub engine_brake_mps2: f64,
    /// Time constant of foot and engine, s.
    #[serde(default = "default_lag")]
    pub lag_s: f64,
    /// Where a driven wheel slips more than this, traction control (or the foot) takes drive torque away; without it wheels
    /// spin as long as the driver wants more.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub lets_go_at_slip: Option<f64>,
}

fn default_gain() -> f64 {
    0.8
}
fn default_integral_time() -> f64 {
    15.0
}
fn default_acceleration() -> f64 {
    2.5
}
fn default_deceleration() -> f64 {
    4.0
}
fn default_engine_brake() -> f64 {
    0.6
}
fn default_lag() -> f64 {
    0.2
}

impl DriverConfig {
    /// An ordinary driver who holds this speed.
    pub fn holding(speed_mps: Vec<Piece>) -> Self {
        Self {
            speed_mps,
            gain_per_s: default_gain(),
            integral_time_s: default_integral_time(),
            acceleration_max_mps2: default_acceleration(),
            deceleration_max_mps2: default_deceleration(),
            engine_brake_mps2: default_engine_brake(),
            lag_s: default_lag(),
            lets_go_at_slip: None,
        }
    }

    pub(super) fn validate(&self, problems: &mut Vec<Problem>) {
        if self.speed_mps.is_empty() {
            problems.push(Problem::new("driver.speed_mps", 0, "needs one piece or more"));
        }
        for (i, piece) in self.speed_mps.iter().enumerate() {
            piece.validate(&format!("driver.speed_mps[{i}]"), problems);
        }
        for (key, value) in [
            ("driver.gain_per_s", self.gain_per_s),
            ("driver.integral_time_s", self.integral_time_s),
            ("driver.acceleration_max_mps2", self.acceleration_max_mps2),
            ("driver.deceleration_max_mps2", self.deceleration_max_mps2),
            ("driver.lag_s", self.lag_s),
        ] {
            positive(problems, key, value);
        }
        if let Some(slip) = self.lets_go_at_slip {
            positive(problems, "driver.lets_go_at_slip", slip);
        }
        if !(self.engine_brake_mps2.is_finite() && self.engine_brake_mps2 >= 0.0) {
            problems.push(Problem::new(
                "driver.engine_brake_mps2",
                self.engine_brake_mps2,
                "must be zero or positive",
            ));
        }
    }
}

/// `[abs]`: an anti-lock brake that cycles each wheel's brake torque about the peak of its tire.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct AbsConfig {
    /// Slip, against that of the peak, at which the brake is released.
    #[serde(default = "default_release")]
    pub release_at_peak_slips: f64,
    /// Slip, against that of the peak, at which it is applied again.
    #[serde(default = "default_apply")]
    pub apply_at_peak_slips: f64,
    /// Rate of release, N m/s per wheel.
    #[serde(default = "default_release_rate")]
    pub release_nm_per_s: f64,
    /// Rate of application, N m/s per wheel.
    #[serde(default = "default_apply_rate")]
    pub apply_nm_per_s: f64,
    /// Below this speed the wheels may lock, m/s.
    #[serde(default = "default_abs_speed")]
    pub speed_min_mps: f64,
    /// How long after the last intervention `abs_active` stays, s.
    #[serde(default = "default_hold")]
    pub active_hold_s: f64,
}

fn default_release() -> f64 {
    2.0
}
fn default_apply() -> f64 {
    1.0
}
fn default_release_rate() -> f64 {
    10_000.0
}
fn default_apply_rate() -> f64 {
    2_500.0
}
fn default_abs_speed() -> f64 {
    2.0
}
fn default_hold() -> f64 {
    0.2
}

impl AbsConfig {
    pub(super) fn validate(&self, problems: &mut Vec<Problem>) {
        for (key, value) in [
            ("abs.release_at_peak_slips", self.release_at_peak_slips),
            ("abs.apply_at_peak_slips", self.apply_at_peak_slips),
            ("abs.release_nm_per_s", self.release_nm_per_s),
            ("abs.apply_nm_per_s", self.apply_nm_per_s),
            ("abs.speed_min_mps", self.speed_min_mps),
            ("abs.active_hold_s", self.active_hold_s),
        ] {
            positive(problems, key, value);
        }
        if self.apply_at_peak_slips > self.release_at_peak_slips {
            problems.push(Problem::new(
                "abs.apply_at_peak_slips",
                self.apply_at_peak_slips,
                "must not exceed release_at_peak_slips",
            ));
        }
    }
}
