//! `--from` and `--to`: a part of a recording.

use std::ops::RangeInclusive;

use clap::Args;

use super::Failure;

/// Which part of the recordings is asked for.
#[derive(Args, Clone, Copy)]
pub struct Part {
    /// Only what is so many seconds after the first frame, or later.
    #[arg(long, value_name = "S")]
    from: Option<f64>,
    /// Only what is so many seconds after the first frame, or earlier.
    #[arg(long, value_name = "S")]
    to: Option<f64>,
}

impl Part {
    /// As seconds; everything where nothing is asked for.
    pub fn seconds(self) -> Result<RangeInclusive<f64>, Failure> {
        let (from, to) = (self.from.unwrap_or(0.0), self.to.unwrap_or(f64::INFINITY));
        if !(from >= 0.0 && from.is_finite()) {
            return Err(Failure::usage(format_args!("--from {from}: must be zero or more seconds")));
        }
        if to.is_nan() || to <= from {
            return Err(Failure::usage(format_args!(
                "--to {to}: must be more than --from, which is {from} s"
            )));
        }
        Ok(from..=to)
    }
}
