//! `gripd explain`: where simulation and recording differ, and why.

mod apply;
mod fmu;
mod recordings;
mod simulation;
mod verify;

pub use recordings::{Read, read};

use std::collections::BTreeMap;
use std::io::Write;
use std::path::{Path, PathBuf};

use clap::Args;

use super::output::{Told, check_outputs, write_json, write_text};
use super::part::Part;
use super::progress::Progress;
use super::{Failure, configuration};
use lab::explain::{Answer, Case, Confirmed, Finding, Order, Recording, STAGES, ToDrive, Work};
use lab::pages::explain as page;
use physics::model::effect::{KINDS, named};

/// What differs, where, what is missing, how sure that is, and how much better it gets on data it has not
/// seen.
#[derive(Args)]
pub struct Explain {
    /// Configuration of the car. What its [vehicle] table calls uncertain is refitted before anything is
    /// called missing.
    #[arg(short, long)]
    config: PathBuf,
    /// Recordings of one car, in any format that `gripd convert` reads (`-` is the standard input). Every third 20 s
    /// of them are kept for the proof.
    #[arg(required = true)]
    logs: Vec<PathBuf>,
    /// Keep these recordings for the proof instead.
    #[arg(long, value_name = "LOG", num_args = 1..)]
    holdout: Vec<PathBuf>,
    /// A healthy drive of the same car (repeatable). Then the answer is what the recordings have that these have not.
    #[arg(long, value_name = "LOG")]
    reference: Vec<PathBuf>,
    /// The recordings are drives of one car in time order: since which of them is something different, and does it grow?
    /// The drives before a change are the healthy ones; those of --reference are it for all.
    #[arg(long, conflicts_with_all = ["holdout", "simulation", "fmu", "confirm", "sensitivity", "isolability"])]
    history: bool,
    /// The output of your own simulation of the recorded drive. Then the answer is what the simulation leaves out: a CSV file
    /// with the columns `t [s]`, `yaw_rate [rad/s]` and what else it has of the configuration's quantities
    /// (`lateral_acceleration [m/s^2]`, `steering_wheel_angle [deg]`, …), or any recording with the signals of the
    /// configuration.
    #[arg(long, value_name = "FILE",
          conflicts_with_all = ["reference", "holdout", "confirm", "sensitivity", "isolability"])]
    simulation: Option<PathBuf>,
    /// The same with your simulation as an FMU for co-simulation (FMI 2.0 or 3.0, with a library for this machine): it is
    /// run with the recorded inputs, in a process of its own. The configuration's [fmu] table says which variable is which
    /// quantity, what is set, and what is tuned within which range.
    #[arg(long, value_name = "FMU",
          conflicts_with_all = ["simulation", "reference", "holdout", "confirm", "sensitivity", "isolability"])]
    fmu: Option<PathBuf>,
    /// Another drive of the same car (repeatable): does what was found help there, too, its numbers unchanged?
    #[arg(long, value_name = "LOG", conflicts_with_all = ["reference", "sensitivity", "isolability"])]
    confirm: Vec<PathBuf>,
    /// Instead of explaining: how large each effect must be for this drive to show it.
    #[arg(long, conflicts_with = "apply")]
    sensitivity: bool,
    /// Put effects of the predicted sizes into the drive (as `gripd conceal` does), explain these drives for real, and tell how
    /// often each was called by its name, beside what was predicted: of all effects, or of these (a kind, or KIND:CHANNEL).
    /// Takes minutes to hours; what was done is kept in a file beside the answer (its name ends in `.verified`), and the
    /// same command goes on from there.
    #[arg(long, value_name = "EFFECT,…", num_args = 0..=1, require_equals = true, value_delimiter = ',',
          default_missing_value = "", requires = "sensitivity")]
    verify: Option<Vec<String>>,
    /// Instead of explaining: which effects this drive shows at their ordinary size, and which pairs it cannot tell apart.
    #[arg(long, conflicts_with_all = ["sensitivity", "apply", "html"])]
    isolability: bool,
    /// Write the answer as JSON (`-`: to the standard output, instead of the text).
    #[arg(long, value_name = "JSON")]
    json: Option<PathBuf>,
    /// Write a page with the answer and its plots.
    #[arg(long, value_name = "HTML")]
    html: Option<PathBuf>,
    /// Write the configuration with what was found and the corrected numbers.
    #[arg(long, value_name = "TOML")]
    apply: Option<PathBuf>,
    /// With `--apply`: take over numbers that are in doubt, too (at a bound of the search, or more than three of the
    /// table's standard deviations from its value).
    #[arg(long, requires = "apply")]
    force: bool,
    /// Seed of what is drawn at random (the bootstrap of the improvement).
    #[arg(long, default_value_t = 1)]
    seed: u64,
    #[command(flatten)]
    part: Part,
}

