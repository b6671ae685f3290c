//! The daemon's loop.

use std::future::Future;
use std::pin::pin;
use std::time::{Duration, Instant};

use sd_notify::NotifyState;
use thiserror::Error;
use tokio::time::{Interval, MissedTickBehavior};

use super::throttle::Throttle;
use super::{Engine, Keeper, SavedState, SetupError, Sink};
use crate::can::{
    Bus, BusState, ErrorReport, Event, Frame, InterfaceName, OpenError, SendError, SocketCan, SocketCanConfig,
};
use crate::{Config, Estimates, Faults, Sample};

/// Something that frames come from and go to: a bus, or a stand-in with the same manners.
pub trait Link {
    /// The next thing that happens. Cancel-safe.
    fn recv(&mut self) -> impl Future<Output = Event>;
    /// Sends without waiting.
    ///
    /// # Errors
    /// If the frame could not be taken; it is then gone.
    fn try_send(&mut self, frame: &Frame) -> Result<(), SendError>;
}

impl Link for Bus {
    fn recv(&mut self) -> impl Future<Output = Event> {
        Bus::recv(self)
    }

    fn try_send(&mut self, frame: &Frame) -> Result<(), SendError> {
        Bus::try_send(self, frame)
    }
}

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

/// What a run of the daemon did.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Tally {
    /// Needed frames received.
    pub received: u64,
    /// Frames published.
    pub published: u64,
    /// Frames that could not be sent.
    pub unsent: u64,
    /// Frames lost before they could be read.
    pub dropped: u64,
}

/// Runs the service on SocketCAN until `shutdown` completes. The interface need not exist yet.
///
/// # Errors
/// If the configuration cannot be used or the kernel refuses a socket; never once it runs.
pub async fn run(
    config: &Config,
    interface: Option<&str>,
    shutdown: impl Future<Output = ()>,
) -> Result<Tally, ServiceError> {
    let mut engine = Engine::new(config)?;
    let name = interface.unwrap_or(&config.bus.interface);
    let ids = Some(engine.ids().to_vec());
    let input = open(name, ids, config)?;
    let output = match config.publish.interface.as_deref() {
        Some(other) if other != name => Some(open(other, Some(Vec::new()), config)?),
        _ => None,
    };
    tracing::info!(
        input = name,
        output = config.publish.interface.as_deref().unwrap_or(name),
        identifiers = engine.ids().len(),
        "gripd {} runs",
        env!("CARGO_PKG_VERSION")
    );
    // Last: what cannot run leaves the file alone.
    let state = SavedState::of_service(config, std::env::var_os("STATE_DIRECTORY").as_deref());
    let every_s = config.service.state_every_s;
    let keeper = state.and_then(|state| Keeper::start(state, every_s, &mut engine));
    let report_every_s = config.service.report_every_s;
    Ok(serve(engine, input, output, &mut Unobserved, keeper, report_every_s, shutdown).await)
}

fn open(name: &str, ids: Option<Vec<crate::can::CanId>>, config: &Config) -> Result<Bus, ServiceError> {
    let interface: InterfaceName = name.parse().map_err(|e| ServiceError::Interface(format!("{e}")))?;
    let receive_buffer = Some(config.bus.receive_buffer_bytes).filter(|bytes| *bytes > 0);
    let config = SocketCanConfig { interface, ids, fd: config.bus.fd, receive_buffer };
    Ok(SocketCan::open(config)?.into())
}

/// The loop itself, on any link. `observer` sees every sample with its estimates, and every frame
/// that is published; `keeper` saves what is learned, where it is to be saved.
pub async fn serve<L: Link>(
    engine: Engine,
    mut input: L,
    mut output: Option<L>,
    observer: &mut impl Sink,
    mut keeper: Option<Keeper>,
    report_every_s: u64,
    shutdown: impl Future<Output = ()>,
) -> Tally {
    let mut daemon = Daemon::new(engine);
    let mut shutdown = pin!(shutdown);
    let mut watchdog = watchdog();
    let mut report = every(Duration::from_secs(report_every_s));
    // Ready means: sockets are open. The interface may come later; the status says so.
    notify(&[NotifyState::Ready]);
    loop {
        tokio::select! {
            biased;
            () = &mut shutdown => break,
            () = tick(&mut watchdog) => notify(&[NotifyState::Watchdog]),
            () = tick(&mut report) => daemon.report(),
            // Before the input, which may never be silent: this one only has news of its state.
            event = next(&mut output) => daemon.output(event),
            event = input.recv() => {
                daemon.input(event, observer);
                let target = output.as_mut().unwrap_or(&mut input);
                daemon.send(target, observer);
                if let Some(keeper) = &mut keeper {
                    keeper.offer(&daemon.engine);
                }
            }
        }
    }
    notify(&[NotifyState::Stopping]);
    daemon.report();
    if let Some(keeper) = keeper {
        keeper.finish(&daemon.engine);
    }
    daemon.tally
}

/// For those who only want frames on the bus.
struct Unobserved;

impl Sink for Unobserved {
    fn publish(&mut self, _frame: &Frame) {}
}

