//! The command line: the service here, what one does at a desk in `desk`.

mod configuration;
#[cfg(feature = "desk")]
mod desk;
mod failure;
mod forget;
mod log;
mod printable;
mod run;

#[cfg(not(feature = "desk"))]
use std::io::stderr;
use std::io::{IsTerminal, Write};
use std::process::ExitCode;

use clap::{Parser, Subcommand};
use tracing::level_filters::LevelFilter;
use tracing_subscriber::filter::Targets;
use tracing_subscriber::fmt;
use tracing_subscriber::layer::{Layer, SubscriberExt};
use tracing_subscriber::util::SubscriberInitExt;

#[cfg(feature = "desk")]
use self::desk::stderr;
use self::log::Log;

#[cfg(feature = "desk")]
pub use desk::{SimulatedFrames, library};
pub use failure::Failure;

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
    /// Run the service on a CAN interface.
    Run(run::Run),
    /// Forget what a state file says of the car: after new tires, or another set of sensors.
    Forget(forget::Forget),
    #[cfg(feature = "desk")]
    #[command(flatten)]
    Desk(Box<desk::Command>),
}

/// Parses the arguments and runs the subcommand. Diagnostics go to stderr, results to stdout.
pub fn main() -> ExitCode {
    #[cfg(feature = "desk")]
    desk::run_fmu_if_asked();
    // Clap itself ends with 2 on bad usage and 0 on --help.
    let arguments = Arguments::parse();
    let log = set_up_logging(&arguments);
    let result = match arguments.command {
        Command::Run(command) => command.run(),
        Command::Forget(command) => command.run(),
        #[cfg(feature = "desk")]
        Command::Desk(command) => command.run(),
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
        (true, _) => LevelFilter::WARN,
        (_, 0) => LevelFilter::INFO,
        (_, 1) => LevelFilter::DEBUG,
        _ => LevelFilter::TRACE,
    };
    let asked = std::env::var("RUST_LOG").ok().filter(|text| !text.is_empty());
    let filter: Option<Targets> = asked.and_then(|text| text.parse().ok());
    let filter = filter.unwrap_or_else(|| Targets::new().with_default(default));
    let lines = fmt::layer()
        .with_target(false)
        // Where stderr is a closed terminal or pipe, saying so there would panic.
        .log_internal_errors(false)
        .with_ansi(std::io::stderr().is_terminal());
    // Under systemd the journal has the time already.
    let journal = std::env::var_os("JOURNAL_STREAM").is_some();
    let thread = matches!(arguments.command, Command::Run(_)).then(Log::start).flatten();
    let lines = match (thread.clone(), journal) {
        (Some(thread), true) => lines.with_writer(thread).without_time().boxed(),
        (Some(thread), false) => lines.with_writer(thread).boxed(),
        (None, true) => lines.with_writer(stderr).without_time().boxed(),
        (None, false) => lines.with_writer(stderr).boxed(),
    };
    tracing_subscriber::registry().with(filter).with(lines).init();
    thread
}
