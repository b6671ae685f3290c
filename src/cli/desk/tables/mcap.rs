//! Rows as messages of an MCAP file, for viewers as Foxglove, PlotJuggler and Rerun: one topic, its schema in the file (Protocol
//! Buffers), the messages in compressed chunks with an index. What is not available is not a number.
//!
//! Learned from mcap.dev/spec. Written by hand: the library for it brings 14 others, and makes zstd's larger.

use std::io::{self, Write};

use flate2::Crc;

use super::Table;
use super::protobuf::{self, Message};
use super::rows::{Column, Rows};
use physics::Micros;

const MAGIC: &[u8] = b"\x89MCAP0\r\n";

// Kinds of records.
const HEADER: u8 = 0x01;
const FOOTER: u8 = 0x02;
const SCHEMA: u8 = 0x03;
const CHANNEL: u8 = 0x04;
const MESSAGE: u8 = 0x05;
const CHUNK: u8 = 0x06;
const MESSAGE_INDEX: u8 = 0x07;
const CHUNK_INDEX: u8 = 0x08;
const STATISTICS: u8 = 0x0B;
const DATA_END: u8 = 0x0F;

/// Of the only schema, and of the only topic.
const ID: [u8; 2] = 1_u16.to_le_bytes();

/// Bytes of messages that are kept until they are written: some 20 s of estimates.
const CHUNK_SIZE: usize = 1 << 20;

/// Writes a chunk of messages at a time.
pub struct Mcap<W> {
    output: W,
    /// Bytes that the output has.
    written: u64,
    /// Schema and topic, as records.
    topic: Vec<u8>,
    /// Messages that are kept until they are written,
    kept: Vec<u8>,
    /// and of each its time, ns, and where it begins.
    places: Vec<(u64, u64)>,
    /// Where the chunks are, as records.
    chunk_index: Vec<u8>,
    chunks: u32,
    messages: u64,
    /// The first and the last time, ns.
    span: (u64, u64),
    columns: u64,
    /// Of the row that is being made, ns.
    time: u64,
    row: Message,
    /// The field of the value written last.
    field: u64,
}

impl<W: Write> Mcap<W> {
    /// Begins the file; `title` is the name of the table.
    pub fn new(output: W, title: &str, columns: &[Column]) -> io::Result<Self> {
        let encoding = sized("protobuf");
        let described = sized(protobuf::description(title, columns));
        let schema = [&ID[..], &sized(format!("gripd.{title}")), &encoding, &described].concat();
        let with_units = columns.iter().filter(|column| !column.unit.is_empty());
        let unit = |column: &Column| [sized(format!("unit {}", column.name)), sized(&*column.unit)].concat();
        let units: Vec<u8> = with_units.flat_map(unit).collect();
        let topic = sized(format!("/gripd/{title}"));
        let channel = [&ID[..], &ID, &topic, &encoding, &sized(units)].concat();
        let mut file = Self {
            output,
            written: 0,
            topic: [record(SCHEMA, &schema), record(CHANNEL, &channel)].concat(),
            kept: Vec::new(),
            places: Vec::new(),
            chunk_index: Vec::new(),
            chunks: 0,
            messages: 0,
            span: (0, 0),
            columns: columns.len() as u64,
            time: 0,
            row: Message::default(),
            field: 0,
        };
        let library = format!("gripd {}", env!("CARGO_PKG_VERSION"));
        let header = record(HEADER, &[sized(""), sized(library)].concat());
        file.write(&[MAGIC, &header, &file.topic].concat())?;
        Ok(file)
    }

    fn write(&mut self, bytes: &[u8]) -> io::Result<()> {
        self.written += bytes.len() as u64;
        self.output.write_all(bytes)
    }

