//! The configuration as the service would use it: the mapping, what is missing, what is published.

use std::path::Path;

use serde::Serialize;

use bus::Config;
use bus::can::CanId;
use bus::dbc::{Database, Warning};
use bus::signals::publish::Publisher;
use bus::signals::{Inputs, SignalsConfig};
use physics::Quantity;
use physics::estimate::PlainReadings;
use physics::model::effect::EffectConfig;

/// Everything about a usable configuration.
#[derive(Debug, Serialize)]
pub struct ConfigurationReport {
    /// The file.
    pub file: String,
    /// Interface frames would come from.
    pub interface: String,
    /// Every configured quantity.
    pub quantities: Vec<QuantityReport>,
    /// Optional quantities that are not configured.
    pub missing: Vec<Missing>,
    /// What is suspicious in `[signals]`.
    pub mapping_warnings: Vec<String>,
    /// What of the needed messages could not be used.
    pub dbc_warnings: Vec<String>,
    /// Warnings about messages that are not needed.
    pub other_dbc_warnings: usize,
    /// The first of these.
    pub first_other_dbc_warning: Option<String>,
    /// What the output DBC lacks or has in vain.
    pub publish_warnings: Vec<String>,
    /// Frames that will be published.
    pub published: Vec<Published>,
    /// Time between two rounds of published frames, ms.
    pub publish_period_ms: u32,
    /// The `[[effect]]` tables of the configuration.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub effects: Vec<EffectReport>,
    /// `[vehicle]` keys that are not given, with the value used instead.
    pub vehicle_defaults: Vec<VehicleDefault>,
}

/// One `[[effect]]` table.
#[derive(Debug, Serialize)]
pub struct EffectReport {
    /// Its kind, with the channel if it has one.
    pub effect: String,
    /// Is it taken out of the readings before anything is told of them?
    pub taken_out: bool,
}

/// One quantity's way from the bus.
#[derive(Debug, Serialize)]
pub struct QuantityReport {
    /// Its name.
    pub quantity: &'static str,
    /// `MESSAGE.Signal`, several of them joined by ` + `.
    pub source: String,
    /// The message's identifier.
    pub id: String,
    /// Unit in the DBC (or in the configuration).
    pub unit: String,
    /// Unit inside.
    pub si_unit: &'static str,
    /// SI per unit, gain included.
    pub to_si: f64,
    /// Added afterwards, SI.
    pub offset: f64,
    /// One raw step, SI.
    pub resolution: f64,
    /// What the bits can carry, SI.
    pub carried: [f64; 2],
    /// What is taken for plausible, SI.
    pub plausible: [f64; 2],
    /// Age of a value when its frame comes, ms.
    pub delay_ms: f64,
    /// Older than this it is absent, ms.
    pub timeout_ms: f64,
    /// Standard deviation of the noise, SI.
    pub noise_std: f64,
    /// A counter is watched.
    pub counter: bool,
    /// A checksum is verified.
    pub checksum: bool,
}

/// An optional quantity that is not configured.
#[derive(Debug, Serialize)]
pub struct Missing {
    /// Its name.
    pub quantity: &'static str,
    /// What is lost without it.
    pub cost: &'static str,
}

/// A frame that will be published.
#[derive(Debug, Serialize)]
pub struct Published {
    /// The message.
    pub message: String,
    /// Its identifier.
    pub id: String,
}

/// A value that nobody gave.
#[derive(Debug, Serialize)]
pub struct VehicleDefault {
    /// The key.
    pub key: &'static str,
    /// What is used.
    pub value: f64,
    /// How uncertain it is.
    pub std: f64,
}

/// A configuration's parts, ready to use.
pub struct Parts {
    /// The mapping.
    pub inputs: Inputs,
    /// What is published.
    pub publisher: Publisher,
    /// The car's DBC files.
    pub database: Database,
    /// The layout of what is published.
    pub output: Database,
}

