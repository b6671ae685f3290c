//! The data of a group or of a channel as one stream, however many blocks it is cut into.

use std::collections::VecDeque;
use std::io::Read;

use flate2::read::ZlibDecoder;

use super::block::{Blocks, HEADER};
use crate::can::recording::LogError;
use crate::can::recording::bytes::{u32_at, u64_at};

/// Bytes read at a time where blocks are not compressed.
const CHUNK: u64 = 1 << 18;
/// A compressed block holds this at most, unpacked (the standard recommends 4 MiB).
const UNPACKED: u64 = 1 << 26;

/// Bytes of the data blocks behind a link, one after the other.
pub struct Stream {
    /// Data blocks to come.
    blocks: VecDeque<u64>,
    /// The next list of such blocks.
    list: u64,
    /// Lists seen: more than fit into the file run in a circle.
    lists: u64,
    /// What is left of an uncompressed block: from where, how many bytes.
    plain: Option<(u64, u64)>,
    buffer: Vec<u8>,
    used: usize,
    /// How many bytes came before the buffer.
    before: u64,
    /// The file ends within this block.
    cut_off: Option<u64>,
}

impl Stream {
    /// What a data link leads to; nothing behind 0.
    pub fn new(file: &Blocks, link: u64) -> Result<Self, LogError> {
        let mut stream = Self {
            blocks: VecDeque::new(),
            list: 0,
            lists: 0,
            plain: None,
            buffer: Vec::new(),
            used: 0,
            before: 0,
            cut_off: None,
        };
        if link != 0 {
            match &file.head(link)?.id {
                b"HL" => stream.list = file.expect(link, b"HL")?.link(0),
                b"DL" => stream.list = link,
                _ => stream.blocks.push_back(link),
            }
        }
        Ok(stream)
    }

    /// Where in the stream the next byte is.
    pub fn place(&self) -> u64 {
        self.before + self.used as u64
    }

    /// The block within which the file ends.
    pub fn cut_off(&self) -> Option<u64> {
        self.cut_off
    }

    /// The next so many bytes, without going on behind them; `None` if there are fewer.
    pub fn peek(&mut self, file: &Blocks, count: usize) -> Result<Option<&[u8]>, LogError> {
        while self.buffer.len() - self.used < count {
            if !self.refill(file)? {
                return Ok(None);
            }
        }
        Ok(self.buffer.get(self.used..self.used + count))
    }

    /// Goes on behind so many bytes, which [`Stream::peek`] has shown.
    pub fn advance(&mut self, count: usize) {
        self.used = (self.used + count).min(self.buffer.len());
    }

    /// Goes on at a place of the stream; `false` if that is behind us, or beyond the end.
    pub fn go_to(&mut self, file: &Blocks, place: u64) -> Result<bool, LogError> {
        if place < self.place() {
            return Ok(false);
        }
        while self.before + (self.buffer.len() as u64) < place {
            self.used = self.buffer.len();
            if !self.refill(file)? {
                return Ok(false);
            }
        }
        self.used = (place - self.before) as usize;
        Ok(true)
    }

    /// Reads some more; `false` at the end.
    fn refill(&mut self, file: &Blocks) -> Result<bool, LogError> {
        self.before += self.used as u64;
        self.buffer.drain(..self.used);
        self.used = 0;
        loop {
            if let Some((at, left)) = self.plain.take() {
                let mut bytes = Vec::new();
                let count = left.min(CHUNK);
                file.read(at, count as usize, &mut bytes)?;
                self.buffer.extend_from_slice(&bytes);
                let got = bytes.len() as u64;
                if got == count && left > count {
                    self.plain = Some((at + count, left - count));
                }
                if got > 0 {
                    return Ok(true);
                }
            }
            let Some(at) = self.blocks.pop_front() else {
                if self.list == 0 {
                    return Ok(false);
                }
                self.read_list(file)?;
                continue;
            };
            if self.open(file, at)? {
                return Ok(true);
            }
        }
    }

    /// The data blocks of the next list.
    fn read_list(&mut self, file: &Blocks) -> Result<(), LogError> {
        self.lists += 1;
        if self.lists > file.size() / HEADER {
            return Err(file.broken(self.list, "a list of data blocks has no end"));
        }
        let list = file.expect(self.list, b"DL")?;
        let (next, blocks) = list.links.split_first().unwrap_or((&0, &[]));
        self.list = *next;
        self.blocks.extend(blocks.iter().filter(|link| **link != 0));
        Ok(())
    }