/// Hears which stage the work is in, and of which share (0–1) of it.
pub type Watch<'w> = &'w (dyn Fn(&str, f64) + Sync);

/// What is read besides the drives.
struct Beside {
    /// Those of --confirm.
    others: recordings::Read,
    simulation: Option<fmu::Simulation>,
}

impl Explain {
    /// Runs it.
    pub fn run(self) -> Result<(), Failure> {
        let config = self.configured()?;
        let kept = self.verify.as_ref().map(|_| verify::kept_in(self.json.as_deref(), &self.logs[0]));
        check_outputs(
            self.logs
                .iter()
                .chain(&self.holdout)
                .chain(&self.reference)
                .chain(&self.confirm)
                .chain(&self.simulation)
                .chain(&self.fmu)
                .chain([&self.config])
                .chain(config.files()),
            self.json.iter().chain(&self.html).chain(&self.apply).chain(&kept),
        )?;
        let work = Work::default();
        let read = self.read(&config, &work)?;
        let case = self.case(&config, &read);
        if self.sensitivity || self.isolability {
            let (logs, part) = (self.all_logs(), |place| self.part_of(place));
            let drives =
                verify::Drives { config: &config, case: &case, read: &read, logs: &logs, part: &part };
            self.could_tell(&drives)?;
            return read.whole();
        }
        // What cannot be read is told before minutes of searching.
        let beside = self.beside(&config, &read)?;
        let progress = Progress::of_stages(STAGES, work);
        let mut answer = self.answer(&case, &beside, &|stage, share| progress.at(stage, share))?;
        progress.finish();
        self.write_manoeuvres(&mut answer.explanation.to_drive)?;
        let explanation = &answer.explanation;
        if self.prints_text() {
            let mut stdout = std::io::stdout().lock();
            page::print(explanation, &mut stdout)?;
            stdout.flush()?;
        }
        if let Some(path) = &self.json {
            write_json(path, explanation)?;
        }
        if let Some(path) = &self.html {
            write_text(path, &page::page(explanation))?;
        }
        if let Some(path) = &self.apply {
            write_text(path, &apply::toml(&self.config, path, &answer, self.force)?)?;
        }
        beside.others.whole().and_then(|()| read.whole())
    }

    /// Writes what to drive next as scenarios, beside the answer: of `answer.json` into `answer.slalom.toml`.
    fn write_manoeuvres(&self, to_drive: &mut [ToDrive]) -> Result<(), Failure> {
        let is_file = |path: &&PathBuf| path.as_path() != Path::new("-");
        let Some(answer) = self.json.iter().chain(&self.html).find(is_file) else { return Ok(()) };
        for it in to_drive {
            let Some((name, scenario)) = &it.manoeuvre else { continue };
            let path = answer.with_extension(format!("{name}.toml"));
            if path == self.config {
                continue;
            }
            let text = toml::to_string(scenario).map_err(Failure::work)?;
            write_text(&path, &format!("# {}.\n{text}", it.words))?;
            it.scenario = Some(path.display().to_string());
        }
        Ok(())
    }

