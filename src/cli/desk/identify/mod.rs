//! `gripd identify`: the vehicle's parameters from recordings.

mod apply;
mod recordings;

use std::io::Write;
use std::path::{Path, PathBuf};

use clap::Args;
use clap::builder::{PossibleValue, PossibleValuesParser, RangedU64ValueParser, TypedValueParser};
use serde::de::value::{Error as ValueError, StrDeserializer};
use serde::de::{DeserializeOwned, IntoDeserializer};

use super::explain::{self, Watch};
use super::output::{Told, check_outputs, write_json, write_text};
use super::part::Part;
use super::progress::Progress;
use super::{Failure, configuration};
use identify::{
    BESIDE, Identification, Identifier, IdentifyConfig, IdentifyError, LongitudinalInput, Method, Record,
    STAGES,
};
use lab::explain::ordinary::{Asked, Ordinary};
use lab::explain::{FIT_STAGES, Work};
use lab::pages;
use lab::pages::identify::{self as page, Story};
use physics::Quantity;

/// What is free, how and how often is searched: `[identify]` in the configuration, or the options here.
#[derive(Args)]
pub struct Identify {
    /// Configuration of the car. What its [vehicle] table calls uncertain is identified.
    #[arg(short, long)]
    config: PathBuf,
    /// Recordings of one car, in any format that `gripd convert` reads (`-` is the standard input), used together.
    #[arg(required = true)]
    logs: Vec<PathBuf>,
    /// Fit nothing to these recordings of the same car, and tell how well they are predicted.
    #[arg(long, value_name = "LOG", num_args = 1..)]
    holdout: Vec<PathBuf>,
    /// Write everything as JSON (`-`: to the standard output, instead of the text).
    #[arg(long, value_name = "JSON")]
    json: Option<PathBuf>,
    /// Write a page with the answer, plots before and after, and how sure it is.
    #[arg(long, value_name = "HTML")]
    html: Option<PathBuf>,
    /// Write the configuration with what was identified.
    #[arg(long, value_name = "TOML")]
    apply: Option<PathBuf>,
    /// With `--apply`: take over numbers that are in doubt, too (at a bound of the search, or more than three of the
    /// table's standard deviations from its value).
    #[arg(long, requires = "apply")]
    force: bool,
    /// Identify these, by their names in [vehicle]; `lateral_stiffness` means both axles' as one.
    #[arg(long, value_name = "NAMES", value_delimiter = ',', value_parser = ParameterNames, hide_possible_values = true)]
    parameters: Option<Vec<String>>,
    /// How segments of the recordings are tied.
    #[arg(long, value_parser = one_of::<Method>(&["auto", "free_run", "segments", "ordinary"]))]
    method: Option<Method>,
    /// What the longitudinal forces come from.
    #[arg(long, value_parser = one_of::<LongitudinalInput>(&["torque", "wheel_speeds", "slips", "speed"]))]
    drive: Option<LongitudinalInput>,
    /// Search from so many starts.
    #[arg(long, value_name = "N", value_parser = starts())]
    starts: Option<usize>,
    #[command(flatten)]
    part: Part,
}

impl Identify {
    /// Runs it.
    pub fn run(self) -> Result<(), Failure> {
        let config = configuration::load(&self.config)?;
        check_outputs(
            self.logs.iter().chain(&self.holdout).chain([&self.config]).chain(config.files()),
            self.json.iter().chain(&self.html).chain(&self.apply),
        )?;
        let used = self.settings()?;
        if used.method == Method::Ordinary {
            return self.ordinary(&config);
        }
        let (read, held_out) = self.records(&config)?;
        let work = Work::default();
        let again = self.drives_again(&config, &work);
        let progress = Progress::of_stages(STAGES, work.clone());
        let watch = |stage: &str, share: f64| progress.at(stage, share);
        let found = self.found(&config, &used, (&read, again.as_ref()), &watch);
        progress.finish();
        let found = found?;
        let story = story(&config, &used, (&read, &held_out), &found);
        if self.prints_text() {
            let mut stdout = std::io::stdout().lock();
            stdout.write_all(page::text(&story).as_bytes()).and_then(|()| stdout.flush())?;
        }
        if let Some(path) = &self.json {
            write_json(path, &page::report(&story))?;
        }
        if let Some(path) = &self.html {
            write_text(path, &page::html(&story))?;
        }
        if let Some(path) = &self.apply {
            write_text(path, &apply::toml((&self.config, path), &found, self.force)?)?;
        }
        whole(&read.broken)
    }

