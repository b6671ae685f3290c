//! The one way to a recording, whatever its format.

use std::fs::File;
use std::io::{self, Read};
use std::path::Path;

use super::candump;
use super::lines::{Grammar, TextReader};
use super::recognize::recognize;
use super::unpack::MF4;
use super::{Compression, Content, Format, LogError, LogStats, Source, asc, blf, csv, mf4, trc, unpack};
use crate::can::Frame;

/// Reads frames from a recording: a file, packed or not, or anything else that can be read.
///
/// What is damaged is skipped and counted ([`LogStats`]); only a failing or broken source is an error. Memory
/// does not depend on the length of the recording.
pub struct Reader {
    format: Format,
    source: Kind,
}

/// candump logs, which are most and largest, are read without a detour.
enum Kind {
    Candump(Box<candump::Reader>),
    Other(Box<dyn Source>),
}

impl Reader {
    /// Opens a recording; `-` is the standard input. Format and compression are recognized by the content.
    ///
    /// # Errors
    /// If it cannot be opened or is evidently none that can be read.
    pub fn open(path: &Path) -> Result<Self, LogError> {
        let hint = Format::of_name(path);
        if path.as_os_str() == "-" {
            return Self::of_source(Box::new(io::stdin()), "standard input".into(), None);
        }
        let name = path.display().to_string();
        let file = match File::open(path) {
            Ok(file) => file,
            Err(source) => return Err(LogError::Open { name, source }),
        };
        if is_mf4(&file) {
            let source = Kind::Other(Box::new(mf4::Reader::open(file, name)?));
            return Ok(Self { format: Format::Mf4, source });
        }
        Self::of_source(Box::new(file), name, hint)
    }

    /// Reads from anything; `name` stands in messages.
    ///
    /// # Errors
    /// If its first bytes cannot be read or are evidently no recording; if it is an MF4 file, which must be read
    /// here and there.
    pub fn from_read(source: Box<dyn Read + Send>, name: &str) -> Result<Self, LogError> {
        Self::of_source(source, name.to_owned(), None)
    }

    fn of_source(source: Box<dyn Read + Send>, name: String, hint: Option<Format>) -> Result<Self, LogError> {
        let failed = |name: &str, source| LogError::Read { name: name.to_owned(), line: 0, source };
        let (source, content) = unpack(source).map_err(|error| failed(&name, error))?;
        let compression = match content {
            Content::Log(compression) => compression,
            Content::Blf | Content::Mf4 => Compression::None,
            Content::Other(format) => return Err(LogError::NotARecording { name, format }),
        };
        let (source, format) =
            recognize(source, hint).map_err(|error| LogError::of_read(&name, compression, 0, error))?;
        let source = match format {
            Format::Candump => {
                Kind::Candump(Box::new(candump::Reader::of_unpacked(source, name, compression)))
            }
            Format::Asc => text(source, name, compression, asc::Asc::default()),
            Format::Trc => text(source, name, compression, trc::Trc::default()),
            Format::Csv => text(source, name, compression, csv::Csv),
            Format::Blf => Kind::Other(Box::new(blf::Reader::new(source, name, compression)?)),
            Format::Mf4 => return Err(LogError::NeedsFile { name, format: "an ASAM MF4 recording" }),
        };
        Ok(Self { format, source })
    }

    /// Its format.
    pub fn format(&self) -> Format {
        self.format
    }

    /// The file's name as it stands in messages.
    pub fn name(&self) -> &str {
        match &self.source {
            Kind::Candump(reader) => reader.name(),
            Kind::Other(source) => &source.about().name,
        }
    }

    /// The interface of the frame delivered last.
    pub fn interface(&self) -> &str {
        match &self.source {
            Kind::Candump(reader) => reader.interface(),
            Kind::Other(source) => &source.about().interface.name,
        }
    }

    /// What was seen so far; after the last frame, of the whole recording.
    #[inline]
    pub fn stats(&self) -> &LogStats {
        match &self.source {
            Kind::Candump(reader) => reader.stats(),
            Kind::Other(source) => &source.about().stats,
        }
    }

    /// The next frame, or `None` at the end.
    ///
    /// # Errors
    /// If the source fails or is broken. What could be read has been delivered before, and the error comes once:
    /// after it there is only `None`.
    #[inline]
    pub fn next_frame(&mut self) -> Result<Option<Frame>, LogError> {
        match &mut self.source {
            Kind::Candump(reader) => reader.next_frame(),
            Kind::Other(source) => source.next_frame(),
        }
    }
}

fn text(
    source: Box<dyn Read + Send>,
    name: String,
    compression: Compression,
    grammar: impl Grammar + 'static,
) -> Kind {
    Kind::Other(Box::new(TextReader::new(source, name, compression, grammar)))
}

/// Looks without taking anything; of what is no file, a pipe or a device, nothing is looked at.
fn is_mf4(file: &File) -> bool {
    use std::os::unix::fs::FileExt;
    let mut head = [0; 5];
    let is_file = file.metadata().is_ok_and(|about| about.is_file());
    is_file && file.read_exact_at(&mut head, 0).is_ok() && MF4.iter().any(|magic| head.starts_with(magic))
}