    /// Begins a data block; are there bytes already?
    fn open(&mut self, file: &Blocks, at: u64) -> Result<bool, LogError> {
        let head = file.head(at)?;
        let body = at + HEADER;
        match &head.id {
            b"DT" | b"SD" | b"RD" => {
                let rest = file.size().saturating_sub(body);
                let is_last = self.blocks.is_empty() && self.list == 0;
                let length = head.length.saturating_sub(HEADER);
                // An unfinished file's last block goes on to the end, whatever its length says.
                let length = if file.unfinished && is_last && length == 0 { rest } else { length };
                if length > rest {
                    self.cut_off = Some(at);
                }
                self.plain = Some((body, length.min(rest))).filter(|(_, length)| *length > 0);
                Ok(false)
            }
            b"DZ" => {
                let mut packed = Vec::new();
                let count = head.length.saturating_sub(HEADER).min(file.size().saturating_sub(body));
                if count < head.length.saturating_sub(HEADER) {
                    self.cut_off = Some(at);
                }
                if count > UNPACKED {
                    return Err(file.broken(at, "a compressed block has an impossible length"));
                }
                file.read(body, count as usize, &mut packed)?;
                self.unpack(file, at, &packed)?;
                Ok(!self.buffer.is_empty())
            }
            [a, b] => {
                let what = format!(
                    "data blocks of kind {}{} are not read (gripd reads DT, SD, DZ, DL and HL)",
                    char::from(*a),
                    char::from(*b)
                );
                Err(file.broken(at, &what))
            }
        }
    }

    /// `what it was (2) how packed (1) – (1) parameter (4) size (8) packed size (8) data`.
    fn unpack(&mut self, file: &Blocks, at: u64, block: &[u8]) -> Result<(), LogError> {
        const DEFLATE: u8 = 0;
        const TRANSPOSED: u8 = 1;
        let (Some(&how), Some(columns), Some(size), Some(data)) =
            (block.get(2), u32_at(block, 4), u64_at(block, 8), block.get(24..))
        else {
            return Err(LogError::CutOff { name: file.name().into(), what: "a compressed block", byte: at });
        };
        if how != DEFLATE && how != TRANSPOSED {
            return Err(file.broken(at, "data are compressed in a way that is not read (zlib is)"));
        }
        if size > UNPACKED {
            return Err(file.broken(at, "a compressed block has an impossible size"));
        }
        let mut bytes = Vec::new();
        let unpacked = ZlibDecoder::new(data).take(size).read_to_end(&mut bytes);
        if bytes.len() as u64 != size {
            // Half of what is transposed is nothing.
            if how == TRANSPOSED {
                bytes.clear();
            }
            if self.cut_off.is_none() {
                let why = unpacked.err().map_or_else(|| "they end too early".into(), |e| e.to_string());
                return Err(file.broken(at, &format!("compressed data are corrupt ({why})")));
            }
        }
        if how == TRANSPOSED {
            transpose_back(&bytes, columns as usize, &mut self.buffer);
        } else {
            self.buffer.append(&mut bytes);
        }
        Ok(())
    }
}

/// Columns one after the other become rows of `columns` bytes again; what fills no row was left as it is.
fn transpose_back(bytes: &[u8], columns: usize, rows: &mut Vec<u8>) {
    let count = bytes.len().checked_div(columns).unwrap_or(0);
    let start = rows.len();
    rows.resize(start + count * columns, 0);
    let out = &mut rows[start..];
    for (column, values) in bytes.chunks_exact(count.max(1)).take(columns).enumerate() {
        for (row, value) in values.iter().enumerate().take(count) {
            out[row * columns + column] = *value;
        }
    }
    rows.extend_from_slice(bytes.get(count * columns..).unwrap_or_default());
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn transposed_rows_come_back() {
        let mut rows = vec![9];
        transpose_back(&[1, 4, 2, 5, 3, 6, 7], 3, &mut rows);
        assert_eq!(rows, [9, 1, 2, 3, 4, 5, 6, 7]);
        for (bytes, columns) in [(&[][..], 3), (&[1, 2], 0), (&[1, 2], 5)] {
            let mut rows = Vec::new();
            transpose_back(bytes, columns, &mut rows);
            assert_eq!(rows, bytes);
        }
    }
}
