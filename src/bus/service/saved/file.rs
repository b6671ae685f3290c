//! The file's format: TOML behind a line with its checksum.
//!
//! ```toml
//! checksum = "1c291ca3"                       # CRC-32 of all that follows this line
//! # What gripd learned of this car. …
//! format = "gripd learned"
//! version = 1
//! vehicle = "5f0e…"                           # fingerprint of [vehicle] and the mapping
//! last_sample_unix_s = 1795320000.0
//! driving_s = 1234.5
//! sensor_error_correlations = […]
//!
//! [yaw_rate_offset_rad_per_s]
//! value = 0.0061
//! std = 0.0004
//! ```
//!
//! A new key or another meaning is a new version. What is older could be translated; there is none yet.

use std::fmt::Write as _;
use std::io;

use flate2::Crc;
use serde::{Deserialize, Serialize};

use super::Refusal;
use crate::Config;
use crate::signals::QuantityConfig;
use physics::estimate::{Known, Learned};
use physics::model::effect::EffectConfig;
use physics::{Micros, Quantity};

/// The version that is written and read.
pub const VERSION: i64 = 1;
/// Longer than a century no car drives, s.
const LONGEST_LIFE_S: f64 = 100.0 * 365.25 * 86400.0;
/// The year 9999, s.
const LATEST_S: f64 = 2.5e11;
const FORMAT: &str = "gripd learned";
const EXPLANATION: &str = "\
# What gripd learned of this car, without friction, which is the road's. To forget it, stop gripd and delete
# this file. Changed by hand it is refused.
";

/// The file but for its checksum.
#[derive(Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Contents {
    format: String,
    version: i64,
    vehicle: String,
    last_sample_unix_s: f64,
    driving_s: f64,
    /// See [`Learned::error_correlations`].
    sensor_error_correlations: [f64; 10],
    yaw_rate_offset_rad_per_s: Option<Number>,
    lateral_acceleration_offset_mps2: Option<Number>,
    road_angle_offset_rad: Option<Number>,
    speed_relative_error: Option<Number>,
    road_angle_relative_error: Option<Number>,
    cornering_stiffness_per_rad: Axles,
    slip_slope: Wheels,
    slip_offset: Wheels,
}

#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Number {
    value: f64,
    std: f64,
}

#[derive(Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Axles {
    front: Option<Number>,
    rear: Option<Number>,
}

#[derive(Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Wheels {
    fl: Option<Number>,
    fr: Option<Number>,
    rl: Option<Number>,
    rr: Option<Number>,
}

impl From<Number> for Known {
    fn from(Number { value, std }: Number) -> Self {
        Self { value, std }
    }
}

impl From<Known> for Number {
    fn from(Known { value, std }: Known) -> Self {
        Self { value, std }
    }
}

impl From<[Option<Known>; 4]> for Wheels {
    fn from(wheels: [Option<Known>; 4]) -> Self {
        let [fl, fr, rl, rr] = wheels.map(|known| known.map(Number::from));
        Self { fl, fr, rl, rr }
    }
}

impl From<Wheels> for [Option<Known>; 4] {
    fn from(Wheels { fl, fr, rl, rr }: Wheels) -> Self {
        [fl, fr, rl, rr].map(|number| number.map(Known::from))
    }
}

impl Contents {
    fn new(learned: &Learned, fingerprint: &str) -> Self {
        let number = |known: Option<Known>| known.map(Number::from);
        let [front, rear] = learned.cornering.map(number);
        Self {
            format: FORMAT.into(),
            version: VERSION,
            vehicle: fingerprint.into(),
            last_sample_unix_s: learned.time.seconds(),
            driving_s: learned.driving_s,
            sensor_error_correlations: learned.error_correlations,
            yaw_rate_offset_rad_per_s: number(learned.yaw_rate_offset),
            lateral_acceleration_offset_mps2: number(learned.lateral_acceleration_offset),
            road_angle_offset_rad: number(learned.road_angle_offset),
            speed_relative_error: number(learned.speed_scale),
            road_angle_relative_error: number(learned.road_angle_scale),
            cornering_stiffness_per_rad: Axles { front, rear },
            slip_slope: learned.slope.into(),
            slip_offset: learned.slip_offset.into(),
        }
    }

    fn learned(self) -> Learned {
        let known = |number: Option<Number>| number.map(Known::from);
        let Axles { front, rear } = self.cornering_stiffness_per_rad;
        Learned {
            time: Micros::from_seconds(self.last_sample_unix_s),
            driving_s: self.driving_s,
            error_correlations: self.sensor_error_correlations,
            slope: self.slip_slope.into(),
            slip_offset: self.slip_offset.into(),
            cornering: [front, rear].map(known),
            yaw_rate_offset: known(self.yaw_rate_offset_rad_per_s),
            lateral_acceleration_offset: known(self.lateral_acceleration_offset_mps2),
            road_angle_offset: known(self.road_angle_offset_rad),
            speed_scale: known(self.speed_relative_error),
            road_angle_scale: known(self.road_angle_relative_error),
        }
    }
}

