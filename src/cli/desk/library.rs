//! The commands for other programs: asked as on the command line, answered by values instead of files.

use std::ffi::OsString;

use clap::Args;

use super::Failure;

pub use super::explain::{Explain, Watch};
pub use super::identify::Identify;
pub use super::output::Told;
pub use super::part::{Part, PartError, PartReader};
pub use super::replay::{Drive, Driven, Listener, Stats};
pub use super::simulate::{Simulate, Simulated};
pub use super::tables::rows;
pub use crate::cli::configuration::for_the_service;

/// A command's options, of what stands behind its name on the command line.
///
/// # Errors
/// As the command line's: what is wrong with them, and the usage.
pub fn options<A: Args>(
    command: &'static str,
    arguments: impl IntoIterator<Item = OsString>,
) -> Result<A, Failure> {
    let parser = A::augment_args(clap::Command::new(command).no_binary_name(true));
    let matches = parser.try_get_matches_from(arguments).map_err(told)?;
    A::from_arg_matches(&matches).map_err(told)
}

fn told(error: clap::Error) -> Failure {
    Failure::usage(error.to_string().trim_start_matches("error: ").trim_end())
}
