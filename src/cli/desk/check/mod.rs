//! `gripd check`: is a configuration usable, and do recordings agree with it?

mod configuration;
mod layout;
mod recording;
mod standing;
mod text;

use std::io::{IsTerminal, Write};
use std::path::{Path, PathBuf};

use clap::Args;
use serde::Serialize;

use self::configuration::ConfigurationReport;
use self::recording::Recorder;
use super::Failure;
use super::output::{check_outputs, write_json};
use super::part::{Part, PartError};
use super::printable::Printable;
use super::progress::Progress;
use super::samples;
use bus::Config;
use bus::service::sensors;
use bus::signals::{Inputs, Sampler, SamplerConfig, SignalsConfig};
use lab::explain::chain::{self, AuditFinding, ChainReport};
use physics::model::effect::EffectConfig;
use physics::{Quantity, Sample};

pub(super) use self::configuration::{Parts, cost};
pub(super) use self::recording::RecordingReport;

/// Without recordings: configuration and DBC. With them: the measurement chain, too.
#[derive(Args)]
pub struct Check {
    /// Configuration of the car.
    #[arg(short, long)]
    config: PathBuf,
    /// Recordings (candump, Vector ASC or BLF, ASAM MF4, Peak TRC, python-can CSV; gzip or zstd around them; `-`
    /// is the standard input), one after the other.
    logs: Vec<PathBuf>,
    /// Write everything as JSON (`-`: to the standard output, instead of the text).
    #[arg(long, value_name = "JSON")]
    json: Option<PathBuf>,
    #[command(flatten)]
    part: Part,
}

/// `--json`.
#[derive(Debug, Serialize)]
pub struct Report {
    /// The configuration.
    pub configuration: ConfigurationReport,
    /// What the recordings hold.
    pub recordings: Option<RecordingReport>,
    /// Does the measurement chain agree with itself and with physics?
    pub chain: Option<ChainReport>,
}

impl Check {
    /// Runs it.
    pub fn run(self) -> Result<(), Failure> {
        let written = crate::cli::configuration::load(&self.config)?;
        // What its effects say of sensors is no finding any more: readings as the service takes them.
        let config = written.clone().corrected();
        check_outputs(self.logs.iter().chain([&self.config]).chain(config.files()), &self.json)?;
        let parts =
            Parts::build(&config, &self.config).map_err(|problems| Failure::Usage(list(&problems)))?;
        let configuration = ConfigurationReport {
            effects: configuration::effects(&written, &config),
            ..parts.report(&config, &self.config)
        };
        let (recordings, chain) = match self.logs.as_slice() {
            [] => (None, None),
            logs => {
                let (recordings, mut samples) = read(logs, self.part, &config, &parts)?;
                samples::make_plain(&mut samples, &config);
                let mut chain = chain::audit(&samples, &config.vehicle, &sensors(&parts.inputs));
                chain.findings.iter_mut().for_each(|finding| beside_effects(finding, &written.effect));
                (Some(recordings), Some(chain))
            }
        };
        let report = Report { configuration, recordings, chain };
        // With `--json -` the standard output is for programs.
        if self.json.as_deref() != Some(Path::new("-")) {
            let mut stdout = std::io::stdout().lock();
            let is_terminal = stdout.is_terminal();
            text::write(&mut Printable(&mut stdout), is_terminal, &report).and_then(|()| stdout.flush())?;
        }
        if let Some(path) = &self.json {
            write_json(path, &report)?;
        }
        report.recordings.as_ref().map_or(Ok(()), failure)
    }
}

/// What an effect of the configuration says already may be said twice: there, and in `[signals]` or by a healthy sensor.
fn beside_effects(finding: &mut AuditFinding, effects: &[EffectConfig]) {
    let is_same = |effect: &&EffectConfig| {
        let channel = effect.channel().map_or_else(String::new, |channel| channel.to_string());
        effect.kind().name == finding.effect && (channel == finding.channel || channel.is_empty())
    };
    if let Some(effect) = effects.iter().find(is_same) {
        finding.or.push(format!(
            "the [[effect]] {} of the configuration, which is taken out already, is wrong: correct it, or leave it away",
            effect.title()
        ));
    }
}

