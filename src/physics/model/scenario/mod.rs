//! A scenario: one drive, with the car, its driver, the road and the sensors, as a TOML text.

mod driver;
mod effects;
mod piece;
mod road;
mod sensors;
pub mod thesis;

use std::fmt;

use serde::{Deserialize, Serialize};
use thiserror::Error;

pub use driver::{AbsConfig, DriverConfig};
pub use piece::Piece;
pub use road::{Side, Stretch};
pub use sensors::{ClockConfig, SensorConfig, SensorsConfig, ToothWheelConfig};

use super::effect::EffectConfig;
use super::integrate::MAX_SUBSTEPS;
use super::{Plant, State, Vehicle};

/// One drive. All inputs are lists of [`Piece`]s that are summed.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Scenario {
    /// What it shows.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub description: String,
    /// Length of the drive, s.
    pub duration_s: f64,
    /// Speed at the start, m/s, rolling freely straight ahead; negative in reverse.
    pub initial_speed_mps: f64,
    /// Seed of all that is random, where none is given otherwise.
    #[serde(default)]
    pub seed: u64,
    /// Integration step, µs; each is divided further as the wheels need.
    #[serde(default = "default_step")]
    pub step_us: u32,
    /// Time between rows of truth, ms.
    #[serde(default = "default_truth_period")]
    pub truth_period_ms: u32,
    /// The car.
    pub vehicle: Vehicle,
    /// Each wheel's radius against `vehicle.wheel_radius_m`, e.g. 0.015: 1.5 % larger.
    #[serde(default)]
    pub radius_difference: WheelNumbers,
    /// Angle at the steering wheel, rad; the front wheels turn by it / `steering_ratio`.
    #[serde(default)]
    pub steering_wheel_angle: Vec<Piece>,
    /// Drive torque of all driven wheels together, N m, added to the driver's.
    #[serde(default)]
    pub drive_torque: Vec<Piece>,
    /// Brake torque of all wheels together, N m, added to the driver's and the pressure's. It is
    /// shared as brake pressure is, or, where the vehicle has no torque per bar, by static load.
    #[serde(default)]
    pub brake_torque: Vec<Piece>,
    /// Brake pressure, bar.
    #[serde(default)]
    pub brake_pressure: Vec<Piece>,
    /// Holds a speed.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub driver: Option<DriverConfig>,
    /// Keeps the wheels from locking.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub abs: Option<AbsConfig>,
    /// Surfaces one after the other; before the first one the vehicle's own.
    #[serde(default)]
    pub road: Vec<Stretch>,
    /// Physics beyond the plain model.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub effect: Vec<EffectConfig>,
    /// What is measured, and how well.
    #[serde(default)]
    pub sensors: SensorsConfig,
    /// How readings are stamped.
    #[serde(default)]
    pub clock: ClockConfig,
}

/// A number for each wheel, zero where none is given.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct WheelNumbers {
    /// Front left.
    #[serde(default)]
    pub fl: f64,
    /// Front right.
    #[serde(default)]
    pub fr: f64,
    /// Rear left.
    #[serde(default)]
    pub rl: f64,
    /// Rear right.
    #[serde(default)]
    pub rr: f64,
}

impl WheelNumbers {
    /// In the order of [`crate::Wheel::ALL`].
    pub fn to_array(self) -> [f64; 4] {
        [self.fl, self.fr, self.rl, self.rr]
    }
}

fn default_step() -> u32 {
    1000
}
fn default_truth_period() -> u32 {
    10
}

/// One value of a scenario that cannot be.
#[derive(Clone, Debug, PartialEq)]
pub struct Problem {
    /// The key, e.g. `road[2].friction`.
    pub key: String,
    /// Its value; empty where the key itself is wrong.
    pub value: String,
    /// What would be accepted.
    pub reason: String,
}

impl Problem {
    fn new(key: impl Into<String>, value: impl ToString, reason: impl Into<String>) -> Self {
        Self { key: key.into(), value: value.to_string(), reason: reason.into() }
    }
}

impl fmt::Display for Problem {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.value.is_empty() {
            write!(f, "{}: {}", self.key, self.reason)
        } else {
            write!(f, "{} = {}: {}", self.key, self.value, self.reason)
        }
    }
}

