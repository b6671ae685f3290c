//! The configuration file: what each room wants to know, joined and checked.

mod corrected;
mod service;
mod tires;

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use serde::Deserialize;
use serde::de::IgnoredAny;
use thiserror::Error;

use crate::dbc::{Database, DbcError};
use crate::signals::SignalsConfig;
use crate::signals::publish::{PublishConfig, built_in_database};
use crate::tire_file::TireFileError;
use physics::estimate::EstimatorsConfig;
use physics::model::effect::EffectConfig;
use physics::model::{Vehicle, VehicleError};

pub use service::{Address, ServiceConfig};

/// The whole file. Unknown keys are errors; paths are relative to the file.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Config {
    /// `[bus]`
    #[serde(default)]
    pub bus: BusConfig,
    /// `[dbc]`
    pub dbc: DbcConfig,
    /// `[signals]`
    pub signals: SignalsConfig,
    /// `[vehicle]`
    pub vehicle: Vehicle,
    /// `[[effect]]`: physics beyond the plain model.
    #[serde(default)]
    pub effect: Vec<EffectConfig>,
    /// `[estimators]`
    #[serde(default)]
    pub estimators: EstimatorsConfig,
    /// `[identify]`: what reads it is not of this crate.
    #[serde(default, rename = "identify")]
    _identify: IgnoredAny,
    /// `[fmu]`: the same.
    #[serde(default, rename = "fmu")]
    _fmu: IgnoredAny,
    /// `[publish]`
    #[serde(default)]
    pub publish: PublishConfig,
    /// `[service]`
    #[serde(default)]
    pub service: ServiceConfig,
    /// Keys of `[vehicle]` that the file or its tire files give.
    #[serde(skip)]
    given: BTreeSet<String>,
    /// The tire files that were read.
    #[serde(skip)]
    tire_files: Vec<PathBuf>,
}

/// `[bus]`: where the frames come from.
#[derive(Clone, Debug, PartialEq, Eq, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct BusConfig {
    /// The CAN interface.
    pub interface: String,
    /// Receive FD frames, too.
    pub fd: bool,
    /// Kernel receive buffer, bytes: how long a pause the kernel bridges. Zero leaves its default.
    pub receive_buffer_bytes: usize,
}

impl Default for BusConfig {
    fn default() -> Self {
        Self { interface: "vcan0".into(), fd: false, receive_buffer_bytes: 1 << 20 }
    }
}

/// `[dbc]`: the car's DBC files, and optionally an own layout for what is published.
#[derive(Clone, Debug, PartialEq, Eq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct DbcConfig {
    /// The car's.
    pub input: Vec<PathBuf>,
    /// Ours; the built-in one if not given.
    #[serde(default)]
    pub output: Option<PathBuf>,
}

/// A configuration that cannot be used.
#[derive(Debug, Error)]
pub enum ConfigError {
    /// The file cannot be read.
    #[error("cannot read the configuration {path}: {source}{}", if source.kind() == std::io::ErrorKind::NotFound {
        "; give its path with -c (`gripd setup` makes one from a car's DBC and a recorded drive)"
    } else {
        ""
    })]
    Read {
        /// The file.
        path: PathBuf,
        /// Why.
        source: std::io::Error,
    },
    /// Not TOML, an unknown or missing key, or a value of the wrong kind; the message has the line.
    #[error("{path}: {message}")]
    Parse {
        /// The file.
        path: PathBuf,
        /// What and where.
        message: String,
    },
    /// A `[vehicle]` value that cannot be.
    #[error("{path}: {source}")]
    Vehicle {
        /// The file.
        path: PathBuf,
        /// Which, and why.
        source: VehicleError,
    },
    /// A value that makes no sense.
    #[error("{path}: {key}: {reason}")]
    Value {
        /// The file.
        path: PathBuf,
        /// The key.
        key: String,
        /// What is wrong and what to do.
        reason: String,
    },
    /// A tire file that cannot be used.
    #[error("{path}: vehicle.tire_file: {source}")]
    TireFile {
        /// The configuration.
        path: PathBuf,
        /// Which, and why.
        source: TireFileError,
    },
    /// A DBC file that cannot be used.
    #[error(transparent)]
    Dbc(#[from] DbcError),
}

