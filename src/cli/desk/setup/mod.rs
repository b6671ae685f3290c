//! `gripd setup`: from a DBC and recordings to a configuration that runs, without an editor.

mod answers;
mod questions;
mod report;
mod rounds;
mod sizes;

use std::io::{IsTerminal, Write};
use std::path::{Path, PathBuf};

use clap::Args;

use self::answers::{Answers, wishes};
use self::questions::Questions;
use self::report::Report;
use self::rounds::{Files, Settled, settle};
use super::map::{gather, relative};
use super::output::{check_outputs, write_text};
use super::part::Part;
use super::printable::Printable;
use super::{Failure, check};
use bus::dbc::Database;
use bus::propose::{Confidence, Proposal, VehicleTable, propose_with};
use physics::Quantity;

/// Finds the signals (as `gripd map`), puts right what `gripd check` is certain of (signs, scales, delays, zeros, codes for
/// "not available"), and fills in the car: what you tell, what the recordings tell, and a class of cars for the rest, each
/// number with its source. On a terminal it asks for what no option tells, with a default for everything; with --yes it
/// asks nothing. Ends with 1, and writes nothing, if a signal that is needed was not found.
#[derive(Args)]
pub struct Setup {
    /// The car's DBC (any file named *.dbc), and recorded drives in any format that `gripd convert` reads: a few minutes
    /// with curves, starts and brakings.
    #[arg(required = true, value_name = "DBC|LOG")]
    files: Vec<PathBuf>,
    /// The configuration to write.
    #[arg(short, long, value_name = "TOML")]
    out: PathBuf,
    /// Ask nothing: defaults for what no option tells.
    #[arg(short, long)]
    yes: bool,
    /// Write over a configuration that is there already.
    #[arg(long)]
    force: bool,
    /// Take this signal for a quantity, or none of them (repeatable): yaw_rate=MESSAGE.Signal, brake_pressure=none.
    #[arg(long = "signal", value_name = "QUANTITY=SIGNAL")]
    signals: Vec<String>,
    #[command(flatten)]
    answers: Answers,
    #[command(flatten)]
    part: Part,
}

impl Setup {
    /// Runs it.
    pub fn run(mut self) -> Result<(), Failure> {
        let (dbcs, logs) = self.sorted_files()?;
        self.may_write(&dbcs, &logs)?;
        let asks = !self.yes;
        if asks && !std::io::stdin().is_terminal() {
            return Err(Failure::usage(
                "the standard input is no terminal, so nobody can be asked: add --yes (a default for everything that \
                 no option tells; `gripd setup --help` has the options)",
            ));
        }
        let database = Database::load_all(&dbcs).map_err(Failure::usage)?;
        let wishes = wishes(&self.signals, &database)?;
        let (drive, broken) = gather(&logs, self.part.clone(), &database)?;
        let mut proposal = propose_with(&database, Some(&drive), wishes.clone());
        // The series of all signals are of no use any more.
        drop(drive);
        for (quantity, _) in wishes.iter().filter(|(_, place)| place.is_some()) {
            let choice =
                proposal.choice(*quantity).filter(|choice| choice.confidence == Confidence::NotFound);
            if let Some(choice) = choice {
                return Err(Failure::usage(format_args!(
                    "--signal {quantity}: cannot be taken: {}",
                    choice.why
                )));
            }
        }
        for note in &proposal.notes {
            tracing::warn!("{note}");
        }
        if asks {
            let mut questions = Questions::new(std::io::stdin().lock(), std::io::stderr());
            questions.about_signals(&mut proposal, |quantity| wishes.contains_key(&quantity))?;
            questions.about_the_car(&mut self.answers)?;
        }
        if let Some(reason) = lacking(&proposal, &database) {
            return Err(Failure::Work(reason));
        }
        let has = |quantity: Quantity| proposal.has(quantity);
        let answers = &self.answers;
        let mut vehicle =
            VehicleTable::new(answers.class.unwrap_or_default(), answers.driven, &answers.told(), has);
        let dbcs: Vec<PathBuf> = dbcs.iter().map(|dbc| relative(dbc, &self.out)).collect();
        let files = Files { out: &self.out, dbcs: &dbcs, logs: &logs, part: self.part.clone() };
        let settled = settle(&mut proposal, &mut vehicle, &files)?;
        write_text(&self.out, &settled.text)?;
        let report = Report { proposal: &proposal, vehicle: &vehicle, settled: &settled, files: &files };
        let mut stdout = std::io::stdout().lock();
        report.write(&mut Printable(&mut stdout)).and_then(|()| stdout.flush())?;
        outcome(&settled, broken)
    }

