//! Rows as Apache Parquet: columns of doubles (null where there is none), whole numbers, booleans and words,
//! compressed with Zstandard, in row groups.
//!
//! The file's metadata say `gripd.version`, `gripd.table` and `gripd.units`, a JSON object of each column's unit.

use std::collections::BTreeMap;
use std::io::{self, Write};
use std::sync::Arc;

use parquet::basic::{Compression, LogicalType, Repetition, Type as Physical, ZstdLevel};
use parquet::data_type::{BoolType, ByteArray, ByteArrayType, DoubleType, Int64Type};
use parquet::errors::ParquetError;
use parquet::file::metadata::KeyValue;
use parquet::file::properties::WriterProperties;
use parquet::file::writer::SerializedFileWriter;
use parquet::schema::types::Type;

use super::Table;
use super::rows::{Column, Kind, Rows};
use physics::Micros;

/// Rows that are kept until they are written: some 15 MB of estimates, 5 minutes at 100 Hz.
const GROUP: usize = 1 << 15;

/// Writes a group of rows at a time.
pub struct Parquet<W: Write + Send> {
    writer: SerializedFileWriter<W>,
    columns: Vec<Values>,
    /// The column of the next value.
    next: usize,
    rows: usize,
}

/// The values of a column.
enum Values {
    /// Those that are there, and for each row whether one is (1) or not (0).
    Real(Vec<f64>, Vec<i16>),
    Count(Vec<i64>),
    Flag(Vec<bool>),
    Word(Vec<ByteArray>),
}

impl Values {
    fn new(kind: Kind) -> Self {
        match kind {
            Kind::Real => Self::Real(Vec::new(), Vec::new()),
            Kind::Count => Self::Count(Vec::new()),
            Kind::Flag => Self::Flag(Vec::new()),
            Kind::Word => Self::Word(Vec::new()),
        }
    }

    fn clear(&mut self) {
        match self {
            Self::Real(values, there) => {
                values.clear();
                there.clear();
            }
            Self::Count(values) => values.clear(),
            Self::Flag(values) => values.clear(),
            Self::Word(values) => values.clear(),
        }
    }

    fn len(&self) -> usize {
        match self {
            Self::Real(_, there) => there.len(),
            Self::Count(values) => values.len(),
            Self::Flag(values) => values.len(),
            Self::Word(values) => values.len(),
        }
    }
}

impl<W: Write + Send> Parquet<W> {
    /// Begins the file; `title` is the name of the table.
    pub fn new(output: W, title: &str, columns: &[Column]) -> io::Result<Self> {
        let fields: Result<Vec<_>, _> = columns.iter().map(|column| field(column).map(Arc::new)).collect();
        let schema = Type::group_type_builder("gripd").with_fields(fields.map_err(failed)?).build();
        let units: BTreeMap<&str, &str> =
            columns.iter().map(|column| (column.name.as_str(), &*column.unit)).collect();
        let units = serde_json::to_string(&units)?;
        let version = env!("CARGO_PKG_VERSION");
        let about = [("gripd.version", version), ("gripd.table", title), ("gripd.units", &units)];
        let about = about.map(|(key, value)| KeyValue::new(key.to_owned(), value.to_owned()));
        let properties = WriterProperties::builder()
            .set_created_by(format!("gripd version {version}"))
            .set_compression(Compression::ZSTD(ZstdLevel::default()))
            .set_key_value_metadata(Some(about.to_vec()))
            .build();
        let schema = Arc::new(schema.map_err(failed)?);
        let writer = SerializedFileWriter::new(output, schema, Arc::new(properties)).map_err(failed)?;
        let columns = columns.iter().map(|column| Values::new(column.kind)).collect();
        Ok(Self { writer, columns, next: 0, rows: 0 })
    }

    fn column(&mut self) -> Option<&mut Values> {
        self.next += 1;
        self.columns.get_mut(self.next - 1)
    }

    /// Writes the rows that are kept.
    fn write(&mut self) -> io::Result<()> {
        if self.rows == 0 {
            return Ok(());
        }
        let mut group = self.writer.next_row_group().map_err(failed)?;
        for column in &mut self.columns {
            let Some(mut writer) = group.next_column().map_err(failed)? else { break };
            let written = match column {
                Values::Real(values, there) => {
                    writer.typed::<DoubleType>().write_batch(values, Some(there), None)
                }
                Values::Count(values) => writer.typed::<Int64Type>().write_batch(values, None, None),
                Values::Flag(values) => writer.typed::<BoolType>().write_batch(values, None, None),
                Values::Word(values) => writer.typed::<ByteArrayType>().write_batch(values, None, None),
            };
            written.and_then(|_| writer.close()).map_err(failed)?;
            column.clear();
        }
        group.close().map_err(failed)?;
        self.rows = 0;
        Ok(())
    }
}

impl<W: Write + Send> Rows for Parquet<W> {
    fn time(&mut self, time: Micros) {
        self.next = 0;
        self.number(Some(time.seconds()));
    }

    fn number(&mut self, value: Option<f64>) {
        if let Some(Values::Real(values, there)) = self.column() {
            values.extend(value);
            there.push(value.is_some().into());
        }
    }

    fn count(&mut self, value: u32) {
        if let Some(Values::Count(values)) = self.column() {
            values.push(value.into());
        }
    }

    fn flag(&mut self, value: bool) {
        if let Some(Values::Flag(values)) = self.column() {
            values.push(value);
        }
    }

    fn word(&mut self, word: &'static str) {
        if let Some(Values::Word(values)) = self.column() {
            values.push(ByteArray::from(word));
        }
    }

    fn end(&mut self) -> io::Result<()> {
        self.rows += 1;
        if self.columns.iter().any(|column| column.len() != self.rows) {
            return Err(io::Error::other("a row does not have the values of its columns"));
        }
        if self.rows == GROUP { self.write() } else { Ok(()) }
    }
}

impl<W: Write + Send> Table<W> for Parquet<W> {
    fn into_inner(mut self: Box<Self>) -> io::Result<W> {
        self.write()?;
        let mut output = self.writer.into_inner().map_err(failed)?;
        output.flush()?;
        Ok(output)
    }
}

fn field(column: &Column) -> Result<Type, ParquetError> {
    let (physical, repetition, logical) = match column.kind {
        // A sample without a time is none.
        Kind::Real if column.name == "t" => (Physical::DOUBLE, Repetition::REQUIRED, None),
        Kind::Real => (Physical::DOUBLE, Repetition::OPTIONAL, None),
        Kind::Count => (Physical::INT64, Repetition::REQUIRED, None),
        Kind::Flag => (Physical::BOOLEAN, Repetition::REQUIRED, None),
        Kind::Word => (Physical::BYTE_ARRAY, Repetition::REQUIRED, Some(LogicalType::String)),
    };
    Type::primitive_type_builder(&column.name, physical)
        .with_repetition(repetition)
        .with_logical_type(logical)
        .build()
}

/// What the library says; a failed output's own words where it is that.
fn failed(error: ParquetError) -> io::Error {
    match error {
        ParquetError::External(source) => match source.downcast::<io::Error>() {
            Ok(error) => *error,
            Err(source) => io::Error::other(source.to_string()),
        },
        error => io::Error::other(error.to_string()),
    }
}
