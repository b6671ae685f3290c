//! Rows as columns of Arrow, batch by batch, with the same names, kinds and nulls as in the commands' Parquet files.

use std::collections::HashMap;
use std::io;
use std::sync::Arc;

use arrow_array::builder::{BooleanBuilder, Float64Builder, Int64Builder, StringBuilder};
use arrow_array::{ArrayRef, RecordBatch};
use arrow_schema::{ArrowError, DataType, Field, Schema, SchemaRef};
use gripd::cli::library::rows::{Column, Kind, Rows};
use physics::Micros;

/// Takes rows.
pub struct Columns {
    schema: SchemaRef,
    columns: Vec<Values>,
    /// The column of the next value.
    next: usize,
    rows: usize,
}

enum Values {
    Real(Float64Builder),
    Count(Int64Builder),
    Flag(BooleanBuilder),
    Word(StringBuilder),
}

impl Columns {
    /// None of a table yet. Each field's metadata say its `unit`.
    pub fn new(title: &str, columns: &[Column]) -> Self {
        let fields: Vec<Field> = columns.iter().enumerate().map(field).collect();
        let about = [("gripd.version", env!("CARGO_PKG_VERSION")), ("gripd.table", title)];
        let about = about.map(|(key, value)| (key.to_owned(), value.to_owned()));
        let values = columns.iter().map(|column| match column.kind {
            Kind::Real => Values::Real(Float64Builder::new()),
            Kind::Count => Values::Count(Int64Builder::new()),
            Kind::Flag => Values::Flag(BooleanBuilder::new()),
            Kind::Word => Values::Word(StringBuilder::new()),
        });
        Self {
            schema: Arc::new(Schema::new_with_metadata(fields, HashMap::from(about))),
            columns: values.collect(),
            next: 0,
            rows: 0,
        }
    }

    /// Its columns.
    pub fn schema(&self) -> SchemaRef {
        self.schema.clone()
    }

    /// Rows that wait to be taken.
    pub fn rows(&self) -> usize {
        self.rows
    }

    /// A row of numbers alone.
    ///
    /// # Errors
    /// If they are not as many as the columns.
    pub fn numbers(&mut self, values: impl IntoIterator<Item = Option<f64>>) -> io::Result<()> {
        self.next = 0;
        values.into_iter().for_each(|value| self.number(value));
        self.end()
    }

    /// The rows that wait, without copying them.
    ///
    /// # Errors
    /// If columns and schema differ.
    pub fn take(&mut self) -> Result<RecordBatch, ArrowError> {
        self.rows = 0;
        let arrays = self.columns.iter_mut().map(|column| -> ArrayRef {
            match column {
                Values::Real(values) => Arc::new(values.finish()),
                Values::Count(values) => Arc::new(values.finish()),
                Values::Flag(values) => Arc::new(values.finish()),
                Values::Word(values) => Arc::new(values.finish()),
            }
        });
        RecordBatch::try_new(self.schema.clone(), arrays.collect())
    }

    fn column(&mut self) -> Option<&mut Values> {
        self.next += 1;
        self.columns.get_mut(self.next - 1)
    }
}

impl Rows for Columns {
    fn time(&mut self, time: Micros) {
        self.next = 0;
        self.number(Some(time.seconds()));
    }

    fn number(&mut self, value: Option<f64>) {
        if let Some(Values::Real(values)) = self.column() {
            values.append_option(value);
        }
    }

    fn count(&mut self, value: u32) {
        if let Some(Values::Count(values)) = self.column() {
            values.append_value(value.into());
        }
    }

    fn flag(&mut self, value: bool) {
        if let Some(Values::Flag(values)) = self.column() {
            values.append_value(value);
        }
    }

    fn word(&mut self, word: &'static str) {
        if let Some(Values::Word(values)) = self.column() {
            values.append_value(word);
        }
    }

    fn end(&mut self) -> io::Result<()> {
        self.rows += 1;
        if self.next == self.columns.len() {
            Ok(())
        } else {
            Err(io::Error::other("a row does not have the values of its columns"))
        }
    }
}

fn field((place, column): (usize, &Column)) -> Field {
    let (kind, nullable) = match column.kind {
        // The first is the time: a row without one is none.
        Kind::Real => (DataType::Float64, place > 0),
        Kind::Count => (DataType::Int64, false),
        Kind::Flag => (DataType::Boolean, false),
        Kind::Word => (DataType::Utf8, false),
    };
    let unit = ("unit".to_owned(), column.unit.clone().into_owned());
    Field::new(&column.name, kind, nullable).with_metadata(HashMap::from([unit]))
}
