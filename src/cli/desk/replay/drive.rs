//! Recordings through the service's own engine, a frame at a time: who drives takes what comes, and may stop anywhere.

use std::collections::{BTreeMap, VecDeque};
use std::path::PathBuf;
use std::time::Instant;

use serde::Serialize;

use super::learned::Learning;
use crate::cli::Failure;
use crate::cli::desk::part::{Part, PartReader};
use crate::cli::desk::progress::Progress;
use crate::cli::desk::recordings;
use bus::Config;
use bus::can::Frame;
use bus::can::recording::Reader;
use bus::service::{Engine, Sink};
use identify::CorneringStiffness;
use lab::report::Page;
use physics::estimate::EstimatorsConfig;
use physics::time::Clock;
use physics::{Estimates, Micros, Quantity, Sample};

/// Who takes what a drive makes.
pub trait Listener: Sink {
    /// A recording begins: its first frame is known.
    fn begin(&mut self, _recording: &PartReader) {}

    /// A frame of a recording, before the engine has it.
    fn frame(&mut self, _recording: &PartReader, _frame: &Frame) {}
}

/// A drive that goes on frame by frame.
pub struct Drive {
    engine: Engine,
    waiting: VecDeque<PathBuf>,
    part: Part,
    reader: Option<PartReader>,
    /// Has nothing come of it yet?
    is_fresh: bool,
    progress: Progress,
    started: Instant,
    heard: Heard,
    totals: Totals,
}

impl Drive {
    /// Nothing is opened yet.
    pub fn new(engine: Engine, config: &Config, logs: &[PathBuf], part: &Part) -> Self {
        let learning = Learning::new(config.vehicle.driven_axle);
        let heard = Heard { learning, estimators: config.estimators.clone() };
        Self {
            engine,
            waiting: logs.iter().cloned().collect(),
            part: part.clone(),
            reader: None,
            is_fresh: false,
            progress: Progress::of_files(logs),
            started: Instant::now(),
            heard,
            totals: Totals::default(),
        }
    }

    /// One frame further; false where there is none left. What is broken ends its recording and no more: what could be
    /// read before the damage is still worth its results.
    ///
    /// # Errors
    /// If a recording cannot be opened.
    #[inline]
    pub fn advance(&mut self, listener: &mut impl Listener) -> Result<bool, Failure> {
        loop {
            let Some(reader) = &mut self.reader else {
                let Some(path) = self.waiting.pop_front() else { return Ok(false) };
                self.reader = Some(self.part.open(&path)?);
                self.is_fresh = true;
                continue;
            };
            match reader.next_frame() {
                Ok(Some(frame)) => {
                    self.heard.learning.begin(reader.clock());
                    if std::mem::take(&mut self.is_fresh) {
                        listener.begin(reader);
                    }
                    listener.frame(reader, &frame);
                    self.engine.frame(&frame, &mut Hearing { heard: &mut self.heard, listener });
                    self.progress.advance(reader.stats().lines);
                    return Ok(true);
                }
                Ok(None) => self.close(),
                Err(error) => {
                    self.totals.broken.push(error.to_string());
                    self.close();
                }
            }
        }
    }

    /// Ends the recording that is open, if one is.
    fn close(&mut self) {
        let Some(reader) = self.reader.take() else { return };
        self.totals.add(&reader);
        if reader.stats().dropped > 0 {
            self.engine.report_dropped(reader.stats().dropped);
        }
    }

    /// Ends it with the samples that waited for later frames; what is configured and never came is told.
    pub fn end(mut self, listener: &mut impl Listener) -> Driven {
        self.close();
        self.engine.finish(&mut Hearing { heard: &mut self.heard, listener });
        self.progress.finish();
        for quantity in Quantity::ALL.into_iter().filter(|q| !self.heard.learning.has(*q)) {
            if self.engine.sampler().inputs().has(quantity) && self.engine.counts().samples > 0 {
                tracing::warn!("{quantity} is configured and never has a value in what was replayed");
            }
        }
        let stats = self.totals.stats(&self.engine, self.started, self.heard.cornering_stiffness());
        Driven { engine: self.engine, stats, heard: self.heard, broken: self.totals.broken }
    }
}