/// A scenario that cannot be driven.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum ScenarioError {
    /// The text is no TOML, or has unknown, missing or mistyped keys.
    #[error("{0}")]
    Toml(#[from] toml::de::Error),
    /// Values that cannot be, all of them.
    #[error("{}", list(.0))]
    Values(Vec<Problem>),
}

fn list(problems: &[Problem]) -> String {
    problems.iter().map(ToString::to_string).collect::<Vec<_>>().join("\n")
}

fn finite(problems: &mut Vec<Problem>, key: &str, value: f64) {
    if !value.is_finite() {
        problems.push(Problem::new(key, value, "must be a finite number"));
    }
}

fn positive(problems: &mut Vec<Problem>, key: &str, value: f64) {
    if !(value.is_finite() && value > 0.0) {
        problems.push(Problem::new(key, value, "must be positive"));
    }
}

impl Scenario {
    /// Reads and checks a scenario.
    ///
    /// # Errors
    /// What is wrong with the text (line and column), or all values that cannot be (by key).
    pub fn parse(text: &str) -> Result<Self, ScenarioError> {
        let scenario: Self = toml::from_str(text)?;
        scenario.validate()?;
        Ok(scenario)
    }

    /// Checks every value.
    ///
    /// # Errors
    /// All values that cannot be, by key.
    pub fn validate(&self) -> Result<(), ScenarioError> {
        let mut problems = Vec::new();
        if let Err(error) = self.vehicle.validate() {
            problems.push(Problem::new(format!("vehicle.{}", error.key), error.value, error.reason));
        }
        if self.vehicle.tire_file.is_some() {
            let reason = "is read in a car's configuration only; give the tires' numbers here";
            problems.push(Problem::new("vehicle.tire_file", "", reason));
        }
        self.validate_times(&mut problems);
        for (key, pieces) in [
            ("steering_wheel_angle", &self.steering_wheel_angle),
            ("drive_torque", &self.drive_torque),
            ("brake_torque", &self.brake_torque),
            ("brake_pressure", &self.brake_pressure),
        ] {
            for (i, piece) in pieces.iter().enumerate() {
                piece.validate(&format!("{key}[{i}]"), &mut problems);
            }
        }
        for (name, difference) in ["fl", "fr", "rl", "rr"].iter().zip(self.radius_difference.to_array()) {
            if !(-0.5..=0.5).contains(&difference) {
                let key = format!("radius_difference.{name}");
                problems.push(Problem::new(key, difference, "must be -0.5 to 0.5"));
            }
        }
        let has_pressure = self.vehicle.brake_torque_per_bar_front_nm.is_some()
            && self.vehicle.brake_torque_per_bar_rear_nm.is_some();
        let used = [
            ("brake_pressure", !self.brake_pressure.is_empty()),
            ("sensors.brake_pressure", self.sensors.by_name.contains_key("brake_pressure")),
        ];
        for (key, _) in used.into_iter().filter(|(_, used)| *used && !has_pressure) {
            let reason = "needs vehicle.brake_torque_per_bar_front_nm and …_rear_nm; or use brake_torque";
            problems.push(Problem::new(key, "", reason));
        }
        if let Some(driver) = &self.driver {
            driver.validate(&mut problems);
        }
        if let Some(abs) = &self.abs {
            abs.validate(&mut problems);
        }
        for (i, stretch) in self.road.iter().enumerate() {
            stretch.validate(&format!("road[{i}]"), &mut problems);
            if i > 0 && stretch.from_s < self.road[i - 1].from_s {
                let key = format!("road[{i}].from_s");
                problems.push(Problem::new(key, stretch.from_s, "must not be before the stretch above"));
            }
        }
        self.sensors.validate(&mut problems);
        self.clock.validate(&mut problems);
        self.validate_effects(&mut problems);
        if problems.is_empty() {
            self.validate_stiffness(&mut problems);
        }
        if problems.is_empty() { Ok(()) } else { Err(ScenarioError::Values(problems)) }
    }

