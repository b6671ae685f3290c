//! `gripd calibrate`: from ABS brakings in recordings to a mapping of slope to friction.

use std::fmt::Write as _;
use std::io::Write as _;
use std::path::{Path, PathBuf};

use clap::Args;
use serde::Serialize;

use super::Failure;
use super::output::{check_outputs, write_json};
use super::part::Part;
use super::progress::Progress;
use bus::Config;
use bus::can::Frame;
use bus::service::{Engine, Sink};
use physics::estimate::mapping::{Braking, Calibration, MappingConfig, MappingFit, MappingKind, PairFinder};
use physics::{Estimates, Quantity, Sample, Sensors};

/// Each recording is a drive of its own: on each surface drive until the slope is valid, then brake
/// into the ABS, and drive on for some seconds. Prints the brakings, the fits, and, where the pairs
/// support a mapping, the table for the configuration.
#[derive(Args)]
pub struct Calibrate {
    /// Configuration of the car.
    #[arg(short, long)]
    config: PathBuf,
    /// Recordings (candump, Vector ASC or BLF, ASAM MF4, Peak TRC, python-can CSV; gzip or zstd around them; `-`
    /// is the standard input).
    #[arg(required = true)]
    logs: Vec<PathBuf>,
    /// Write brakings, pairs, fits and the verdict as JSON.
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,
    #[command(flatten)]
    part: Part,
}

impl Calibrate {
    /// Runs it.
    pub fn run(self) -> Result<(), Failure> {
        let config = super::configuration::for_the_service(&self.config)?;
        check_outputs(self.logs.iter().chain([&self.config]).chain(config.files()), &self.json)?;
        if !config.signals.quantities.contains_key(&Quantity::AbsActive) {
            return Err(Failure::usage(format_args!(
                "{}: signals.abs_active: is not mapped; it is by this signal that ABS brakings are found",
                self.config.display()
            )));
        }
        let (input, output) = (config.input_database()?, config.output_database()?);
        let progress = Progress::of_files(&self.logs);
        let mut rows = Vec::new();
        let mut broken = Vec::new();
        let mut samples = 0;
        for path in &self.logs {
            let mut engine = Engine::with_databases(&config, &input, &output)?;
            let mut finder = Finder(PairFinder::new(&config.vehicle, &sensors(&config)));
            let mut reader = self.part.open(path)?;
            loop {
                match reader.next_frame() {
                    Ok(Some(frame)) => engine.frame(&frame, &mut finder),
                    Ok(None) => break,
                    // What could be read before the damage is still worth its results.
                    Err(error) => {
                        broken.push(error.to_string());
                        break;
                    }
                }
                progress.advance(reader.stats().lines);
            }
            engine.finish(&mut finder);
            samples += engine.counts().samples;
            rows.extend(finder.0.finish().into_iter().map(|braking| Row::new(path, &braking)));
        }
        progress.finish();
        let report = Report::new(rows);
        if let Some(path) = &self.json {
            write_json(path, &report)?;
        }
        // Standard output is either for a machine or for a person.
        let for_machine = self.json.as_deref() == Some(Path::new("-"));
        let text = if for_machine || report.brakings.is_empty() { String::new() } else { report.text() };
        std::io::stdout().write_all(text.as_bytes())?;
        if !broken.is_empty() {
            return Err(Failure::Work(broken.join("; ")));
        }
        if samples == 0 {
            return Err(Failure::work(
                "nothing to calibrate from: none of the needed identifiers is in the recordings; are they \
                 of this car and bus? `gripd check` tells more",
            ));
        }
        if report.brakings.is_empty() {
            return Err(Failure::work(
                "no ABS braking in the recordings: signals.abs_active was never 1 while driving above 5 m/s",
            ));
        }
        Ok(())
    }
}

/// What the configuration maps.
fn sensors(config: &Config) -> Sensors {
    let mut sensors = Sensors::default();
    for quantity in config.signals.quantities.keys() {
        sensors.add(*quantity, None);
    }
    sensors
}

struct Finder(PairFinder);

impl Sink for Finder {
    fn estimates(&mut self, sample: &Sample, estimates: &Estimates) {
        self.0.step(sample, estimates);
    }

    fn publish(&mut self, _frame: &Frame) {}
}

