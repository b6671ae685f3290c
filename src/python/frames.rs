//! Frames as columns of Arrow: those that a replay publishes.

use std::sync::Arc;

use arrow_array::RecordBatch;
use arrow_array::builder::{BinaryBuilder, BooleanBuilder, Float64Builder, StringBuilder, UInt32Builder};
use arrow_schema::{ArrowError, DataType, Field, Schema, SchemaRef};
use bus::can::Frame;
use bus::dbc::Database;

/// Takes frames, named by a database.
pub struct Frames {
    database: Database,
    schema: SchemaRef,
    time: Float64Builder,
    id: UInt32Builder,
    is_extended: BooleanBuilder,
    message: StringBuilder,
    data: BinaryBuilder,
    rows: usize,
}

impl Frames {
    /// None yet.
    pub fn new(database: Database) -> Self {
        let schema = Schema::new(vec![
            Field::new("t", DataType::Float64, false),
            Field::new("id", DataType::UInt32, false),
            Field::new("is_extended", DataType::Boolean, false),
            Field::new("message", DataType::Utf8, true),
            Field::new("data", DataType::Binary, false),
        ]);
        Self {
            database,
            schema: Arc::new(schema),
            time: Float64Builder::new(),
            id: UInt32Builder::new(),
            is_extended: BooleanBuilder::new(),
            message: StringBuilder::new(),
            data: BinaryBuilder::new(),
            rows: 0,
        }
    }

    /// Its columns.
    pub fn schema(&self) -> SchemaRef {
        self.schema.clone()
    }

    /// Frames that wait to be taken.
    pub fn rows(&self) -> usize {
        self.rows
    }

    /// A frame.
    pub fn push(&mut self, frame: &Frame) {
        self.time.append_value(frame.time.seconds());
        self.id.append_value(frame.id.number());
        self.is_extended.append_value(frame.id.is_extended());
        let message = self.database.message_with_id(frame.id);
        self.message.append_option(message.map(|message| &message.name));
        self.data.append_value(frame.data());
        self.rows += 1;
    }

    /// The frames that wait, without copying them.
    ///
    /// # Errors
    /// If columns and schema differ.
    pub fn take(&mut self) -> Result<RecordBatch, ArrowError> {
        self.rows = 0;
        RecordBatch::try_new(
            self.schema.clone(),
            vec![
                Arc::new(self.time.finish()),
                Arc::new(self.id.finish()),
                Arc::new(self.is_extended.finish()),
                Arc::new(self.message.finish()),
                Arc::new(self.data.finish()),
            ],
        )
    }
}
