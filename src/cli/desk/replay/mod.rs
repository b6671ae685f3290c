//! `gripd replay`: the service's own engine over recordings.

mod learned;

use std::collections::BTreeMap;
use std::io::Write as _;
use std::path::PathBuf;
use std::time::Instant;

use clap::Args;
use serde::Serialize;

use self::learned::Learning;
use super::Failure;
use super::output::{Output, check_outputs, write_json, write_text};
use super::part::{Part, PartError, PartReader};
use super::player::Player;
use super::progress::Progress;
use super::tables::{EstimatesTable, SamplesTable, TableFormat};
use bus::Config;
use bus::can::Frame;
use bus::can::recording::{Format, LogError, Reader, Writer};
use bus::service::saved::{Claim, Refusal};
use bus::service::{Engine, SavedState, Sink};
use lab::identify::CorneringStiffness;
use lab::pages::plot::{self, Drive};
use physics::estimate::{EstimatorsConfig, Learned};
use physics::time::Clock;
use physics::{Estimates, Micros, Quantity, Sample};

/// Without -i nothing touches a bus, and the same input gives the same output to the last bit.
#[derive(Args)]
pub struct Replay {
    /// Configuration of the car.
    #[arg(short, long)]
    config: PathBuf,
    /// Recordings (candump, Vector ASC or BLF, ASAM MF4, Peak TRC, python-can CSV; gzip or zstd around them; `-`
    /// is the standard input), one after the other.
    #[arg(required = true)]
    logs: Vec<PathBuf>,
    /// Write the published frames: as candump lines (`-`: standard output), or in the format that the name ends in
    /// (`.mf4`, `.blf`, `.asc`, `.trc`, `.csv`).
    #[arg(short, long)]
    out: Option<PathBuf>,
    /// Write the recordings' own frames to --out, too.
    #[arg(long, requires = "out")]
    all: bool,
    /// Write the estimates, a row for each sample: as Parquet where the name ends in `.parquet`, as signals for MDF
    /// viewers where it ends in `.mf4`, else as CSV.
    #[arg(long, value_name = "TABLE")]
    estimates: Option<PathBuf>,
    /// Write the decoded signals as the estimators see them, likewise.
    #[arg(long, value_name = "TABLE")]
    samples: Option<PathBuf>,
    /// Write a page to look into: the estimates over time with their intervals and when they were valid, beside what was
    /// measured; friction used and available, handling curve, track; and what was learned.
    #[arg(long, value_name = "HTML")]
    html: Option<PathBuf>,
    /// Write counts and speed as JSON.
    #[arg(long, value_name = "JSON")]
    stats: Option<PathBuf>,
    /// Go on from what an earlier drive learned of this car, and write there what this one did: the
    /// service's `state_file`. A file that is refused is an error, and stays as it is.
    #[arg(long, value_name = "TOML")]
    state: Option<PathBuf>,
    /// Play in real time, or X times as fast.
    #[arg(long, value_name = "X", num_args = 0..=1, require_equals = true, default_missing_value = "1")]
    realtime: Option<f64>,
    /// Play the recording onto this interface, together with what is published on it.
    #[arg(short, long, value_name = "IF")]
    interface: Option<String>,
    #[command(flatten)]
    part: Part,
}

