//! Writes what was learned while the service goes on.

use std::sync::mpsc::{Receiver, RecvTimeoutError, SyncSender, TrySendError, sync_channel};
use std::thread;
use std::time::{Duration, Instant};

use super::{Claim, SavedState, TakenUp};
use crate::service::Engine;
use physics::Faults;
use physics::estimate::Learned;

/// Hands copies of what was learned to a thread of its own, which waits for the disk. The estimation only
/// puts a copy into a slot that was there before: no allocation, and no waiting for anybody.
#[derive(Debug)]
pub struct Keeper {
    state: SavedState,
    slot: SyncSender<Copied>,
    /// Closes when the writer has ended.
    ended: Receiver<()>,
    every_s: f64,
    /// Seconds of driving at which the next copy is due, and those of the last one that was handed over.
    next_s: f64,
    saved_s: f64,
    /// What this drive began with.
    before: Learned,
    /// The next copy lacks something that the file has.
    forgetting: bool,
    /// What was left out of the last copy contradicts the car's table.
    contradicts: bool,
}

/// What is to be written.
#[derive(Clone, Copy, Debug)]
struct Copied {
    learned: Learned,
    /// What is not in it must not come back from anywhere.
    is_final: bool,
}

impl Keeper {
    /// While the writer has not even begun with the last copy, it is asked again after this, s of driving.
    const BUSY_S: f64 = 1.0;
    /// So long the end of the service waits for the disk: systemd would kill it after five seconds.
    const PATIENCE: Duration = Duration::from_secs(2);

    /// Puts what was saved into a new engine, and starts the writer; `None` if nothing must or can be
    /// written, which was said in the log. `every_s`: seconds of driving between two writings; 0: only at the
    /// end.
    pub fn start(state: SavedState, every_s: u64, engine: &mut Engine) -> Option<Self> {
        let claim = state.claim();
        if matches!(claim, Claim::Taken) {
            tell_taken(&state);
            engine.report(Faults::CONFIG);
            if let Ok(Some(learned)) = state.load() {
                engine.restore(&learned);
            }
            return None;
        }
        let TakenUp { learned, may_write, refused } = state.take_up();
        if let Some(learned) = learned {
            engine.restore(&learned);
        }
        if refused {
            engine.report(Faults::CONFIG);
        }
        if !may_write {
            return None;
        }
        let before = learned.unwrap_or_default();
        Self::spawn(state, every_s, engine, |_| Some(claim)).map(|keeper| Self { before, ..keeper })
    }

    /// After a reload: goes on as before where car and file are the same, else hands over to a new one.
    /// `engine` runs from now on, `learned` is what the one before it knew. Waits for nothing: the new writer
    /// looks at its file once the old one has ended.
    pub fn follow(
        before: Option<Self>,
        learned: &Learned,
        state: Option<SavedState>,
        every_s: u64,
        engine: &Engine,
    ) -> Option<Self> {
        let ended = match before {
            Some(mut same) if state.as_ref() == Some(&same.state) => {
                same.every_s = seconds(every_s);
                same.next_s = same.saved_s + same.every_s;
                return Some(same);
            }
            Some(other) => Some(other.hand_over(learned)),
            None => None,
        };
        Self::spawn(state?, every_s, engine, move |state| {
            // An error: it has ended.
            let _ = ended.map(|ended| ended.recv());
            let claim = state.claim();
            if matches!(claim, Claim::Taken) {
                tell_taken(state);
                return None;
            }
            state.take_up().may_write.then_some(claim)
        })
    }

    /// Starts the writer, whose first step is to see whether it may write: then it has the file for itself.
    fn spawn(
        state: SavedState,
        every_s: u64,
        engine: &Engine,
        may_write: impl FnOnce(&SavedState) -> Option<Claim> + Send + 'static,
    ) -> Option<Self> {
        let (slot, copies) = sync_channel(1);
        let (writer_lives, ended) = sync_channel(0);
        let own = state.clone();
        let writer = thread::Builder::new().name("state".into()).spawn(move || {
            if let Some(_ours) = may_write(&own) {
                write(&own, &copies);
            }
            drop(writer_lives);
        });
        if let Err(error) = writer {
            tracing::warn!("no thread for saving what is learned ({error}): nothing will be saved");
            return None;
        }
        let every_s = seconds(every_s);
        let saved_s = engine.driving_s();
        let next_s = saved_s + every_s;
        let before = Learned::default();
        Some(Self {
            state,
            slot,
            ended,
            every_s,
            next_s,
            saved_s,
            before,
            forgetting: false,
            contradicts: false,
        })
    }