/// What is left of a drive.
pub struct Driven {
    /// What it knows now.
    pub engine: Engine,
    /// Counts and speed.
    pub stats: Stats,
    heard: Heard,
    broken: Vec<String>,
}

impl Driven {
    /// What was learned, for people.
    pub fn learned(&self) -> String {
        self.heard.learning.text(&self.heard.estimators)
    }

    /// The same as a part of a page.
    pub fn write(&self, page: &mut Page) {
        self.heard.learning.write(page, &self.heard.estimators);
    }

    /// # Errors
    /// If there was nothing to estimate from, or a recording could not be read to its end.
    pub fn whole(&self) -> Result<(), Failure> {
        if self.broken.is_empty() && self.stats.samples == 0 {
            let ids: Vec<_> = self.engine.ids().iter().map(ToString::to_string).collect();
            return Err(Failure::work(format_args!(
                "nothing to estimate from: none of the needed identifiers ({}) is in the recording; \
                 is it of this car and bus? `gripd check` tells more",
                ids.join(", ")
            )));
        }
        if self.broken.is_empty() { Ok(()) } else { Err(Failure::Work(self.broken.join("; "))) }
    }
}

/// What a drive keeps of what goes by.
struct Heard {
    learning: Learning,
    estimators: EstimatorsConfig,
}

impl Heard {
    fn cornering_stiffness(&self) -> CorneringStiffness {
        self.learning.cornering_stiffness(&self.estimators)
    }
}

/// Listens, and hands on.
struct Hearing<'h, L> {
    heard: &'h mut Heard,
    listener: &'h mut L,
}

impl<L: Listener> Sink for Hearing<'_, L> {
    fn estimates(&mut self, sample: &Sample, estimates: &Estimates) {
        self.heard.learning.hear(sample);
        self.heard.learning.take(estimates, &self.heard.estimators);
        self.listener.estimates(sample, estimates);
    }

    fn publish(&mut self, frame: &Frame) {
        self.listener.publish(frame);
    }
}

/// `--stats`.
#[derive(Serialize)]
pub struct Stats {
    /// Frames offered.
    pub frames_in: u64,
    /// Frames published.
    pub frames_out: u64,
    /// Samples made.
    pub samples: u64,
    /// Of all recordings together.
    pub seconds_of_recording: f64,
    /// What it took.
    pub wall_s: f64,
    frames_per_s: f64,
    /// When the first recording begins, where its stamps are dates.
    #[serde(skip_serializing_if = "Option::is_none")]
    begins_utc: Option<String>,
    skipped_lines: u64,
    dropped_by_recorder: u64,
    time_backwards: u64,
    faults: BTreeMap<String, u64>,
    cornering_stiffness: CorneringStiffness,
}

/// Sums over all recordings.
#[derive(Default)]
struct Totals {
    /// Stamp of the first frame.
    first: Option<Micros>,
    seconds: f64,
    skipped_lines: u64,
    dropped: u64,
    time_backwards: u64,
    broken: Vec<String>,
}

impl Totals {
    fn add(&mut self, reader: &Reader) {
        let stats = reader.stats();
        self.first = self.first.or(stats.first_time);
        self.seconds += stats.seconds();
        self.skipped_lines += stats.skipped_lines;
        self.dropped += stats.dropped;
        self.time_backwards += stats.time_backwards;
        if stats.frames == 0 && stats.skipped_lines > 0 {
            self.broken.push(recordings::nothing_in(reader));
        }
        recordings::warn(reader);
    }

    fn stats(&self, engine: &Engine, started: Instant, cornering_stiffness: CorneringStiffness) -> Stats {
        let counts = engine.counts();
        let wall_s = started.elapsed().as_secs_f64();
        Stats {
            frames_in: counts.frames_in,
            frames_out: counts.frames_out,
            samples: counts.samples,
            seconds_of_recording: self.seconds,
            begins_utc: self.first.and_then(|first| Clock::of(first).utc(0.0)),
            wall_s,
            frames_per_s: if wall_s > 0.0 { counts.frames_in as f64 / wall_s } else { 0.0 },
            skipped_lines: self.skipped_lines,
            dropped_by_recorder: self.dropped,
            time_backwards: self.time_backwards,
            faults: engine.fault_counts().iter().collect(),
            cornering_stiffness,
        }
    }
}
