//! The demo car, built in: its configuration and DBC need no files.

use std::path::Path;

use super::Failure;
use bus::Config;
use bus::dbc::Database;

const CONFIGURATION: &str = include_str!("../../../config/demo.toml");
const DBC: &str = include_str!("../../../dbc/demo.dbc");

/// Its configuration, and the database that goes with it.
pub fn configuration() -> Result<(Config, Database), Failure> {
    let config = Config::parse(CONFIGURATION, Path::new("demo.toml (built in)"))?;
    let database = Database::parse(DBC.as_bytes(), "demo.dbc (built in)").map_err(Failure::work)?;
    Ok((config, database))
}
