//! The black box: what was on the bus around each new fault and each change of surface, as recordings that a replay
//! takes.
//!
//! The loop puts every frame that it receives into a ring and looks whether something is new. Another thread does all
//! the rest; if it has no time, the loop does not wait: what cannot be told it is counted.

mod cause;
mod folder;
mod ring;
mod writer;

use std::sync::atomic::AtomicU64;
use std::sync::atomic::Ordering::Relaxed;
use std::sync::mpsc::{Receiver, RecvTimeoutError, SyncSender, sync_channel};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::thread;
use std::time::Duration;

use self::cause::{Cause, Watch};
use self::folder::{Folder, Limits};
use self::ring::{Front, Origin};
use self::writer::Writer;
use super::Engine;
use crate::can::{CanId, ErrorReport, Frame, FrameKind};
use crate::config::ServiceConfig;
use physics::Micros;
use physics::estimate::Learned;

/// The loop's side of it.
#[derive(Debug)]
pub struct BlackBox {
    frames: Front,
    triggers: SyncSender<Trigger>,
    watch: Watch,
    counts: Arc<Counts>,
    /// Closes when the writer has ended.
    ended: Receiver<()>,
    /// Of the car whose state stands beside a recording. The loop touches it at reloads only.
    fingerprint: Arc<Mutex<String>>,
}

/// What became of what was to be recorded.
#[derive(Debug, Default)]
pub(super) struct Counts {
    /// Recordings that are complete.
    pub written: AtomicU64,
    /// Those that could not be written, and causes that the writer had no time for.
    pub missed: AtomicU64,
}

/// Something is new.
#[derive(Clone, Copy, Debug)]
struct Trigger {
    /// Stamp of the latest frame.
    time: Micros,
    cause: Cause,
    /// What was known of the car: a replay that begins with it knows the tires sooner.
    learned: Learned,
}

impl BlackBox {
    /// 4 MiB, three words for a frame of eight bytes: a minute and a half at 2,000 of them a second. Twenty seconds are
    /// needed, and the rest is how long the disk may take.
    const WORDS: usize = 1 << 19;
    /// Causes that wait while the disk is slow. What comes when they are that many is counted as missed.
    const WAITING: usize = 8;
    /// So long the end of the service waits for the disk.
    const PATIENCE: Duration = Duration::from_secs(1);

    /// With the folder that is configured, if there is one; `input` and `output` are what lines call the interfaces.
    pub fn start(config: &ServiceConfig, input: &str, output: &str, engine: &Engine) -> Option<Self> {
        let path = config.record_faults.as_ref().filter(|path| !path.as_os_str().is_empty())?;
        let limits = Limits { files: config.record_files, bytes: config.record_bytes };
        let (frames, back) = ring::ring(Self::WORDS);
        let (triggers, inbox) = sync_channel(Self::WAITING);
        let (writer_lives, ended) = sync_channel(0);
        let counts = Arc::<Counts>::default();
        let fingerprint = Arc::new(Mutex::new(engine.fingerprint().to_owned()));
        let writer = Writer {
            frames: back,
            triggers: inbox,
            folder: Folder::new(path, limits),
            input: input.to_owned(),
            output: output.to_owned(),
            fingerprint: Arc::clone(&fingerprint),
            counts: Arc::clone(&counts),
            left: None,
        };
        let work = move || {
            writer.work();
            drop(writer_lives);
        };
        if let Err(error) = thread::Builder::new().name("recorder".into()).spawn(work) {
            tracing::warn!("no thread for recording faults ({error}): nothing will be recorded");
            return None;
        }
        tracing::info!("faults are recorded in {}", path.display());
        let watch = Watch::new(engine.surface_changes());
        Some(Self { frames, triggers, watch, counts, ended, fingerprint })
    }

    /// Every frame that comes on the input, before the engine has it.
    pub fn input(&mut self, frame: &Frame) {
        self.watch.heard(frame.time);
        self.frames.push(frame, Origin::Input);
    }

    /// A frame that comes where we only publish.
    pub fn output(&mut self, frame: &Frame) {
        self.watch.heard(frame.time);
        self.frames.push(frame, Origin::Output);
    }

    /// A report of errors, as the frame that it was.
    pub fn error(&mut self, report: &ErrorReport) {
        let id = CanId::extended(report.class.bits() & CanId::MAX_EXTENDED);
        let frame = id.map(|id| Frame::new(report.time, id, FrameKind::Error, &report.data));
        if let Some(Ok(frame)) = frame {
            self.input(&frame);
        }
    }

    /// After each of them: is something new?
    pub fn look(&mut self, engine: &Engine) {
        let Some((time, cause)) = self.watch.look(engine.present_faults(), engine.surface_changes()) else {
            return;
        };
        let trigger = Trigger { time, cause, learned: engine.learned() };
        if self.triggers.try_send(trigger).is_err() {
            self.counts.missed.fetch_add(1, Relaxed);
        }
    }

    /// After a reload, between two frames.
    pub fn follow(&self, engine: &Engine) {
        engine.fingerprint().clone_into(&mut locked(&self.fingerprint));
    }

    /// Recordings written, and missed.
    pub fn counts(&self) -> (u64, u64) {
        (self.counts.written.load(Relaxed), self.counts.missed.load(Relaxed))
    }

    /// At the end of the service: what is being recorded is completed with what there is, if the disk answers.
    pub fn finish(self) {
        let Self { triggers, ended, .. } = self;
        drop(triggers);
        if ended.recv_timeout(Self::PATIENCE) == Err(RecvTimeoutError::Timeout) {
            tracing::warn!("the disk does not answer: the recording of the last fault may be lost");
        }
    }
}

fn locked(fingerprint: &Mutex<String>) -> MutexGuard<'_, String> {
    fingerprint.lock().unwrap_or_else(PoisonError::into_inner)
}
