//! The command line: one file per subcommand.

mod calibrate;
mod check;
mod completions;
mod configuration;
mod convert;
mod demo;
mod demo_car;
mod explain;
mod forget;
mod identify;
mod interrupted;
mod log;
mod man;
mod map;
mod monitor;
mod output;
mod player;
mod printable;
mod progress;
mod recordings;
mod replay;
mod reproduce;
mod run;
mod samples;
mod simulate;
mod tables;
mod view;
mod watched;

use std::fmt;
use std::io::{self, IsTerminal, Write};
use std::process::ExitCode;

use clap::{Parser, Subcommand};
use tracing_subscriber::EnvFilter;

use self::log::Log;
use bus::can::recording::LogError;
use bus::config::ConfigError;
use bus::service::SetupError;

pub use simulate::SimulatedFrames;

/// How a command failed; decides the exit code.
#[derive(Debug)]
pub enum Failure {
    /// Exit code 1: the work failed.
    Work(String),
    /// Exit code 2: bad usage or configuration.
    Usage(String),
    /// Whoever read our standard output has seen enough: no failure, and nothing to say.
    ReaderGone,
}

impl Failure {
    /// The work failed.
    fn work(reason: impl fmt::Display) -> Self {
        Self::Work(reason.to_string())
    }

    /// The user has to change something.
    fn usage(reason: impl fmt::Display) -> Self {
        Self::Usage(reason.to_string())
    }
}

/// Of reading and writing results; the error names the file where there is one.
impl From<io::Error> for Failure {
    fn from(error: io::Error) -> Self {
        match error.kind() {
            io::ErrorKind::BrokenPipe => Self::ReaderGone,
            // The system's own word, of what has no name.
            _ if error.raw_os_error().is_some() => {
                Self::work(format_args!("cannot write to the standard output: {error}"))
            }
            _ => Self::work(error),
        }
    }
}

impl From<LogError> for Failure {
    fn from(error: LogError) -> Self {
        match error {
            error if error.is_broken_pipe() => Self::ReaderGone,
            // It is the name that has to be another one.
            error @ LogError::NotAStream { .. } => Self::usage(error),
            error => Self::work(error),
        }
    }
}

impl From<ConfigError> for Failure {
    fn from(error: ConfigError) -> Self {
        Self::usage(error)
    }
}

impl From<SetupError> for Failure {
    fn from(error: SetupError) -> Self {
        Self::usage(error)
    }
}

/// Tire stiffness and tire-road friction from a vehicle's CAN bus.
#[derive(Parser)]
#[command(name = "gripd", version, about, max_term_width = 100)]
struct Arguments {
    #[command(subcommand)]
    command: Command,
    /// Log more (-v: debug, -vv: trace). RUST_LOG, if set, decides instead.
    #[arg(short, long, global = true, action = clap::ArgAction::Count)]
    verbose: u8,
    /// Log warnings and errors only.
    #[arg(short, long, global = true, conflicts_with = "verbose")]
    quiet: bool,
}

#[derive(Subcommand)]
enum Command {
    /// Simulate a drive over asphalt, gravel and ice, run the service on it, draw a page of plots.
    Demo(demo::Demo),
    /// Run the service on a CAN interface.
    Run(run::Run),
    /// Run the same pipeline over recordings.
    Replay(replay::Replay),
    /// Simulate a scenario to a recording.
    Simulate(simulate::Simulate),
    /// Identify the vehicle's parameters from recordings.
    Identify(identify::Identify),
    /// Where simulation and recording differ: locate it, name the missing physics, prove it on held-out data.
    Explain(explain::Explain),
    /// Carry out the thesis's experiments again and tell which claims hold.
    Reproduce(reproduce::Reproduce),
    /// Find ABS brakings in recordings and map the slip slope to friction.
    Calibrate(calibrate::Calibrate),
    /// Check a configuration, and on recordings the measurement chain.
    Check(check::Check),
    /// Propose a configuration's signals for an unknown car, from its DBC and a recorded drive.
    Map(map::Map),
    /// Forget what a state file says of the car: after new tires, or another set of sensors.
    Forget(forget::Forget),
    /// Turn a recording of any format into one of another.
    Convert(convert::Convert),
    /// Watch a bus or a recording in the terminal: inputs, estimates, faults, frame rates.
    Monitor(monitor::Monitor),
    /// Watch a bus or a recording on a local web page with live plots.
    View(view::View),
    /// Write what a shell needs to complete the arguments.
    Completions(completions::Completions),
    /// Write manual pages.
    Man(man::Pages),
}

/// Parses the arguments and runs the subcommand. Diagnostics go to stderr, results to stdout.
pub fn main() -> ExitCode {
    // Clap itself ends with 2 on bad usage and 0 on --help.
    let arguments = Arguments::parse();
    let log = set_up_logging(&arguments);
    // These end in their own way.
    if !matches!(arguments.command, Command::Run(_) | Command::Monitor(_) | Command::View(_)) {
        interrupted::tidies_up();
    }
    let result = match arguments.command {
        Command::Demo(command) => command.run(),
        Command::Run(command) => command.run(),
        Command::Replay(command) => command.run(),
        Command::Simulate(command) => command.run(),
        Command::Identify(command) => command.run(),
        Command::Explain(command) => command.run(),
        Command::Reproduce(command) => command.run(),
        Command::Calibrate(command) => command.run(),
        Command::Check(command) => command.run(),
        Command::Map(command) => command.run(),
        Command::Forget(command) => command.run(),
        Command::Convert(command) => command.run(),
        Command::Monitor(command) => command.run(),
        Command::View(command) => command.run(),
        Command::Completions(command) => command.run(),
        Command::Man(command) => command.run(),
    };
    if let Some(log) = log {
        log.flush();
    }
    let (reason, code) = match result {
        Ok(()) | Err(Failure::ReaderGone) => return ExitCode::SUCCESS,
        Err(Failure::Work(reason)) => (reason, 1),
        Err(Failure::Usage(reason)) => (reason, 2),
    };
    // Not eprintln: it panics where stderr is closed, and the exit code is what counts.
    let _ = writeln!(std::io::stderr(), "gripd: {}", printable::printable(&reason));
    ExitCode::from(code)
}

/// Logs to stderr; the service through a thread that is given back, to be flushed at the end.
fn set_up_logging(arguments: &Arguments) -> Option<Log> {
    let default = match (arguments.quiet, arguments.verbose) {
        (true, _) => "warn",
        (_, 0) => "info",
        (_, 1) => "debug",
        _ => "trace",
    };
    let filter = EnvFilter::try_from_default_env().unwrap_or_else(|_| EnvFilter::new(default));
    // Under systemd the journal has the time already.
    let journal = std::env::var_os("JOURNAL_STREAM").is_some();
    let log = tracing_subscriber::fmt()
        .with_env_filter(filter)
        .with_target(false)
        // Where stderr is a closed terminal or pipe, saying so there would panic.
        .log_internal_errors(false)
        .with_ansi(std::io::stderr().is_terminal());
    let thread = matches!(arguments.command, Command::Run(_)).then(Log::start).flatten();
    match (thread.clone(), journal) {
        (Some(thread), true) => log.with_writer(thread).without_time().init(),
        (Some(thread), false) => log.with_writer(thread).init(),
        (None, true) => log.with_writer(monitor::stderr).without_time().init(),
        (None, false) => log.with_writer(monitor::stderr).init(),
    }
    thread
}
