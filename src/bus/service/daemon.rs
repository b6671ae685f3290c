//! The daemon's loop.

use std::future::Future;
use std::pin::pin;
use std::sync::Arc;
use std::time::Duration;

use tokio::sync::mpsc::Receiver;
use tokio::time::Interval;

use super::link::{next, retune};
use super::rounds::{Rounds, Verdict};
use super::said::Said;
use super::saved::Part;
use super::waits::{Waits, every, next_forget, next_reload, tick};
use super::{BlackBox, Engine, Fresh, Health, Keeper, Link, Reloads, Sink, Survived, systemd};
use crate::can::{Event, Frame};
use physics::{Estimates, Faults, Micros, Sample};

/// What a run of the daemon did.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Tally {
    /// Needed frames received.
    pub received: u64,
    /// Frames published.
    pub published: u64,
    /// Frames that could not be sent.
    pub unsent: u64,
    /// Frames that were not sent because they would have been too late.
    pub late: u64,
    /// Frames of somebody else with an identifier that we publish on.
    pub foreign: u64,
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
    /// Records what is on the bus around faults, where it is to be recorded.
    pub black_box: Option<BlackBox>,
    /// A line with counts goes to the log this often, s; 0: never.
    pub report_every_s: u64,
    /// Brings other configurations; `None`: there is only the one.
    pub reloads: Option<Reloads>,
    /// What is to be forgotten while it runs.
    pub forgets: Option<Receiver<&'static [Part]>>,
    /// Counts for whoever watches.
    pub health: Option<Arc<Health>>,
}

impl<L> Service<L> {
    /// One link, and nothing that need not be.
    pub fn new(engine: Engine, input: L) -> Self {
        Self {
            engine,
            input,
            output: None,
            keeper: None,
            black_box: None,
            report_every_s: 0,
            reloads: None,
            forgets: None,
            health: None,
        }
    }
}

/// The loop itself, on any link. `observer` sees every sample with its estimates, and every frame
/// that is published.
pub async fn serve<L: Link>(
    service: Service<L>,
    observer: &mut impl Sink,
    shutdown: impl Future<Output = ()>,
) -> Tally {
    let Service {
        engine,
        mut input,
        mut output,
        mut keeper,
        black_box,
        report_every_s,
        mut reloads,
        mut forgets,
        health,
    } = service;
    let mut daemon = Daemon::new(engine, health, black_box, output.is_none());
    let mut beat = daemon.beat();
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
                beat = daemon.beat();
            }
            parts = next_forget(&mut forgets) => {
                tracing::info!("forgets what it learned: {parts:?}");
                daemon.engine.forget(parts);
                if let Some(keeper) = &mut keeper {
                    keeper.forgotten(&daemon.engine);
                }
            }
            // Before the input, which may never be silent: this one only has news of its state.
            event = next(&mut output) => daemon.output(event),
            event = input.recv() => {
                daemon.input(event, observer);
                let now = input.now();
                let target = output.as_mut().unwrap_or(&mut input);
                daemon.send(now, target, observer, false);
                daemon.show();
                if let Some(keeper) = &mut keeper {
                    keeper.offer(&daemon.engine);
                    daemon.show_contradiction(keeper);
                }
            }
            // After the input: all that came is read when it is these branches' turn.
            () = daemon.waits.over() => {
                let now = input.now();
                daemon.send(now, output.as_mut().unwrap_or(&mut input), observer, true);
            }
            () = tick(&mut beat) => {
                let now = input.now();
                daemon.idle(now, observer);
                daemon.send(now, output.as_mut().unwrap_or(&mut input), observer, true);
                daemon.show();
            }
        }
    }
    systemd::stopping();
    if let Some(now) = input.now() {
        daemon.farewell(now, output.as_mut().unwrap_or(&mut input), observer);
    }
    daemon.report();
    if let Some(keeper) = keeper {
        keeper.finish(&daemon.engine);
    }
    if let Some(black_box) = daemon.black_box {
        black_box.finish();
    }
    daemon.tally
}

struct Daemon {
    engine: Engine,
    /// What is on its way out.
    rounds: Rounds,
    waits: Waits,
    /// The input is where we publish, too.
    shares: bool,
    /// The link that we publish on is up.
    can_send: bool,
    tally: Tally,
    said: Said,
    /// What systemd was last told of the input.
    status: &'static str,
    health: Option<Arc<Health>>,
    black_box: Option<BlackBox>,
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
    fn new(engine: Engine, health: Option<Arc<Health>>, black_box: Option<BlackBox>, shares: bool) -> Self {
        Self {
            engine,
            rounds: Rounds::new(),
            waits: Waits::Not,
            shares,
            can_send: false,
            tally: Tally::default(),
            said: Said::default(),
            status: "starting",
            health,
            black_box,
        }
    }

    /// As often as rounds are due.
    fn beat(&self) -> Option<Interval> {
        every(Duration::from_micros(self.engine.publisher().period().0.unsigned_abs()))
    }

    /// Somebody else's frame under our own name? Own ones do not come back.
    fn is_foreign(&self, frame: &Frame) -> bool {
        frame.is_data() && self.engine.publisher().ids().contains(&frame.id)
    }

    fn foreign(&mut self, frame: &Frame) {
        self.tally.foreign += 1;
        self.engine.report(Faults::FOREIGN_SENDER);
        self.said.foreign(frame.id);
    }