    fn validate_times(&self, problems: &mut Vec<Problem>) {
        if !(self.duration_s > 0.0 && self.duration_s <= 1e5) {
            problems.push(Problem::new("duration_s", self.duration_s, "must be positive, at most 1e5"));
        }
        if !(-100.0..=100.0).contains(&self.initial_speed_mps) {
            let value = self.initial_speed_mps;
            problems.push(Problem::new("initial_speed_mps", value, "must be -100 to 100"));
        }
        if !(10..=10_000).contains(&self.step_us) {
            problems.push(Problem::new("step_us", self.step_us, "must be 10 to 10000"));
        } else if !(1..=10_000).contains(&self.truth_period_ms)
            || !(self.truth_period_ms * 1000).is_multiple_of(self.step_us)
        {
            problems.push(Problem::new(
                "truth_period_ms",
                self.truth_period_ms,
                "must be 1 to 10000 and a multiple of step_us",
            ));
        }
    }

    /// The wheels must not be faster than the integration can follow.
    fn validate_stiffness(&self, problems: &mut Vec<Problem>) {
        let plant = Plant::new(&self.vehicle);
        let standing = State::rolling(&plant, 0.0).velocity;
        let stiffest = self
            .road
            .iter()
            .flat_map(|stretch| [stretch.side(true), stretch.side(false)])
            .map(|side| {
                let own = plant.nominal.contact[0].stiffness_x.min(plant.nominal.contact[2].stiffness_x);
                side.slope.map_or(side.longitudinal_factor.unwrap_or(1.0), |slope| slope / own)
            })
            .fold(1.0, f64::max);
        let stiffest = stiffest * self.stiffer_by_effects();
        let rate = stiffest * plant.fastest_rate(&standing, &plant.nominal);
        let most = f64::from(MAX_SUBSTEPS) / (f64::from(self.step_us) * 1e-6);
        if rate > most {
            problems.push(Problem::new(
                "vehicle.wheel_inertia_kgm2",
                self.vehicle.wheel_inertia_kgm2.value,
                format!(
                    "too small for the longitudinal stiffness: the wheel would settle within {:.1e} s at \
                     standstill, {:.1e} s is the least",
                    1.0 / rate,
                    1.0 / most
                ),
            ));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const PLAIN: &str = r#"
        duration_s = 10
        initial_speed_mps = 20
        [vehicle]
        mass_kg = 1500
        wheelbase_m = 2.7
        cg_to_front_m = 1.2
        wheel_radius_m = 0.31
        steering_ratio = 15
        driven_axle = "front"
    "#;

    fn keys(text: &str) -> Vec<String> {
        match Scenario::parse(text) {
            Err(ScenarioError::Values(problems)) => problems.into_iter().map(|p| p.key).collect(),
            other => panic!("{other:?}"),
        }
    }

    #[test]
    fn the_least_scenario_is_a_car_rolling() {
        let scenario = Scenario::parse(PLAIN).unwrap();
        assert_eq!(scenario.step_us, 1000);
        assert!(scenario.sensors.by_name.is_empty());
    }

    #[test]
    fn unknown_keys_are_named_with_their_line() {
        let error = Scenario::parse(&format!("{PLAIN}\n[[road]]\nfriktion = 1.0")).unwrap_err().to_string();
        assert!(error.contains("friktion") && error.contains("line"), "{error}");
    }

    #[test]
    fn every_wrong_value_is_named() {
        let text = format!(
            "{PLAIN}
            [[road]]
            friction = -1
            [[road]]
            from_s = -5
            [road.left]
            slope = nan
            [[steering_wheel_angle]]
            kind = \"points\"
            points = [[1, 0], [0, 1]]
            [[brake_pressure]]
            kind = \"constant\"
            value = 10
            [sensors.yaw_rate]
            period_ms = 0
            [sensors.yaw]
            period_ms = 10"
        );
        assert_eq!(
            keys(&text),
            [
                "steering_wheel_angle[0].points[1]",
                "brake_pressure",
                "road[0].friction",
                "road[1].left.slope",
                "road[1].from_s",
                "sensors.yaw",
                "sensors.yaw_rate.period_ms",
            ]
        );
    }

    #[test]
    fn a_wheel_too_light_to_integrate_is_refused() {
        let text = format!("{PLAIN}\nwheel_inertia_kgm2 = 1e-4");
        assert_eq!(keys(&text), ["vehicle.wheel_inertia_kgm2"]);
    }
}