    /// What `--json` has, written nowhere.
    ///
    /// # Errors
    /// As the command's, but for recordings that could not be read to their end.
    pub fn told(&self, watch: Watch<'_>) -> Result<Told, Failure> {
        let config = configuration::load(&self.config)?;
        let used = self.settings()?;
        if used.method == Method::Ordinary {
            let read = self.drives(&config, &Work::default())?;
            let ordinary = self.fitted(&config, &read, watch)?;
            return Told::new(&pages::ordinary::report(&ordinary), whole(&read.broken));
        }
        let (read, held_out) = self.records(&config)?;
        let again = self.drives_again(&config, &Work::default());
        let found = self.found(&config, &used, (&read, again.as_ref()), watch)?;
        Told::new(&page::report(&story(&config, &used, (&read, &held_out), &found)), whole(&read.broken))
    }

    /// The ordinary car by free runs, the measured speed an input.
    fn ordinary(&self, config: &bus::Config) -> Result<(), Failure> {
        let work = Work::default();
        let read = self.drives(config, &work)?;
        let progress = Progress::of_stages(FIT_STAGES, work);
        let ordinary = self.fitted(config, &read, &|stage, share| progress.at(stage, share));
        progress.finish();
        let ordinary = ordinary?;
        if self.prints_text() {
            let mut stdout = std::io::stdout().lock();
            stdout.write_all(pages::ordinary::text(&ordinary).as_bytes()).and_then(|()| stdout.flush())?;
        }
        if let Some(path) = &self.json {
            write_json(path, &pages::ordinary::report(&ordinary))?;
        }
        if let Some(path) = &self.html {
            write_text(path, &pages::ordinary::html(&ordinary, &config.vehicle))?;
        }
        if let Some(path) = &self.apply {
            write_text(path, &apply::of_ordinary((&self.config, path), &ordinary, self.force)?)?;
        }
        whole(&read.broken)
    }

    /// What is fitted to, and what is only predicted; what is broken of either stands with the first.
    fn records(&self, config: &bus::Config) -> Result<(recordings::Read, Vec<Record>), Failure> {
        let config = config.clone().with_true_signals();
        let mut read = recordings::read(&self.logs, &self.part, &config)?;
        let held_out = recordings::read(&self.holdout, &Part::default(), &config)?;
        read.broken.extend(held_out.broken);
        Ok((read, held_out.records))
    }

    /// The recordings as `explain` has them, the held-out ones last, which count in `work` how far the fit is.
    fn drives(&self, config: &bus::Config, work: &Work) -> Result<explain::Read, Failure> {
        let logs: Vec<PathBuf> = self.logs.iter().chain(&self.holdout).cloned().collect();
        let part = |place| if place < self.logs.len() { self.part.clone() } else { Part::default() };
        let mut read = explain::read(&logs, part, config)?;
        read.recordings.iter_mut().for_each(|recording| recording.work = work.clone());
        Ok(read)
    }

    /// The recordings as `explain` has them, where it takes them; none of the standard input, which is not there twice.
    fn drives_again(&self, config: &bus::Config, work: &Work) -> Option<explain::Read> {
        let is_there = self.logs.iter().chain(&self.holdout).all(|log| log != Path::new("-"));
        is_there.then(|| self.drives(config, work).ok()).flatten()
    }

    /// The car by segments or free runs, beside the ordinary one: what they tell of the axles is one quantity.
    fn found(
        &self,
        config: &bus::Config,
        used: &IdentifyConfig,
        (read, again): (&recordings::Read, Option<&explain::Read>),
        watch: Watch<'_>,
    ) -> Result<Identification, Failure> {
        let mut found = Identifier::new(&read.records, &config.vehicle, used)
            .and_then(|identifier| identifier.run(watch))
            .map_err(|error| failure(&error, &read.broken))?;
        if let Some(again) = again.filter(|_| found.tells_stiffness()) {
            let ordinary = self.fitted(config, again, &|_, share| watch(BESIDE, share));
            if let Some(car) = ordinary.ok().filter(Ordinary::is_the_car) {
                found.beside_ordinary(&car.cornering_stiffness);
            }
        }
        Ok(found)
    }

