//! The daemon's loop.

use std::future::Future;
use std::io;
use std::pin::pin;
use std::sync::Arc;
use std::time::Duration;

use tokio::time::{Interval, MissedTickBehavior};

use super::run::reception;
use super::said::Said;
use super::{Engine, Fresh, Health, Keeper, Reloads, Sink, Survived, systemd};
use crate::can::{Bus, Event, Frame, Reception, SendError};
use physics::{Estimates, Faults, Sample};

/// Something that frames come from and go to: a bus, or a stand-in with the same manners.
pub trait Link {
    /// The next thing that happens. Cancel-safe.
    fn recv(&mut self) -> impl Future<Output = Event>;
    /// Sends without waiting.
    ///
    /// # Errors
    /// If the frame could not be taken; it is then gone.
    fn try_send(&mut self, frame: &Frame) -> Result<(), SendError>;
    /// Receives something else from now on; one that hands on everything has nothing to do.
    ///
    /// # Errors
    /// If that cannot be; then everything is as before.
    fn retune(&mut self, _reception: Reception) -> io::Result<()> {
        Ok(())
    }
}

impl Link for Bus {
    fn recv(&mut self) -> impl Future<Output = Event> {
        Bus::recv(self)
    }

    fn try_send(&mut self, frame: &Frame) -> Result<(), SendError> {
        Bus::try_send(self, frame)
    }

    fn retune(&mut self, reception: Reception) -> io::Result<()> {
        Bus::retune(self, reception)
    }
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

/// What the loop works with.
pub struct Service<L> {
    /// Decodes, estimates, publishes.
    pub engine: Engine,
    /// Where frames come from.
    pub input: L,
    /// Where frames go to; `None`: where they come from.
    pub output: Option<L>,
    /// Saves what is learned, where it is to be saved.
    pub keeper: Option<Keeper>,
    /// A line with counts goes to the log this often, s; 0: never.
    pub report_every_s: u64,
    /// Brings other configurations; `None`: there is only the one.
    pub reloads: Option<Reloads>,
    /// Counts for whoever watches.
    pub health: Option<Arc<Health>>,
}

impl<L> Service<L> {
    /// One link, and nothing that need not be.
    pub fn new(engine: Engine, input: L) -> Self {
        Self { engine, input, output: None, keeper: None, report_every_s: 0, reloads: None, health: None }
    }
}

/// The loop itself, on any link. `observer` sees every sample with its estimates, and every frame
/// that is published.
pub async fn serve<L: Link>(
    service: Service<L>,
    observer: &mut impl Sink,
    shutdown: impl Future<Output = ()>,
) -> Tally {
    let Service { engine, mut input, mut output, mut keeper, report_every_s, mut reloads, health } = service;
    let mut daemon = Daemon::new(engine, health);
    let mut shutdown = pin!(shutdown);
    let mut watchdog = systemd::watchdog_period().and_then(every);
    let mut report = every(Duration::from_secs(report_every_s));
    // Ready means: sockets are open. The interface may come later; the status says so.
    systemd::ready();
    loop {
        tokio::select! {
            biased;
            () = &mut shutdown => break,
            // From this loop and no other task: while a frame takes for ever, systemd hears nothing.
            () = tick(&mut watchdog) => systemd::alive(),
            () = tick(&mut report) => daemon.report(),
            fresh = next_reload(&mut reloads) => {
                let accepted = fresh.and_then(|fresh| {
                    retune(&fresh, &mut input, output.as_mut())?;
                    report = every(Duration::from_secs(fresh.config.service.report_every_s));
                    keeper = daemon.reload(fresh, keeper.take(), observer);
                    Ok(())
                });
                daemon.reloaded(accepted);
            }
            // Before the input, which may never be silent: this one only has news of its state.
            event = next(&mut output) => daemon.output(event),
            event = input.recv() => {
                daemon.input(event, observer);
                let target = output.as_mut().unwrap_or(&mut input);
                daemon.send(target, observer);
                daemon.show();
                if let Some(keeper) = &mut keeper {
                    keeper.offer(&daemon.engine);
                }
            }
        }
    }
    systemd::stopping();
    daemon.report();
    if let Some(keeper) = keeper {
        keeper.finish(&daemon.engine);
    }
    daemon.tally
}

struct Daemon {
    engine: Engine,
    /// Frames on their way out; emptied after each frame that comes in.
    outbox: Vec<Frame>,
    tally: Tally,
    said: Said,
    /// What systemd was last told of the input.
    status: &'static str,
    health: Option<Arc<Health>>,
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
    fn new(engine: Engine, health: Option<Arc<Health>>) -> Self {
        let (outbox, status) = (Vec::with_capacity(16), "starting");
        Self { engine, outbox, tally: Tally::default(), said: Said::default(), status, health }
    }

