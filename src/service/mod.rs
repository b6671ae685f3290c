//! The daemon: receive, estimate, publish.
//!
//! One task does all of it, in order: a frame is decoded, sampled, estimated and answered before the
//! next one is looked at. There is no queue between receiving and publishing that could grow old.

mod daemon;
mod endpoint;
mod engine;
mod health;
mod reload;
mod run;
mod said;
pub mod saved;
mod systemd;
mod throttle;

use std::path::PathBuf;

use serde::Deserialize;
use thiserror::Error;

use crate::can::CanId;
use crate::config::ConfigError;
use crate::dbc::DbcError;
use crate::signals::SignalsError;
use crate::signals::publish::PublishError;

pub use daemon::{Link, Service, Tally, serve};
pub use endpoint::{Address, Endpoint};
pub use engine::{Engine, EngineCounts, Sink, Survived, sensors};
pub use health::Health;
pub use reload::{Fresh, Reloads};
pub use run::{ServiceError, run};
pub use saved::{Keeper, SavedState};

/// `[service]`.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct ServiceConfig {
    /// A line with counts goes to the log this often, s; 0: never.
    pub report_every_s: u64,
    /// Where what was learned is kept between drives, relative to the configuration. Default: `learned.toml`
    /// in systemd's `STATE_DIRECTORY`, if there is one; `""`: nowhere.
    pub state_file: Option<PathBuf>,
    /// It is written after so many seconds of driving, and at the end, s; 0: at the end only.
    pub state_every_s: u64,
    /// Where Prometheus can read counts: the path of a Unix socket, relative to the configuration, or
    /// `127.0.0.1:PORT`. Default: nowhere.
    pub metrics: Option<Address>,
    /// Keep all memory in RAM: no page is waited for while a frame is handled.
    pub lock_memory: bool,
}

impl Default for ServiceConfig {
    fn default() -> Self {
        Self { report_every_s: 60, state_file: None, state_every_s: 60, metrics: None, lock_memory: false }
    }
}

/// A configuration that parses but cannot be set up.
#[derive(Debug, Error)]
pub enum SetupError {
    /// Reading the configuration or its DBC files.
    #[error(transparent)]
    Config(#[from] ConfigError),
    /// The mapping of `[signals]`.
    #[error(transparent)]
    Signals(#[from] SignalsError),
    /// The layout of what is published.
    #[error(transparent)]
    Publish(#[from] PublishError),
    /// An identifier that is both needed and published.
    #[error(
        "identifier {id} is needed as an input and would be published, too: \
         give the message another one in [publish.ids]"
    )]
    OwnIdentifier {
        /// The identifier.
        id: CanId,
    },
}

impl From<DbcError> for SetupError {
    fn from(error: DbcError) -> Self {
        Self::Config(error.into())
    }
}
