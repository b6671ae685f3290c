//! What can go wrong before or during a search.

use thiserror::Error;

use super::parameter::Parameter;

/// Why nothing could be identified.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum IdentifyError {
    /// No TOML, or a key that is none; the message has the line.
    #[error("{0}")]
    Parse(String),
    /// A name in the list is none.
    #[error("identify.parameters: `{0}` is no parameter; there are lateral_stiffness and {all}", all = names())]
    Unknown(String),
    /// A parameter that the equations or the vehicle's table do not have.
    #[error("identify.parameters: `{name}`: {reason}")]
    Unusable {
        /// Which.
        name: String,
        /// Why.
        reason: String,
    },
    /// A setting that cannot be.
    #[error("identify.{key} = {value}: {reason}")]
    Setting {
        /// Which.
        key: &'static str,
        /// Its value.
        value: String,
        /// What would do.
        reason: &'static str,
    },
    /// Nothing to learn from.
    #[error(
        "no stretch of {least_s} s or more with a speed above 3 m/s, steering and yaw rate or lateral \
         acceleration (braking {braking}) in {records}: record a longer drive, or see `gripd check`"
    )]
    NothingUsable {
        /// Least length.
        least_s: f64,
        /// Whether braking counts.
        braking: &'static str,
        /// The records.
        records: String,
    },
    /// No start led anywhere.
    #[error("the search did not come to an end from any of {starts} starts: {reason}")]
    NoEnd {
        /// How many.
        starts: usize,
        /// What happened.
        reason: &'static str,
    },
}

fn names() -> String {
    Parameter::ALL.map(Parameter::name).join(", ")
}
