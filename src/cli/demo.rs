//! `gripd demo`.

use clap::Args;

use super::Failure;

/// Placeholder until the page is in.
#[derive(Args)]
pub struct Demo {}

impl Demo {
    /// Runs it.
    pub fn run(self) -> Result<(), Failure> {
        Err(Failure::work("not yet"))
    }
}