/// An ABS braking, as the JSON has it.
#[derive(Serialize)]
struct Row {
    recording: String,
    time_s: f64,
    speed_mps: f64,
    duration_s: f64,
    mu: Option<f64>,
    mu_std: Option<f64>,
    slope: Option<f64>,
    slope_std: Option<f64>,
    slope_age_s: Option<f64>,
    /// The surface was watched afterwards, too, and did not change.
    confirmed: bool,
    pair: bool,
    /// Why it is not a pair.
    reason: Option<String>,
    #[serde(skip)]
    braking: Braking,
}

impl Row {
    fn new(recording: &Path, braking: &Braking) -> Self {
        Self {
            recording: recording.display().to_string(),
            time_s: braking.time.seconds(),
            speed_mps: braking.speed,
            duration_s: braking.duration_s,
            mu: braking.mu.map(|(mu, _)| mu),
            mu_std: braking.mu.map(|(_, std)| std),
            slope: braking.slope.map(|slope| slope.value),
            slope_std: braking.slope.map(|slope| slope.std),
            slope_age_s: braking.slope.map(|slope| slope.age_s),
            confirmed: braking.confirmed,
            pair: braking.pair().is_some(),
            reason: braking.not_a_pair.map(|reason| reason.to_string()),
            braking: braking.clone(),
        }
    }
}

/// A mapping fitted, as the JSON has it.
#[derive(Serialize)]
struct Fit {
    /// `constant`, `linear` or `quadratic`.
    kind: &'static str,
    /// Constant: [mu]; linear: [a, b] of mu = a k + b; quadratic: [a] of mu = a k².
    coefficients: Vec<f64>,
    /// Their standard deviations.
    std: Vec<f64>,
    residual_std: f64,
    r_square: f64,
    aicc: f64,
    p_value: f64,
}

impl Fit {
    fn new(fit: &MappingFit) -> Self {
        let r = &fit.regression;
        let (aa, bb) = (r.covariance.aa.sqrt(), r.covariance.bb.sqrt());
        let (kind, coefficients, std) = match fit.kind {
            None => ("constant", vec![r.b], vec![bb]),
            Some(MappingKind::Linear) => ("linear", vec![r.a, r.b], vec![aa, bb]),
            Some(MappingKind::Quadratic) => ("quadratic", vec![r.a], vec![aa]),
        };
        Self {
            kind,
            coefficients,
            std,
            residual_std: fit.residual_std(),
            r_square: r.r_square,
            aicc: r.aicc,
            p_value: fit.p_value,
        }
    }

    fn formula(&self) -> String {
        let term = |i: usize| {
            let (value, std) = (self.coefficients.get(i), self.std.get(i));
            let (value, std) = (value.copied().unwrap_or(f64::NAN), std.copied().unwrap_or(f64::NAN));
            // As many decimals as the standard deviation has two digits of.
            let decimals = (1.0 - std.abs().max(1e-9).log10().floor()).clamp(0.0, 9.0) as usize;
            format!("({value:.decimals$} ± {std:.decimals$})")
        };
        match self.kind {
            "constant" => format!("mu = {}", term(0)),
            "linear" => format!("mu = {} k + {}", term(0), term(1)),
            _ => format!("mu = {} k²", term(0)),
        }
    }
}

/// `--json`.
#[derive(Serialize)]
struct Report {
    brakings: Vec<Row>,
    /// Number of pairs among them.
    pairs: usize,
    fits: Vec<Fit>,
    /// The mapping, as `[estimators.mapping]` has it; null if refused.
    chosen: Option<MappingConfig>,
    /// Why there is none.
    reason: Option<String>,
    remarks: Vec<String>,
}

impl Report {
    fn new(brakings: Vec<Row>) -> Self {
        let pairs: Vec<_> = brakings.iter().filter_map(|row| row.braking.pair()).collect();
        let calibration = Calibration::new(&pairs);
        let reason = calibration.chosen.as_ref().err().map(ToString::to_string);
        Self {
            brakings,
            pairs: pairs.len(),
            fits: calibration.fits.iter().map(Fit::new).collect(),
            chosen: calibration.chosen.ok(),
            reason,
            remarks: calibration.remarks,
        }
    }

    /// For people, every line but the table for the configuration a comment, so that the whole can be
    /// appended to it.
    fn text(&self) -> String {
        let mut out = String::new();
        // Writing to a string cannot fail.
        let _ = self.write_text(&mut out);
        out
    }

