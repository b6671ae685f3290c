//! `gripd run`: the service on SocketCAN.

use std::path::PathBuf;

use clap::Args;
use tokio::signal::unix::{SignalKind, signal};

use super::Failure;
use crate::service::{self, ServiceError};

/// Ends cleanly on SIGINT and SIGTERM; SIGHUP changes nothing.
#[derive(Args)]
pub struct Run {
    /// Configuration of the car.
    #[arg(short, long)]
    config: PathBuf,
    /// The CAN interface, instead of the configuration's.
    #[arg(short, long, value_name = "IF")]
    interface: Option<String>,
}

impl Run {
    /// Runs it.
    pub fn run(self) -> Result<(), Failure> {
        let config = super::for_the_service(&self.config)?;
        // One thread: frames are handled in order, and nothing waits for another core.
        let runtime =
            tokio::runtime::Builder::new_current_thread().enable_all().build().map_err(Failure::work)?;
        runtime.block_on(async {
            let mut interrupt = signal(SignalKind::interrupt()).map_err(Failure::work)?;
            let mut terminate = signal(SignalKind::terminate()).map_err(Failure::work)?;
            let mut hangup = signal(SignalKind::hangup()).map_err(Failure::work)?;
            let shutdown = async move {
                let name = loop {
                    tokio::select! {
                        _ = interrupt.recv() => break "SIGINT",
                        _ = terminate.recv() => break "SIGTERM",
                        _ = hangup.recv() => tracing::warn!(
                            "SIGHUP: the configuration is read at the start only; restart to change it"
                        ),
                    }
                };
                tracing::info!("{name}: shutting down");
            };
            match service::run(&config, self.interface.as_deref(), shutdown).await {
                Ok(_) => Ok(()),
                Err(ServiceError::Open(error)) => Err(Failure::work(error)),
                Err(error) => Err(Failure::usage(error)),
            }
        })
    }
}