    /// A last copy, if there is room for it, and no more after it. What is returned closes when it is written.
    fn hand_over(self, learned: &Learned) -> Receiver<()> {
        if learned.driving_s > self.saved_s {
            // Full: the disk is slow, and has the copy before.
            let _ = self.slot.try_send(Copied { learned: *learned, is_final: self.forgetting });
        }
        self.ended
    }

    /// To be called now and then, after any frame: hands a copy over if one is due.
    pub fn offer(&mut self, engine: &Engine) {
        let driving_s = engine.driving_s();
        if driving_s < self.next_s {
            return;
        }
        let copied = self.copy(engine);
        match self.slot.try_send(copied) {
            Ok(()) => {
                (self.saved_s, self.next_s) = (driving_s, driving_s + self.every_s);
                self.forgetting = false;
            }
            // The disk is slow. What is learned later is better anyway.
            Err(TrySendError::Full(_)) => self.next_s = driving_s + Self::BUSY_S,
            Err(TrySendError::Disconnected(_)) => self.next_s = f64::INFINITY,
        }
    }

    /// Hands a copy over at once: what was forgotten must not come back from the file. While the disk is slow, with the
    /// next one.
    pub fn forgotten(&mut self, engine: &Engine) {
        self.next_s = engine.driving_s();
        self.saved_s = f64::NEG_INFINITY;
        self.before = Learned::default();
        self.forgetting = true;
        self.offer(engine);
    }

    /// Did what was learned until the last copy contradict the car's table? It was not saved.
    pub fn contradicts(&self) -> bool {
        self.contradicts
    }

    /// What is worth keeping; says once what is not, and why.
    fn copy(&mut self, engine: &Engine) -> Copied {
        let contradiction = engine.contradiction();
        let contradicts = contradiction.is_some();
        if let Some(contradiction) = contradiction.filter(|_| !self.contradicts) {
            tracing::warn!(
                "{}: what is learned is not saved as far as that goes: the {contradiction}. A sensor is wrong, or \
                 [vehicle] is: `gripd check` tells which",
                self.state.path().display()
            );
        }
        self.contradicts = contradicts;
        Copied { learned: engine.learned_or(&self.before), is_final: self.forgetting }
    }

    /// At the end of the service: a last copy, if the car moved since the one before, and waits for the
    /// disk, but not for ever.
    pub fn finish(mut self, engine: &Engine) {
        let copied = (engine.driving_s() > self.saved_s).then(|| self.copy(engine));
        let Self { slot, ended, .. } = self;
        let deadline = Instant::now() + Self::PATIENCE;
        if let Some(mut copy) = copied {
            while let Err(TrySendError::Full(back)) = slot.try_send(copy) {
                if Instant::now() > deadline {
                    break;
                }
                copy = back;
                thread::sleep(Duration::from_millis(5));
            }
        }
        drop(slot);
        let left = deadline.saturating_duration_since(Instant::now());
        if ended.recv_timeout(left) == Err(RecvTimeoutError::Timeout) {
            tracing::warn!("the disk does not answer: what was learned last may not be saved");
        }
    }
}

fn tell_taken(state: &SavedState) {
    tracing::warn!(
        "{}: another gripd has this file; what is learned here is not saved. Stop one of them, or give each its own \
         [service] state_file",
        state.path().display()
    );
}

/// Zero is never.
fn seconds(every_s: u64) -> f64 {
    if every_s == 0 { f64::INFINITY } else { every_s as f64 }
}

/// The writer: says once that it cannot write and why, and once that it can again.
fn write(state: &SavedState, copies: &Receiver<Copied>) {
    let path = state.path().display();
    let mut failing = None;
    while let Ok(Copied { learned, is_final }) = copies.recv() {
        // Nothing is known: nothing to keep, and an older file says what was forgotten.
        let saved = match (learned.is_empty(), is_final) {
            (true, true) => state.remove(),
            (true, false) => Ok(()),
            (false, true) => state.save_forgotten(&learned),
            (false, false) => state.save(&learned),
        };
        match saved {
            Ok(()) => {
                tracing::debug!("{path}: saved after {:.0} s of driving", learned.driving_s);
                if failing.take().is_some() {
                    tracing::info!("{path}: what is learned is saved again");
                }
            }
            Err(error) => {
                if failing.replace(error.kind()) != Some(error.kind()) {
                    tracing::warn!(
                        "{path}: what is learned cannot be saved: {error}. The service goes on without; its \
                         user must be able to write into that folder, and the disk must have room"
                    );
                }
            }
        }
    }
}