impl Parts {
    /// Builds everything the service would.
    ///
    /// # Errors
    /// All that is wrong, one string for each problem.
    pub fn build(config: &Config, path: &Path) -> Result<Self, Vec<String>> {
        let mut problems = Vec::new();
        let place = path.display();
        let database = config.input_database().map_err(|e| problems.push(format!("{place}: dbc.input: {e}")));
        let output = config.output_database().map_err(|e| problems.push(format!("{place}: dbc.output: {e}")));
        let radius = config.vehicle.wheel_radius_m.value;
        let inputs = database.as_ref().ok().and_then(|database| {
            Inputs::compile(&config.signals, database, radius)
                .map_err(|e| problems.extend(e.problems.iter().map(|p| format!("{place}: {p}"))))
                .ok()
        });
        let publisher = output.as_ref().ok().and_then(|output| {
            Publisher::new(output, &config.publish)
                .map_err(|e| problems.extend(e.0.iter().map(|p| format!("{place}: {p}"))))
                .ok()
        });
        if let (Some(inputs), Some(publisher)) = (&inputs, &publisher) {
            for id in publisher.ids().iter().filter(|id| inputs.ids().contains(id)) {
                problems.push(format!(
                    "{place}: publish: identifier {id} is needed as an input and would be published, too: \
                     give the message another one in [publish.ids]"
                ));
            }
        }
        if let Some(database) = database.as_ref().ok().filter(|_| !problems.is_empty()) {
            // What was not found may stand in a line that was not understood.
            problems.extend(
                database.warnings().iter().take(3).map(|warning| format!("{place}: dbc.input: {warning}")),
            );
        }
        match (inputs, publisher, database, output) {
            (Some(inputs), Some(publisher), Ok(database), Ok(output)) if problems.is_empty() => {
                Ok(Self { inputs, publisher, database, output })
            }
            _ => Err(problems),
        }
    }

    /// Describes it.
    pub fn report(&self, config: &Config, path: &Path) -> ConfigurationReport {
        let quantities = Quantity::ALL.into_iter().filter_map(|q| self.quantity(config, q)).collect();
        let missing = Quantity::ALL
            .into_iter()
            .filter(|q| !self.inputs.has(*q))
            .map(|q| Missing { quantity: q.name(), cost: cost(q) })
            .collect();
        let (needed, others): (Vec<&Warning>, Vec<&Warning>) =
            self.database.warnings().iter().partition(|warning| self.concerns_input(warning));
        ConfigurationReport {
            file: path.display().to_string(),
            interface: config.bus.interface.clone(),
            quantities,
            missing,
            mapping_warnings: used_twice(&config.signals),
            dbc_warnings: needed.iter().map(ToString::to_string).collect(),
            other_dbc_warnings: others.len(),
            first_other_dbc_warning: others.first().map(ToString::to_string),
            publish_warnings: self.publisher.warnings().iter().map(ToString::to_string).collect(),
            published: self.published(config),
            publish_period_ms: config.publish.period_ms,
            effects: Vec::new(),
            vehicle_defaults: defaults(config),
        }
    }

    fn quantity(&self, config: &Config, quantity: Quantity) -> Option<QuantityReport> {
        let mapped = self.inputs.describe(quantity)?;
        let given = config.signals.quantities.get(&quantity)?;
        let names: Vec<&str> =
            given.signal.iter().chain(given.sum.iter().flatten()).map(String::as_str).collect();
        let of_dbc = || self.database.signal(names.first()?).ok().map(|(_, signal)| signal.unit.clone());
        Some(QuantityReport {
            quantity: quantity.name(),
            source: names.join(" + "),
            id: mapped.id.to_string(),
            unit: given.unit.clone().or_else(of_dbc).unwrap_or_default(),
            si_unit: quantity.unit(),
            to_si: mapped.to_si,
            offset: given.offset,
            resolution: mapped.resolution,
            carried: mapped.carried,
            plausible: mapped.plausible,
            delay_ms: 1e3 * mapped.delay.seconds(),
            timeout_ms: 1e3 * mapped.timeout.seconds(),
            noise_std: mapped.noise_std,
            counter: mapped.has_counter,
            checksum: mapped.has_checksum,
        })
    }

