//! `gripd check`.

use clap::Args;

use super::Failure;

/// Placeholder until the audit is in.
#[derive(Args)]
pub struct Check {}

impl Check {
    /// Runs it.
    pub fn run(self) -> Result<(), Failure> {
        Err(Failure::work("not yet"))
    }
}