/// Recordings that cannot be read, or that lack what is required, are a failure of the work.
fn failure(recordings: &RecordingReport) -> Result<(), Failure> {
    let mut reasons: Vec<String> = recordings.files.iter().filter_map(|file| file.broken.clone()).collect();
    let empty = recordings.files.iter().filter(|file| file.frames == 0 && file.broken.is_none());
    reasons.extend(empty.map(|file| {
        format!(
            "{}: no frame in it ({} lines skipped); is it a CAN recording?",
            file.file, file.skipped_lines
        )
    }));
    let channel = |quantity: Quantity| recordings.quantities.iter().find(|c| c.quantity == quantity.name());
    let has = |quantity| channel(quantity).is_some_and(|channel| channel.min.is_some());
    for lacking in Quantity::lacking(has) {
        for channel in lacking.into_iter().filter_map(channel) {
            let why = if channel.frames == 0 {
                "its message never comes: check the identifier in the DBC and which bus was recorded"
            } else {
                "all of its frames say `not available`: check valid, valid_when and not_available"
            };
            reasons.push(format!("signals.{}: no value in the recordings; {why}", channel.quantity));
        }
    }
    if reasons.is_empty() { Ok(()) } else { Err(Failure::Work(list(&reasons))) }
}

/// One or several problems, in words.
pub(super) fn list(problems: &[String]) -> String {
    match problems {
        [only] => only.clone(),
        several => format!("{} problems:\n  {}", several.len(), several.join("\n  ")),
    }
}

/// Reads all recordings once: as the service would see them, and without its plausibility limits, which
/// would hide a wrong unit from the audit.
pub(super) fn read(
    logs: &[PathBuf],
    part: Part,
    config: &Config,
    parts: &Parts,
) -> Result<(RecordingReport, Vec<Sample>), Failure> {
    let mut sampler = Sampler::new(parts.inputs.clone(), &config.signals.sampling);
    let open = unlimited(&config.signals);
    let radius = config.vehicle.wheel_radius_m.value;
    let inputs = Inputs::compile(&open, &parts.database, radius).map_err(Failure::usage)?;
    let mut open = Sampler::new(inputs, &open.sampling);
    let mut recorder = Recorder::new(&parts.inputs);
    let mut samples = Vec::new();
    let mut made = 0;
    let progress = Progress::of_files(logs);
    for path in logs {
        let mut reader = part.open(path)?;
        let broken = loop {
            match reader.next_frame() {
                Ok(None) => break None,
                // Of a part that there is not, every warning would be false.
                Err(error @ PartError::Nothing(_)) => return Err(error.into()),
                Err(error) => break Some(error.to_string()),
                Ok(Some(frame)) => {
                    let pushed = sampler.push(&frame);
                    recorder.frame(&parts.inputs, &frame, pushed);
                    open.push(&frame);
                    made += std::iter::from_fn(|| sampler.next_sample()).count() as u64;
                    samples.extend(std::iter::from_fn(|| open.next_sample()));
                    progress.advance(reader.stats().lines);
                }
            }
        };
        recorder.end_of_file(&reader, broken);
    }
    open.flush();
    sampler.flush();
    made += std::iter::from_fn(|| sampler.next_sample()).count() as u64;
    samples.extend(std::iter::from_fn(|| open.next_sample()));
    progress.finish();
    Ok((recorder.finish(&sampler, made), samples))
}

/// The same mapping with nothing taken for implausible.
fn unlimited(signals: &SignalsConfig) -> SignalsConfig {
    let mut open = signals.clone();
    for quantity in open.quantities.values_mut() {
        quantity.min = Some(f64::MIN);
        quantity.max = Some(f64::MAX);
        quantity.rate_max = Some(f64::MAX);
    }
    open.sampling = SamplerConfig { cross_checks: false, rate_watch: false, ..signals.sampling };
    open
}
