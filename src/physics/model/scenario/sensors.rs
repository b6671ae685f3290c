//! What each sensor makes of the truth.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use super::{Problem, finite, positive};
use crate::{Quantity, Sensors};

/// The group name that stands for all four wheel speeds.
const WHEELS: &str = "wheel_speed";

/// `[sensors]`: a table for each quantity that is measured, by its name; `wheel_speed` stands for
/// all four wheels, a single wheel's own table replaces it.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(transparent)]
pub struct SensorsConfig {
    /// By name.
    pub by_name: BTreeMap<String, SensorConfig>,
}

/// One sensor: value = quantised(gain · truth(t − delay) + offset + noise).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SensorConfig {
    /// Time between readings.
    pub period_ms: f64,
    /// Time of the first reading.
    #[serde(default)]
    pub phase_ms: f64,
    /// Standard deviation of white noise, SI.
    #[serde(default)]
    pub noise_std: f64,
    /// Step of the value, SI; zero: none.
    #[serde(default)]
    pub quantum: f64,
    /// Added constant, SI.
    #[serde(default)]
    pub offset: f64,
    /// Factor.
    #[serde(default = "default_gain")]
    pub gain: f64,
    /// Age of what is measured.
    #[serde(default)]
    pub delay_ms: f64,
    /// Wheel speeds only: measured by the pulses of a tooth wheel.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub tooth_wheel: Option<ToothWheelConfig>,
}

/// A tooth wheel: the time between pulses gives the speed.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ToothWheelConfig {
    /// Teeth on the circumference.
    #[serde(default = "default_teeth")]
    pub teeth: u32,
    /// Standard deviation of the place of each tooth, as a share of the pitch; fixed for a seed.
    #[serde(default = "default_pitch_error")]
    pub pitch_error_std: f64,
    /// The speed is that of the pulses of at least this time: half of it late.
    #[serde(default = "default_window")]
    pub window_ms: f64,
    /// Without a pulse for this long the speed is zero.
    #[serde(default = "default_standstill")]
    pub standstill_ms: f64,
}

fn default_gain() -> f64 {
    1.0
}
fn default_teeth() -> u32 {
    48
}
fn default_pitch_error() -> f64 {
    0.01
}
fn default_window() -> f64 {
    10.0
}
fn default_standstill() -> f64 {
    500.0
}

/// `[clock]`: how the stamps of the readings differ from true time.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ClockConfig {
    /// The stamping clock runs this much too fast.
    #[serde(default)]
    pub skew_ppm: f64,
    /// Readings come late by the absolute value of a normal variable of this standard deviation, as
    /// frames that wait for the bus. Sensors of the same period and phase are late together.
    #[serde(default)]
    pub jitter_std_ms: f64,
}

/// Longest delay of a sensor, ms.
pub const DELAY_MAX_MS: f64 = 2000.0;

impl SensorsConfig {
    /// The sensor of a quantity, if it is measured.
    pub fn get(&self, quantity: Quantity) -> Option<&SensorConfig> {
        let own = self.by_name.get(quantity.name());
        if quantity.wheel().is_some() { own.or_else(|| self.by_name.get(WHEELS)) } else { own }
    }

    /// What is measured, and how noisy, as a data sheet would promise it.
    pub fn promised(&self) -> Sensors {
        let mut sensors = Sensors::default();
        for quantity in Quantity::ALL {
            if let Some(config) = self.get(quantity) {
                sensors.add(quantity, (config.noise_std > 0.0).then_some(config.noise_std));
            }
        }
        sensors
    }

    pub(super) fn validate(&self, problems: &mut Vec<Problem>) {
        for (name, sensor) in &self.by_name {
            let quantity = name.parse::<Quantity>();
            let is_wheel = name == WHEELS || quantity.as_ref().is_ok_and(|q| q.wheel().is_some());
            if let (Err(reason), false) = (quantity, is_wheel) {
                problems.push(Problem::new(format!("sensors.{name}"), "", reason));
            }
            sensor.validate(&format!("sensors.{name}"), is_wheel, problems);
        }
    }
}

impl SensorConfig {
    fn validate(&self, key: &str, is_wheel: bool, problems: &mut Vec<Problem>) {
        if !(1.0..=10_000.0).contains(&self.period_ms) {
            problems.push(Problem::new(format!("{key}.period_ms"), self.period_ms, "must be 1 to 10000"));
        }
        for (name, value) in [
            ("phase_ms", self.phase_ms),
            ("noise_std", self.noise_std),
            ("quantum", self.quantum),
            ("delay_ms", self.delay_ms),
        ] {
            if !(value.is_finite() && value >= 0.0) {
                problems.push(Problem::new(format!("{key}.{name}"), value, "must be zero or positive"));
            }
        }
        if self.delay_ms > DELAY_MAX_MS {
            problems.push(Problem::new(format!("{key}.delay_ms"), self.delay_ms, "must be at most 2000"));
        }
        finite(problems, &format!("{key}.offset"), self.offset);
        finite(problems, &format!("{key}.gain"), self.gain);
        let Some(tooth_wheel) = &self.tooth_wheel else { return };
        let key = format!("{key}.tooth_wheel");
        if !is_wheel {
            problems.push(Problem::new(key.clone(), "", "is for wheel speeds only"));
        }
        if !(4..=512).contains(&tooth_wheel.teeth) {
            problems.push(Problem::new(format!("{key}.teeth"), tooth_wheel.teeth, "must be 4 to 512"));
        }
        if !(0.0..=0.1).contains(&tooth_wheel.pitch_error_std) {
            let value = tooth_wheel.pitch_error_std;
            problems.push(Problem::new(format!("{key}.pitch_error_std"), value, "must be 0 to 0.1"));
        }
        if tooth_wheel.window_ms > 100.0 {
            let value = tooth_wheel.window_ms;
            problems.push(Problem::new(format!("{key}.window_ms"), value, "must be at most 100"));
        }
        positive(problems, &format!("{key}.window_ms"), tooth_wheel.window_ms);
        positive(problems, &format!("{key}.standstill_ms"), tooth_wheel.standstill_ms);
    }
}

impl ClockConfig {
    pub(super) fn validate(&self, problems: &mut Vec<Problem>) {
        if !(-10_000.0..=10_000.0).contains(&self.skew_ppm) {
            problems.push(Problem::new("clock.skew_ppm", self.skew_ppm, "must be -10000 to 10000"));
        }
        if !(0.0..=100.0).contains(&self.jitter_std_ms) {
            problems.push(Problem::new("clock.jitter_std_ms", self.jitter_std_ms, "must be 0 to 100"));
        }
    }
}
