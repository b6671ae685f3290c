//! The compiled `[signals]` table: for each needed identifier, what to read from its frames.

use super::compile::Compiler;
use super::config::{QuantityConfig, SignalsConfig, micros};
use super::error::{Problems, SignalsError};
use super::limits::Limits;
use super::mapping::{Mapping, MessageInput};
use crate::can::CanId;
use crate::dbc::Database;
use physics::{Micros, Quantity};

/// What is read from which frame, and how each quantity is to be treated afterwards.
#[derive(Clone, Debug, PartialEq)]
pub struct Inputs {
    pub(super) messages: Vec<MessageInput>,
    pub(super) traits: [Option<Traits>; Quantity::COUNT],
    /// A configured quantity's place among the configured ones.
    pub(super) places: [u8; Quantity::COUNT],
    pub(super) wheel_radius_m: f64,
    ids: Vec<CanId>,
}

/// How a quantity is treated once it is a number.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Traits {
    pub(super) timeout: Micros,
    pub(super) delay: Micros,
    pub(super) interpolate: bool,
    pub(super) limits: Limits,
    pub(super) noise_std: f64,
}

impl Inputs {
    /// Compiles the mapping. `wheel_radius_m` turns circumferential into angular wheel speeds.
    ///
    /// # Errors
    /// All that is wrong with it: names that the DBC does not have, units that do not fit, keys that
    /// contradict each other, required quantities that are missing.
    pub fn compile(
        config: &SignalsConfig,
        database: &Database,
        wheel_radius_m: f64,
    ) -> Result<Self, SignalsError> {
        let mut problems = Problems::default();
        for lacking in Quantity::lacking(|quantity| config.quantities.contains_key(&quantity)) {
            if let [quantity] = lacking[..] {
                problems.add(
                    format!("signals.{quantity}"),
                    format!("is required; add {quantity} = \"MESSAGE.Signal\""),
                );
            } else {
                let names: Vec<_> = lacking.iter().map(|quantity| quantity.name()).collect();
                problems.add(
                    "signals",
                    format!("some speed is required; add one or more of {}", names.join(", ")),
                );
            }
        }
        check_sampling(config, &mut problems);
        let mut compiler = Compiler::new(database, wheel_radius_m, problems);
        let messages = compiler.messages(config);
        compiler.problems.finish()?;
        let mut traits = [None; Quantity::COUNT];
        for mapping in messages.iter().flat_map(|message| &message.mappings) {
            if let Some(quantity) = config.quantities.get(&mapping.quantity) {
                traits[mapping.quantity as usize] = Some(Traits::new(mapping, quantity, config));
            }
        }
        let mut places = [u8::MAX; Quantity::COUNT];
        let configured = (0..Quantity::COUNT).filter(|index| traits[*index].is_some());
        for (place, index) in configured.enumerate() {
            places[index] = place as u8;
        }
        let ids = messages.iter().map(|message| message.id).collect();
        Ok(Self { messages, traits, places, wheel_radius_m, ids })
    }

    /// The identifiers that are needed, ascending: standard ones first.
    pub fn ids(&self) -> &[CanId] {
        &self.ids
    }

    /// Is the quantity configured?
    pub fn has(&self, quantity: Quantity) -> bool {
        self.traits[quantity as usize].is_some()
    }

    /// Standard deviation of a configured quantity's noise, SI: as configured, else typical for such a
    /// sensor, quantization included.
    pub fn noise_std(&self, quantity: Quantity) -> Option<f64> {
        self.traits[quantity as usize].map(|traits| traits.noise_std)
    }

    /// What of the configured is [basic](Quantity::basic), as bits.
    pub fn basic(&self) -> u16 {
        let configured = Quantity::ALL.into_iter().filter(|quantity| self.has(*quantity));
        Quantity::basic(configured.fold(0, |bits, quantity| bits | quantity.bit()))
    }

    /// After so long without any frame nothing has a value that the estimators stand on.
    pub fn longest_timeout(&self) -> Micros {
        let basic = self.basic();
        let stood_on = Quantity::ALL.into_iter().filter(|quantity| basic & quantity.bit() != 0);
        let timeouts = stood_on.filter_map(|quantity| self.traits[quantity as usize]).map(|t| t.timeout);
        timeouts.max().unwrap_or_default()
    }

    /// The name in the DBC of the message that carries this identifier, if it is needed.
    pub fn message_name(&self, id: CanId) -> Option<&str> {
        let index = self.ids.binary_search(&id).ok()?;
        Some(&self.messages[index].name)
    }
}

impl Traits {
    fn new(mapping: &Mapping, config: &QuantityConfig, signals: &SignalsConfig) -> Self {
        let quantity = mapping.quantity;
        let typical = Limits::typical(quantity);
        let quantization = mapping.resolution() / 12f64.sqrt();
        Self {
            timeout: micros(config.timeout_ms.unwrap_or(signals.sampling.timeout_ms)),
            delay: micros(config.delay_ms),
            interpolate: config.interpolate.unwrap_or(!mapping.is_flag()),
            limits: Limits {
                min: config.min.unwrap_or(typical.min),
                max: config.max.unwrap_or(typical.max),
                rate_max: config.rate_max.unwrap_or(typical.rate_max),
            },
            noise_std: config.noise_std.unwrap_or_else(|| typical_noise(quantity).hypot(quantization)),
        }
    }
}

/// Noise of a production car's sensors, SI. Wheel speeds: tooth wheel errors included.
fn typical_noise(quantity: Quantity) -> f64 {
    match quantity {
        _ if quantity.wheel().is_some() => 0.05,
        Quantity::YawRate => 0.003,
        Quantity::LateralAcceleration | Quantity::LongitudinalAcceleration => 0.08,
        Quantity::SteeringWheelAngle => 0.002,
        Quantity::DriveTorque | Quantity::BrakeTorque => 5.0,
        Quantity::BrakePressure => 0.3,
        Quantity::VehicleSpeed => 0.05,
        _ => 0.0,
    }
}

fn check_sampling(config: &SignalsConfig, problems: &mut Problems) {
    let sampling = &config.sampling;
    for (key, value, low, high) in [
        ("period_ms", sampling.period_ms, 1.0, 100.0),
        ("lag_ms", sampling.lag_ms, 0.0, 1000.0),
        ("timeout_ms", sampling.timeout_ms, 1.0, 60_000.0),
        ("start_ms", sampling.start_ms, 0.0, 10_000.0),
    ] {
        if !(low..=high).contains(&value) {
            problems.add(
                format!("signals.sampling.{key}"),
                format!("{value} is not between {low} and {high} ms"),
            );
        }
    }
}