/// The whole file.
///
/// # Errors
/// None that is known of: numbers and strings can all be written.
pub fn text(learned: &Learned, fingerprint: &str) -> io::Result<String> {
    let contents = toml::to_string(&Contents::new(learned, fingerprint)).map_err(io::Error::other)?;
    Ok(sealed(&format!("{EXPLANATION}{contents}")))
}

/// The contents behind their checksum.
fn sealed(contents: &str) -> String {
    format!("checksum = \"{:08x}\"\n{contents}", crc(contents.as_bytes()))
}

/// The fingerprint of the vehicle that a file is of.
///
/// # Errors
/// Why the file is none of ours.
pub fn fingerprint_in(bytes: &[u8]) -> Result<String, Refusal> {
    let line = |line: &&[u8]| line.starts_with(b"vehicle = \"");
    let line = bytes.split(|byte| *byte == b'\n').find(line).unwrap_or_default();
    let line = std::str::from_utf8(line).map_err(|_| Refusal::NotOurs("no text"))?;
    let vehicle = line.split('"').nth(1).unwrap_or_default().to_owned();
    parse(bytes, &vehicle).map(|_| vehicle)
}

/// What a file says of the vehicle with this fingerprint.
///
/// # Errors
/// Why it is not used.
pub fn parse(bytes: &[u8], fingerprint: &str) -> Result<Learned, Refusal> {
    let text = std::str::from_utf8(bytes).map_err(|_| Refusal::NotOurs("no text"))?;
    let (checksum, contents) = text
        .strip_prefix("checksum = \"")
        .and_then(|rest| rest.split_once("\"\n"))
        .ok_or(Refusal::NotOurs("no checksum in its first line"))?;
    if checksum != format!("{:08x}", crc(contents.as_bytes())) {
        return Err(Refusal::Checksum);
    }
    let wrong = |error: toml::de::Error| Refusal::Contents(error.message().to_owned());
    let table: toml::Table = toml::from_str(contents).map_err(wrong)?;
    if table.get("format").and_then(toml::Value::as_str) != Some(FORMAT) {
        return Err(Refusal::NotOurs("another format"));
    }
    // Before anything else is looked at: in another version all of it may mean something else.
    match table.get("version").and_then(toml::Value::as_integer) {
        Some(VERSION) => {}
        Some(found) => return Err(Refusal::Version { found }),
        None => return Err(Refusal::NotOurs("no version")),
    }
    if table.get("vehicle").and_then(toml::Value::as_str) != Some(fingerprint) {
        return Err(Refusal::OtherVehicle);
    }
    let contents = table.try_into::<Contents>().map_err(wrong)?;
    // A number that a second more does not change would be written with each frame.
    if !(0.0..=LONGEST_LIFE_S).contains(&contents.driving_s) {
        return Err(Refusal::Value("seconds of driving"));
    }
    if !(0.0..=LATEST_S).contains(&contents.last_sample_unix_s) {
        return Err(Refusal::Value("time of the last sample"));
    }
    let learned = contents.learned();
    learned.problem().map_or(Ok(learned), |what| Err(Refusal::Value(what)))
}

fn crc(bytes: &[u8]) -> u32 {
    let mut crc = Crc::new();
    crc.update(bytes);
    crc.sum()
}

