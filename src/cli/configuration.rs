//! The configuration file: each room reads its own table of it.

use std::path::Path;

use bus::Config;
use bus::config::ConfigError;
use lab::identify::IdentifyConfig;

/// What the bus's side reads; the tables of the others are checked, too.
pub fn load(path: &Path) -> Result<Config, ConfigError> {
    load_all(path).map(|(config, _)| config)
}

/// The same, and `[identify]`.
pub fn load_all(path: &Path) -> Result<(Config, IdentifyConfig), ConfigError> {
    let config = Config::load(path)?;
    let text = bus::plain_file::read_to_string(path)
        .map_err(|source| ConfigError::Read { path: path.to_owned(), source })?;
    let identify = IdentifyConfig::of_file(&text)
        .map_err(|error| ConfigError::Parse { path: path.to_owned(), message: error.to_string() })?;
    Ok((config, identify))
}

/// As the service takes it: its effects are put where it can use them.
pub fn for_the_service(path: &Path) -> Result<Config, ConfigError> {
    let config = load(path)?.corrected();
    for effect in &config.effect {
        tracing::warn!(
            "{}: effect {} is for simulations: nothing is corrected for it",
            path.display(),
            effect.kind().name
        );
    }
    Ok(config)
}