    /// The explanation as `--json` has it, written nowhere.
    ///
    /// # Errors
    /// As the command's, but for recordings that could not be read to their end.
    pub fn told(&self, watch: Watch<'_>) -> Result<Told, Failure> {
        let config = self.configured()?;
        let read = self.read(&config, &Work::default())?;
        let beside = self.beside(&config, &read)?;
        let answer = self.answer(&self.case(&config, &read), &beside, watch)?;
        Told::new(&answer.explanation, beside.others.whole().and_then(|()| read.whole()))
    }

    /// The configuration, if what is asked can be.
    fn configured(&self) -> Result<bus::Config, Failure> {
        if self.simulation.is_some() && self.logs.len() > 1 {
            return Err(Failure::usage(
                "--simulation takes the one recording that was simulated; name one LOG",
            ));
        }
        if self.fmu.is_some() && self.logs.len() > 1 {
            return Err(Failure::usage("--fmu takes the one recording that it is driven with; name one LOG"));
        }
        if self.history && self.logs.len() + self.reference.len() < 2 {
            return Err(Failure::usage("--history compares drives: name two LOGs or more, or a --reference"));
        }
        self.check_verify()?;
        Ok(configuration::load(&self.config)?)
    }

    /// In the order of a case.
    fn all_logs(&self) -> Vec<PathBuf> {
        self.reference.iter().chain(&self.logs).chain(&self.holdout).cloned().collect()
    }

    /// The part is of what is explained, not of what it is compared with.
    fn part_of(&self, place: usize) -> Part {
        let first = self.reference.len();
        let is_explained = first..first + self.logs.len();
        if is_explained.contains(&place) { self.part.clone() } else { Part::default() }
    }

    /// The drives, which count in `work` how far the fits are.
    fn read(&self, config: &bus::Config, work: &Work) -> Result<recordings::Read, Failure> {
        let mut read = recordings::read(&self.all_logs(), |place| self.part_of(place), config)?;
        read.recordings.iter_mut().for_each(|recording| recording.work = work.clone());
        if self.history && read.put_in_order(self.reference.len()) == Order::Given {
            tracing::info!("{AS_GIVEN}");
        }
        Ok(read)
    }

    fn case<'c>(&self, config: &'c bus::Config, read: &'c recordings::Read) -> Case<'c> {
        Case {
            vehicle: &config.vehicle,
            effects: &config.effect,
            recordings: &read.recordings,
            references: self.reference.len(),
            in_order: self.history,
            held_out: self.holdout.len(),
            chain: &read.chain,
            library: KINDS,
            seed: self.seed,
        }
    }

    fn beside(&self, config: &bus::Config, read: &recordings::Read) -> Result<Beside, Failure> {
        let others = recordings::read(&self.confirm, |_| Part::default(), config)?;
        Ok(Beside { others, simulation: self.simulated(config, &read.recordings[0])? })
    }

    fn answer<'c>(&self, case: &Case<'c>, beside: &Beside, watch: Watch<'_>) -> Result<Answer<'c>, Failure> {
        let mut answer = match &beside.simulation {
            Some(fmu::Simulation { recording: simulation, .. }) => {
                case.left_out(simulation, watch).map_err(|why| {
                    Failure::work(format_args!(
                        "{} beside {}: {why}",
                        simulation.name,
                        self.logs[0].display()
                    ))
                })?
            }
            None => case.explain(watch),
        };
        let explanation = &mut answer.explanation;
        if let (Some(simulated), Some(simulation)) = (&mut explanation.simulation, &beside.simulation) {
            simulated.tuned.clone_from(&simulation.tuned);
        }
        explanation.confirm = confirmed(case, &explanation.findings, &beside.others.recordings)?;
        explanation.tell_dates(case.recordings);
        let next = case.next_drives(explanation, watch);
        explanation.to_drive.splice(0..0, next);
        Ok(answer)
    }

