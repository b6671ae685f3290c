//! Compiles the `[signals]` table against a DBC, gathering all that is wrong.

use super::checks::{Checksum, Counter};
use super::config::{CrcConfig, CrcKind, QuantityConfig, SignalsConfig};
use super::error::Problems;
use super::mapping::{Gate, Mapping, MessageInput, Part, Quality};
use super::units;
use crate::dbc::{Database, Message, Signal};
use physics::Quantity;

/// Looks up names, converts units and remembers every problem.
pub(super) struct Compiler<'a> {
    pub(super) database: &'a Database,
    pub(super) wheel_radius_m: f64,
    pub(super) problems: Problems,
    /// Quality signals found so far that stand in other messages than the values.
    gates: Vec<(&'a Message, Gate)>,
}

impl<'a> Compiler<'a> {
    pub(super) fn new(database: &'a Database, wheel_radius_m: f64, problems: Problems) -> Self {
        Self { database, wheel_radius_m, problems, gates: Vec::new() }
    }

    /// All messages that carry configured quantities, by identifier.
    pub(super) fn messages(&mut self, config: &SignalsConfig) -> Vec<MessageInput> {
        if !(self.wheel_radius_m.is_finite() && self.wheel_radius_m > 0.0) {
            self.problems
                .add("vehicle.wheel_radius_m", "must be positive: wheel speeds in km/h are divided by it");
        }
        let mut messages: Vec<MessageInput> = Vec::new();
        for (&quantity, config) in &config.quantities {
            let key = format!("signals.{quantity}");
            self.check_numbers(&key, config);
            let Some((message, mapping)) = self.mapping(quantity, &key, config) else { continue };
            let counter = self.counter(&key, config, message);
            let checksum = self.checksum(&key, config, message, counter.as_ref());
            let known = entry(&mut messages, message);
            known.mappings.push(mapping);
            self.once(&mut known.counter, counter, format!("{key}.counter"), &message.name);
            self.once(&mut known.checksum, checksum, format!("{key}.crc"), &message.name);
        }
        for (message, gate) in std::mem::take(&mut self.gates) {
            entry(&mut messages, message).gates.push(gate);
        }
        messages.sort_by_key(|message| message.id);
        messages
    }

    /// Counter and checksum belong to the message; several quantities may name them, if they agree.
    fn once<T: PartialEq>(&mut self, known: &mut Option<T>, new: Option<T>, key: String, message: &str) {
        match (&known, new) {
            (_, None) => {}
            (None, new) => *known = new,
            (Some(known), Some(new)) if *known == new => {}
            _ => self.problems.add(
                key,
                format!(
                    "another quantity of {message} gives another one; a message has only one: name it once"
                ),
            ),
        }
    }

    fn mapping(
        &mut self,
        quantity: Quantity,
        key: &str,
        config: &QuantityConfig,
    ) -> Option<(&'a Message, Mapping)> {
        let (message, signals) = self.sources(key, config)?;
        let mut parts = Vec::new();
        for (signal_key, name, signal) in &signals {
            let unit = config.unit.as_deref().unwrap_or(&signal.unit);
            // A fine part often has no unit of its own.
            let unit = if unit.is_empty() { &signals[0].2.unit } else { unit };
            match units::to_si(quantity, unit, self.wheel_radius_m) {
                Ok(to_si) => parts.push(Part { codec: signal.codec(), mux: signal.mux().clone(), to_si }),
                Err(error) if config.unit.is_some() => {
                    self.problems.add(format!("{key}.unit"), error.to_string());
                }
                Err(error) => self.problems.add(signal_key.clone(), format!("{name}: {error}")),
            }
        }
        let sign = config.sign.as_ref().and_then(|name| {
            let signal = self.beside(&format!("{key}.sign"), name, message)?;
            if signal.size != 1 {
                self.problems.add(
                    format!("{key}.sign"),
                    format!("{name} has {} bits; a sign has one (1 = negative)", signal.size),
                );
            }
            Some(signal.codec())
        });
        let (valid, gates) = self.qualities(quantity, key, config, message);
        let not_available = self.codes(&format!("{key}.not_available"), config, signals[0].2, quantity);
        let gain = config.gain.unwrap_or(1.0);
        if parts.len() != signals.len() {
            return None;
        }
        Some((
            message,
            Mapping { quantity, parts, sign, valid, gates, not_available, gain, offset: config.offset },
        ))
    }

