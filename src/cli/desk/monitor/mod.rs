//! `gripd monitor`: a bus or a recording, watched in a terminal.

mod draw;
mod look;
mod once;
mod screen;
mod sections;
mod session;
mod strip;
#[cfg(test)]
mod tests;

use std::io::IsTerminal;

use clap::Args;

use super::Failure;
use super::watched::Watched;
use look::Look;
pub use screen::stderr;

/// Inputs, estimates with their intervals, faults and frame rates, as they are on the bus: what is shown of the
/// estimates is decoded from the frames that a gripd publishes, their checksums and counters checked. With
/// --estimate, or on a recording, the same estimators run here. Nothing is ever sent.
#[derive(Args)]
pub struct Monitor {
    #[command(flatten)]
    watched: Watched,
    /// Print one snapshot as text and end: of a bus after so many seconds (3), of a recording after so many seconds
    /// of it (at its end), read as fast as it can be. Ends with 1 if nothing was heard.
    #[arg(long, value_name = "SECONDS", num_args = 0..=1, require_equals = true)]
    once: Option<Option<f64>>,
}

impl Monitor {
    /// Is the whole terminal taken, so that nothing else must write on it?
    pub fn takes_the_screen(&self) -> bool {
        self.once.is_none() && std::io::stdout().is_terminal()
    }

    /// Runs it.
    pub fn run(self) -> Result<(), Failure> {
        if let Some(Some(seconds)) = self.once
            && !(seconds.is_finite() && seconds > 0.0)
        {
            return Err(Failure::usage(format_args!(
                "--once={seconds}: must be a positive number of seconds"
            )));
        }
        let takes_the_screen = self.takes_the_screen();
        if self.once.is_none() {
            let dumb = std::env::var_os("TERM").is_none_or(|name| name == "dumb" || name.is_empty());
            if !takes_the_screen || dumb {
                let what = if takes_the_screen { "this terminal (TERM)" } else { "the standard output" };
                return Err(Failure::usage(format_args!(
                    "{what} cannot show a moving picture; `gripd monitor … --once` prints one snapshot as text"
                )));
            }
        }
        let subject = self.watched.prepare()?;
        let runtime =
            tokio::runtime::Builder::new_current_thread().enable_all().build().map_err(Failure::work)?;
        match self.once {
            Some(seconds) => runtime.block_on(once::run(subject, seconds)),
            None => runtime.block_on(session::run(subject, Look::of_environment())),
        }
    }
}
