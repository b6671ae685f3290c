//! What can be wrong with a tire property file.

use std::io;

use thiserror::Error;

/// A tire property file that cannot be used.
#[derive(Debug, Error)]
pub enum TireFileError {
    /// The file could not be read.
    #[error("cannot read the tire file {file}: {source}")]
    Read {
        /// The file.
        file: String,
        /// What the system says.
        source: io::Error,
    },
    /// The file is beyond any size that a tire property file has.
    #[error("{file}: larger than {limit_kib} KiB; this cannot be a tire property file")]
    TooLarge {
        /// The file.
        file: String,
        /// What would be accepted, KiB.
        limit_kib: u64,
    },
    /// What a line says cannot be.
    #[error("{file}:{line}: {reason}")]
    Line {
        /// The file.
        file: String,
        /// The line, counted from 1.
        line: usize,
        /// What is wrong and what to do.
        reason: String,
    },
    /// What is wrong with the whole, or is missing.
    #[error("{file}: {reason}")]
    Whole {
        /// The file.
        file: String,
        /// What is wrong and what to do.
        reason: String,
    },
}
