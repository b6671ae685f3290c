//! `gripd run`: the service on SocketCAN.

use std::path::PathBuf;
use std::sync::Arc;

use clap::Args;
use tokio::signal::unix::{SignalKind, signal};
use tokio::sync::Notify;
use tokio::sync::mpsc::channel;

use super::Failure;
use bus::service::saved::Part;
use bus::service::{self, Reloads, ServiceError};

/// Ends cleanly on SIGINT and SIGTERM; reads its configuration anew on SIGHUP; forgets what it learned on SIGUSR1, and
/// on SIGUSR2 what it learned of tires and radii.
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
            let mut everything = signal(SignalKind::user_defined1()).map_err(Failure::work)?;
            let mut tires = signal(SignalKind::user_defined2()).map_err(Failure::work)?;
            let (forget, forgets) = channel::<&'static [Part]>(4);
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
                        // Full: it is being forgotten.
                        _ = everything.recv() => drop(forget.try_send(&Part::ALL)),
                        _ = tires.recv() => drop(forget.try_send(&[Part::Tires, Part::Radii])),
                    }
                };
                tracing::info!("{name}: shutting down");
            };
            match service::run(&config, self.interface.as_deref(), Some(reloads), Some(forgets), shutdown)
                .await
            {
                Ok(_) => Ok(()),
                Err(ServiceError::Open(error)) => Err(Failure::work(error)),
                Err(error) => Err(Failure::usage(error)),
            }
        })
    }
}
