//! The daemon: receive, estimate, publish.
//!
//! One task does all of it, in order: a frame is decoded, sampled, estimated and answered before the
//! next one is looked at. There is no queue between receiving and publishing that could grow old.

mod black_box;
mod daemon;
mod endpoint;
mod engine;
mod health;
mod link;
mod reload;
mod rounds;
mod run;
mod said;
pub mod saved;
mod systemd;
mod throttle;
mod waits;

use thiserror::Error;

use crate::can::CanId;
use crate::config::ConfigError;
use crate::dbc::DbcError;
use crate::signals::SignalsError;
use crate::signals::publish::PublishError;

pub use black_box::BlackBox;
pub use daemon::{Service, Tally, serve};
pub use endpoint::Endpoint;
pub use engine::{Engine, EngineCounts, Sink, Survived, sensors};
pub use health::Health;
pub use link::Link;
pub use reload::{Fresh, Reloads};
pub use run::{ServiceError, run};
pub use saved::{Keeper, SavedState};

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