    /// Somebody's simulation of the recording, if there is one.
    fn simulated(
        &self,
        config: &bus::Config,
        recording: &Recording,
    ) -> Result<Option<fmu::Simulation>, Failure> {
        match (&self.simulation, &self.fmu) {
            (Some(path), _) => {
                let recording = simulation::read(path, config)?;
                Ok(Some(fmu::Simulation { recording, tuned: BTreeMap::new() }))
            }
            (None, Some(path)) => {
                let table = configuration::fmu(&self.config)?;
                fmu::run(path, &table, config, recording).map(Some)
            }
            (None, None) => Ok(None),
        }
    }

    /// What is verified is read more than once, and must have a name that there is.
    fn check_verify(&self) -> Result<(), Failure> {
        let Some(wanted) = self.wanted() else { return Ok(()) };
        if self.logs.iter().chain(&self.holdout).any(|log| log.as_os_str() == "-") {
            return Err(Failure::usage(
                "--verify reads the recordings more than once: give files, not the standard input",
            ));
        }
        let is_unknown = |name: &&String| named(name.split(':').next().unwrap_or_default()).is_none();
        match wanted.iter().find(is_unknown) {
            Some(name) => Err(Failure::usage(format_args!(
                "--verify={name}: there is no such effect; `gripd conceal --list` lists them"
            ))),
            None => Ok(()),
        }
    }

    /// With `--json -` the standard output is for programs.
    fn prints_text(&self) -> bool {
        let outputs = [&self.json, &self.html, &self.apply];
        outputs.into_iter().flatten().all(|path| path.as_path() != Path::new("-"))
    }

    /// What the drives could have told.
    fn could_tell(&self, drives: &verify::Drives<'_>) -> Result<(), Failure> {
        let case = drives.case;
        let untold = || Failure::work(NO_CAR);
        if self.isolability {
            let mut answer = case.isolability().ok_or_else(untold)?;
            self.write_manoeuvres(&mut answer.to_drive)?;
            return self.put(&answer, &page::sensitivity::pairs(&answer));
        }
        let mut answer = case.sensitivity().ok_or_else(untold)?;
        if let Some(wanted) = self.wanted() {
            let kept = verify::kept_in(self.json.as_deref(), &self.logs[0]);
            answer.verified = Some(verify::verified(&answer, &wanted, drives, &kept)?);
        }
        if let Some(path) = &self.html {
            write_text(path, &page::sensitivity::page(&answer))?;
        }
        self.put(&answer, &page::sensitivity::text(&answer))
    }

    /// Effects whose prediction is to be verified; all where none is named. None where nothing is.
    fn wanted(&self) -> Option<Vec<String>> {
        let named = self.verify.as_ref()?.iter().filter(|name| !name.is_empty());
        Some(named.cloned().collect())
    }

    fn put(&self, answer: &impl serde::Serialize, text: &str) -> Result<(), Failure> {
        if self.prints_text() {
            std::io::stdout().lock().write_all(text.as_bytes())?;
        }
        self.json.as_ref().map_or(Ok(()), |path| write_json(path, answer))
    }
}

/// What was found, on other drives; what a drive does not tell is said on the way.
fn confirmed(case: &Case<'_>, findings: &[Finding], others: &[Recording]) -> Result<Vec<Confirmed>, Failure> {
    let mut all = Vec::new();
    for recording in others {
        match case.confirm(findings, recording).map_err(Failure::work)? {
            Some(confirmed) => all.push(confirmed),
            None => tracing::warn!(
                "{}: nothing to confirm: nothing was found that is always there and of the car, or this drive does not \
                 tell the car itself",
                recording.name
            ),
        }
    }
    Ok(all)
}

const AS_GIVEN: &str = "the drives are taken in the order in which they were given: not all of their stamps are dates, or two of \
                        them would have been driven at the same time";

const NO_CAR: &str = "the drives do not tell the car itself: steering, yaw rate, a speed and 12 s of driving above 4 m/s are \
                      needed, and a model that predicts the yaw rate; `gripd explain` without this option says what is wrong";