    /// The quality signals: those of the same message, and the numbers of those that are not.
    fn qualities(
        &mut self,
        quantity: Quantity,
        key: &str,
        config: &QuantityConfig,
        message: &Message,
    ) -> (Vec<Quality>, Vec<usize>) {
        let (mut valid, mut gates) = (Vec::new(), Vec::new());
        for name in &config.valid {
            let Some((home, signal)) = self.find(&format!("{key}.valid"), name) else { continue };
            let codec = signal.codec();
            let allowing = config.valid_when.clone();
            if allowing.is_empty() || allowing.iter().any(|bits| *bits > codec.extractor.mask()) {
                self.problems.add(
                    format!("{key}.valid_when"),
                    format!("must be one or more raw values that {name} can have ({} bits)", signal.size),
                );
            }
            let quality = Quality { codec, mux: signal.mux().clone(), allowing };
            if home.id == message.id {
                valid.push(quality);
            } else {
                let number = self.gates.len();
                self.gates.push((home, Gate { number, quantity, quality }));
                gates.push(number);
            }
        }
        (valid, gates)
    }

    /// The signals that are added up, with their keys and names, and the message they are all in.
    #[allow(clippy::type_complexity, reason = "a private triple, taken apart at once")]
    fn sources(
        &mut self,
        key: &str,
        config: &QuantityConfig,
    ) -> Option<(&'a Message, Vec<(String, String, &'a Signal)>)> {
        let names: Vec<(String, String)> = match (&config.signal, &config.sum) {
            (Some(signal), None) => vec![(key.to_owned(), signal.clone())],
            (None, Some(sum)) if !sum.is_empty() => {
                sum.iter().map(|name| (format!("{key}.sum"), name.clone())).collect()
            }
            _ => {
                let message =
                    "give either signal = \"MESSAGE.Signal\" or sum = [\"MESSAGE.Coarse\", \"MESSAGE.Fine\"]";
                self.problems.add(key, message);
                return None;
            }
        };
        let mut found = Vec::new();
        let mut message: Option<&'a Message> = None;
        let mut complete = true;
        for (key, name) in names {
            let signal = match message {
                None => self.find(&key, &name).map(|(first, signal)| {
                    message = Some(first);
                    signal
                }),
                Some(message) => self.beside(&key, &name, message),
            };
            match signal {
                Some(signal) => found.push((key, name, signal)),
                None => complete = false,
            }
        }
        message.filter(|_| complete).map(|message| (message, found))
    }

    fn find(&mut self, key: &str, name: &str) -> Option<(&'a Message, &'a Signal)> {
        let database = self.database;
        match database.signal(name) {
            Ok(found) => Some(found),
            Err(error) => {
                self.problems.add(key, error.to_string());
                None
            }
        }
    }

    /// A signal that must be in the same frame as another.
    fn beside(&mut self, key: &str, name: &str, message: &Message) -> Option<&'a Signal> {
        let (found, signal) = self.find(key, name)?;
        if found.id == message.id {
            return Some(signal);
        }
        self.problems.add(
            key,
            format!("{name} is not in {}; only a signal of the same message can tell of it", message.name),
        );
        None
    }

    fn codes(&mut self, key: &str, config: &QuantityConfig, signal: &Signal, quantity: Quantity) -> Vec<u64> {
        let mask = signal.codec().extractor.mask();
        let mut codes = Vec::new();
        for &code in &config.not_available {
            // Raw codes are written as bit patterns (32768) or as the signed number they are (−32768).
            let bits = code as u64 & mask;
            let fits = if code < 0 { code >= -((mask / 2) as i64) - 1 } else { code as u64 <= mask };
            if fits {
                codes.push(bits);
            } else {
                self.problems
                    .add(key, format!("{code} does not fit the {} bits of {}", signal.size, signal.name));
            }
        }
        let is_flag = matches!(quantity, Quantity::BrakeActive | Quantity::AbsActive);
        if signal.size > 4 && !is_flag {
            for (value, _) in signal.values.iter().filter(|(_, name)| means_not_available(name)) {
                let bits = *value as u64 & mask;
                if !codes.contains(&bits) {
                    codes.push(bits);
                }
            }
        }
        codes
    }

    fn counter(&mut self, key: &str, config: &QuantityConfig, message: &Message) -> Option<Counter> {
        let key = format!("{key}.counter");
        if config.counter.is_empty() {
            if config.counter_modulo.is_some() {
                self.problems
                    .add(format!("{key}_modulo"), "has no meaning without counter = \"MESSAGE.Signal\"");
            }
            return None;
        }
        let mut parts = Vec::new();
        for name in &config.counter {
            parts.push(self.beside(&key, name, message)?.codec());
        }
        let profile_1 = |crc: &CrcConfig| matches!(crc.kind, CrcKind::E2eP01a | CrcKind::E2eP01b);
        let four_bits = parts.iter().map(|part| part.extractor.size()).sum::<u32>() == 4;
        // Profile 1 counts from 0 to 14.
        let implied = (four_bits && config.crc.as_ref().is_some_and(profile_1)).then_some(15);
        let counter = Counter::new(parts, config.counter_modulo.or(implied));
        if counter.is_none() {
            self.problems.add(
                key,
                "counts to no such modulo with its bits; give 2 to 2^bits as counter_modulo, at most 32 bits",
            );
        }
        counter
    }

    fn checksum(
        &mut self,
        key: &str,
        config: &QuantityConfig,
        message: &Message,
        counter: Option<&Counter>,
    ) -> Option<Checksum> {
        let crc = config.crc.as_ref()?;
        let signal = self.beside(&format!("{key}.crc.signal"), &crc.signal, message)?;
        match Checksum::new(crc, message, signal.codec(), counter) {
            Ok(checksum) => Some(checksum),
            Err(reason) => {
                self.problems.add(format!("{key}.crc"), reason);
                None
            }
        }
    }

    fn check_numbers(&mut self, key: &str, config: &QuantityConfig) {
        let positive = |value: f64| value.is_finite() && value > 0.0;
        let mut require = |fine: bool, name: &str, what: &str| {
            if !fine {
                self.problems.add(format!("{key}.{name}"), what);
            }
        };
        require(
            config.gain.is_none_or(|g| g.is_finite() && g != 0.0),
            "gain",
            "must be a number other than zero",
        );
        require(config.offset.is_finite(), "offset", "must be a finite number (in SI units)");
        require(
            config.timeout_ms.is_none_or(|ms| (1.0..=60_000.0).contains(&ms)),
            "timeout_ms",
            "must be between 1 and 60000 ms",
        );
        require((0.0..=1000.0).contains(&config.delay_ms), "delay_ms", "must be between 0 and 1000 ms");
        require(config.noise_std.is_none_or(positive), "noise_std", "must be positive (in SI units)");
        require(config.rate_max.is_none_or(positive), "rate_max", "must be positive (SI per second)");
        let (min, max) = (config.min.unwrap_or(f64::NEG_INFINITY), config.max.unwrap_or(f64::INFINITY));
        require(min < max, "min", "must be less than max");
    }
}

