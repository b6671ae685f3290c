//! The `[signals]` table as it is written: which DBC signal is which quantity.

use std::collections::BTreeMap;
use std::fmt;

use serde::Deserialize;
use serde::de::value::MapAccessDeserializer;
use serde::de::{Deserializer, Error as _, MapAccess, Visitor};

use super::error::nearest;
use physics::{Micros, Quantity};

/// The `[signals]` table: a mapping for each quantity, and `sampling` for how samples are made of them.
///
/// Names are not checked against a DBC here; [`super::Inputs::compile`] does that.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SignalsConfig {
    /// Where each quantity comes from.
    pub quantities: BTreeMap<Quantity, QuantityConfig>,
    /// The key `sampling`: the uniform time grid.
    pub sampling: SamplerConfig,
}

/// Where one quantity comes from: `"MESSAGE.Signal"`, or a table.
///
/// The value in SI units is `gain · (± the signal's physical value, in SI units) + offset`; so `offset`
/// is in the quantity's SI unit (rad/s, m/s², rad, N m; bar for `brake_pressure`) and a
/// `gain = -1.0` turns a sensor mounted the wrong way round.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct QuantityConfig {
    /// `"MESSAGE.Signal"`. Either this or [`Self::sum`].
    pub signal: Option<String>,
    /// Signals of one message to be added: coarse first, then fine.
    pub sum: Option<Vec<String>>,
    /// A one-bit signal of the same message, 1 where the value is negative.
    pub sign: Option<String>,
    /// Quality signals, all of which must allow the value. In the same message they tell of the value beside
    /// them; in another message, of the values until it comes again.
    pub valid: Vec<String>,
    /// Raw values at which a quality signal allows the value. Default `[0]`.
    pub valid_when: Vec<u64>,
    /// Factor on the converted value.
    pub gain: Option<f64>,
    /// Added after the gain, in the quantity's SI unit.
    pub offset: f64,
    /// The unit, where the DBC's is missing or wrong.
    pub unit: Option<String>,
    /// Raw codes (of the first signal) that mean "not available", besides those that the DBC names so.
    pub not_available: Vec<i64>,
    /// Older than this the value is absent. Default: `sampling.timeout_ms`.
    pub timeout_ms: Option<f64>,
    /// How late the value is in its frame: filtering and transport inside the sensor.
    pub delay_ms: f64,
    /// The message's counter; several signals are put together, least significant first.
    pub counter: Vec<String>,
    /// At how much the counter starts over. Default: what its bits can hold; 15 for four bits with a checksum
    /// of AUTOSAR's profile 1.
    pub counter_modulo: Option<u64>,
    /// The message's checksum.
    pub crc: Option<CrcConfig>,
    /// Standard deviation of the noise, SI. Default: typical for the quantity.
    pub noise_std: Option<f64>,
    /// Lowest plausible value, SI.
    pub min: Option<f64>,
    /// Highest plausible value, SI.
    pub max: Option<f64>,
    /// Fastest plausible change, SI per second.
    pub rate_max: Option<f64>,
    /// Between two frames: on a straight line (`true`), or the older value (`false`). Default: a straight
    /// line, but for `brake_active` and `abs_active`.
    pub interpolate: Option<bool>,
}

/// The table form, as TOML has it.
#[derive(Deserialize)]
#[serde(deny_unknown_fields, expecting = "\"MESSAGE.Signal\", or a table with `signal` or `sum`")]
struct QuantityTable {
    signal: Option<String>,
    sum: Option<Vec<String>>,
    sign: Option<String>,
    #[serde(default)]
    valid: OneOrMany<String>,
    valid_when: Option<OneOrMany<u64>>,
    gain: Option<f64>,
    #[serde(default)]
    offset: f64,
    unit: Option<String>,
    #[serde(default)]
    not_available: OneOrMany<i64>,
    timeout_ms: Option<f64>,
    #[serde(default)]
    delay_ms: f64,
    #[serde(default)]
    counter: OneOrMany<String>,
    counter_modulo: Option<u64>,
    crc: Option<CrcConfig>,
    noise_std: Option<f64>,
    min: Option<f64>,
    max: Option<f64>,
    rate_max: Option<f64>,
    interpolate: Option<bool>,
}

impl From<QuantityTable> for QuantityConfig {
    fn from(table: QuantityTable) -> Self {
        Self {
            signal: table.signal,
            sum: table.sum,
            sign: table.sign,
            valid: table.valid.into(),
            valid_when: table.valid_when.map_or_else(|| vec![0], Vec::from),
            gain: table.gain,
            offset: table.offset,
            unit: table.unit,
            not_available: table.not_available.into(),
            timeout_ms: table.timeout_ms,
            delay_ms: table.delay_ms,
            counter: table.counter.into(),
            counter_modulo: table.counter_modulo,
            crc: table.crc,
            noise_std: table.noise_std,
            min: table.min,
            max: table.max,
            rate_max: table.rate_max,
            interpolate: table.interpolate,
        }
    }
}

