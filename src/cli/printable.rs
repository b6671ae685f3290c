//! What others have named must not steer the terminal: units and names of a DBC, values of a TOML file, file names.

use std::io::{self, Write};

/// Does a terminal do something else with it than show it (control characters, and those that turn the writing
/// direction)?
fn steers(letter: char) -> bool {
    let turns = matches!(letter, '\u{200E}' | '\u{200F}' | '\u{202A}'..='\u{202E}' | '\u{2066}'..='\u{2069}');
    (letter.is_control() && letter != '\n') || turns
}

/// A text of ours with such characters written as `\u{1b}`. Line ends stay.
pub fn printable(text: &str) -> String {
    let mut shown = String::with_capacity(text.len());
    for letter in text.chars() {
        if steers(letter) {
            shown.extend(letter.escape_unicode());
        } else {
            shown.push(letter);
        }
    }
    shown
}

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