    fn write_text(&self, out: &mut String) -> std::fmt::Result {
        let number = |value: Option<f64>, digits: usize| {
            value.map_or_else(|| "–".into(), |value| format!("{value:.digits$}"))
        };
        writeln!(
            out,
            "# {} ABS brakings, {} of them pairs of slope and friction",
            self.brakings.len(),
            self.pairs
        )?;
        writeln!(out, "#\n#  {:>16} {:>6} {:>5}  {:>13}  {:>13}", "time, s", "m/s", "s", "slope", "mu")?;
        let mut recording = "";
        for row in &self.brakings {
            if row.recording != recording {
                recording = &row.recording;
                writeln!(out, "#  {recording}")?;
            }
            let slope = format!("{} ± {}", number(row.slope, 1), number(row.slope_std, 1));
            let mu = format!("{} ± {}", number(row.mu, 3), number(row.mu_std, 3));
            let verdict = match (&row.reason, row.confirmed) {
                (Some(reason), _) => format!("no pair: {reason}"),
                (None, true) => "pair".into(),
                (None, false) => "pair (the drive ends too soon after it to confirm the surface)".into(),
            };
            writeln!(
                out,
                "#  {:>16.2} {:>6.1} {:>5.1}  {slope:>13}  {mu:>13}  {verdict}",
                row.time_s, row.speed_mps, row.duration_s
            )?;
        }
        if !self.fits.is_empty() {
            writeln!(out, "#\n#  {:<9} {:>5} {:>8} {:>7} {:>9}", "", "R²", "residual", "AICc", "p")?;
        }
        for fit in &self.fits {
            let p = if fit.kind == "constant" { "–".into() } else { format!("{:.2e}", fit.p_value) };
            writeln!(
                out,
                "#  {:<9} {:>5.2} {:>8.3} {:>7.1} {p:>9}   {}",
                fit.kind,
                fit.r_square,
                fit.residual_std,
                fit.aicc,
                fit.formula()
            )?;
        }
        if let Some(reason) = &self.reason {
            return writeln!(out, "#\n# No mapping: {reason}.");
        }
        let Some(chosen) = &self.chosen else { return Ok(()) };
        writeln!(out, "#\n# The pairs support a mapping. For the configuration:")?;
        for remark in &self.remarks {
            writeln!(out, "# But {remark}.")?;
        }
        writeln!(out, "\n{}", table(chosen))
    }
}

/// The mapping as a table of the configuration.
fn table(mapping: &MappingConfig) -> String {
    let list = |values: &[f64]| {
        let texts: Vec<_> = values.iter().map(|value| format!("{value:e}")).collect();
        format!("[{}]", texts.join(", "))
    };
    let (kind, formula) = match mapping.kind {
        MappingKind::Linear => ("linear", "mu = a k + b"),
        MappingKind::Quadratic => ("quadratic", "mu = a k²"),
    };
    let rows: Vec<_> = mapping.covariance.iter().map(|row| list(row)).collect();
    let [low, high] = mapping.slope_range;
    let roughness = mapping
        .roughness_mps
        .map_or(String::new(), |[low, high]| format!("roughness_mps = [{low:.4}, {high:.4}]\n"));
    format!(
        "[estimators.mapping]    # {formula}; for this car with these tires, on roads like those\n\
         kind = \"{kind}\"\n\
         coefficients = {}\n\
         covariance = [{}]\n\
         residual_std = {:.4}\n\
         slope_range = [{low:.2}, {high:.2}]\n\
         {roughness}\
         pairs = {}",
        list(&mapping.coefficients),
        rows.join(", "),
        mapping.residual_std,
        mapping.pairs
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_table_reads_back_as_the_mapping() {
        let line = vec![vec![1.2e-7, -3.1e-6], vec![-3.1e-6, 4.0e-4]];
        for (kind, coefficients, covariance, roughness_mps) in [
            (MappingKind::Linear, vec![0.0061, 0.21], line, Some([0.0021, 0.125])),
            (MappingKind::Quadratic, vec![9.1e-5], vec![vec![2.5e-11]], None),
        ] {
            let mapping = MappingConfig {
                kind,
                coefficients,
                covariance,
                residual_std: 0.0412,
                slope_range: [48.25, 97.5],
                roughness_mps,
                pairs: 9,
            };
            let text = table(&mapping);
            let document: toml::Table = toml::from_str(&text).unwrap();
            let read: MappingConfig = document["estimators"]["mapping"].clone().try_into().unwrap();
            assert_eq!(read, mapping, "{text}");
        }
    }
}