impl From<&str> for QuantityConfig {
    fn from(signal: &str) -> Self {
        Self { signal: Some(signal.to_owned()), valid_when: vec![0], ..Self::default() }
    }
}

impl<'de> Deserialize<'de> for QuantityConfig {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct StringOrTable;
        impl<'de> Visitor<'de> for StringOrTable {
            type Value = QuantityConfig;
            fn expecting(&self, f: &mut fmt::Formatter) -> fmt::Result {
                f.write_str("\"MESSAGE.Signal\", or a table with `signal` or `sum`")
            }
            fn visit_str<E>(self, signal: &str) -> Result<QuantityConfig, E> {
                Ok(signal.into())
            }
            fn visit_map<A: MapAccess<'de>>(self, map: A) -> Result<QuantityConfig, A::Error> {
                QuantityTable::deserialize(MapAccessDeserializer::new(map)).map(Into::into)
            }
        }
        deserializer.deserialize_any(StringOrTable)
    }
}

impl<'de> Deserialize<'de> for SignalsConfig {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct Table;
        impl<'de> Visitor<'de> for Table {
            type Value = SignalsConfig;
            fn expecting(&self, f: &mut fmt::Formatter) -> fmt::Result {
                f.write_str("a table of quantities, such as yaw_rate = \"MESSAGE.Signal\"")
            }
            fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<SignalsConfig, A::Error> {
                let mut config = SignalsConfig::default();
                while let Some(key) = map.next_key()? {
                    match key {
                        Key::Sampling => config.sampling = map.next_value()?,
                        Key::Quantity(quantity) => {
                            config.quantities.insert(quantity, map.next_value()?);
                        }
                    }
                }
                Ok(config)
            }
        }
        deserializer.deserialize_map(Table)
    }
}

/// A key of `[signals]`. Refused as a key, so that the error stands in the key's own line.
enum Key {
    Sampling,
    Quantity(Quantity),
}

impl<'de> Deserialize<'de> for Key {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let key = String::deserialize(deserializer)?;
        if key == "sampling" {
            return Ok(Self::Sampling);
        }
        key.parse().map(Self::Quantity).map_err(|_| D::Error::custom(unknown_key(&key)))
    }
}

fn unknown_key(key: &str) -> String {
    let names: Vec<_> = Quantity::ALL.iter().map(|q| q.name()).chain(["sampling"]).collect();
    match nearest(key, names.iter().copied()) {
        Some(name) => format!("signals.{key}: no such quantity; did you mean `{name}`?"),
        None => format!("signals.{key}: no such quantity; known are {}", names.join(", ")),
    }
}

/// One value, or a list of them.
#[derive(Clone, Debug, Deserialize)]
#[serde(untagged, expecting = "one value, or a list of values")]
enum OneOrMany<T> {
    Many(Vec<T>),
    One(T),
}

impl<T> Default for OneOrMany<T> {
    fn default() -> Self {
        Self::Many(Vec::new())
    }
}

impl<T> From<OneOrMany<T>> for Vec<T> {
    fn from(values: OneOrMany<T>) -> Self {
        match values {
            OneOrMany::Many(values) => values,
            OneOrMany::One(value) => vec![value],
        }
    }
}

/// A message's checksum: where it stands and how it is reckoned.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CrcConfig {
    /// The signal that carries it: eight bits that fill one byte.
    pub signal: String,
    /// How it is reckoned.
    pub kind: CrcKind,
    /// `e2e_p01a`, `e2e_p01b`: the data ID, 16 bits. `crc8`, `sum8`, `xor8`: not used.
    pub data_id: Option<u16>,
    /// `vw_mqb`: the message's magic byte, or one for each of the 16 counter values.
    #[serde(default, deserialize_with = "one_or_many")]
    pub magic: Vec<u8>,
    /// `crc8`: the polynomial without its leading one.
    pub polynomial: Option<u8>,
    /// `crc8`, `sum8`, `xor8`: the start value. Default 0.
    pub init: Option<u8>,
    /// `crc8`, `sum8`, `xor8`: xored to the result. Default 0.
    pub xor_out: Option<u8>,
    /// `crc8`, `sum8`, `xor8`: bytes reckoned before the data.
    #[serde(default)]
    pub prefix: Vec<u8>,
    /// `crc8`, `sum8`, `xor8`: bytes reckoned after the data.
    #[serde(default)]
    pub suffix: Vec<u8>,
}

fn one_or_many<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Vec<u8>, D::Error> {
    OneOrMany::deserialize(deserializer).map(Vec::from)
}

