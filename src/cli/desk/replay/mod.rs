//! `gripd replay`: the service's own engine over recordings.

mod drive;
mod learned;

use std::io::Write as _;
use std::path::PathBuf;

use clap::Args;

use super::Failure;
use super::output::{Output, check_outputs, write_json, write_text};
use super::part::{Part, PartReader};
use super::player::Player;
use super::tables::rows::{Column, estimates_columns, estimates_row, samples_columns, samples_row};
use super::tables::{Table, TableFormat, table};
use bus::Config;
use bus::can::Frame;
use bus::can::recording::{Format, Writer};
use bus::service::saved::{Claim, Refusal};
use bus::service::{Engine, SavedState, Sink};
use lab::pages::plot;
use physics::estimate::Learned;
use physics::{Estimates, Quantity, Sample};

pub use drive::{Drive, Driven, Listener, Stats};

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
    /// viewers where it ends in `.mf4`, for Foxglove, PlotJuggler and Rerun where it ends in `.mcap`, else as CSV.
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
        let mut drive = Drive::new(engine, &config, &self.logs, &self.part);
        while results.failure.is_none() && drive.advance(&mut results)? {
            for published in results.published.drain(..) {
                results.player.send(&published);
            }
        }
        let driven = drive.end(&mut results);
        let Driven { engine, stats, .. } = &driven;
        if let (Some(path), Some(page)) = (&self.html, results.page.take().filter(|page| !page.is_empty())) {
            let page = plot::page(&page, &config.vehicle, |page| driven.write(page));
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
            write_json(path, stats)?;
        }
        // For people: whoever wants to hear of errors only is not told.
        let learned = driven.learned();
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
        driven.whole()
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
    estimates: Option<Box<dyn Table<Output>>>,
    samples: Option<Box<dyn Table<Output>>>,
    quantities: Vec<Quantity>,
    player: Player,
    /// Frames that still have to go onto a bus.
    published: Vec<Frame>,
    onto_bus: bool,
    /// What the page is made of.
    page: Option<plot::Drive>,
    failure: Option<Failure>,
}

impl Results {
    fn create(command: &Replay, config: &Config) -> Result<Self, Failure> {
        let interface = config.publish.interface.as_deref().unwrap_or(&config.bus.interface);
        let out = command.out.as_ref().map(|path| {
            let format = super::recordings::format_of(path, "")?;
            let writer = Writer::create(path, format, interface)?;
            Ok::<_, Failure>(Recording { path: path.clone(), format, writer })
        });
        let quantities: Vec<Quantity> = config.signals.quantities.keys().copied().collect();
        let begun = |path: Option<&PathBuf>, title, columns: &[Column]| {
            let begin = |path: &PathBuf| {
                let format = TableFormat::of(path)?;
                table(Output::create(path)?, format, title, columns).map_err(Failure::work)
            };
            path.map(begin).transpose()
        };
        let estimates = begun(command.estimates.as_ref(), "estimates", &estimates_columns())?;
        let samples = begun(command.samples.as_ref(), "samples", &samples_columns(&quantities))?;
        Ok(Self {
            out: out.transpose()?,
            all: command.all,
            estimates,
            samples,
            quantities,
            player: Player::new(command.realtime, command.interface.as_deref(), config)?,
            published: Vec::new(),
            onto_bus: command.interface.is_some(),
            page: command.html.as_ref().map(|_| {
                let quantities = config.signals.quantities.keys().copied().collect();
                plot::Drive::new(quantities, [None; 2])
            }),
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

impl Listener for Results {
    fn begin(&mut self, recording: &PartReader) {
        if let Some(page) = &mut self.page {
            page.begin(recording.name(), recording.clock().begins());
        }
    }

    fn frame(&mut self, recording: &PartReader, frame: &Frame) {
        self.player.play(frame);
        self.input(recording.interface(), frame);
    }
}

impl Sink for Results {
    fn estimates(&mut self, sample: &Sample, estimates: &Estimates) {
        if let Some(page) = &mut self.page {
            page.push(sample, estimates);
        }
        if let Some(table) = &mut self.estimates {
            let written = estimates_row(&mut **table, sample, estimates);
            self.check(written);
        }
        if let Some(table) = &mut self.samples {
            let written = samples_row(&mut **table, sample, &self.quantities);
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
