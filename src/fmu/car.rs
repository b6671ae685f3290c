//! The car that an FMU is of: what lies in it as a resource.

use std::fmt::Write as _;

use physics::Quantity;
use physics::model::effect::{EffectConfig, EffectError};
use physics::model::{Scenario, ScenarioError, Uncertain, Vehicle};
use serde::{Deserialize, Serialize};
use thiserror::Error;

/// The longest drive, s: that of a scenario.
pub const LONGEST_S: f64 = 1e5;

/// What an FMU is of a car.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Part {
    /// The whole of it.
    #[default]
    Car,
    /// What its effects add to a plain car that somebody else simulates.
    Correction,
}

impl Part {
    // By reference, because serde asks so.
    fn is_car(&self) -> bool {
        *self == Self::Car
    }
}

/// A car with everything that was found of it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Car {
    /// What the FMU is called.
    pub name: String,
    /// What the FMU is of it.
    #[serde(default, skip_serializing_if = "Part::is_car")]
    pub part: Part,
    /// The plain car.
    pub vehicle: Vehicle,
    /// Physics beyond it, and errors of the sensors.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub effect: Vec<EffectConfig>,
}

/// A car that no FMU can be made of.
#[derive(Debug, Error)]
pub enum CarError {
    /// The resource is not one.
    #[error("{CAR_FILE} in the resources of the FMU: {0}")]
    Resource(#[from] toml::de::Error),
    /// It cannot be written as a resource.
    #[error("this car cannot be written into an FMU: {0}")]
    Unwritable(#[from] toml::ser::Error),
    /// Numbers that cannot be.
    #[error(transparent)]
    Values(#[from] ScenarioError),
    /// A number of an effect that cannot be.
    #[error(transparent)]
    Effect(#[from] EffectError),
}

/// Name of the resource.
pub const CAR_FILE: &str = "car.toml";

/// How a car is driven in an FMU.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Setting {
    /// Speed at the start, m/s.
    pub initial_speed_mps: f64,
    /// Steering wheel angle at the start, rad.
    pub initial_steering_rad: f64,
    /// Integration step, µs.
    pub step_us: u32,
    /// A driver holds the speed.
    pub holds_speed: bool,
}

impl Car {
    /// Reads the resource.
    ///
    /// # Errors
    /// What is wrong with it.
    pub fn parse(text: &str) -> Result<Self, CarError> {
        Ok(toml::from_str(text)?)
    }

    /// The resource.
    ///
    /// # Errors
    /// If a number of it cannot be written.
    pub fn text(&self) -> Result<String, CarError> {
        Ok(toml::to_string(self)?)
    }

    /// With a yaw inertia of its own: a parameter needs a value to start from.
    pub fn with_every_number(mut self) -> Self {
        let inertia = Uncertain::known(self.vehicle.yaw_inertia());
        self.vehicle.yaw_inertia_kgm2.get_or_insert(inertia);
        self
    }

    /// Has it a torque per bar of brake pressure?
    pub fn takes_pressure(&self) -> bool {
        let Vehicle { brake_torque_per_bar_front_nm: front, brake_torque_per_bar_rear_nm: rear, .. } =
            &self.vehicle;
        front.is_some() && rear.is_some()
    }

    /// What sensors can say of it.
    pub fn measured(&self) -> impl Iterator<Item = Quantity> + '_ {
        let is_there = |quantity: &Quantity| match quantity {
            Quantity::AbsActive => false,
            Quantity::BrakePressure => self.takes_pressure(),
            _ => true,
        };
        Quantity::ALL.into_iter().filter(is_there)
    }

    /// Where a `sensor_delay` makes a sensor early against the others, all are this late, s: none says what is yet to come.
    pub fn all_late_s(&self) -> f64 {
        let of = |quantity| {
            let delays = self.effect.iter().filter_map(|effect| effect.effect().delay());
            delays.filter(|(late, _)| *late == quantity).map(|(_, delay)| delay).sum::<f64>()
        };
        self.measured().map(|quantity| -of(quantity)).fold(0.0, f64::max)
    }

    /// The same car with other numbers: of `vehicle` by name, of each effect by its place.
    ///
    /// # Errors
    /// A number that cannot be.
    pub fn with_numbers(
        &self,
        vehicle: &[(&'static str, f64)],
        effects: &[(usize, usize, f64)],
    ) -> Result<Self, CarError> {
        let mut table = toml::Table::try_from(&self.vehicle)?;
        for (name, value) in vehicle {
            table.insert((*name).to_owned(), toml::Value::Float(*value));
        }
        let mut car = Self { vehicle: table.try_into()?, ..self.clone() };
        for (place, effect) in car.effect.iter_mut().enumerate() {
            let mut numbers = effect.numbers().to_vec();
            for (_, number, value) in effects.iter().filter(|(of, ..)| *of == place) {
                if let Some(of) = numbers.get_mut(*number) {
                    *of = Uncertain::known(*value);
                }
            }
            *effect = EffectConfig::new(effect.kind(), effect.channel(), numbers, effect.course().clone())?;
        }
        Ok(car)
    }

    /// The drive that is simulated: as `gripd simulate` would, with perfect sensors that read at every step.
    ///
    /// # Errors
    /// Values that cannot be, by key.
    pub fn scenario(&self, setting: &Setting) -> Result<Scenario, CarError> {
        let Setting { initial_speed_mps, initial_steering_rad, step_us, holds_speed } = *setting;
        let driver =
            if holds_speed { "[driver]\nspeed_mps = [{ kind = 'constant', value = 0.0 }]\n" } else { "" };
        let mut text = format!(
            "duration_s = {LONGEST_S:?}\ninitial_speed_mps = {initial_speed_mps:?}\n\
             steering_wheel_angle = [{{ kind = 'constant', value = {initial_steering_rad:?} }}]\n{driver}"
        );
        let late_ms = 1e3 * self.all_late_s();
        let period_ms = f64::from(step_us) * 1e-3;
        for quantity in self.measured() {
            // Writing to a string does not fail.
            let _ = write!(text, "[sensors.{quantity}]\nperiod_ms = {period_ms:?}\ndelay_ms = {late_ms:?}\n");
        }
        let mut table: toml::Table = toml::from_str(&text)?;
        table.insert("vehicle".to_owned(), toml::Table::try_from(&self.vehicle)?.into());
        let mut scenario: Scenario = table.try_into()?;
        scenario.effect.clone_from(&self.effect);
        scenario.step_us = step_us;
        // Rows are asked for, not made by the clock: any multiple of the step will do.
        scenario.truth_period_ms = step_us.max(1);
        scenario.validate()?;
        Ok(scenario)
    }
}
