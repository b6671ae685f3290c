//! Recognizes what a file holds by its first bytes, and unpacks it while it is read.

use std::fmt;
use std::io::{self, BufReader, Cursor, Read};

use flate2::bufread::MultiGzDecoder;

/// How a recording is packed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Compression {
    /// Plain text.
    #[default]
    None,
    /// gzip, of any number of members.
    Gzip,
    /// Zstandard, of any number of frames.
    Zstd,
}

impl fmt::Display for Compression {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Compression::None => "text",
            Compression::Gzip => "gzip",
            Compression::Zstd => "zstd",
        })
    }
}

/// What the first bytes of a file tell.
#[derive(Debug, PartialEq, Eq)]
pub(in crate::can) enum Content {
    /// Text, perhaps packed.
    Log(Compression),
    /// A Vector BLF file.
    Blf,
    /// An ASAM MDF file.
    Mf4,
    /// Something else that people hand to a log reader.
    Other(&'static str),
}

/// First bytes by which other formats are known.
const OTHERS: [(&[u8], &str); 6] = [
    (b"\x0A\x0D\x0D\x0A", "a pcapng capture"),
    (b"\xD4\xC3\xB2\xA1", "a pcap capture"),
    (b"\xFD7zXZ", "xz-compressed data"),
    (b"BZh", "bzip2-compressed data"),
    (b"PK\x03\x04", "a zip archive"),
    (b"\xFF\xFE", "UTF-16 text"),
];

/// Begins a Vector BLF file.
pub(super) const BLF: &[u8] = b"LOGG";
/// Begins an ASAM MDF file, finished or not.
pub(super) const MF4: [&[u8]; 2] = [b"MDF ", b"UnFin"];

/// What some editors put in front of a text; not part of its first line.
const BYTE_ORDER_MARK: &[u8] = b"\xEF\xBB\xBF";

/// The longest magic number there is.
const MAGIC: usize = 6;

/// Looks at the first bytes.
fn recognize(head: &[u8]) -> Content {
    if let Some((_, format)) = OTHERS.iter().find(|(magic, _)| head.starts_with(magic)) {
        return Content::Other(format);
    }
    if head.starts_with(BLF) {
        return Content::Blf;
    }
    if MF4.iter().any(|magic| head.starts_with(magic)) {
        return Content::Mf4;
    }
    Content::Log(match head {
        [0x1F, 0x8B, ..] => Compression::Gzip,
        // The second form is a skippable frame, as pzstd and seekable files begin with.
        [0x28, 0xB5, 0x2F, 0xFD, ..] | [0x50..=0x5F, 0x2A, 0x4D, 0x18, ..] => Compression::Zstd,
        _ => Compression::None,
    })
}

/// Peeks at the first bytes and puts the fitting decompressor in front.
///
/// # Errors
/// If not even the first bytes can be read.
pub(in crate::can) fn unpack(
    mut source: Box<dyn Read + Send>,
) -> io::Result<(Box<dyn Read + Send>, Content)> {
    let mut head = Vec::with_capacity(MAGIC);
    source.by_ref().take(MAGIC as u64).read_to_end(&mut head)?;
    let content = recognize(&head);
    if head.starts_with(BYTE_ORDER_MARK) {
        head.drain(..BYTE_ORDER_MARK.len());
    }
    let whole = Cursor::new(head).chain(source);
    Ok((
        match content {
            Content::Log(Compression::Gzip) => {
                Box::new(MultiGzDecoder::new(BufReader::with_capacity(1 << 16, whole)))
            }
            Content::Log(Compression::Zstd) => Box::new(zstd::Decoder::new(whole)?),
            _ => Box::new(whole),
        },
        content,
    ))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn formats_are_known_by_their_first_bytes() {
        assert_eq!(recognize(b"\x1F\x8B\x08"), Content::Log(Compression::Gzip));
        assert_eq!(recognize(b"\x28\xB5\x2F\xFD\x00"), Content::Log(Compression::Zstd));
        assert_eq!(recognize(b"(1.0) "), Content::Log(Compression::None));
        assert_eq!(recognize(b""), Content::Log(Compression::None));
        assert_eq!(recognize(b"LOGG\x90"), Content::Blf);
    }
}