    fn input(&mut self, event: Event, observer: &mut impl Sink) {
        match (&mut self.black_box, event) {
            (Some(black_box), Event::Frame(frame)) => black_box.input(&frame),
            (Some(black_box), Event::Error(error)) => black_box.error(&error),
            _ => {}
        }
        match event {
            Event::Frame(frame) if self.shares && self.is_foreign(&frame) => self.foreign(&frame),
            Event::Frame(frame) => {
                self.tally.received += 1;
                let held = self.rounds.frames.len();
                self.engine.frame(&frame, &mut Collect { outbox: &mut self.rounds.frames, observer });
                self.replace(held);
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
                self.engine.set_lasting(Faults::BUS_DOWN, false);
                self.set_up(true);
                self.tell("the input interface is up");
                self.said.link("input", event);
            }
            Event::Down | Event::Gone => {
                self.engine.set_lasting(Faults::BUS_DOWN, true);
                self.set_up(false);
                self.tell("waiting for the input interface");
                self.said.link("input", event);
            }
        }
        self.look();
    }

    /// Something that is worth a recording?
    fn look(&mut self) {
        if let Some(black_box) = &mut self.black_box {
            black_box.look(&self.engine);
        }
    }

    /// While nothing comes.
    fn idle(&mut self, now: Option<Micros>, observer: &mut impl Sink) {
        if let Some(now) = now.filter(|_| self.can_send) {
            let held = self.rounds.frames.len();
            self.engine.idle(now, &mut Collect { outbox: &mut self.rounds.frames, observer });
            self.replace(held);
        }
    }

    /// The last round.
    fn farewell(&mut self, now: Micros, link: &mut impl Link, observer: &mut impl Sink) {
        if self.can_send {
            let held = self.rounds.frames.len();
            self.engine.farewell(now, &mut Collect { outbox: &mut self.rounds.frames, observer });
            self.replace(held);
            self.hand_over(link, observer);
        }
    }

    /// If there is a newer round now than the one that was held, that one is given up.
    fn replace(&mut self, held: usize) {
        if self.rounds.frames.len() > held {
            self.give_up(held);
            self.rounds.told = self.engine.told();
        }
    }

    /// So many frames would be too late: they are dropped, and that is told.
    fn give_up(&mut self, count: usize) {
        if count > 0 {
            self.rounds.frames.drain(..count);
            self.tally.late += count as u64;
            self.engine.untold(self.rounds.told);
            self.engine.report(Faults::DROPPED);
            self.said.late(self.tally.late);
        }
    }

    fn set_up(&mut self, up: bool) {
        if self.shares {
            self.can_send = up;
        }
        if let Some(health) = &self.health {
            health.set_input_up(up);
        }
    }

    fn show(&self) {
        if let Some(health) = &self.health {
            health.update(&self.tally, &self.engine);
            if let Some(black_box) = &self.black_box {
                health.set_recordings(black_box.counts());
            }
        }
    }

    fn show_contradiction(&self, keeper: &Keeper) {
        if let Some(health) = &self.health {
            health.set_contradicted(keeper.contradicts());
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
        let survived =
            self.engine.take_over(before, &mut Collect { outbox: &mut self.rounds.frames, observer });
        if let (Survived::Nothing, Some(kept)) = (survived, kept) {
            self.engine.restore(&kept);
        }
        if let Some(black_box) = &self.black_box {
            black_box.follow(&self.engine);
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
        if let (Some(black_box), Event::Frame(frame)) = (&mut self.black_box, event) {
            black_box.output(&frame);
        }
        match event {
            Event::Up | Event::Down | Event::Gone => {
                self.can_send = event == Event::Up;
                self.said.link("output", event);
            }
            Event::Frame(frame) if self.is_foreign(&frame) => self.foreign(&frame),
            Event::Error(error) => {
                self.engine.report(Faults::BUS_ERROR);
                self.said.error("output", error);
            }
            Event::Frame(_) | Event::Dropped(_) => {}
        }
        self.look();
    }

    /// Sends the round that there is, if it may go now.
    fn send(
        &mut self,
        now: Option<Micros>,
        link: &mut impl Link,
        observer: &mut impl Sink,
        all_is_read: bool,
    ) {
        self.waits = Waits::Not;
        if self.rounds.frames.is_empty() {
            return;
        }
        let Some(now) = now else { return self.hand_over(link, observer) };
        let period = self.engine.publisher().period();
        match self.rounds.judge(now, period, all_is_read) {
            Verdict::Nothing => {}
            Verdict::Now => {
                self.hand_over(link, observer);
                self.rounds.went(now, period, all_is_read);
            }
            Verdict::TooLate => self.give_up(self.rounds.frames.len()),
            Verdict::OnceAllIsRead => self.waits = Waits::Input,
            Verdict::After(wait) => {
                let wait = Duration::from_micros(wait.0.unsigned_abs());
                self.waits = Waits::Until(tokio::time::Instant::now() + wait);
            }
        }
    }

    /// What cannot be sent now is dropped: later it would be a stale value with a live counter.
    fn hand_over(&mut self, link: &mut impl Link, observer: &mut impl Sink) {
        link.stay_with_the_name();
        for frame in &self.rounds.frames {
            match link.try_send(frame) {
                Ok(()) => {
                    self.tally.published += 1;
                    observer.publish(frame);
                }
                Err(error) => {
                    self.tally.unsent += 1;
                    self.engine.report(Faults::BUS_ERROR);
                    self.engine.untold(self.rounds.told);
                    self.said.unsent(self.tally.unsent, &error);
                }
            }
        }
        self.rounds.frames.clear();
    }

    fn report(&self) {
        let Tally { received, published, unsent, late, foreign, dropped } = self.tally;
        tracing::info!(received, published, unsent, late, foreign, dropped, "frames so far; {}", self.status);
    }
}
