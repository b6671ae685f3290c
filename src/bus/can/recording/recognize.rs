//! Which format is it? The content tells; a name's extension only where the content leaves it open.

use std::fmt;
use std::io::{self, Cursor, Read};
use std::path::Path;

use super::unpack::{BLF, MF4};

/// A format of recordings.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Format {
    /// can-utils' `candump -L`.
    Candump,
    /// Vector's text.
    Asc,
    /// Vector's binary logging format.
    Blf,
    /// ASAM's measurement data format 4 with bus logging.
    Mf4,
    /// Peak's text.
    Trc,
    /// python-can's comma-separated values.
    Csv,
}

impl Format {
    /// What one of its skipped parts is.
    pub fn part(self) -> &'static str {
        match self {
            Self::Candump | Self::Asc | Self::Trc | Self::Csv => "line",
            Self::Blf => "object",
            Self::Mf4 => "record",
        }
    }

    /// Is it a text, which may be packed and streamed?
    pub fn is_text(self) -> bool {
        !matches!(self, Self::Blf | Self::Mf4)
    }

    /// All of them, by the names that [`Format::named`] knows.
    pub const NAMES: [(&str, Format); 6] = [
        ("candump", Self::Candump),
        ("asc", Self::Asc),
        ("blf", Self::Blf),
        ("mf4", Self::Mf4),
        ("trc", Self::Trc),
        ("csv", Self::Csv),
    ];

    /// By its short name; `None` if there is none of that name.
    pub fn named(name: &str) -> Option<Self> {
        Self::NAMES.iter().find(|(known, _)| *known == name).map(|(_, format)| *format)
    }

    /// By the extension of a file's name, that of a packed file by the one before.
    pub fn of_name(path: &Path) -> Option<Self> {
        let extension = |path: &Path| Some(path.extension()?.to_str()?.to_ascii_lowercase());
        let mut last = extension(path)?;
        if last == "gz" || last == "zst" {
            last = extension(Path::new(path.file_stem()?))?;
        }
        if last == "log" { Some(Self::Candump) } else { Self::named(&last) }
    }
}

impl fmt::Display for Format {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Candump => "candump",
            Self::Asc => "Vector ASC",
            Self::Blf => "Vector BLF",
            Self::Mf4 => "ASAM MF4",
            Self::Trc => "Peak TRC",
            Self::Csv => "python-can CSV",
        })
    }
}

/// Bytes that are looked at, at most; headers are shorter.
const LOOK: usize = 1 << 14;

/// Reads as much of an unpacked source as it takes to know its format, and puts it back in front.
///
/// # Errors
/// If not even the first bytes can be read.
pub(super) fn recognize(
    mut source: Box<dyn Read + Send>,
    hint: Option<Format>,
) -> io::Result<(Box<dyn Read + Send>, Format)> {
    let mut head = Vec::new();
    let mut buffer = [0; 4096];
    let (format, failure) = loop {
        match source.read(&mut buffer) {
            Ok(0) => break (None, None),
            Ok(count) => head.extend_from_slice(&buffer[..count]),
            Err(error) if error.kind() == io::ErrorKind::Interrupted => continue,
            Err(error) if head.is_empty() => return Err(error),
            // It is told again where the reader comes to it.
            Err(error) => break (None, Some(error)),
        }
        // A pipe that is still being written to must not be waited for longer than need be.
        if let Some(format) = of_content(&head) {
            break (Some(format), None);
        }
        if head.len() >= LOOK {
            break (None, None);
        }
    };
    let format = format.or_else(|| of_last_line(&head)).or(hint).unwrap_or(Format::Candump);
    let head = Cursor::new(head);
    Ok(match failure {
        None => (Box::new(head.chain(source)), format),
        Some(error) => (Box::new(head.chain(Failed(Some(error)))), format),
    })
}

/// Fails once, then is at its end.
struct Failed(Option<io::Error>);

impl Read for Failed {
    fn read(&mut self, _: &mut [u8]) -> io::Result<usize> {
        self.0.take().map_or(Ok(0), Err)
    }
}

/// By magic bytes or by the first complete line that only one format has.
fn of_content(head: &[u8]) -> Option<Format> {
    if head.starts_with(BLF) {
        return Some(Format::Blf);
    }
    if MF4.iter().any(|magic| head.starts_with(magic)) {
        return Some(Format::Mf4);
    }
    // A candump line shows itself before its end.
    let start = head.trim_ascii_start();
    if start.starts_with(b"(") {
        return Some(Format::Candump);
    }
    let end = head.iter().rposition(|byte| *byte == b'\n')?;
    head[..end].split(|byte| *byte == b'\n').find_map(of_line)
}

/// A file without a newline at all.
fn of_last_line(head: &[u8]) -> Option<Format> {
    head.split(|byte| *byte == b'\n').next_back().and_then(of_line)
}

/// What a line shows.
fn of_line(line: &[u8]) -> Option<Format> {
    let line = line.trim_ascii().to_ascii_lowercase();
    let begins = |word: &str| line.starts_with(word.as_bytes());
    if begins("(") || begins("dropcount:") {
        return Some(Format::Candump);
    }
    if begins(";$") {
        return Some(Format::Trc);
    }
    if begins("date ") || begins("base ") || begins("begin trigger") || begins("// version") {
        return Some(Format::Asc);
    }
    if begins("timestamp,arbitration_id,") {
        return Some(Format::Csv);
    }
    // `     1)      1841.3  Rx         0001  8  00 …`
    let digits = line.iter().take_while(|byte| byte.is_ascii_digit()).count();
    let rest = line[digits..].strip_prefix(b")").unwrap_or_default().trim_ascii_start();
    // A candump line that has lost its beginning goes on with a name.
    (digits > 0 && rest.first().is_some_and(u8::is_ascii_digit)).then_some(Format::Trc)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn contents_tell_and_names_only_help() {
        let of = |text: &[u8], hint| {
            let (mut whole, format) = recognize(Box::new(Cursor::new(text.to_vec())), hint).unwrap();
            let mut read = Vec::new();
            whole.read_to_end(&mut read).unwrap();
            assert_eq!(read, text);
            format
        };
        assert_eq!(of(b"\n (1.0) can0 123#", Some(Format::Csv)), Format::Candump);
        assert_eq!(of(b"# comment\n(1.0) can0 123#", None), Format::Candump);
        assert_eq!(of(b"000584) can0 123#00\n(1.0) can0 123#00\n", None), Format::Candump);
        assert_eq!(of(b"LOGG", None), Format::Blf);
        assert_eq!(of(b"UnFinMF 4.10", None), Format::Mf4);
        assert_eq!(of(b"date Thu Oct 09 08:53:20 2025\r\nbase hex", None), Format::Asc);
        assert_eq!(of(b"timestamp,arbitration_id,extended,remote,error,dlc,data\n", None), Format::Csv);
        assert_eq!(of(b";####\n; C:\\x.trc\n;\n     1)      1841 0001 8 00", None), Format::Trc);
        assert_eq!(of(b";$FILEVERSION=2.1\n", Some(Format::Asc)), Format::Trc);
        assert_eq!(of(b"1.5,0x123,0,0,0,0,\n", Some(Format::Csv)), Format::Csv);
        assert_eq!(of(b"", None), Format::Candump);
    }

    #[test]
    fn extensions_are_seen_through_packing() {
        assert_eq!(Format::of_name(Path::new("a/drive.ASC.gz")), Some(Format::Asc));
        assert_eq!(Format::of_name(Path::new("drive.zst")), None);
        assert_eq!(Format::of_name(Path::new("-")), None);
    }
}
