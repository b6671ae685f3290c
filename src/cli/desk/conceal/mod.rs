//! `gripd conceal`: puts effects into a recording of a real car.

mod asked;
mod list;
mod truth;

use std::path::{Path, PathBuf};

use clap::Args;

use super::output::{check_outputs, write_json};
use super::part::Part;
use super::progress::Progress;
use super::{Failure, configuration, explain, recordings};
use asked::Wanted;
use bus::Config;
use bus::can::recording::{Format, Reader, Writer, candump};
use bus::signals::Alterer;
use lab::explain::ordinary::conceal::{Asked, Concealment};
use physics::model::effect::EffectConfig;
use physics::{Micros, Quantity};

/// A recording in which the car has something more: a payload, a small wheel, a late sensor. Noise, road and all that is
/// odd about the car stay, and so does every bit that the effect does not change. What acts on the car is the difference
/// of two free runs of the fitted car, with the effect and without; what is of a sensor or a wheel's radius is put onto
/// the frames exactly. The unchanged recording is the control of what `gripd explain` says of the changed one.
#[derive(Args)]
pub struct Conceal {
    /// Configuration of the car.
    #[arg(short, long, required_unless_present = "list")]
    config: Option<PathBuf>,
    /// The recording, in any format that `gripd convert` reads (gzip or zstd around it).
    #[arg(required_unless_present = "list")]
    recording: Option<PathBuf>,
    /// An effect: the name of its kind, with its numbers by --set; its table, as in 'kind = "payload", mass_kg = 350'; or
    /// a file with [[effect]] tables. Several act together.
    #[arg(short, long = "effect", value_name = "EFFECT", required_unless_present = "list")]
    effects: Vec<String>,
    /// A number (or the channel) of the effect that --effect names.
    #[arg(short, long = "set", value_name = "NAME=VALUE")]
    sets: Vec<String>,
    /// The changed recording (candump, or the format that the name ends in; `.gz` and `.zst` are packed; `-` is the
    /// standard output). From candump to candump all that is not changed stays as it is to the byte.
    #[arg(short, long, required_unless_present = "list")]
    out: Option<PathBuf>,
    /// Write what was put in, and how strong that is, as JSON.
    #[arg(long, value_name = "JSON")]
    truth: Option<PathBuf>,
    /// Seed of courses that are drawn at random.
    #[arg(long, value_name = "N", default_value_t = 1)]
    seed: u64,
    /// List the effects, their numbers, and the channels that they need; with --config, whether the car has these.
    #[arg(long)]
    list: bool,
}

impl Conceal {
    /// Runs it.
    pub fn run(self) -> Result<(), Failure> {
        if self.list {
            let config = self.config.as_deref().map(configuration::load).transpose()?;
            return list::print(config.as_ref());
        }
        let (Some(config_path), Some(log), Some(out)) = (&self.config, &self.recording, &self.out) else {
            return Err(Failure::usage("give --config, a recording and --out"));
        };
        if log.as_os_str() == "-" {
            return Err(Failure::usage(
                "the recording is read more than once: give a file, not the standard input",
            ));
        }
        let wanted = asked::read(&self.effects, &self.sets)?;
        let config = configuration::load(config_path)?;
        let files = [config_path, log].into_iter().chain(config.files());
        check_outputs(files, [out].into_iter().chain(&self.truth))?;
        let read = explain::read(std::slice::from_ref(log), |_| Part::default(), &config)?;
        if !read.broken.is_empty() {
            return Err(Failure::Work(read.broken.join("; ")));
        }
        let (Some(recording), Some(start)) = (read.recordings.first(), read.starts.first()) else {
            return Err(Failure::work(format_args!("{}: there is nothing in it", log.display())));
        };
        let effects = Wanted::configs(&wanted, recording.seconds(), self.seed)?;
        let progress = Progress::of_parts(1);
        progress.begin("fit the ordinary car".into());
        let asked =
            Asked { vehicle: &config.vehicle, configured: &config.effect, recording, effects: &effects };
        let concealment =
            Concealment::of(asked).map_err(|why| Failure::work(format_args!("{}: {why}", log.display())))?;
        progress.finish();
        let change = |quantity: Quantity, time: Micros, value: f64| {
            concealment.reading(quantity, (time - *start).seconds(), value)
        };
        let (alterer, notes) = written([log, out], &config, self.seed, &change)?;
        tell(&alterer, out, &effects);
        notes.iter().for_each(|note| tracing::warn!("{}: {note}", out.display()));
        let Some(path) = &self.truth else { return Ok(()) };
        let truth = truth::of(&truth::Done {
            log,
            seed: self.seed,
            wanted: &wanted,
            effects: &effects,
            seconds: recording.seconds(),
            concealment: &concealment,
            alterer: &alterer,
            notes: &notes,
        });
        write_json(path, &truth)
    }
}

