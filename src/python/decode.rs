//! `decode`: what the signals of a DBC say in recordings, a table for each message.

use std::collections::HashMap;
use std::path::PathBuf;

use arrow_array::RecordBatch;
use bus::can::{CanId, Frame};
use bus::dbc::{Database, Message};
use gripd::cli::Failure;
use gripd::cli::library::rows::{Column, Kind, Rows};
use gripd::cli::library::{Part, PartReader};
use pyo3::prelude::*;

use crate::columns::Columns;
use crate::failure::{exception, words};
use crate::stream::Batches;

/// Rows of a batch.
const ROWS: usize = 1 << 15;
/// Frames between two looks whether somebody has pressed Ctrl-C: some milliseconds.
const FRAMES: usize = 1 << 14;

/// Messages by their names, and why a recording could not be read to its end.
type Decoded = (Vec<(String, Batches)>, Option<String>);

/// Tables of all messages that are in the recordings, or of those that are asked for.
#[pyfunction]
#[pyo3(signature = (databases, recordings, messages, start, end))]
pub fn decode(
    py: Python<'_>,
    databases: Vec<PathBuf>,
    recordings: Vec<PathBuf>,
    messages: Option<Vec<String>>,
    start: Option<&str>,
    end: Option<&str>,
) -> PyResult<Decoded> {
    let database = Database::load_all(&databases).map_err(|error| exception(Failure::usage(error)))?;
    let mut decoder = Decoder::new(&database, messages.as_deref()).map_err(exception)?;
    let part = Part::new(start, end);
    let mut broken = Vec::new();
    for path in &recordings {
        let mut reader = py.detach(|| part.open(path)).map_err(exception)?;
        loop {
            let goes_on = py.detach(|| decoder.advance(&mut reader, &mut broken));
            py.check_signals()?;
            if !goes_on.map_err(exception)? {
                break;
            }
        }
    }
    let tables = py.detach(|| decoder.tables()).map_err(exception)?;
    Ok((tables, (!broken.is_empty()).then(|| broken.join("; "))))
}

/// Decodes frames into the tables of their messages.
struct Decoder<'d> {
    messages: HashMap<CanId, One<'d>>,
}

/// A message, and its frames so far.
struct One<'d> {
    message: &'d Message,
    columns: Columns,
    kept: Vec<RecordBatch>,
}

impl<'d> Decoder<'d> {
    fn new(database: &'d Database, wanted: Option<&[String]>) -> Result<Self, Failure> {
        let unknown = wanted.and_then(|names| names.iter().find(|name| database.message(name).is_none()));
        if let Some(name) = unknown {
            return Err(Failure::usage(format_args!("there is no message {name} in the DBC")));
        }
        let is_wanted = |message: &&Message| wanted.is_none_or(|names| names.contains(&message.name));
        let messages = database.messages().iter().filter(is_wanted);
        Ok(Self { messages: messages.map(|message| (message.id, One::new(message))).collect() })
    }

    /// Some thousand frames further; false at the end of the recording.
    fn advance(&mut self, reader: &mut PartReader, broken: &mut Vec<String>) -> Result<bool, Failure> {
        for _ in 0..FRAMES {
            match reader.next_frame() {
                Ok(Some(frame)) => {
                    if frame.is_data()
                        && let Some(one) = self.messages.get_mut(&frame.id)
                    {
                        one.push(&frame)?;
                    }
                }
                Ok(None) => return Ok(false),
                // What could be read before the damage is still worth its tables.
                Err(error) => {
                    broken.push(words(error.into()));
                    return Ok(false);
                }
            }
        }
        Ok(true)
    }

    /// Of all messages that were there, in the order of their names.
    fn tables(self) -> Result<Vec<(String, Batches)>, Failure> {
        let mut tables = Vec::new();
        for mut one in self.messages.into_values() {
            if one.columns.rows() > 0 {
                one.keep()?;
            }
            if !one.kept.is_empty() {
                tables.push((one.message.name.clone(), Batches::kept(one.columns.schema(), one.kept)));
            }
        }
        tables.sort_by(|(one, _), (other, _)| one.cmp(other));
        Ok(tables)
    }
}

impl<'d> One<'d> {
    fn new(message: &'d Message) -> Self {
        let real = |name: &str, unit: &str| Column::new(name, unit.to_owned(), Kind::Real);
        let signals = message.signals.iter().map(|signal| real(&signal.name, &signal.unit));
        let columns: Vec<_> = [real("t", "s")].into_iter().chain(signals).collect();
        Self { message, columns: Columns::new(&message.name, &columns), kept: Vec::new() }
    }

    fn push(&mut self, frame: &Frame) -> Result<(), Failure> {
        let data = frame.data();
        self.columns.time(frame.time);
        for signal in &self.message.signals {
            let value = if signal.is_active(data) { signal.decode(data) } else { None };
            self.columns.number(value);
        }
        self.columns.end().map_err(Failure::work)?;
        if self.columns.rows() == ROWS { self.keep() } else { Ok(()) }
    }

    fn keep(&mut self) -> Result<(), Failure> {
        self.kept.push(self.columns.take().map_err(Failure::work)?);
        Ok(())
    }
}
