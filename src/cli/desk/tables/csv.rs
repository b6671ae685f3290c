//! Rows as comma-separated values, empty where there is none; flags are 0 and 1.

use std::fmt::Write as _;
use std::io::{self, Write};

use super::Table;
use super::rows::{Column, Rows};
use physics::Micros;

/// Writes a line for each row.
pub struct Csv<W> {
    output: W,
    row: String,
}

impl<W: Write> Csv<W> {
    /// Writes the names.
    pub fn new(mut output: W, columns: &[Column]) -> io::Result<Self> {
        let names: Vec<&str> = columns.iter().map(|column| column.name.as_str()).collect();
        writeln!(output, "{}", names.join(","))?;
        Ok(Self { output, row: String::new() })
    }
}

impl<W: Write> Rows for Csv<W> {
    fn time(&mut self, time: Micros) {
        self.row.clear();
        // Writing to a string cannot fail.
        let _ = write!(self.row, "{time}");
    }

    fn number(&mut self, value: Option<f64>) {
        self.row.push(',');
        if let Some(value) = value {
            let _ = write!(self.row, "{value}");
        }
    }

    fn count(&mut self, value: u32) {
        let _ = write!(self.row, ",{value}");
    }

    fn flag(&mut self, value: bool) {
        self.row.push_str(if value { ",1" } else { ",0" });
    }

    fn word(&mut self, word: &'static str) {
        self.row.push(',');
        self.row.push_str(word);
    }

    fn end(&mut self) -> io::Result<()> {
        self.row.push('\n');
        self.output.write_all(self.row.as_bytes())
    }
}

impl<W: Write> Table<W> for Csv<W> {
    fn into_inner(mut self: Box<Self>) -> io::Result<W> {
        self.output.flush()?;
        Ok(self.output)
    }
}
