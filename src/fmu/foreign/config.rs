//! The `[fmu]` table: how an FMU and the recorded quantities go together.

use std::collections::BTreeMap;

use physics::Quantity;
use serde::Deserialize;

/// The `[fmu]` table. Every key has a default.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct FmuConfig {
    /// Length of a step, ms; left out: what the FMU asks for, 10 ms at most where it leaves a choice.
    pub step_ms: Option<f64>,
    /// Time that all runs together may take, s.
    pub time_limit_s: f64,
    /// Which variable takes a recorded quantity; none given: those of the same name.
    pub inputs: BTreeMap<String, Wire>,
    /// Which variable gives a quantity; none given: those of the same name, `measured.…` before others.
    pub outputs: BTreeMap<String, Wire>,
    /// Parameters that begin at what is recorded of a quantity at the start.
    pub start: BTreeMap<String, String>,
    /// Parameters and inputs that are set to a number.
    pub set: BTreeMap<String, Number>,
    /// Parameters that are tuned, each within two numbers.
    pub tune: BTreeMap<String, [f64; 2]>,
}

/// A variable: its name, or a table.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(untagged, expecting = "a variable's name, or { variable = \"…\", unit = \"…\", gain = … }")]
pub enum Wire {
    /// Its name.
    Name(String),
    /// With more about it.
    Table(WireTable),
}

/// A variable with more about it.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct WireTable {
    /// Its name.
    pub variable: String,
    /// Its unit, where the FMU gives none, or a wrong one.
    #[serde(default)]
    pub unit: Option<String>,
    /// Variable / quantity beside the unit: −1 for the other sign.
    #[serde(default = "one")]
    pub gain: f64,
}

fn one() -> f64 {
    1.0
}

/// A number or a switch.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[serde(untagged, expecting = "a number, true or false")]
pub enum Number {
    /// A switch.
    Switch(bool),
    /// A number.
    Real(f64),
}

impl Number {
    /// As a number.
    pub fn value(self) -> f64 {
        match self {
            Self::Switch(is_on) => f64::from(u8::from(is_on)),
            Self::Real(value) => value,
        }
    }
}

impl Wire {
    /// Its name, unit and gain.
    pub(super) fn parts(&self) -> (&str, Option<&str>, f64) {
        match self {
            Self::Name(name) => (name, None, 1.0),
            Self::Table(WireTable { variable, unit, gain }) => (variable, unit.as_deref(), *gain),
        }
    }
}

impl Default for FmuConfig {
    fn default() -> Self {
        Self {
            step_ms: None,
            time_limit_s: 60.0,
            inputs: BTreeMap::new(),
            outputs: BTreeMap::new(),
            start: BTreeMap::new(),
            set: BTreeMap::new(),
            tune: BTreeMap::new(),
        }
    }
}

impl FmuConfig {
    /// Reads the table out of a whole configuration; other rooms read the others.
    ///
    /// # Errors
    /// No TOML, or a key or value that cannot be; the message has the line or the key.
    pub fn of_file(text: &str) -> Result<Self, String> {
        #[derive(Deserialize)]
        struct File {
            #[serde(default)]
            fmu: FmuConfig,
        }
        let File { fmu } = toml::from_str(text).map_err(|error| error.to_string().trim_end().to_owned())?;
        fmu.problem().map_or(Ok(fmu), |(key, reason)| Err(format!("fmu.{key}: {reason}")))
    }

    fn problem(&self) -> Option<(String, String)> {
        if let Some(step) = self.step_ms.filter(|step| !(*step >= 0.01 && *step <= 1000.0)) {
            return Some(("step_ms".into(), format!("{step} cannot be; it must be 0.01 to 1000")));
        }
        if !(self.time_limit_s > 0.0 && self.time_limit_s <= 1e6) {
            return Some((
                "time_limit_s".into(),
                format!("{} cannot be; it must be positive", self.time_limit_s),
            ));
        }
        for (table, wires) in [("inputs", &self.inputs), ("outputs", &self.outputs)] {
            for (quantity, wire) in wires {
                if let Err(reason) = quantity.parse::<Quantity>() {
                    return Some((table.into(), reason));
                }
                let (_, _, gain) = wire.parts();
                if !(gain.is_finite() && gain != 0.0) {
                    return Some((
                        format!("{table}.{quantity}.gain"),
                        "must be a number that is not zero".into(),
                    ));
                }
            }
        }
        for (variable, quantity) in &self.start {
            if let Err(reason) = quantity.parse::<Quantity>() {
                return Some((format!("start.{variable}"), reason));
            }
        }
        let set = self.set.iter().find(|(_, number)| !number.value().is_finite());
        if let Some((variable, _)) = set {
            return Some((format!("set.{variable}"), "must be a finite number".into()));
        }
        let range =
            |(_, [low, high]): &(&String, &[f64; 2])| !(low.is_finite() && high.is_finite() && low < high);
        let (variable, [low, high]) = self.tune.iter().find(range)?;
        Some((format!("tune.{variable}"), format!("[{low}, {high}] is no range; give [smallest, largest]")))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_cannot_be_is_named_by_its_key() {
        for (text, expected) in [
            ("[fmu]\nstep_ms = 0", "fmu.step_ms"),
            ("[fmu]\nsteps = 1", "unknown field `steps`"),
            ("[fmu.inputs]\nyaw = 'r'", "fmu.inputs: unknown quantity `yaw`"),
            ("[fmu.outputs]\nyaw_rate = { variable = 'r', gain = 0 }", "fmu.outputs.yaw_rate.gain"),
            ("[fmu.outputs]\nyaw_rate = 3", "a variable's name"),
            ("[fmu.start]\nv0 = 'speed'", "fmu.start.v0"),
            ("[fmu.set]\nv0 = nan", "fmu.set.v0"),
            ("[fmu.tune]\nm = [2, 1]", "fmu.tune.m: [2, 1]"),
        ] {
            let error = FmuConfig::of_file(text).unwrap_err();
            assert!(error.contains(expected), "{text}: {error}");
        }
        let read = FmuConfig::of_file("[vehicle]\nx = 1\n[fmu.set]\nabs = true\nv = 2").unwrap();
        assert_eq!(read.set["abs"].value() + read.set["v"].value(), 3.0);
        assert_eq!(FmuConfig::of_file("").unwrap(), FmuConfig::default());
    }
}