    /// Does the warning stand inside a message that is needed, or name it?
    fn concerns_input(&self, warning: &Warning) -> bool {
        let needed = |id: &CanId| self.database.message_with_id(*id);
        self.inputs.ids().iter().filter_map(needed).any(|message| {
            let lines = message.signals.iter().map(|signal| signal.line);
            let last = lines.max().unwrap_or(message.line);
            let inside = (message.line..=last).contains(&warning.line) && warning.file == message.file;
            let named = warning.message.split(|c: char| !(c.is_alphanumeric() || c == '_'));
            inside || named.into_iter().any(|word| word == message.name)
        })
    }

    fn published(&self, config: &Config) -> Vec<Published> {
        let own = |name: &str| config.publish.ids.get(name).and_then(|id| id.id());
        let messages = self.output.messages().iter();
        messages
            .map(|message| (message, own(&message.name).unwrap_or(message.id)))
            .filter(|(_, id)| self.publisher.ids().contains(id))
            .map(|(message, id)| Published { message: message.name.clone(), id: id.to_string() })
            .collect()
    }
}

/// Signals that are taken for two quantities.
fn used_twice(signals: &SignalsConfig) -> Vec<String> {
    let used: Vec<(Quantity, &String)> = signals
        .quantities
        .iter()
        .flat_map(|(quantity, mapped)| {
            mapped.signal.iter().chain(mapped.sum.iter().flatten()).map(|name| (*quantity, name))
        })
        .collect();
    let twice = used.iter().enumerate().filter_map(|(place, (quantity, name))| {
        let (other, _) = used[..place].iter().find(|(other, taken)| taken == name && other != quantity)?;
        Some(format!(
            "signals.{quantity}: {name} is signals.{other}, too; one of them measures something else"
        ))
    });
    twice.collect()
}

/// What the estimators lose without a quantity.
pub fn cost(quantity: Quantity) -> &'static str {
    match quantity {
        _ if quantity.wheel().is_some() => {
            "no slip slope of this wheel, nor of the driven one that it is compared with; no check of one wheel by the \
             others"
        }
        Quantity::LateralAcceleration => {
            "sideslip less surely, no cornering stiffness and no friction in curves; the slip slopes remain"
        }
        Quantity::LongitudinalAcceleration => {
            "acceleration is differentiated from wheel speeds: noisier, and blind to grade"
        }
        Quantity::DriveTorque => {
            "traction is taken from the acceleration: grade and drag pass for tire force"
        }
        Quantity::BrakeTorque => {
            "one of brake torque and brake pressure is enough; without both, braking is left out"
        }
        Quantity::BrakePressure => {
            "one of brake torque and brake pressure is enough; without both, braking is left out"
        }
        Quantity::VehicleSpeed => {
            "speed is taken from the undriven wheels; while all wheels slip it is not known"
        }
        Quantity::BrakeActive => "braking is recognized from deceleration only",
        Quantity::AbsActive => {
            "ABS brakings, which measure friction directly, are recognized from wheel slip only"
        }
        _ => "nothing can be estimated",
    }
}

/// The effects of a configuration as it is written; what its tables can hold is in those of the corrected one.
pub fn effects(written: &Config, corrected: &Config) -> Vec<EffectReport> {
    let is_left = |effect: &EffectConfig| {
        corrected.effect.iter().any(|left| left.title() == effect.title())
            && !PlainReadings::takes(&corrected.vehicle, effect)
    };
    let report = |effect| EffectReport { effect: EffectConfig::title(effect), taken_out: !is_left(effect) };
    written.effect.iter().map(report).collect()
}

/// `[vehicle]` keys that neither the file nor its tire files have.
fn defaults(config: &Config) -> Vec<VehicleDefault> {
    let parameters = config.vehicle.parameters().into_iter().filter(|(key, _)| !config.is_given(key));
    parameters.map(|(key, u)| VehicleDefault { key, value: u.value, std: u.std }).collect()
}