    /// Writes the messages that are kept.
    fn write_chunk(&mut self) -> io::Result<()> {
        let times = || self.places.iter().map(|(time, _)| *time);
        let (Some(first), Some(last)) = (times().min(), times().max()) else { return Ok(()) };
        let span = [first.to_le_bytes(), last.to_le_bytes()].concat();
        let packed = zstd::bulk::compress(&self.kept, zstd::DEFAULT_COMPRESSION_LEVEL)?;
        let compression = sized("zstd");
        let (packed_size, size) = (length(&packed), length(&self.kept));
        let checksum = checksum(&self.kept);
        let chunk = [&span, &size[..], &checksum, &compression, &packed_size, &packed].concat();
        let chunk = record(CHUNK, &chunk);
        let places = self.places.iter().flat_map(|(time, place)| [time.to_le_bytes(), place.to_le_bytes()]);
        let places: Vec<u8> = places.flatten().collect();
        let index = record(MESSAGE_INDEX, &[&ID[..], &sized(places)].concat());

        let index_at = self.written + chunk.len() as u64;
        let entry = [
            &span,
            &self.written.to_le_bytes()[..],
            &length(&chunk),
            &sized([&ID[..], &index_at.to_le_bytes()].concat()),
            &length(&index),
            &compression,
            &packed_size,
            &size,
        ];
        self.chunk_index.extend(record(CHUNK_INDEX, &entry.concat()));
        self.write(&chunk)?;
        self.write(&index)?;
        self.span =
            if self.chunks == 0 { (first, last) } else { (self.span.0.min(first), self.span.1.max(last)) };
        self.chunks += 1;
        self.kept.clear();
        self.places.clear();
        Ok(())
    }

    fn next(&mut self) -> u64 {
        self.field += 1;
        self.field
    }
}

impl<W: Write> Rows for Mcap<W> {
    fn time(&mut self, time: Micros) {
        // Before 1970 there is none in this format.
        self.time = u64::try_from(time.0).unwrap_or(0).saturating_mul(1000);
        self.row.clear();
        self.field = 0;
        self.number(Some(time.seconds()));
    }

    fn number(&mut self, value: Option<f64>) {
        let field = self.next();
        self.row.double(field, value.unwrap_or(f64::NAN));
    }

    fn count(&mut self, value: u32) {
        let field = self.next();
        self.row.unsigned(field, value.into());
    }

    fn flag(&mut self, value: bool) {
        let field = self.next();
        self.row.unsigned(field, value.into());
    }

    fn word(&mut self, word: &'static str) {
        let field = self.next();
        self.row.bytes_of(field, word.as_bytes());
    }

    fn end(&mut self) -> io::Result<()> {
        if self.field != self.columns {
            return Err(io::Error::other("a row does not have the values of its columns"));
        }
        let time = self.time.to_le_bytes();
        // Begins anew after four thousand million rows.
        let sequence = (self.messages as u32).to_le_bytes();
        self.messages += 1;
        self.places.push((self.time, self.kept.len() as u64));
        self.kept.extend(record(MESSAGE, &[&ID[..], &sequence, &time, &time, self.row.bytes()].concat()));
        if self.kept.len() >= CHUNK_SIZE { self.write_chunk() } else { Ok(()) }
    }
}

impl<W: Write> Table<W> for Mcap<W> {
    fn into_inner(mut self: Box<Self>) -> io::Result<W> {
        self.write_chunk()?;
        self.write(&record(DATA_END, &[0; 4]))?;
        let summary_at = self.written.to_le_bytes();
        let messages = self.messages.to_le_bytes();
        let statistics = [
            &messages[..],
            &1_u16.to_le_bytes(), // schemas
            &1_u32.to_le_bytes(), // topics
            &[0; 4],              // attachments
            &[0; 4],              // metadata
            &self.chunks.to_le_bytes(),
            &self.span.0.to_le_bytes(),
            &self.span.1.to_le_bytes(),
            &sized([&ID[..], &messages].concat()),
        ];
        let statistics = record(STATISTICS, &statistics.concat());
        // The summary's checksum stands in the footer, and is of the fields before it there, too.
        let before_checksum = [&summary_at[..], &[0; 8], &[0; 4]].concat();
        let footer = record(FOOTER, &before_checksum);
        let mut summary = [&self.topic[..], &statistics, &self.chunk_index, &footer].concat();
        summary.truncate(summary.len() - 4);
        summary.extend(checksum(&summary));
        summary.extend(MAGIC);
        self.write(&summary)?;
        self.output.flush()?;
        Ok(self.output)
    }
}

/// A record of a kind.
fn record(kind: u8, content: &[u8]) -> Vec<u8> {
    [&[kind][..], &length(content), content].concat()
}

/// Text, bytes, lists and maps: their length stands before them. None of them is longer than a chunk.
fn sized(bytes: impl AsRef<[u8]>) -> Vec<u8> {
    let bytes = bytes.as_ref();
    [&(bytes.len() as u32).to_le_bytes(), bytes].concat()
}

fn length(bytes: &[u8]) -> [u8; 8] {
    (bytes.len() as u64).to_le_bytes()
}

/// CRC-32.
fn checksum(bytes: &[u8]) -> [u8; 4] {
    let mut checksum = Crc::new();
    checksum.update(bytes);
    checksum.sum().to_le_bytes()
}
