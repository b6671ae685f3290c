//! Why a recording cannot be read or written (any further).

use std::io;

use thiserror::Error;

use super::{Compression, Format};

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
    /// It is of a format that is not read at all.
    #[error(
        "{name}: this is {format}; convert it to a format that gripd reads (candump, Vector ASC or BLF, ASAM MF4, \
         Peak TRC, python-can CSV) first"
    )]
    NotARecording {
        /// The file.
        name: String,
        /// What it seems to be.
        format: &'static str,
    },
    /// It is of another format than the one that this reader reads.
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
    /// A recording that is not made of lines stops in the middle.
    #[error(
        "{name}: ends in the middle of {what}, at byte {byte}: the file was cut off; what was before has been read"
    )]
    CutOff {
        /// The file.
        name: String,
        /// In what.
        what: &'static str,
        /// Where that begins.
        byte: u64,
    },
    /// A recording that is not made of lines is broken.
    #[error("{name}: byte {byte}: {what}; {to_do}")]
    Broken {
        /// The file.
        name: String,
        /// What is wrong.
        what: String,
        /// Where.
        byte: u64,
        /// What to do.
        to_do: &'static str,
    },
    /// The format must be read here and there in the file.
    #[error(
        "{name}: {format} cannot be read from a pipe or a packed file; unpack it and give the file's name"
    )]
    NeedsFile {
        /// The source.
        name: String,
        /// Its format.
        format: &'static str,
    },
    /// The format is written here and there in the file, and packed in itself.
    #[error(
        "{name}: {format} is written to a plain file only, neither to a pipe nor packed once more; \
         give it a file's name without .gz or .zst"
    )]
    NotAStream {
        /// The file.
        name: String,
        /// Its format.
        format: Format,
    },
    /// Reading failed.
    #[error("{name}: cannot be read{}: {source}", beyond(*line))]
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

/// Where in the text; nothing was read before the first line.
fn beyond(line: u64) -> String {
    if line == 0 { String::new() } else { format!(" beyond line {line}") }
}

impl LogError {
    /// What a failed read of a source means that is perhaps packed.
    #[cold]
    pub(in crate::can) fn of_read(
        name: &str,
        compression: Compression,
        line: u64,
        source: io::Error,
    ) -> Self {
        let name = name.to_owned();
        match (compression, source.kind(), source.raw_os_error()) {
            // An error with a number comes from the operating system, not from the decompressor.
            (Compression::None, ..) | (_, _, Some(_)) => Self::Read { name, line, source },
            (_, io::ErrorKind::UnexpectedEof, _) => Self::Truncated { name, compression, line },
            _ => Self::Corrupt { name, compression, line, source },
        }
    }

    /// Whoever was to read what we write has gone (`gripd replay … -o - | head`): no reason to complain.
    pub fn is_broken_pipe(&self) -> bool {
        matches!(self, LogError::Write { source, .. } if source.kind() == io::ErrorKind::BrokenPipe)
    }
}