    fn input(&mut self, event: Event, observer: &mut impl Sink) {
        match event {
            Event::Frame(frame) => {
                self.tally.received += 1;
                self.engine.frame(&frame, &mut Collect { outbox: &mut self.outbox, observer });
                self.said.doubts(&self.engine);
            }
            Event::Dropped(count) => {
                self.tally.dropped += u64::from(count);
                self.engine.report_dropped(u64::from(count));
                self.said.dropped(count, self.tally.dropped);
            }
            Event::Error(error) => {
                self.engine.report(Faults::BUS_ERROR);
                self.said.error("input", error);
            }
            Event::Up => {
                self.set_up(true);
                self.tell("the input interface is up");
                self.said.link("input", event);
            }
            Event::Down | Event::Gone => {
                self.engine.report(Faults::BUS_DOWN);
                self.set_up(false);
                self.tell("waiting for the input interface");
                self.said.link("input", event);
            }
        }
    }

    fn set_up(&self, up: bool) {
        if let Some(health) = &self.health {
            health.set_input_up(up);
        }
    }

    fn show(&self) {
        if let Some(health) = &self.health {
            health.update(&self.tally, &self.engine);
        }
    }

    fn tell(&mut self, status: &'static str) {
        self.status = status;
        systemd::status(status);
    }

    /// Between two frames: what is read anew takes over.
    fn reload(&mut self, fresh: Fresh, keeper: Option<Keeper>, observer: &mut impl Sink) -> Option<Keeper> {
        let Fresh { config, engine, state, learned: kept } = fresh;
        let before = std::mem::replace(&mut self.engine, engine);
        let learned = before.learned();
        let survived = self.engine.take_over(before, &mut Collect { outbox: &mut self.outbox, observer });
        if let (Survived::Nothing, Some(kept)) = (survived, kept) {
            self.engine.restore(&kept);
        }
        tracing::info!(
            identifiers = self.engine.ids().len(),
            "the new configuration is in use; {}",
            match survived {
                Survived::Everything => "the estimators go on",
                Survived::Learned => "the estimators begin anew with what was learned",
                Survived::Nothing => "[vehicle] or the mapping is another one: the estimators begin anew",
            }
        );
        Keeper::follow(keeper, &learned, state, config.service.state_every_s, &self.engine)
    }

    /// Until there is a good one, each status frame tells of a configuration that was refused.
    fn reloaded(&mut self, accepted: Result<(), String>) {
        self.engine.set_lasting(Faults::CONFIG, accepted.is_err());
        if let Some(health) = &self.health {
            health.count_reload(accepted.is_ok());
        }
        match accepted {
            Ok(()) => systemd::status(self.status),
            Err(reason) => {
                tracing::error!("the new configuration is refused, the one before stays in use: {reason}");
                systemd::status("the new configuration is refused, see the log; the one before is in use");
            }
        }
        systemd::ready();
    }

    fn output(&mut self, event: Event) {
        match event {
            Event::Up | Event::Down | Event::Gone => self.said.link("output", event),
            Event::Error(error) => {
                self.engine.report(Faults::BUS_ERROR);
                self.said.error("output", error);
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
                    self.engine.untold();
                    self.said.unsent(self.tally.unsent, &error);
                }
            }
        }
        self.outbox.clear();
    }

    fn report(&self) {
        let Tally { received, published, unsent, dropped } = self.tally;
        tracing::info!(received, published, unsent, dropped, "frames so far; {}", self.status);
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

async fn next_reload(reloads: &mut Option<Reloads>) -> Result<Fresh, String> {
    match reloads {
        Some(reloads) => reloads.next().await,
        None => std::future::pending().await,
    }
}

/// Filters and buffers of what the new configuration needs, before it takes over.
fn retune<L: Link>(fresh: &Fresh, input: &mut L, output: Option<&mut L>) -> Result<(), String> {
    let refused = |error| format!("the kernel does not take the receive filters: {error}");
    input.retune(reception(&fresh.config, fresh.engine.ids())).map_err(refused)?;
    output.map_or(Ok(()), |output| output.retune(reception(&fresh.config, &[]))).map_err(refused)
}

fn every(period: Duration) -> Option<Interval> {
    (!period.is_zero()).then(|| {
        let start = tokio::time::Instant::now() + period;
        let mut interval = tokio::time::interval_at(start, period);
        interval.set_missed_tick_behavior(MissedTickBehavior::Delay);
        interval
    })
}
