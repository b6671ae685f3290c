//! What can be wrong with a DBC file, with a name looked up in it, or with a value to be encoded.

use std::fmt;
use std::io;
use std::sync::Arc;

use thiserror::Error;

/// A DBC file that cannot be used at all.
#[derive(Debug, Error)]
pub enum DbcError {
    /// The file could not be read.
    #[error("{file}: cannot be read: {source}")]
    Read {
        /// The file.
        file: String,
        /// What the system says.
        source: io::Error,
    },
    /// The file is beyond any size that a DBC file has.
    #[error("{file}: larger than {limit_mib} MiB; this cannot be a DBC file")]
    TooLarge {
        /// The file.
        file: String,
        /// What would be accepted, MiB.
        limit_mib: u64,
    },
    /// Not one statement of the DBC format was found.
    #[error("{file}:1: not a DBC file: no line starts with a DBC keyword such as VERSION, BU_ or BO_")]
    NotDbc {
        /// The file.
        file: String,
    },
    /// There are statements, but not one usable message.
    #[error("{file}:{line}: no usable message in this file: {reason}")]
    NoMessages {
        /// The file.
        file: String,
        /// Where the first message was lost.
        line: usize,
        /// Why.
        reason: String,
    },
}

/// Something in a DBC file that could not be used and was left out. Displayed as `file:line: message`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Warning {
    /// The file, as it was named by the user.
    pub file: Arc<str>,
    /// The line, counted from 1.
    pub line: usize,
    /// What is wrong and what became of it.
    pub message: String,
}

impl fmt::Display for Warning {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}:{}: {}", self.file, self.line, self.message)
    }
}

/// A name that does not lead to a signal.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
pub enum LookupError {
    /// Not of the form MESSAGE.Signal.
    #[error("`{0}` names no signal; write MESSAGE.Signal")]
    NotQualified(String),
    /// No file has such a message.
    #[error("no message `{name}` in the DBC{}", hint(.nearest))]
    UnknownMessage {
        /// What was asked for.
        name: String,
        /// Similar names, best first.
        nearest: Vec<String>,
    },
    /// The message has no such signal.
    #[error("no signal `{signal}` in message `{message}`{}", hint(.nearest))]
    UnknownSignal {
        /// The message, which exists.
        message: String,
        /// What was asked for.
        signal: String,
        /// Similar or elsewhere existing names, best first.
        nearest: Vec<String>,
    },
    /// It is in the file but was left out when the file was loaded.
    #[error("`{name}` cannot be used: {reason}")]
    Skipped {
        /// What was asked for.
        name: String,
        /// The warning of that time, with file and line.
        reason: String,
    },
}

fn hint(nearest: &[String]) -> String {
    match nearest {
        [] => String::new(),
        names => format!("; did you mean {}?", names.join(" or ")),
    }
}

/// A value that a signal cannot carry.
#[derive(Clone, Copy, Debug, PartialEq, Error)]
pub enum EncodeError {
    /// NaN.
    #[error("not a number cannot be encoded")]
    NotANumber,
    /// Beyond the first or last bit pattern.
    #[error("{value} is outside {low} to {high}, which is all the signal can carry")]
    OutOfRange {
        /// The value.
        value: f64,
        /// Lowest physical value.
        low: f64,
        /// Highest physical value.
        high: f64,
    },
    /// The payload ends before the signal does.
    #[error("the payload has {length} bytes, the signal needs {needed}")]
    TooShort {
        /// Bytes needed.
        needed: usize,
        /// Bytes there.
        length: usize,
    },
}
