//! Blocks, of which an MDF 4 file is made.
//!
//! ```text
//! 0  "##CG"  – (4)  length (8)  count of links (8)  links (8 each)  data
//! ```

use std::fs::File;
use std::io;
use std::os::unix::fs::FileExt;

use crate::can::recording::bytes::{u16_at, u32_at, u64_at};
use crate::can::recording::{Compression, LogError};

/// Bytes before the links.
pub const HEADER: u64 = 24;
/// No block that describes is larger.
const LARGEST: u64 = 1 << 20;
/// What can be done about a broken file.
pub const TO_DO: &str = "take another copy of the recording, or let its recorder's tools repair it";

/// The file, read here and there.
pub struct Blocks {
    name: String,
    file: File,
    size: u64,
    /// Its recorder did not come to finish it: what lengths and counts say is not final.
    pub unfinished: bool,
}

/// A block that describes.
#[derive(Debug)]
pub struct Block {
    /// Where it is.
    pub at: u64,
    /// Which it is: `CG`, …
    pub id: [u8; 2],
    /// Where others are; 0: nowhere.
    pub links: Vec<u64>,
    /// What it says.
    pub data: Vec<u8>,
}

impl Block {
    /// A link; 0 if there is none.
    pub fn link(&self, place: usize) -> u64 {
        self.links.get(place).copied().unwrap_or(0)
    }

    /// A byte of its data; 0 if it is too short, as older versions are.
    pub fn u8(&self, place: usize) -> u8 {
        self.data.get(place).copied().unwrap_or(0)
    }

    /// Two bytes, likewise.
    pub fn u16(&self, place: usize) -> u16 {
        u16_at(&self.data, place).unwrap_or(0)
    }

    /// Four bytes, likewise.
    pub fn u32(&self, place: usize) -> u32 {
        u32_at(&self.data, place).unwrap_or(0)
    }

    /// Eight bytes, likewise.
    pub fn u64(&self, place: usize) -> u64 {
        u64_at(&self.data, place).unwrap_or(0)
    }
}

/// A block's header.
#[derive(Clone, Copy, Debug)]
pub struct Head {
    /// Which it is.
    pub id: [u8; 2],
    /// Bytes, the header among them.
    pub length: u64,
    /// Links.
    pub links: u64,
}

impl Blocks {
    /// Of a file, whose first bytes said that it is one.
    pub fn new(file: File, name: String) -> Result<Self, LogError> {
        let size = match file.metadata() {
            Ok(about) => about.len(),
            Err(source) => return Err(LogError::Open { name, source }),
        };
        Ok(Self { name, file, size, unfinished: false })
    }

    /// The file's name.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Bytes in the file.
    pub fn size(&self) -> u64 {
        self.size
    }

    /// Up to so many bytes from a place on, in place of those of `bytes`; fewer at the end of the file.
    pub fn read(&self, at: u64, count: usize, bytes: &mut Vec<u8>) -> Result<(), LogError> {
        let there = usize::try_from(self.size.saturating_sub(at)).unwrap_or(usize::MAX);
        bytes.clear();
        bytes.resize(count.min(there), 0);
        let mut filled = 0;
        while let Some(rest) = bytes.get_mut(filled..).filter(|rest| !rest.is_empty()) {
            match self.file.read_at(rest, at + filled as u64) {
                Ok(0) => break,
                Ok(count) => filled += count,
                Err(error) if error.kind() == io::ErrorKind::Interrupted => {}
                Err(error) => return Err(LogError::of_read(&self.name, Compression::None, 0, error)),
            }
        }
        bytes.truncate(filled);
        Ok(())
    }

    /// The header of the block at a place.
    pub fn head(&self, at: u64) -> Result<Head, LogError> {
        let mut bytes = Vec::new();
        self.read(at, HEADER as usize, &mut bytes)?;
        let ([b'#', b'#', a, b, ..], Some(length), Some(links)) =
            (bytes.as_slice(), u64_at(&bytes, 8), u64_at(&bytes, 16))
        else {
            return Err(self.broken(at, "there is no block"));
        };
        Ok(Head { id: [*a, *b], length, links })
    }

    /// The block at a place.
    pub fn block(&self, at: u64) -> Result<Block, LogError> {
        let head = self.head(at)?;
        let links = head.links.saturating_mul(8);
        if !(HEADER.saturating_add(links)..=LARGEST).contains(&head.length) {
            return Err(self.broken(at, "a block has an impossible length"));
        }
        let mut bytes = Vec::new();
        let count = (head.length - HEADER) as usize;
        self.read(at + HEADER, count, &mut bytes)?;
        if bytes.len() < count {
            return Err(LogError::CutOff { name: self.name.clone(), what: "a block", byte: at });
        }
        let data = bytes.split_off(links as usize);
        let links = bytes.chunks_exact(8).filter_map(|link| u64_at(link, 0)).collect();
        Ok(Block { at, id: head.id, links, data })
    }

    /// The block at a place, which must be of that kind.
    pub fn expect(&self, at: u64, id: &[u8; 2]) -> Result<Block, LogError> {
        let block = self.block(at)?;
        if block.id != *id {
            let [a, b] = id.map(char::from);
            return Err(self.broken(at, &format!("there is no {a}{b} block")));
        }
        Ok(block)
    }

    /// A text block's text; empty if there is none.
    pub fn text(&self, at: u64) -> Result<String, LogError> {
        if at == 0 {
            return Ok(String::new());
        }
        let block = self.block(at)?;
        let end = block.data.iter().position(|byte| *byte == 0).unwrap_or(block.data.len());
        Ok(String::from_utf8_lossy(&block.data[..end]).into_owned())
    }

    /// Something is wrong.
    pub fn broken(&self, byte: u64, what: &str) -> LogError {
        LogError::Broken { name: self.name.clone(), what: what.into(), byte, to_do: TO_DO }
    }
}