/// Writes the changed recording: what became of it, and what is to be said of its checksums.
fn written(
    [log, out]: [&Path; 2],
    config: &Config,
    seed: u64,
    change: &dyn Fn(Quantity, Micros, f64) -> f64,
) -> Result<(Alterer, Vec<String>), Failure> {
    let database = config.input_database()?;
    let radius = config.vehicle.wheel_radius_m.value;
    let mut alterer = Alterer::compile(&config.signals, &database, radius).map_err(Failure::usage)?;
    let mut reader = Reader::open(log).map_err(Failure::work)?;
    while let Some(frame) = reader.next_frame()? {
        alterer.look(&frame, change);
    }
    let notes = alterer.looked(seed);
    recordings::warn(&reader);
    let format = recordings::format_of(out, "")?;
    if (reader.format(), format) == (Format::Candump, Format::Candump) {
        candump::rewrite(log, out, |frame| alterer.alter(frame, change))?;
    } else {
        let mut reader = Reader::open(log).map_err(Failure::work)?;
        let mut writer = Writer::create(out, format, "can0")?;
        while let Some(frame) = reader.next_frame()? {
            let changed = alterer.alter(&frame, change).unwrap_or(frame);
            writer.write_as(reader.interface(), &changed)?;
        }
        recordings::tell_losses(out, format, &writer.finish()?);
    }
    let notes = notes.into_iter().filter(|(id, _)| alterer.has_changed(*id)).map(|(_, note)| note).collect();
    Ok((alterer, notes))
}

/// Where less than this share of a change is left in the frames, that is told.
const LEAST_KEPT: f64 = 0.8;

/// What is worth a word on the way.
fn tell(alterer: &Alterer, out: &Path, effects: &[EffectConfig]) {
    let name = out.display();
    let mut is_anything_wanted = false;
    for quantity in Quantity::ALL {
        let altered = alterer.of(quantity);
        is_anything_wanted |= altered.wanted_rms() > 0.0;
        if altered.changed > 0 {
            tracing::info!(
                "{name}: {quantity} changed in {} of {} frames, by {:.3e} {} rms",
                altered.changed,
                altered.readings,
                altered.rms(),
                quantity.unit()
            );
        }
        if altered.clipped > 0 {
            tracing::warn!(
                "{name}: {} values of {quantity} do not fit the bits of its signal: the nearest that do are there",
                altered.clipped
            );
        }
        // What is far below a raw unit is no change to anybody.
        if altered.wanted_rms() > 0.01 * altered.step && altered.kept() < LEAST_KEPT {
            tracing::warn!(
                "{name}: {quantity} should change by {:.3e} {} rms, and {:.0} % of that is in the frames: a raw unit of \
                 its signal is {:.3e}",
                altered.wanted_rms(),
                quantity.unit(),
                100.0 * altered.kept(),
                altered.step
            );
        }
    }
    if !is_anything_wanted {
        let titles: Vec<_> = effects.iter().map(EffectConfig::title).collect();
        tracing::warn!("{name}: with these numbers {} changes nothing", titles.join(" and "));
    }
}
