//! `--estimates` and `--samples`: CSV, empty where not available, or Parquet, MF4 or MCAP where the file's name ends so.

mod csv;
mod mcap;
mod mf4;
mod parquet;
mod protobuf;
pub mod rows;

use std::io::{self, Seek, Write};
use std::path::Path;

use self::csv::Csv;
use self::mcap::Mcap;
use self::mf4::Mf4;
use self::parquet::Parquet;
use self::rows::{Column, Rows};
use super::Failure;

/// How a table is written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TableFormat {
    /// Comma-separated values.
    Csv,
    /// Apache Parquet.
    Parquet,
    /// ASAM MF4: signals.
    Mf4,
    /// MCAP: messages.
    Mcap,
}

impl TableFormat {
    /// By the extension of a file's name; CSV where that says nothing.
    pub fn of(path: &Path) -> Result<Self, Failure> {
        let ends_in = |what: &&str| path.extension().is_some_and(|end| end.eq_ignore_ascii_case(what));
        match ["parquet", "mf4", "mcap", "gz", "zst"].iter().find(|what| ends_in(what)) {
            Some(&"parquet") => Ok(Self::Parquet),
            Some(&"mf4") => Ok(Self::Mf4),
            Some(&"mcap") => Ok(Self::Mcap),
            Some(packed) => Err(Failure::usage(format_args!(
                "{}: tables are not written as .{packed}; Parquet is packed (.parquet)",
                path.display()
            ))),
            None => Ok(Self::Csv),
        }
    }
}

/// Rows that end in an output.
pub trait Table<W>: Rows {
    /// The output, with everything in it.
    fn into_inner(self: Box<Self>) -> io::Result<W>;
}

/// Begins a table of a title and columns.
pub fn table<W: Write + Seek + Send + 'static>(
    output: W,
    format: TableFormat,
    title: &str,
    columns: &[Column],
) -> io::Result<Box<dyn Table<W>>> {
    Ok(match format {
        TableFormat::Csv => Box::new(Csv::new(output, columns)?),
        TableFormat::Parquet => Box::new(Parquet::new(output, title, columns)?),
        TableFormat::Mf4 => Box::new(Mf4::new(output, title, columns)?),
        TableFormat::Mcap => Box::new(Mcap::new(output, title, columns)?),
    })
}

#[cfg(test)]
mod tests {
    use std::io::Cursor;

    use super::rows::{estimates_columns, estimates_row};
    use super::*;
    use physics::{Estimates, Micros, Sample};

    #[test]
    fn every_row_has_as_many_fields_as_the_header() {
        let output = Cursor::new(Vec::new());
        let mut table = table(output, TableFormat::Csv, "estimates", &estimates_columns()).unwrap();
        let sample = Sample::empty(Micros(20_000), 0.01);
        estimates_row(&mut *table, &sample, &Estimates::default()).unwrap();
        let text = String::from_utf8(table.into_inner().unwrap().into_inner()).unwrap();
        let fields: Vec<usize> = text.lines().map(|line| line.split(',').count()).collect();
        assert_eq!(fields[0], fields[1], "{text}");
        assert!(text.lines().nth(1).unwrap().starts_with("0.020000,,"));
    }
}
