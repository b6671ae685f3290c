//! Recordings in the log format of can-utils' candump (`candump -L` and `-l`).
//!
//! ```text
//! (1760000000.000584) can0 123#1122334455667788        a classic frame
//! (1760000000.000601) can0 18FEF100#R8                 a remote request, extended identifier
//! (1760000000.000614) can0 123##5112233445566778899AABBCC    an FD frame with bit rate switch
//! ```
//!
//! The grammar is that of can-utils' `lib.h`; nothing here was taken from its code.

mod compression;
mod line;
mod reader;
mod stats;
mod writer;

use std::io;

use thiserror::Error;

pub use compression::Compression;
pub use line::Damage;
pub use reader::Reader;
pub use stats::{LogStats, SkippedLine};
pub use writer::{Writer, write_line};

/// A recording that cannot be read or written (any further).
#[derive(Debug, Error)]
pub enum LogError {
    /// It could not be opened or created.
    #[error("{name}: cannot be opened: {source}; check the path and its permissions")]
    Open {
        /// The file.
        name: String,
        /// Why.
        source: io::Error,
    },
    /// It is a recording, but of a format that is not candump's.
    #[error("{name}: this is {format}, not a candump log; convert it to one first")]
    OtherFormat {
        /// The file.
        name: String,
        /// What it seems to be.
        format: &'static str,
    },
    /// The compressed data stop in the middle.
    #[error(
        "{name}: the {compression} data end too early, after line {line}: the file was cut off; \
         what was before has been read"
    )]
    Truncated {
        /// The file.
        name: String,
        /// How it is compressed.
        compression: Compression,
        /// The last complete line.
        line: u64,
    },
    /// The compressed data are broken.
    #[error(
        "{name}: the {compression} data are corrupt after line {line} ({source}); what was before has been read"
    )]
    Corrupt {
        /// The file.
        name: String,
        /// How it is compressed.
        compression: Compression,
        /// The last complete line.
        line: u64,
        /// What the decompressor says.
        source: io::Error,
    },
    /// Reading failed.
    #[error("{name}: cannot be read beyond line {line}: {source}")]
    Read {
        /// The file.
        name: String,
        /// The last complete line.
        line: u64,
        /// Why.
        source: io::Error,
    },
    /// Writing failed.
    #[error("{name}: cannot be written: {source}")]
    Write {
        /// The file.
        name: String,
        /// Why.
        source: io::Error,
    },
}

impl LogError {
    /// Whoever was to read what we write has gone (`gripd replay … -o - | head`): no reason to complain.
    pub fn is_broken_pipe(&self) -> bool {
        matches!(self, LogError::Write { source, .. } if source.kind() == io::ErrorKind::BrokenPipe)
    }
}
