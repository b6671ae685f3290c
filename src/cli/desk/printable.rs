//! Texts for a terminal that say nothing else to it.

use std::io::{self, Write};

use crate::cli::printable::printable;

/// Writes texts as [`printable`] makes them. Each `write` must be of whole characters, as those of `write!` are.
pub struct Printable<W>(pub W);

impl<W: Write> Write for Printable<W> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.0.write_all(printable(&String::from_utf8_lossy(bytes)).as_bytes())?;
        Ok(bytes.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        self.0.flush()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_what_steers_is_written_otherwise() {
        let mut out = Vec::new();
        let named = "\u{1b}[31m\u{9b}2J\r\t\u{202e}x";
        writeln!(Printable(&mut out), "km/h° {named}").unwrap();
        let text = String::from_utf8(out).unwrap();
        assert_eq!(text, "km/h° \\u{1b}[31m\\u{9b}2J\\u{d}\\u{9}\\u{202e}x\n");
    }
}