impl Config {
    /// Reads and checks a file, and the tire files that it names; DBC files are not opened yet.
    ///
    /// # Errors
    /// Names the file and the line or key, what is wrong, and what to do.
    pub fn load(path: &Path) -> Result<Self, ConfigError> {
        let text = crate::plain_file::read_to_string(path)
            .map_err(|source| ConfigError::Read { path: path.to_owned(), source })?;
        Self::parse(&text, path)
    }

    /// The same from text; `path` is where its relative paths start, and what errors name.
    ///
    /// # Errors
    /// As [`Self::load`].
    pub fn parse(text: &str, path: &Path) -> Result<Self, ConfigError> {
        let mut config: Self = toml::from_str(text).map_err(|error| ConfigError::Parse {
            path: path.to_owned(),
            message: error.to_string().trim_end().to_owned(),
        })?;
        let folder = path.parent().unwrap_or(Path::new(""));
        for file in config.dbc.input.iter_mut().chain(config.dbc.output.as_mut()) {
            *file = folder.join(&*file);
        }
        // An empty name stays one: it means that nothing is kept.
        let ServiceConfig { state_file, record_faults, .. } = &mut config.service;
        for path in
            [state_file, record_faults].into_iter().flatten().filter(|path| !path.as_os_str().is_empty())
        {
            *path = folder.join(&*path);
        }
        if let Some(Address::Unix(socket)) = &mut config.service.metrics {
            *socket = folder.join(&*socket);
        }
        config.take_tire_files(text, path)?;
        config.validate(path)?;
        Ok(config)
    }

    fn validate_vehicle(&self, path: &Path) -> Result<(), ConfigError> {
        self.vehicle.validate().map_err(|source| ConfigError::Vehicle { path: path.to_owned(), source })
    }

    fn validate(&self, path: &Path) -> Result<(), ConfigError> {
        self.validate_vehicle(path)?;
        let fail = |key: &str, reason: String| {
            Err(ConfigError::Value { path: path.to_owned(), key: key.to_owned(), reason })
        };
        if let Some((place, key, reason)) = EffectConfig::problem_among(&self.effect) {
            return fail(&format!("effect[{place}].{key}"), reason);
        }
        if self.dbc.input.is_empty() {
            return fail("dbc.input", "name at least one DBC file of the car".into());
        }
        if let Some(file) = &self.service.state_file
            && (file == path
                || self.dbc.input.contains(file)
                || self.tire_files.contains(file)
                || self.dbc.output.as_ref() == Some(file))
        {
            return fail("service.state_file", "is written: give it a name of its own".into());
        }
        // One recording must fit, or the folder would always be empty.
        let ServiceConfig { record_files, record_bytes, .. } = self.service;
        if record_files == 0 || record_bytes < 100_000 {
            let key = if record_files == 0 { "record_files" } else { "record_bytes" };
            let reason = "is too little for one recording; leave record_faults out to have none";
            return fail(&format!("service.{key}"), reason.into());
        }
        if let Some((key, reason)) = self.estimators.problem() {
            return fail(&format!("estimators.{key}"), reason.into());
        }
        Ok(())
    }

    /// The files it names: none of them may become a result.
    pub fn files(&self) -> impl Iterator<Item = &PathBuf> {
        let read = self.dbc.input.iter().chain(&self.dbc.output).chain(&self.tire_files);
        read.chain(&self.service.state_file)
    }

    /// Does the file, or a tire file that it names, give this key of `[vehicle]`? If not, its value is a default.
    pub fn is_given(&self, key: &str) -> bool {
        self.given.contains(key)
    }

    /// The car's DBC files as one database.
    ///
    /// # Errors
    /// If a file cannot be read or is no DBC.
    pub fn input_database(&self) -> Result<Database, ConfigError> {
        Ok(Database::load_all(&self.dbc.input)?)
    }

    /// The layout of what is published.
    ///
    /// # Errors
    /// If the given file cannot be read or is no DBC.
    pub fn output_database(&self) -> Result<Database, ConfigError> {
        Ok(match &self.dbc.output {
            Some(path) => Database::load(path)?,
            None => built_in_database()?,
        })
    }
}
