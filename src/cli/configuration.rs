//! The configuration file: each room reads its own table of it.

use std::path::Path;

use bus::Config;
use bus::config::ConfigError;
#[cfg(feature = "desk")]
use fmu::foreign::FmuConfig;
#[cfg(feature = "desk")]
use identify::IdentifyConfig;
use physics::estimate::PlainReadings;

/// What the bus's side reads; the tables of the others are checked, too, where this build has them.
pub fn load(path: &Path) -> Result<Config, ConfigError> {
    let config = Config::load(path)?;
    #[cfg(feature = "desk")]
    {
        identify(path)?;
        fmu(path)?;
    }
    Ok(config)
}

/// The `[identify]` table.
#[cfg(feature = "desk")]
pub fn identify(path: &Path) -> Result<IdentifyConfig, ConfigError> {
    table(path, |text| IdentifyConfig::of_file(text).map_err(|error| error.to_string()))
}

/// The `[fmu]` table.
#[cfg(feature = "desk")]
pub fn fmu(path: &Path) -> Result<FmuConfig, ConfigError> {
    table(path, FmuConfig::of_file)
}

#[cfg(feature = "desk")]
fn table<T>(path: &Path, of_file: impl Fn(&str) -> Result<T, String>) -> Result<T, ConfigError> {
    let text = bus::plain_file::read_to_string(path)
        .map_err(|source| ConfigError::Read { path: path.to_owned(), source })?;
    of_file(&text).map_err(|message| ConfigError::Parse { path: path.to_owned(), message })
}

/// As the service takes it: its effects are put where it can use them.
pub fn for_the_service(path: &Path) -> Result<Config, ConfigError> {
    let config = load(path)?.corrected();
    for effect in config.effect.iter().filter(|effect| !PlainReadings::takes(&config.vehicle, effect)) {
        tracing::warn!(
            "{}: effect {} is for simulations: what it changes of tires, loads or road is estimated as it drives",
            path.display(),
            effect.kind().name
        );
    }
    Ok(config)
}