    /// DBCs and recordings, told apart by their names.
    fn sorted_files(&self) -> Result<(Vec<PathBuf>, Vec<PathBuf>), Failure> {
        let is_dbc = |path: &&PathBuf| path.extension().is_some_and(|end| end.eq_ignore_ascii_case("dbc"));
        let (dbcs, logs): (Vec<&PathBuf>, Vec<&PathBuf>) = self.files.iter().partition(is_dbc);
        if dbcs.is_empty() {
            return Err(Failure::usage(
                "no DBC: give the car's file (named *.dbc), which says what its frames mean; without one no recording \
                 of frames can be read",
            ));
        }
        if logs.is_empty() {
            return Err(Failure::usage(
                "no recording: give a recorded drive, too; by the names in a DBC alone, `gripd map` proposes signals",
            ));
        }
        if logs.iter().any(|log| log.as_os_str() == "-") {
            return Err(Failure::usage(
                "the standard input cannot be read twice, and setup has to: write the recording to a file first",
            ));
        }
        let owned = |paths: Vec<&PathBuf>| paths.into_iter().cloned().collect();
        Ok((owned(dbcs), owned(logs)))
    }

    fn may_write(&self, dbcs: &[PathBuf], logs: &[PathBuf]) -> Result<(), Failure> {
        if self.out.as_os_str() == "-" {
            return Err(Failure::usage("-o -: give the configuration a file name"));
        }
        if self.out.symlink_metadata().is_ok() && !self.force {
            return Err(Failure::usage(format_args!(
                "{} is already there and is not overwritten; give another name, or --force",
                self.out.display()
            )));
        }
        check_outputs(dbcs.iter().chain(logs), [&self.out])
    }
}

/// What is needed and was not found, with what is nearest and what to do; `None` if nothing is.
fn lacking(proposal: &Proposal, database: &Database) -> Option<String> {
    let groups = proposal.missing();
    if groups.is_empty() {
        return None;
    }
    let mut problems = Vec::new();
    for group in groups {
        let names = group.iter().map(|quantity| quantity.name()).collect::<Vec<_>>().join(" or ");
        let nearest = group.iter().find_map(|quantity| {
            let choice = proposal.choice(*quantity)?;
            let other = choice.contradicted.iter().chain(&choice.alternatives).next();
            other.map(|other| format!("{} is nearest, but {}", other.signal, other.data))
        });
        problems.push(format!("{names}: {}", nearest.unwrap_or_else(|| "nothing is called so".into())));
    }
    // What is missing may stand in a line that was not understood.
    problems.extend(database.warnings().iter().take(3).map(ToString::to_string));
    Some(format!(
        "not found, and needed, so nothing is written: {}; if you know the signal, name it: --signal \
         QUANTITY=MESSAGE.Signal (`gripd map` lists what was looked at)",
        check::list(&problems)
    ))
}

/// A configuration was written; is it a good one?
fn outcome(settled: &Settled, broken: Option<String>) -> Result<(), Failure> {
    let mut reasons: Vec<String> = broken.into_iter().collect();
    reasons.extend(settled.certain().map(|finding| {
        format!("{} of {}: {}; {}", finding.effect, finding.channel, finding.evidence, finding.repair)
    }));
    if reasons.is_empty() {
        return Ok(());
    }
    Err(Failure::Work(format!("written, but not all is well: {}", check::list(&reasons))))
}

/// A path as a shell takes it.
fn quoted(path: &Path) -> String {
    let text = path.display().to_string();
    let plain = |c: char| c.is_alphanumeric() || "/._-+:@%,".contains(c);
    if !text.is_empty() && text.chars().all(plain) {
        text
    } else {
        format!("'{}'", text.replace('\'', "'\\''"))
    }
}

/// Is it found by a name that leaves doubt?
fn is_unsure(confidence: Confidence) -> bool {
    confidence == Confidence::Unsure
}
