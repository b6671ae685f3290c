//! The lines of a tire property file: keys with their values, sections, and what is left over.

use std::cell::Cell;
use std::collections::BTreeMap;

use super::TireFileError;

/// What a file says, by key. Sections count for the units only: everywhere else a key means the same in all of them.
#[derive(Debug)]
pub(super) struct Entries {
    file: String,
    by_key: BTreeMap<String, Vec<Entry>>,
    /// Lines that are neither sections nor `KEY = value`: rows of tables, and what is no such file.
    rows: usize,
}

#[derive(Debug)]
struct Entry {
    line: usize,
    text: String,
    is_used: Cell<bool>,
}

/// The section whose keys are known by its name, too.
const UNITS: &str = "UNITS";

impl Entries {
    /// Takes a text to pieces; `file` is what errors name.
    pub(super) fn parse(text: &str, file: &str) -> Self {
        let mut entries = Self { file: file.to_owned(), by_key: BTreeMap::new(), rows: 0 };
        let mut section = String::new();
        let text = text.trim_start_matches('\u{feff}');
        for (place, line) in text.lines().enumerate() {
            let line_text = without_comment(line).trim();
            if let Some(name) = line_text.strip_prefix('[') {
                section = name.trim_end_matches(']').trim().to_ascii_uppercase();
            } else if let Some((key, value)) = line_text.split_once('=') {
                let key = key.trim().to_ascii_uppercase();
                let key = if section == UNITS { format!("{UNITS}.{key}") } else { key };
                let text = unquoted(value.trim()).to_owned();
                let entry = Entry { line: place + 1, text, is_used: Cell::new(false) };
                entries.by_key.entry(key).or_default().push(entry);
            } else if !line_text.is_empty() {
                entries.rows += 1;
            }
        }
        entries
    }

    /// The file, as errors name it.
    pub(super) fn file(&self) -> &str {
        &self.file
    }

    /// A key's text. Said twice and differently, it is refused.
    pub(super) fn text(&self, key: &str) -> Result<Option<&str>, TireFileError> {
        let Some([first, others @ ..]) = self.by_key.get(key).map(Vec::as_slice) else { return Ok(None) };
        first.is_used.set(true);
        for other in others {
            other.is_used.set(true);
            if !other.text.eq_ignore_ascii_case(&first.text) {
                let reason = format!(
                    "{key} = {} again, and line {} has {}; leave one of them",
                    other.text, first.line, first.text
                );
                return Err(TireFileError::Line { file: self.file.clone(), line: other.line, reason });
            }
        }
        Ok(Some(&first.text))
    }

    /// A key's number.
    pub(super) fn number(&self, key: &str) -> Result<Option<f64>, TireFileError> {
        let Some(text) = self.text(key)? else { return Ok(None) };
        // Fortran writes an exponent with a D.
        let number = text.replace(['d', 'D'], "e").parse::<f64>();
        match number.ok().filter(|number| number.is_finite()) {
            Some(number) => Ok(Some(number)),
            None => Err(self.wrong(key, "is not a finite number; write one with a decimal point".into())),
        }
    }

    /// An error about a key, at its line where it has one.
    pub(super) fn wrong(&self, key: &str, reason: String) -> TireFileError {
        let file = self.file.clone();
        let name = key.trim_start_matches(&format!("{UNITS}."));
        match self.by_key.get(key).and_then(|all| all.first()) {
            Some(entry) => {
                let reason = format!("{name} = {}: {reason}", entry.text);
                TireFileError::Line { file, line: entry.line, reason }
            }
            None => TireFileError::Whole { file, reason: format!("{name}: {reason}") },
        }
    }

    /// How many lines were used, and how many were not.
    pub(super) fn counts(&self) -> (usize, usize) {
        let all = || self.by_key.values().flatten();
        let used = all().filter(|entry| entry.is_used.get()).count();
        (used, all().count() - used + self.rows)
    }
}

/// A line up to its comment: `$` and `!` begin one, unless they stand between quotes.
fn without_comment(line: &str) -> &str {
    let mut quote = None;
    for (place, letter) in line.char_indices() {
        match (quote, letter) {
            (None, '$' | '!') => return &line[..place],
            (None, '\'' | '"') => quote = Some(letter),
            (Some(open), letter) if letter == open => quote = None,
            _ => {}
        }
    }
    line
}

fn unquoted(text: &str) -> &str {
    text.trim_matches(['\'', '"']).trim()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn keys_come_without_case_quotes_and_comments() {
        let text = "\u{feff}$ PCY1 = 3\n[Units]\nforce = 'Newton' ! not kN\n[lateral]\n pCy1=1.3D+0 $ C\nNAME = 'a $ b'\n{x y}\n1 2\n";
        let entries = Entries::parse(text, "x.tir");
        assert_eq!(entries.number("PCY1").unwrap(), Some(1.3));
        assert_eq!(entries.text("UNITS.FORCE").unwrap(), Some("Newton"));
        assert_eq!(entries.text("NAME").unwrap(), Some("a $ b"));
        assert_eq!(entries.text("FORCE").unwrap(), None);
        assert_eq!(entries.counts(), (3, 2));
    }

    #[test]
    fn a_key_with_two_values_is_refused_at_its_second_line() {
        let entries = Entries::parse("A = 1\nA = 1\nB = 1\nB = 2\n", "x.tir");
        assert_eq!(entries.number("A").unwrap(), Some(1.0));
        let error = entries.number("B").unwrap_err().to_string();
        assert_eq!(error, "x.tir:4: B = 2 again, and line 3 has 1; leave one of them");
    }

    #[test]
    fn what_is_no_number_is_refused_with_its_line() {
        for text in ["", "nan", "inf", "1e999", "1,5", "1 2", "0x10", "'"] {
            let entries = Entries::parse(&format!("\nA = {text}\n"), "x.tir");
            let error = entries.number("A").unwrap_err().to_string();
            assert!(error.starts_with("x.tir:2: A = "), "{text}: {error}");
        }
    }
}