/// The checksums that are known. All skip the byte that the checksum itself stands in.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum CrcKind {
    /// AUTOSAR E2E profile 1, variant A: both bytes of the data ID (low first), then the data, by CRC-8
    /// SAE J1850 with start value and final xor zero (AUTOSAR PRS E2E Protocol, profile 1).
    E2eP01a,
    /// The same, variant B: of the data ID only the low byte where the counter is even, the high byte
    /// where it is odd. Needs `counter`.
    E2eP01b,
    /// Toyota: the sum of identifier bytes, length and data bytes.
    Toyota,
    /// Volkswagen MQB: CRC-8 8H2F (polynomial 0x2F, start value and final xor 0xFF) over the data and one
    /// magic byte, which depends on message and counter. Needs `counter` unless the magic byte is one.
    VwMqb,
    /// Any CRC-8 that takes the highest bit first.
    Crc8,
    /// The sum of the bytes.
    Sum8,
    /// The exclusive or of the bytes.
    Xor8,
}

/// How frames of many periods become samples of one: `[signals.sampling]`.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct SamplerConfig {
    /// Distance of the samples, ms (1 to 100).
    pub period_ms: f64,
    /// How long a sample waits for late frames and for a frame to interpolate to, ms; the largest
    /// `delay_ms` comes on top.
    pub lag_ms: f64,
    /// A quantity older than this is absent, ms, where it says nothing itself.
    pub timeout_ms: f64,
    /// Longest wait for the required quantities before the first sample, ms.
    pub start_ms: f64,
    /// Watch for stuck and contradicting sensors. (Range and rate are watched in any case.)
    pub cross_checks: bool,
    /// Watch how often each message comes: one that comes more than 1.3 times as often as it did, or as the DBC
    /// says, is sent by two nodes, and not used. To be switched off where time runs faster than in the car.
    pub rate_watch: bool,
}

impl Default for SamplerConfig {
    fn default() -> Self {
        Self {
            period_ms: 10.0,
            lag_ms: 20.0,
            timeout_ms: 200.0,
            start_ms: 500.0,
            cross_checks: true,
            rate_watch: true,
        }
    }
}

impl SamplerConfig {
    /// Distance of the samples.
    pub fn period(&self) -> Micros {
        micros(self.period_ms)
    }
}

/// From a configured number of milliseconds.
pub(super) fn micros(milliseconds: f64) -> Micros {
    Micros::from_seconds(milliseconds * 1e-3)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn parse(text: &str) -> Result<SignalsConfig, String> {
        toml::from_str(text).map_err(|e| e.to_string())
    }

    #[test]
    fn a_name_and_a_table_say_the_same() {
        let config = parse("yaw_rate = \"A.B\"\nlateral_acceleration = { signal = \"A.B\" }").unwrap();
        assert_eq!(config.quantities[&Quantity::YawRate], config.quantities[&Quantity::LateralAcceleration]);
    }

    #[test]
    fn everything_the_contract_names_is_understood() {
        let config = parse(
            r#"
            yaw_rate = { signal = "E.Y", sign = "E.S", valid = "E.Q", valid_when = 1, gain = -1, offset = 0.01,
                         unit = "deg/s", not_available = [32768], timeout_ms = 100, counter = "E.C",
                         crc = { signal = "E.X", kind = "e2e_p01a", data_id = 0x101 }, noise_std = 0.01, delay_ms = 6.5 }
            steering_wheel_angle = { sum = ["S.A", "S.F"], counter = ["S.L", "S.H"] }
            sampling = { period_ms = 5 }
            "#,
        )
        .unwrap();
        let yaw = &config.quantities[&Quantity::YawRate];
        assert_eq!((yaw.gain, yaw.offset, yaw.delay_ms), (Some(-1.0), 0.01, 6.5));
        assert_eq!((&yaw.valid[..], &yaw.valid_when[..]), (&["E.Q".to_owned()][..], &[1][..]));
        assert_eq!(yaw.crc.as_ref().unwrap().kind, CrcKind::E2eP01a);
        assert_eq!(config.quantities[&Quantity::SteeringWheelAngle].counter, ["S.L", "S.H"]);
        assert_eq!(config.sampling, SamplerConfig { period_ms: 5.0, ..SamplerConfig::default() });
    }

    #[test]
    fn a_mistyped_quantity_is_answered_with_the_right_one() {
        let message = parse("yawrate = \"A.B\"").unwrap_err();
        assert!(message.contains("signals.yawrate") && message.contains("`yaw_rate`"), "{message}");
        assert!(message.contains("line 1"), "{message}");
    }

    #[test]
    fn a_mistyped_key_is_named_with_its_line_and_what_would_be_accepted() {
        let message = parse("yaw_rate = { signal = \"A.B\",\nsgn = \"A.S\" }").unwrap_err();
        assert!(message.contains("sgn") && message.contains("sign"), "{message}");
        assert!(message.contains("line 2"), "{message}");
        let message = parse("yaw_rate = 3").unwrap_err();
        assert!(message.contains("MESSAGE.Signal"), "{message}");
    }
}