/// `--stats`.
#[derive(Serialize)]
struct Stats {
    frames_in: u64,
    frames_out: u64,
    samples: u64,
    seconds_of_recording: f64,
    wall_s: f64,
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

impl Replay {
    /// Runs it.
    pub fn run(self) -> Result<(), Failure> {
        if let Some(speed) = self.realtime.filter(|speed| !(speed.is_finite() && *speed > 0.0)) {
            return Err(Failure::usage(format_args!("--realtime={speed}: must be a positive number")));
        }
        let config = super::configuration::for_the_service(&self.config)?;
        // A state is read before it is written, and what is none is refused then.
        check_outputs(
            self.logs.iter().chain([&self.config]).chain(&self.state).chain(config.files()),
            [&self.out, &self.estimates, &self.samples, &self.html, &self.stats].into_iter().flatten(),
        )?;
        let mut engine = Engine::new(&config)?;
        if self.estimates.is_some() {
            engine = engine.with_thesis();
        }
        let state = self.state.as_deref().map(|path| SavedState::new(path, &config));
        let claim = state.as_ref().map(SavedState::claim);
        let mut before = Learned::default();
        if let Some(state) = &state {
            if matches!(claim, Some(Claim::Taken)) {
                let path = state.path().display();
                return Err(Failure::work(format_args!(
                    "{path}: another gripd has this file: stop it first"
                )));
            }
            before = take_up(state, &mut engine)?;
        }
        let driven_before_s = engine.driving_s();
        let mut results = Results::create(&self, &config)?;
        let mut player = Player::new(self.realtime, self.interface.as_deref(), &config)?;
        let started = Instant::now();
        let mut totals = Totals::default();
        let progress = Progress::of_files(&self.logs);
        for path in &self.logs {
            let mut reader = self.part.open(path)?;
            // What could be read before the damage is still worth its results.
            if let Err(error) = play(&mut reader, &mut engine, &mut results, &mut player, &progress) {
                totals.broken.push(error.to_string());
            }
            totals.add(&reader);
            if reader.stats().dropped > 0 {
                engine.report_dropped(reader.stats().dropped);
            }
        }
        engine.finish(&mut results);
        progress.finish();
        for quantity in Quantity::ALL.into_iter().filter(|q| results.heard & q.bit() == 0) {
            if engine.sampler().inputs().has(quantity) && engine.counts().samples > 0 {
                tracing::warn!("{quantity} is configured and never has a value in what was replayed");
            }
        }
        let stats = totals.stats(&engine, started, results.learning.cornering_stiffness(&config.estimators));
        let learned = results.learning.text(&config.estimators);
        if let (Some(path), Some(drive)) = (&self.html, results.drive.take().filter(|it| !it.is_empty())) {
            let page = plot::page(&drive, &config.vehicle, |page| {
                results.learning.write(page, &config.estimators);
            });
            write_text(path, &page.html())?;
        }
        results.finish()?;
        if let Some(state) = state.filter(|_| engine.driving_s() > driven_before_s) {
            if let Some(contradiction) = engine.contradiction() {
                let path = state.path().display();
                tracing::warn!(
                    "{path}: what was learned is not saved as far as that goes: the {contradiction}"
                );
            }
            let failed = |error| format!("cannot write {}: {error}", state.path().display());
            state.save(&engine.learned_or(&before)).map_err(|error| Failure::work(failed(error)))?;
        }
        if let Some(path) = &self.stats {
            write_json(path, &stats)?;
        }
        // For people: whoever wants to hear of errors only is not told.
        if tracing::enabled!(tracing::Level::INFO) && !learned.is_empty() {
            let _ = write!(std::io::stderr().lock(), "\n{learned}\n");
        }
        tracing::info!(
            "{} frames in, {} published; {:.1} s of recording in {:.2} s",
            stats.frames_in,
            stats.frames_out,
            stats.seconds_of_recording,
            stats.wall_s
        );
        if totals.broken.is_empty() && stats.samples == 0 {
            let ids: Vec<_> = engine.ids().iter().map(ToString::to_string).collect();
            return Err(Failure::work(format_args!(
                "nothing to estimate from: none of the needed identifiers ({}) is in the recording; \
                 is it of this car and bus? `gripd check` tells more",
                ids.join(", ")
            )));
        }
        if totals.broken.is_empty() { Ok(()) } else { Err(Failure::Work(totals.broken.join("; "))) }
    }
}

/// What an earlier drive saved, where there is something.
fn take_up(state: &SavedState, engine: &mut Engine) -> Result<Learned, Failure> {
    let refused = |refusal: Refusal| {
        let what_to_do = "give another name, or delete it to begin anew";
        Failure::usage(format_args!("{} {refusal}; {what_to_do}", state.path().display()))
    };
    let learned = state.load().map_err(refused)?;
    if let Some(learned) = &learned {
        engine.restore(learned);
    }
    Ok(learned.unwrap_or_default())
}

/// One recording through the engine.
fn play(
    reader: &mut PartReader,
    engine: &mut Engine,
    results: &mut Results,
    player: &mut Player,
    progress: &Progress,
) -> Result<(), PartError> {
    let mut is_first = true;
    while let Some(frame) = reader.next_frame()? {
        results.learning.begin(reader.clock());
        if let Some(drive) = results.drive.as_mut().filter(|_| std::mem::take(&mut is_first)) {
            drive.begin(reader.name(), reader.clock().begins());
        }
        player.play(&frame);
        results.input(reader.interface(), &frame);
        engine.frame(&frame, results);
        for published in results.published.drain(..) {
            player.send(&published);
        }
        progress.advance(reader.stats().lines);
        if results.failure.is_some() {
            break;
        }
    }
    Ok(())
}

/// The frames that are written.
struct Recording {
    path: PathBuf,
    format: Format,
    writer: Writer,
}

/// Everything a replay writes. The first failure to write is kept and ends the replay.
struct Results {
    out: Option<Recording>,
    all: bool,
    estimates: Option<EstimatesTable<Output>>,
    samples: Option<SamplesTable<Output>>,
    /// Frames that still have to go onto a bus.
    published: Vec<Frame>,
    onto_bus: bool,
    /// Quantities that had a value, as bits.
    heard: u16,
    learning: Learning,
    /// What the page is made of.
    drive: Option<Drive>,
    estimators: EstimatorsConfig,
    failure: Option<Failure>,
}

impl Results {
    fn create(command: &Replay, config: &Config) -> Result<Self, Failure> {
        let interface = config.publish.interface.as_deref().unwrap_or(&config.bus.interface);
        let out = command.out.as_ref().map(|path| {
            let format = Format::of_name(path).unwrap_or(Format::Candump);
            let writer = Writer::create(path, format, interface)?;
            Ok(Recording { path: path.clone(), format, writer })
        });
        let estimates = command.estimates.as_ref().map(|path| {
            let format = TableFormat::of(path)?;
            EstimatesTable::new(Output::create(path)?, format).map_err(Failure::work)
        });
        let samples = command.samples.as_ref().map(|path| {
            let quantities = config.signals.quantities.keys().copied().collect();
            let format = TableFormat::of(path)?;
            SamplesTable::new(Output::create(path)?, format, quantities).map_err(Failure::work)
        });
        Ok(Self {
            out: out.transpose().map_err(|error: LogError| Failure::from(error))?,
            all: command.all,
            estimates: estimates.transpose()?,
            samples: samples.transpose()?,
            published: Vec::new(),
            onto_bus: command.interface.is_some(),
            heard: 0,
            learning: Learning::default(),
            drive: command.html.as_ref().map(|_| {
                let quantities = config.signals.quantities.keys().copied().collect();
                Drive::new(quantities, [None; 2])
            }),
            estimators: config.estimators.clone(),
            failure: None,
        })
    }

