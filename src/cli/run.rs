//! `gripd run`: the service on SocketCAN.

use std::path::PathBuf;
use std::sync::Arc;

use clap::Args;
use tokio::signal::unix::{SignalKind, signal};
use tokio::sync::Notify;

use super::Failure;
use bus::service::{self, Reloads, ServiceError};

/// Ends cleanly on SIGINT and SIGTERM; reads its configuration anew on SIGHUP.
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
        let config = super::configuration::for_the_service(&self.config)?;
        // One thread: frames are handled in order, and nothing waits for another core.
        let runtime =
            tokio::runtime::Builder::new_current_thread().enable_all().build().map_err(Failure::work)?;
        runtime.block_on(async {
            let mut interrupt = signal(SignalKind::interrupt()).map_err(Failure::work)?;
            let mut terminate = signal(SignalKind::terminate()).map_err(Failure::work)?;
            let mut hangup = signal(SignalKind::hangup()).map_err(Failure::work)?;
            let bell = Arc::new(Notify::new());
            let reloads = Reloads::new(&config, Arc::clone(&bell), move || {
                super::configuration::for_the_service(&self.config)
            });
            let shutdown = async move {
                let name = loop {
                    tokio::select! {
                        _ = interrupt.recv() => break "SIGINT",
                        _ = terminate.recv() => break "SIGTERM",
                        _ = hangup.recv() => bell.notify_one(),
                    }
                };
                tracing::info!("{name}: shutting down");
            };
            match service::run(&config, self.interface.as_deref(), Some(reloads), shutdown).await {
                Ok(_) => Ok(()),
                Err(ServiceError::Open(error)) => Err(Failure::work(error)),
                Err(error) => Err(Failure::usage(error)),
            }
        })
    }
}
