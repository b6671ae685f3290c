//! The lines of a tire property file as it is written.

use std::fmt::Write as _;

use physics::model::Uncertain;

/// A file as it grows. Writing to a string cannot fail.
pub(super) struct Page(String);

impl Page {
    /// An empty one.
    pub(super) fn new() -> Self {
        Self(String::new())
    }

    /// Its text.
    pub(super) fn into_text(self) -> String {
        self.0
    }

    /// A section begins.
    pub(super) fn section(&mut self, name: &str) {
        let _ = writeln!(self.0, "[{name}]");
    }

    /// A line for people.
    pub(super) fn comment(&mut self, text: &str) {
        let _ = writeln!(self.0, "$ {text}");
    }

    /// A key whose value is a word.
    pub(super) fn words(&mut self, key: &str, text: &str) {
        let _ = writeln!(self.0, "{key:<24} = '{text}'");
    }

    /// A key whose value is a whole number.
    pub(super) fn integer(&mut self, key: &str, number: u32, comment: &str) {
        let _ = writeln!(self.0, "{key:<24} = {number} $ {comment}");
    }

    /// With all its digits: it comes back as it was.
    pub(super) fn number(&mut self, key: &str, number: f64, comment: &str) {
        let mark = if comment.is_empty() { "" } else { " $ " };
        let line = format!("{key:<24} = {number:?}{mark}{comment}");
        let _ = writeln!(self.0, "{}", line.trim_end());
    }

    /// Keys that change nothing.
    pub(super) fn zeros(&mut self, keys: &[&str]) {
        keys.iter().for_each(|key| self.number(key, 0.0, ""));
    }
}

/// What a number is, with its value and standard deviation where it has one.
pub(super) fn with_std(name: &str, Uncertain { value, std }: Uncertain) -> String {
    let value = short(value);
    if std > 0.0 { format!("{name} {value} +- {}", short(std)) } else { format!("{name} {value}") }
}

/// Of as many digits as somebody reads.
fn short(number: f64) -> f64 {
    // What was written as a number is one.
    format!("{number:.4e}").parse().unwrap_or(number)
}

/// The format is ASCII, and a comment ends with its line.
pub(super) fn ascii(text: &str) -> String {
    text.chars().map(|c| if c == ' ' || c.is_ascii_graphic() { c } else { '?' }).collect()
}