struct Daemon {
    engine: Engine,
    /// Frames on their way out; emptied after each frame that comes in.
    outbox: Vec<Frame>,
    tally: Tally,
    said: Said,
}

/// What was said lately, so that a bad day does not fill the log.
#[derive(Debug, Default)]
struct Said {
    dropped: Throttle,
    unsent: Throttle,
    bus_off: Throttle,
    bus_state: Throttle,
}

/// Collects what the engine publishes, and shows estimates to the observer.
struct Collect<'a, S> {
    outbox: &'a mut Vec<Frame>,
    observer: &'a mut S,
}

impl<S: Sink> Sink for Collect<'_, S> {
    fn estimates(&mut self, sample: &Sample, estimates: &Estimates) {
        self.observer.estimates(sample, estimates);
    }

    fn publish(&mut self, frame: &Frame) {
        self.outbox.push(*frame);
    }
}

impl Daemon {
    fn new(engine: Engine) -> Self {
        Self { engine, outbox: Vec::with_capacity(16), tally: Tally::default(), said: Said::default() }
    }

    fn input(&mut self, event: Event, observer: &mut impl Sink) {
        match event {
            Event::Frame(frame) => {
                self.tally.received += 1;
                self.engine.frame(&frame, &mut Collect { outbox: &mut self.outbox, observer });
            }
            Event::Dropped(count) => {
                self.tally.dropped += u64::from(count);
                self.engine.report_dropped(u64::from(count));
                if self.said.dropped.pass(Instant::now()).is_some() {
                    let total = self.tally.dropped;
                    tracing::warn!(count, total, "the kernel dropped frames: we are too slow");
                }
            }
            Event::Error(error) => {
                self.engine.report(Faults::BUS_ERROR);
                self.say_error("input", error);
            }
            Event::Up => {
                tracing::info!("the input interface is up");
                notify(&[NotifyState::Status("the input interface is up")]);
            }
            Event::Down | Event::Gone => {
                self.engine.report(Faults::BUS_DOWN);
                let text = if event == Event::Down { "is down" } else { "does not exist" };
                tracing::warn!("the input interface {text}; waiting for it");
                notify(&[NotifyState::Status("waiting for the input interface")]);
            }
        }
    }

    fn output(&mut self, event: Event) {
        match event {
            Event::Up => tracing::info!("the output interface is up"),
            Event::Down => tracing::warn!("the output interface is down; nothing can be published"),
            Event::Gone => tracing::warn!("the output interface does not exist; nothing can be published"),
            Event::Error(error) => {
                self.engine.report(Faults::BUS_ERROR);
                self.say_error("output", error);
            }
            Event::Frame(_) | Event::Dropped(_) => {}
        }
    }

    /// What cannot be sent now is dropped: later it would be a stale value with a live counter.
    fn send(&mut self, link: &mut impl Link, observer: &mut impl Sink) {
        for frame in &self.outbox {
            match link.try_send(frame) {
                Ok(()) => {
                    self.tally.published += 1;
                    observer.publish(frame);
                }
                Err(error) => {
                    self.tally.unsent += 1;
                    self.engine.report(Faults::BUS_ERROR);
                    if self.said.unsent.pass(Instant::now()).is_some() {
                        tracing::warn!(total = self.tally.unsent, "a frame was not sent: {error}");
                    }
                }
            }
        }
        self.outbox.clear();
    }

    /// Changes of the controller's state, each at its own level; single errors are for debugging only.
    fn say_error(&mut self, place: &str, error: ErrorReport) {
        let Some(state) = error.bus_state() else {
            tracing::debug!("{place}: {error}");
            return;
        };
        let said = if state == BusState::Off { &mut self.said.bus_off } else { &mut self.said.bus_state };
        let Some(withheld) = said.pass(Instant::now()) else { return };
        match state {
            BusState::Off => tracing::error!(withheld, "{place}: {error}"),
            BusState::Passive | BusState::Warning => tracing::warn!(withheld, "{place}: {error}"),
            BusState::Active => tracing::info!(withheld, "{place}: {error}"),
        }
    }

    fn report(&self) {
        let Tally { received, published, unsent, dropped } = self.tally;
        tracing::info!(received, published, unsent, dropped, "frames so far");
    }
}

async fn next<L: Link>(link: &mut Option<L>) -> Event {
    match link {
        Some(link) => link.recv().await,
        None => std::future::pending().await,
    }
}

async fn tick(interval: &mut Option<Interval>) {
    match interval {
        Some(interval) => drop(interval.tick().await),
        None => std::future::pending().await,
    }
}

/// Twice as often as systemd wants to hear from us.
fn watchdog() -> Option<Interval> {
    sd_notify::watchdog_enabled().and_then(|period| every(period / 2))
}

fn every(period: Duration) -> Option<Interval> {
    (!period.is_zero()).then(|| {
        let start = tokio::time::Instant::now() + period;
        let mut interval = tokio::time::interval_at(start, period);
        interval.set_missed_tick_behavior(MissedTickBehavior::Delay);
        interval
    })
}

/// Tells systemd, where there is one.
fn notify(states: &[NotifyState]) {
    if let Err(error) = sd_notify::notify(states) {
        tracing::debug!("systemd was not told: {error}");
    }
}
