//! Reading the configuration anew while the service runs.
//!
//! Files are read, checked and compiled on a thread of their own, so that no frame waits for a disk. The
//! loop gets an engine that is ready to take over, or the reason why there is none.

use std::path::PathBuf;
use std::sync::Arc;
use std::thread;
use std::time::Duration;

use tokio::sync::oneshot::error::TryRecvError;
use tokio::sync::{Notify, oneshot};
use tokio::time::{Instant, sleep_until, timeout_at};

use super::{Engine, SavedState, SetupError, systemd};
use crate::config::{Address, Config, ConfigError};
use physics::estimate::Learned;

/// A configuration that was read anew and can be used.
#[derive(Debug)]
pub struct Fresh {
    /// What was read.
    pub config: Config,
    /// Made of it; it has seen no frame yet.
    pub engine: Engine,
    /// Where what is learned is to be kept.
    pub state: Option<SavedState>,
    /// What is kept there of this car.
    pub learned: Option<Learned>,
}

/// Reads the configuration anew whenever the bell was rung. However often it rings, files are read by one
/// thread at a time, and once a second at most; the last ring is always followed by a reading.
pub struct Reloads {
    bell: Arc<Notify>,
    read: Arc<Read>,
    /// What is open, by name.
    input: String,
    output: Option<String>,
    metrics: Option<Address>,
    recordings: (Option<PathBuf>, u64, u64),
    next: Instant,
    stage: Stage,
    /// A reading that took too long and may still go on.
    stuck: Option<oneshot::Receiver<Result<Fresh, SetupError>>>,
}

type Read = dyn Fn() -> Result<Config, ConfigError> + Send + Sync;

/// Kept here and not in a future, which a `select!` drops whenever something else comes first.
enum Stage {
    Idle,
    Rung,
    /// Until then the answer is waited for.
    Reading(oneshot::Receiver<Result<Fresh, SetupError>>, Instant),
}

impl Reloads {
    /// Between the beginnings of two readings.
    const PAUSE: Duration = Duration::from_secs(1);
    /// Files that are not read by then are on a disk that does not answer.
    const PATIENCE: Duration = Duration::from_secs(10);

    /// `at_start` is what the service runs with, `read` gives what the files say now.
    pub fn new(
        at_start: &Config,
        bell: Arc<Notify>,
        read: impl Fn() -> Result<Config, ConfigError> + Send + Sync + 'static,
    ) -> Self {
        Self {
            bell,
            read: Arc::new(read),
            input: at_start.bus.interface.clone(),
            output: at_start.publish.interface.clone(),
            metrics: at_start.service.metrics.clone(),
            recordings: recordings(at_start),
            next: Instant::now(),
            stage: Stage::Idle,
            stuck: None,
        }
    }

    /// The next configuration, or why it cannot be used, for people to read. Cancel-safe.
    pub(super) async fn next(&mut self) -> Result<Fresh, String> {
        loop {
            match &mut self.stage {
                Stage::Idle => {
                    self.bell.notified().await;
                    self.stage = Stage::Rung;
                }
                Stage::Rung => {
                    sleep_until(self.next).await;
                    self.next = Instant::now() + Self::PAUSE;
                    systemd::reloading();
                    tracing::info!("reading the configuration anew");
                    if self
                        .stuck
                        .as_mut()
                        .is_some_and(|stuck| matches!(stuck.try_recv(), Err(TryRecvError::Empty)))
                    {
                        self.stage = Stage::Idle;
                        return Err("its files are still being read since the last time".to_owned());
                    }
                    self.stuck = None;
                    self.stage = Stage::Reading(self.start(), Instant::now() + Self::PATIENCE);
                }
                Stage::Reading(answer, deadline) => {
                    let result = timeout_at(*deadline, &mut *answer).await;
                    let before = std::mem::replace(&mut self.stage, Stage::Idle);
                    let Ok(result) = result else {
                        if let Stage::Reading(answer, _) = before {
                            self.stuck = Some(answer);
                        }
                        let seconds = Self::PATIENCE.as_secs();
                        return Err(format!("its files could not be read within {seconds} s"));
                    };
                    // Without an answer the thread could not be had, or it panicked.
                    let fresh = result.map_err(|_| "it could not be read to its end".to_owned())?;
                    let fresh = fresh.map_err(|error| error.to_string())?;
                    self.warn_of_what_stays(&fresh.config);
                    return Ok(fresh);
                }
            }
        }
    }

    fn start(&self) -> oneshot::Receiver<Result<Fresh, SetupError>> {
        let (answer, result) = oneshot::channel();
        let read = Arc::clone(&self.read);
        let work = move || drop(answer.send(prepare(&*read)));
        if let Err(error) = thread::Builder::new().name("reload".into()).spawn(work) {
            tracing::warn!("no thread for reading the configuration: {error}");
        }
        result
    }

    fn warn_of_what_stays(&self, config: &Config) {
        let keys = [
            ("bus.interface", self.input != config.bus.interface),
            ("publish.interface", self.output != config.publish.interface),
            ("service.metrics", self.metrics != config.service.metrics),
            ("service.record_faults, record_files or record_bytes", self.recordings != recordings(config)),
        ];
        for (key, _) in keys.iter().filter(|(_, changed)| *changed) {
            tracing::warn!("{key} has changed: it is opened at the start only, restart for that");
        }
    }
}

/// Where faults are recorded, and how many.
fn recordings(config: &Config) -> (Option<PathBuf>, u64, u64) {
    let service = &config.service;
    (service.record_faults.clone(), service.record_files, service.record_bytes)
}

fn prepare(read: &Read) -> Result<Fresh, SetupError> {
    let config = read()?;
    let engine = Engine::new(&config)?;
    let state = SavedState::of_process(&config);
    // What is wrong with the file is said by the keeper that takes it over.
    let learned = state.as_ref().and_then(|state| state.load().ok().flatten());
    Ok(Fresh { config, engine, state, learned })
}
