//! Rows as messages of an MCAP file, for viewers as Foxglove, PlotJuggler and Rerun: a topic for each table, its schema in
//! the file (Protocol Buffers). What is not available is not a number.

use std::collections::BTreeMap;
use std::io::{self, Seek, Write};

use mcap::records::MessageHeader;
use mcap::{Compression, McapError, WriteOptions, Writer};

use super::Table;
use super::protobuf::{self, Message};
use super::rows::{Column, Rows};
use physics::Micros;

/// A file of topics, each with messages of its own columns.
pub struct Topics<W: Write + Seek> {
    writer: Writer<W>,
    /// Messages so far.
    count: u32,
}

impl<W: Write + Seek> Topics<W> {
    /// Begins it.
    pub fn new(output: W) -> io::Result<Self> {
        let options = WriteOptions::new()
            .library(format!("gripd {}", env!("CARGO_PKG_VERSION")))
            .compression(Some(Compression::Zstd))
            // In this thread, as everything else.
            .compression_threads(0);
        Ok(Self { writer: options.create(output).map_err(failed)?, count: 0 })
    }

    /// The topic `/gripd/NAME`: what messages with these columns are written by.
    pub fn add(&mut self, name: &str, columns: &[Column]) -> io::Result<u16> {
        let described = protobuf::description(name, columns);
        let schema = self.writer.add_schema(&format!("gripd.{name}"), "protobuf", &described);
        let units = columns.iter().filter(|column| !column.unit.is_empty());
        let units: BTreeMap<String, String> =
            units.map(|column| (format!("unit {}", column.name), column.unit.clone().into_owned())).collect();
        schema
            .and_then(|schema| {
                self.writer.add_channel(schema, &format!("/gripd/{name}"), "protobuf", &units)
            })
            .map_err(failed)
    }

    /// A message of a topic.
    pub fn write(&mut self, topic: u16, time: Micros, message: &Message) -> io::Result<()> {
        // Before 1970 there is none in this format.
        let time = u64::try_from(time.0).unwrap_or(0) * 1000;
        let header =
            MessageHeader { channel_id: topic, sequence: self.count, log_time: time, publish_time: time };
        self.count = self.count.wrapping_add(1);
        self.writer.write_to_known_channel(&header, message.bytes()).map_err(failed)
    }

    /// The output, with the file's index in it.
    pub fn finish(mut self) -> io::Result<W> {
        self.writer.finish().map_err(failed)?;
        Ok(self.writer.into_inner())
    }
}

/// Rows of one table.
pub struct Mcap<W: Write + Seek> {
    topics: Topics<W>,
    topic: u16,
    columns: u64,
    time: Micros,
    row: Message,
    /// The field of the value written last.
    field: u64,
}

impl<W: Write + Seek> Mcap<W> {
    /// Begins the file; `title` is the name of the table. The first column is the time.
    pub fn new(output: W, title: &str, columns: &[Column]) -> io::Result<Self> {
        let mut topics = Topics::new(output)?;
        let topic = topics.add(title, columns)?;
        let columns = columns.len() as u64;
        Ok(Self { topics, topic, columns, time: Micros(0), row: Message::default(), field: 0 })
    }

    fn next(&mut self) -> u64 {
        self.field += 1;
        self.field
    }
}

impl<W: Write + Seek> Rows for Mcap<W> {
    fn time(&mut self, time: Micros) {
        self.row.clear();
        (self.time, self.field) = (time, 0);
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
        self.topics.write(self.topic, self.time, &self.row)
    }
}

impl<W: Write + Seek> Table<W> for Mcap<W> {
    fn into_inner(self: Box<Self>) -> io::Result<W> {
        self.topics.finish()
    }
}

/// What the library says; a failed output's own words where it is that.
fn failed(error: McapError) -> io::Error {
    match error {
        McapError::Io(error) => error,
        error => io::Error::other(error.to_string()),
    }
}
