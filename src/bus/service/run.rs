//! The daemon on SocketCAN: what is opened and read before its loop begins.

use std::future::Future;
use std::sync::Arc;

use nix::sys::mman::{MlockAllFlags, mlockall};
use thiserror::Error;
use tokio::sync::mpsc::Receiver;

use super::saved::Part;
use super::{
    BlackBox, Endpoint, Engine, Health, Keeper, Reloads, SavedState, Service, SetupError, Sink, Tally, serve,
};
use crate::Config;
use crate::can::{Bus, CanId, Frame, InterfaceName, OpenError, Reception, SocketCan, SocketCanConfig};

/// Why the daemon did not start.
#[derive(Debug, Error)]
pub enum ServiceError {
    /// The configuration.
    #[error(transparent)]
    Setup(#[from] SetupError),
    /// The interface's name.
    #[error("{0}")]
    Interface(String),
    /// The interface.
    #[error(transparent)]
    Open(#[from] OpenError),
}

/// Runs the service on SocketCAN until `shutdown` completes. The interface need not exist yet. What `forgets` brings is
/// forgotten.
///
/// # Errors
/// If the configuration cannot be used or the kernel refuses a socket; never once it runs.
pub async fn run(
    config: &Config,
    interface: Option<&str>,
    reloads: Option<Reloads>,
    forgets: Option<Receiver<&'static [Part]>>,
    shutdown: impl Future<Output = ()>,
) -> Result<Tally, ServiceError> {
    let mut engine = Engine::new(config)?;
    let name = interface.unwrap_or(&config.bus.interface);
    let output = config.publish.interface.as_deref().filter(|other| *other != name);
    let input = open(name, input_reception(config, &engine, output.is_none()))?;
    let output = output.map(|other| open(other, output_reception(config, &engine))).transpose()?;
    if engine.publisher().needs_fd() && !config.bus.fd {
        tracing::warn!(
            "the output DBC has FD messages, but `fd = true` is missing in [bus]: they cannot be sent"
        );
    }
    tracing::info!(
        input = name,
        output = config.publish.interface.as_deref().unwrap_or(name),
        identifiers = engine.ids().len(),
        "gripd {} runs",
        env!("CARGO_PKG_VERSION")
    );
    // Last: what cannot run leaves the file alone.
    let keeper = SavedState::of_process(config)
        .and_then(|state| Keeper::start(state, config.service.state_every_s, &mut engine));
    let report_every_s = config.service.report_every_s;
    // Kept until the end: then it takes its socket away.
    let (health, _endpoint) = watched(config).unzip();
    if config.service.lock_memory {
        lock_memory();
    }
    let published_on = config.publish.interface.as_deref().unwrap_or(name);
    let black_box = BlackBox::start(&config.service, name, published_on, &engine);
    let service =
        Service { engine, input, output, keeper, black_box, report_every_s, reloads, forgets, health };
    Ok(serve(service, &mut Unobserved, shutdown).await)
}

/// The endpoint that is configured, if it can be had: nobody who watches is no reason not to run.
fn watched(config: &Config) -> Option<(Arc<Health>, Endpoint)> {
    let address = config.service.metrics.as_ref()?;
    let health = Arc::new(Health::default());
    match Endpoint::start(address, Arc::clone(&health)) {
        Ok(endpoint) => {
            tracing::info!("metrics at {address}");
            Some((health, endpoint))
        }
        Err(error) => {
            tracing::warn!(
                "service.metrics: {address} cannot be opened: {error}; the service goes on without"
            );
            None
        }
    }
}

fn lock_memory() {
    if let Err(errno) = mlockall(MlockAllFlags::MCL_CURRENT | MlockAllFlags::MCL_FUTURE) {
        tracing::warn!(
            "service.lock_memory: the memory cannot be locked: {errno}; allow it by LimitMEMLOCK= in the unit, or \
             `ulimit -l`. The service goes on without"
        );
    }
}

/// What the input's socket is to receive: what is needed and, if that is where we publish, whatever comes under our own
/// identifiers. Own frames do not come back, so that those are somebody else's.
pub(super) fn input_reception(config: &Config, engine: &Engine, publishes: bool) -> Reception {
    let own = engine.publisher().ids().iter().filter(|_| publishes);
    reception(config, engine.ids().iter().chain(own).copied().collect())
}

/// What the socket of an output of its own is to receive: what comes under our own identifiers.
pub(super) fn output_reception(config: &Config, engine: &Engine) -> Reception {
    reception(config, engine.publisher().ids().to_vec())
}

fn reception(config: &Config, ids: Vec<CanId>) -> Reception {
    let receive_buffer = Some(config.bus.receive_buffer_bytes).filter(|bytes| *bytes > 0);
    Reception { ids: Some(ids), fd: config.bus.fd, receive_buffer }
}

fn open(name: &str, reception: Reception) -> Result<Bus, ServiceError> {
    let interface: InterfaceName = name.parse().map_err(|e| ServiceError::Interface(format!("{e}")))?;
    let Reception { ids, fd, receive_buffer } = reception;
    Ok(SocketCan::open(SocketCanConfig { interface, ids, fd, receive_buffer })?.into())
}

/// For those who only want frames on the bus.
struct Unobserved;

impl Sink for Unobserved {
    fn publish(&mut self, _frame: &Frame) {}
}