    fn input(&mut self, interface: &str, frame: &Frame) {
        if self.all
            && let Some(out) = &mut self.out
        {
            let written = out.writer.write_as(interface, frame);
            self.check(written);
        }
    }

    fn check(&mut self, result: Result<(), impl Into<Failure>>) {
        if let Err(error) = result {
            self.failure.get_or_insert_with(|| error.into());
        }
    }

    fn finish(self) -> Result<(), Failure> {
        if let Some(failure) = self.failure {
            return Err(failure);
        }
        if let Some(out) = self.out {
            let Recording { path, format, writer } = out;
            super::recordings::tell_losses(&path, format, &writer.finish()?);
        }
        if let Some(table) = self.estimates {
            table.into_inner()?.finish()?;
        }
        if let Some(table) = self.samples {
            table.into_inner()?.finish()?;
        }
        Ok(())
    }
}

impl Sink for Results {
    fn estimates(&mut self, sample: &Sample, estimates: &Estimates) {
        self.heard |= sample.present();
        self.learning.take(estimates, &self.estimators);
        if let Some(drive) = &mut self.drive {
            drive.push(sample, estimates);
        }
        if let Some(table) = &mut self.estimates {
            let written = table.row(sample, estimates);
            self.check(written);
        }
        if let Some(table) = &mut self.samples {
            let written = table.row(sample);
            self.check(written);
        }
    }

    fn publish(&mut self, frame: &Frame) {
        if let Some(out) = &mut self.out {
            let written = out.writer.write(frame);
            self.check(written);
        }
        if self.onto_bus {
            self.published.push(*frame);
        }
    }
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
            self.broken.push(super::recordings::nothing_in(reader));
        }
        super::recordings::warn(reader);
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
