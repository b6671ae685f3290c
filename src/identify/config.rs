//! The `[identify]` table.

use serde::{Deserialize, Serialize};

use super::error::IdentifyError;
use super::fit::Method;
use super::free::Tied;
use super::longitudinal_input::LongitudinalInput;
use super::parameter::Parameter;

/// The `[identify]` table: what is to be found, and how. Every key has a default.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct IdentifyConfig {
    /// What is free, by name; `lateral_stiffness` means both axles' as one. Empty: all that the vehicle's
    /// table calls uncertain, and the sensors' offsets.
    pub parameters: Vec<String>,
    /// How longitudinal forces get into the equations; left out: by torque where the bus has it.
    pub drive: Option<LongitudinalInput>,
    /// How segments are tied.
    pub method: Method,
    /// Length of a segment, s.
    pub segment_s: f64,
    /// Searches from so many starts; the first one is the vehicle's table, the others are drawn around it.
    pub starts: usize,
    /// Seed of the starts.
    pub seed: u64,
    /// Profile the likelihood of each parameter: shows what a standard deviation hides.
    pub profile: bool,
}

impl Default for IdentifyConfig {
    fn default() -> Self {
        Self {
            parameters: Vec::new(),
            drive: None,
            method: Method::Auto,
            segment_s: 2.0,
            starts: 6,
            seed: 1,
            profile: true,
        }
    }
}

impl IdentifyConfig {
    /// More starts than this find nothing that these did not.
    pub const MOST_STARTS: usize = 1000;

    /// Reads the table out of a whole configuration; other rooms read the others.
    ///
    /// # Errors
    /// No TOML, or a key or value that cannot be; the message has the line or the key.
    pub fn of_file(text: &str) -> Result<Self, IdentifyError> {
        #[derive(Deserialize)]
        struct File {
            #[serde(default)]
            identify: IdentifyConfig,
        }
        let File { identify } = toml::from_str(text)
            .map_err(|error| IdentifyError::Parse(error.to_string().trim_end().to_owned()))?;
        identify.validate()?;
        Ok(identify)
    }

    /// Checks what can be checked without a recording.
    ///
    /// # Errors
    /// The first setting that cannot be, by key.
    pub fn validate(&self) -> Result<(), IdentifyError> {
        if !(0.1..=60.0).contains(&self.segment_s) {
            let value = self.segment_s.to_string();
            return Err(IdentifyError::Setting { key: "segment_s", value, reason: "must be 0.1 to 60" });
        }
        if !(1..=Self::MOST_STARTS).contains(&self.starts) {
            let value = self.starts.to_string();
            return Err(IdentifyError::Setting { key: "starts", value, reason: "must be 1 to 1000" });
        }
        let mut seen: Vec<Tied> = Vec::new();
        for name in &self.parameters {
            let tied = named(name)?;
            if seen.iter().any(|other| other.overlaps(tied)) {
                return Err(IdentifyError::Unusable {
                    name: name.clone(),
                    reason: "it is named twice (lateral_stiffness means both axles'); name it once".into(),
                });
            }
            seen.push(tied);
        }
        Ok(())
    }
}

impl IdentifyConfig {
    /// All names that `parameters` takes.
    pub fn names() -> impl Iterator<Item = &'static str> {
        Parameter::ALL.into_iter().map(Parameter::name).chain(["lateral_stiffness"])
    }
}

/// The parameter, or the two, of a name.
pub(super) fn named(name: &str) -> Result<Tied, IdentifyError> {
    match name {
        "lateral_stiffness" => Ok(Tied::BothLateral),
        other => Parameter::named(other).map(Tied::One).ok_or_else(|| IdentifyError::Unknown(name.into())),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn problem(toml: &str) -> String {
        let config: IdentifyConfig = toml::from_str(toml).unwrap();
        config.validate().unwrap_err().to_string()
    }

    #[test]
    fn what_cannot_be_is_named_by_its_key() {
        assert!(problem("parameters = [\"mass\"]").contains("`mass` is no parameter"));
        assert!(problem("parameters = [\"mass\"]").contains("mass_kg"));
        let twice = "parameters = [\"lateral_stiffness\", \"lateral_stiffness_rear\"]";
        assert!(problem(twice).contains("`lateral_stiffness_rear`: it is named twice"));
        assert!(problem("segment_s = nan").starts_with("identify.segment_s = NaN"));
        assert!(problem("starts = 0").starts_with("identify.starts = 0"));
        assert_eq!(toml::from_str::<IdentifyConfig>("").unwrap().validate(), Ok(()));
        assert!(toml::from_str::<IdentifyConfig>("segments = 3").is_err());
    }
}
