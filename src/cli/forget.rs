//! `gripd forget`: takes out of a state file what is true no more.

use std::path::PathBuf;

use clap::{Args, ValueEnum};

use super::Failure;
use bus::service::saved::{self, Claim, SavedState};

/// A running service is told by a signal instead: SIGUSR1 to forget everything, SIGUSR2 tires and radii.
#[derive(Args)]
pub struct Forget {
    /// The service's `state_file`.
    state: PathBuf,
    /// Only this; may be given several times.
    #[arg(long, value_enum)]
    part: Vec<Part>,
}

/// What can be forgotten by itself.
#[derive(Clone, Copy, PartialEq, ValueEnum)]
enum Part {
    /// Slip slopes and cornering stiffnesses.
    Tires,
    /// Differences of the wheels' radii, and the error of the speed.
    Radii,
    /// Offsets of the sensors, and the error of the steering ratio.
    Offsets,
}

impl From<Part> for saved::Part {
    fn from(part: Part) -> Self {
        match part {
            Part::Tires => Self::Tires,
            Part::Radii => Self::Radii,
            Part::Offsets => Self::Offsets,
        }
    }
}

impl Forget {
    /// Runs it.
    pub fn run(self) -> Result<(), Failure> {
        let path = self.state.display();
        let state = SavedState::of_file(&self.state)
            .map_err(|refusal| Failure::usage(format_args!("{path} {refusal}")))?;
        let claim = state.claim();
        if matches!(claim, Claim::Taken) {
            return Err(Failure::work(format_args!(
                "{path}: a running gripd has this file: stop it, or send it SIGUSR1 (SIGUSR2: tires and radii only)"
            )));
        }
        let refused = |refusal: saved::Refusal| Failure::usage(format_args!("{path} {refusal}"));
        let learned = state.load().map_err(refused)?.unwrap_or_default();
        let parts: Vec<saved::Part> = self.part.iter().map(|part| (*part).into()).collect();
        let parts = if parts.is_empty() { &saved::Part::ALL[..] } else { &parts };
        let failed = |error| Failure::work(format_args!("cannot write {path}: {error}"));
        state.save(&saved::without(learned, parts)).map_err(failed)
    }
}
