//! The table that closes a drive: how much of the time each published number was valid, and what else is told of it.

use std::fmt::Write as _;

/// Of one published number.
pub struct Line {
    /// What it is.
    pub name: String,
    /// Share of the time in which it was published as valid.
    pub valid: f64,
    /// What else is told, by column.
    pub told: Vec<String>,
}

/// A column: its head, and its width where its cells stand to the right.
pub type Column = (&'static str, Option<usize>);

/// Heads and lines; a cell that stands to the left is the last one of its line.
pub fn table(columns: &[Column], lines: &[Line]) -> String {
    let mut text = String::new();
    let heads: Vec<String> = columns.iter().map(|(head, _)| (*head).to_owned()).collect();
    let rows = lines.iter().map(|line| (line.name.as_str(), percent(line.valid), &line.told));
    for (name, valid, told) in std::iter::once(("", "valid".to_owned(), &heads)).chain(rows) {
        let mut line = format!("{name:<26} {valid:>6}");
        for ((_, width), cell) in columns.iter().zip(told) {
            // Writing to a string cannot fail.
            let _ = match width {
                Some(width) => write!(line, " {cell:>width$}"),
                None => write!(line, "   {cell}"),
            };
        }
        text += line.trim_end();
        text.push('\n');
    }
    text
}

/// As a percentage; what is there at all is not 0 %, what is not always there not 100 %.
pub fn percent(share: f64) -> String {
    match 100.0 * share {
        percent if !percent.is_finite() => "–".into(),
        percent if percent > 0.0 && percent < 0.5 => "< 1 %".into(),
        percent if (99.5..100.0).contains(&percent) => "> 99 %".into(),
        percent => format!("{percent:.0} %"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shares_are_never_rounded_to_all_or_nothing() {
        let shown = [0.0, 0.001, 0.5, 0.9999, 1.0, f64::NAN].map(percent);
        assert_eq!(shown, ["0 %", "< 1 %", "50 %", "> 99 %", "100 %", "–"]);
    }
}
