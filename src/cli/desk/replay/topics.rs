//! What is published as topics of an MCAP file, for viewers: the frames decoded, a topic for each message.

use std::collections::HashMap;
use std::io;
use std::path::Path;

use crate::cli::Failure;
use crate::cli::desk::output::Output;
use crate::cli::desk::tables::mcap::Topics;
use crate::cli::desk::tables::protobuf::Message;
use crate::cli::desk::tables::rows::{Column, Kind};
use bus::can::{CanId, Frame};
use bus::dbc::{Database, Signal};

/// Signals that have more names than "yes" and "no" are words.
const WORDS: usize = 3;

/// Frames that become messages.
pub struct Published {
    database: Database,
    topics: Topics<Output>,
    /// Of each message of the database.
    known: HashMap<CanId, u16>,
    row: Message,
}

impl Published {
    /// Begins the file with the topics of all messages.
    pub fn create(path: &Path, database: Database) -> Result<Self, Failure> {
        let mut topics = Topics::new(Output::create(path)?)?;
        let mut known = HashMap::new();
        for message in database.messages() {
            let signals = message.signals.iter();
            let signals = signals.map(|it| Column::new(&it.name, it.unit.clone(), kind(it)));
            let columns: Vec<_> = [Column::new("t", "s", Kind::Real)].into_iter().chain(signals).collect();
            known.insert(message.id, topics.add(&message.name, &columns)?);
        }
        Ok(Self { database, topics, known, row: Message::default() })
    }

    /// A frame. What its signals call `not_available` is not a number.
    pub fn write(&mut self, frame: &Frame) -> io::Result<()> {
        let (Some(message), Some(topic)) =
            (self.database.message_with_id(frame.id), self.known.get(&frame.id))
        else {
            return Ok(());
        };
        self.row.clear();
        self.row.double(1, frame.time.seconds());
        for (field, signal) in (2..).zip(&message.signals) {
            let bits = signal.bits(frame.data());
            let name = bits.and_then(|bits| signal.value_name(bits));
            match kind(signal) {
                Kind::Word => self.row.bytes_of(field, name.unwrap_or_default().as_bytes()),
                _ => {
                    let number = bits.filter(|_| name != Some("not_available"));
                    self.row.double(field, number.map_or(f64::NAN, |bits| signal.physical(bits)));
                }
            }
        }
        self.topics.write(*topic, frame.time, &self.row)
    }

    /// The file gets its name.
    pub fn finish(self) -> Result<(), Failure> {
        self.topics.finish()?.finish()
    }
}

fn kind(signal: &Signal) -> Kind {
    if signal.values.len() >= WORDS { Kind::Word } else { Kind::Real }
}