    fn fitted(
        &self,
        config: &bus::Config,
        read: &explain::Read,
        watch: Watch<'_>,
    ) -> Result<Ordinary, Failure> {
        watch(FIT_STAGES[0].name, 0.0);
        let asked = Asked { held_out: self.holdout.len(), ..Asked::CAR };
        Ordinary::of(&config.vehicle, &config.effect, &read.recordings, asked).ok_or_else(|| {
            Failure::work("no recording has steering, yaw rate and 12 s of driving above 4 m/s")
        })
    }

    /// With `--json -` the standard output is for programs.
    fn prints_text(&self) -> bool {
        let outputs = [&self.json, &self.html, &self.apply];
        outputs.into_iter().flatten().all(|path| path.as_path() != Path::new("-"))
    }

    /// The configuration's table with the command line's changes.
    fn settings(&self) -> Result<IdentifyConfig, Failure> {
        let mut used = configuration::identify(&self.config)?;
        if let Some(names) = &self.parameters {
            used.parameters = names.iter().map(|name| name.trim().to_owned()).collect();
        }
        used.method = self.method.unwrap_or(used.method);
        used.drive = self.drive.or(used.drive);
        used.starts = self.starts.unwrap_or(used.starts);
        used.validate().map_err(Failure::usage)?;
        Ok(used)
    }
}

fn story<'s>(
    config: &'s bus::Config,
    used: &'s IdentifyConfig,
    (read, held_out): (&'s recordings::Read, &'s [Record]),
    found: &'s Identification,
) -> Story<'s> {
    let offsets = Quantity::ALL
        .map(|quantity| config.signals.quantities.get(&quantity).map_or(0.0, |config| config.offset));
    Story {
        offsets,
        vehicle: &config.vehicle,
        used,
        records: &read.records,
        held_out,
        predicted: found.predicts(held_out, &config.vehicle),
        found,
    }
}

/// What could be read was worth its results; that something was lost is said all the same.
fn whole(broken: &[String]) -> Result<(), Failure> {
    if broken.is_empty() { Ok(()) } else { Err(Failure::Work(broken.join("; "))) }
}

/// Names of parameters. Shells complete them; which of them can be used, the search knows, and says better.
#[derive(Clone)]
struct ParameterNames;

impl TypedValueParser for ParameterNames {
    type Value = String;

    fn parse_ref(
        &self,
        command: &clap::Command,
        argument: Option<&clap::Arg>,
        value: &std::ffi::OsStr,
    ) -> Result<String, clap::Error> {
        clap::builder::StringValueParser::new().parse_ref(command, argument, value)
    }

    fn possible_values(&self) -> Option<Box<dyn Iterator<Item = PossibleValue> + '_>> {
        Some(Box::new(IdentifyConfig::names().map(PossibleValue::new)))
    }
}

/// As many as the configuration takes.
fn starts() -> impl TypedValueParser<Value = usize> {
    RangedU64ValueParser::<usize>::new().range(1..=IdentifyConfig::MOST_STARTS as u64)
}

/// Words of the configuration's as an option.
fn one_of<T>(words: &'static [&'static str]) -> impl TypedValueParser<Value = T>
where
    T: DeserializeOwned + Clone + Send + Sync + 'static,
{
    PossibleValuesParser::new(words).try_map(|word| {
        let word: StrDeserializer<ValueError> = word.as_str().into_deserializer();
        T::deserialize(word)
    })
}

/// Who has to do something about it: who wrote the configuration, or who drove.
fn failure(error: &IdentifyError, broken: &[String]) -> Failure {
    match error {
        IdentifyError::Parse(_)
        | IdentifyError::Unknown(_)
        | IdentifyError::Unusable { .. }
        | IdentifyError::Setting { .. } => Failure::usage(error),
        IdentifyError::NothingUsable { .. } | IdentifyError::NoEnd { .. } => {
            let mut reasons = vec![error.to_string()];
            reasons.extend_from_slice(broken);
            Failure::Work(reasons.join("; "))
        }
    }
}