/// What the learned numbers stand on: `[vehicle]`, and what the mapping makes of the signals whose
/// errors are learned or whose size the stiffnesses have. Another sign, gain, zero or unit, another
/// signal or another data sheet is another vehicle; time-outs, limits and noise are not.
pub fn fingerprint(config: &Config) -> String {
    let mut text = toml::to_string(&config.vehicle).unwrap_or_default();
    let configured = config.signals.quantities.keys().fold(0, |bits, quantity| bits | quantity.bit());
    let others = Quantity::DriveTorque.bit() | Quantity::LongitudinalAcceleration.bit();
    let matters = Quantity::basic(configured) | others;
    for (quantity, mapping) in &config.signals.quantities {
        if matters & quantity.bit() == 0 {
            continue;
        }
        let QuantityConfig { signal, sum, sign, gain, offset, unit, .. } = mapping;
        // Writing into a string cannot fail.
        let _ = writeln!(text, "{quantity} {signal:?} {sum:?} {sign:?} {gain:?} {offset:?} {unit:?}");
    }
    text += &EffectConfig::write_all(&config.effect);
    format!("{:08x}-{:x}", crc(text.as_bytes()), text.len())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn learned() -> Learned {
        let known = |value, std| Some(Known { value, std });
        Learned {
            time: Micros(1_795_320_000_123_456),
            driving_s: 1234.5,
            slope: [known(95.25, 2.0), known(1.0 / 3.0 * 300.0, 3.0), None, None],
            slip_offset: [known(0.015, 1e-5), known(-0.001, 2e-5), None, None],
            cornering: [known(12.1, 0.3), None],
            yaw_rate_offset: known(0.1 + 0.02, 4e-4),
            lateral_acceleration_offset: None,
            road_angle_offset: known(-3e-7, 1e-12),
            speed_scale: known(0.0, 0.01),
            road_angle_scale: None,
            error_correlations: [0.0, 1.0 / 3.0, 0.0, 0.0, 0.0, 0.0, 0.0, -0.1, 0.0, 0.0],
        }
    }

    #[test]
    fn what_is_written_is_read_again_to_the_last_bit() {
        let text = text(&learned(), "car").unwrap();
        assert_eq!(parse(text.as_bytes(), "car").unwrap(), learned(), "{text}");
        let nothing = super::text(&Learned::default(), "car").unwrap();
        assert_eq!(parse(nothing.as_bytes(), "car").unwrap(), Learned::default());
        assert!(!text.contains("friction =") && !text.contains("mu_"), "{text}");
    }

    #[test]
    fn cut_short_anywhere_or_with_any_byte_changed_it_is_refused() {
        let text = text(&learned(), "car").unwrap();
        let bytes = text.as_bytes();
        for length in 0..bytes.len() {
            assert!(parse(&bytes[..length], "car").is_err(), "the first {length} of {}", bytes.len());
        }
        for place in 0..bytes.len() {
            for change in [1, 2, 0x20, 0x80, 0xFF] {
                let mut changed = bytes.to_vec();
                changed[place] ^= change;
                assert!(parse(&changed, "car").is_err(), "byte {place} changed by {change:#x}");
            }
        }
        let longer = format!("{text}\n");
        assert!(matches!(parse(longer.as_bytes(), "car"), Err(Refusal::Checksum)));
    }

    #[test]
    fn what_is_whole_and_yet_not_ours_is_refused_with_the_reason() {
        let text = text(&learned(), "car").unwrap();
        let (_, contents) = text.split_once('\n').unwrap();
        let refusal = |was: &str, is: &str| {
            assert!(contents.contains(was), "{was}");
            parse(sealed(&contents.replace(was, is)).as_bytes(), "car").unwrap_err()
        };
        assert!(matches!(refusal("version = 1", "version = 2"), Refusal::Version { found: 2 }));
        assert!(matches!(refusal("version = 1", "version = 0"), Refusal::Version { found: 0 }));
        assert!(matches!(refusal("version = 1", ""), Refusal::NotOurs("no version")));
        assert!(matches!(refusal("\"gripd learned\"", "\"x\""), Refusal::NotOurs("another format")));
        assert!(matches!(refusal("vehicle = \"car\"", "vehicle = \"van\""), Refusal::OtherVehicle));
        assert!(matches!(refusal("driving_s = 1234.5", "driving_s = nan"), Refusal::Value(_)));
        for nonsense in ["1e300", "-1.0", "inf", "3.2e9"] {
            let nonsense = format!("driving_s = {nonsense}");
            assert!(matches!(refusal("driving_s = 1234.5", &nonsense), Refusal::Value("seconds of driving")));
        }
        for nonsense in ["1e300", "-1.0", "nan"] {
            let nonsense = format!("last_sample_unix_s = {nonsense}");
            let refused = refusal("last_sample_unix_s = 1795320000.123456", &nonsense);
            assert!(matches!(refused, Refusal::Value("time of the last sample")));
        }
        assert!(matches!(refusal("value = 0.015", "value = nan"), Refusal::Value("slip offset fl")));
        assert!(matches!(refusal("value = 95.25", "value = 1e9"), Refusal::Value("slope fl")));
        assert!(matches!(refusal("value = 95.25", "value = \"95\""), Refusal::Contents(_)));
        assert!(matches!(refusal("std = 0.3", "std = -0.3"), Refusal::Value(_)));
        assert!(matches!(refusal("-0.1,", "-1.1,"), Refusal::Value(_)));
        assert!(matches!(refusal("std = 0.3", "std = 0.3\nmu_max = 1.0"), Refusal::Contents(_)));
        assert!(matches!(refusal("format", "["), Refusal::Contents(_)));
        assert!(matches!(parse(b"\xFF", "car"), Err(Refusal::NotOurs("no text"))));
    }
}