/// What is read from a message; nothing as yet, if it is new.
fn entry<'m>(messages: &'m mut Vec<MessageInput>, message: &Message) -> &'m mut MessageInput {
    let index = messages.iter().position(|known| known.id == message.id).unwrap_or_else(|| {
        messages.push(MessageInput {
            id: message.id,
            name: message.name.clone(),
            length: message.length,
            is_fd: message.is_fd,
            cycle: message.cycle,
            counter: None,
            checksum: None,
            mappings: Vec::new(),
            gates: Vec::new(),
        });
        messages.len() - 1
    });
    &mut messages[index]
}

/// Names that value tables give to raw values which are no measurement. Only whole names count, so that
/// "NoFault" is not one.
fn means_not_available(name: &str) -> bool {
    let plain: String = name.chars().filter(char::is_ascii_alphanumeric).collect::<String>().to_lowercase();
    matches!(
        plain.as_str(),
        "sna"
            | "notavailable"
            | "signalnotavailable"
            | "unavailable"
            | "nichtverfuegbar"
            | "na"
            | "invalid"
            | "ungueltig"
            | "error"
            | "errorindicator"
            | "fehler"
            | "fault"
            | "faulty"
            | "nodata"
            | "nodataexists"
            | "init"
            | "initialisierung"
            | "unterspannung"
            | "undefined"
    )
}
