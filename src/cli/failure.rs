//! How a command fails.

use std::fmt;
use std::io;

#[cfg(feature = "desk")]
use bus::can::recording::LogError;
use bus::config::ConfigError;
use bus::service::SetupError;

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
    pub fn work(reason: impl fmt::Display) -> Self {
        Self::Work(reason.to_string())
    }

    /// The user has to change something.
    pub fn usage(reason: impl fmt::Display) -> Self {
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

#[cfg(feature = "desk")]
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
