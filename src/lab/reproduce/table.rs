//! The table on the terminal.

use std::fmt;

use super::Done;
use super::Verdict;

/// Its columns; notes stand below the row they are about.
pub const COLUMNS: [&str; 5] = ["figure", "claim", "thesis", "ours", "verdict"];
/// How wide, in characters; longer cells wrap.
const WIDTHS: [usize; 5] = [9, 42, 26, 36, 7];
const GAP: &str = "  ";

/// The rows of one experiment: cells, and the note.
pub fn cells(done: &Done) -> Vec<([String; 5], String)> {
    let figure = done.experiment.figure;
    match &done.outcome {
        Ok(outcome) => {
            let rows = outcome.claims.iter().enumerate().map(|(index, claim)| {
                let figure = if index == 0 { figure } else { "" };
                let verdict = word(claim.verdict);
                let cells = [figure, &claim.what, &claim.thesis, &claim.ours, verdict].map(str::to_owned);
                (cells, claim.note.clone())
            });
            rows.collect()
        }
        Err(error) => {
            let cells = [figure, done.experiment.title, "", "", "failed"].map(str::to_owned);
            vec![(cells, error.reason.clone())]
        }
    }
}

/// The whole table with its last line.
pub fn text(done: &[Done]) -> String {
    let mut text = String::new();
    line(&mut text, &COLUMNS.map(str::to_owned));
    line(&mut text, &WIDTHS.map(|width| "─".repeat(width)));
    for (cells, note) in done.iter().flat_map(cells) {
        line(&mut text, &cells);
        let [figure, rest @ ..] = WIDTHS;
        let width = rest.iter().sum::<usize>() + 3 * GAP.len() - 2;
        for part in wrap(&note, width).iter().filter(|part| !part.is_empty()) {
            text += &format!("{:figure$}{GAP}  {part}\n", "");
        }
    }
    text + &format!("\n{}\n", Counts::of(done))
}

/// One row, on as many lines as its longest cell takes.
fn line(text: &mut String, cells: &[String; 5]) {
    let mut wrapped: Vec<Vec<String>> = Vec::new();
    for (cell, width) in cells.iter().zip(WIDTHS) {
        wrapped.push(wrap(cell, width));
    }
    for index in 0..wrapped.iter().map(Vec::len).max().unwrap_or(0) {
        let mut row = String::new();
        for (cell, width) in wrapped.iter().zip(WIDTHS) {
            row += &format!("{:<width$}{GAP}", cell.get(index).map_or("", String::as_str));
        }
        *text += row.trim_end();
        text.push('\n');
    }
}

/// At spaces, and within a word only if it is too long for a line.
fn wrap(text: &str, width: usize) -> Vec<String> {
    let mut lines = Vec::new();
    let mut line = String::new();
    for word in text.split_whitespace() {
        let mut word: Vec<char> = word.chars().collect();
        if !line.is_empty() && line.chars().count() + 1 + word.len() > width {
            lines.push(std::mem::take(&mut line));
        }
        while word.len() > width {
            let rest = word.split_off(width);
            lines.push(word.into_iter().collect());
            word = rest;
        }
        if !line.is_empty() {
            line.push(' ');
        }
        line.extend(word);
    }
    lines.push(line);
    lines
}

fn word(verdict: Verdict) -> &'static str {
    match verdict {
        Verdict::Holds => "holds",
        Verdict::Differs => "differs",
        Verdict::Better => "better",
        Verdict::Short => "short",
    }
}

/// How many of each.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Counts {
    experiments: usize,
    failed: usize,
    holds: usize,
    differs: usize,
    better: usize,
    short: usize,
}

impl Counts {
    /// Counts.
    pub fn of(done: &[Done]) -> Self {
        let mut counts = Self { experiments: done.len(), ..Self::default() };
        for done in done {
            let Ok(outcome) = &done.outcome else {
                counts.failed += 1;
                continue;
            };
            for claim in &outcome.claims {
                *match claim.verdict {
                    Verdict::Holds => &mut counts.holds,
                    Verdict::Differs => &mut counts.differs,
                    Verdict::Better => &mut counts.better,
                    Verdict::Short => &mut counts.short,
                } += 1;
            }
        }
        counts
    }
}

impl fmt::Display for Counts {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { experiments, failed, holds, differs, better, short } = self;
        write!(
            f,
            "{experiments} experiments: of the thesis's claims {holds} hold and {differs} differ; of our own \
             answers {better} are better and {short} fall short"
        )?;
        if *failed > 0 { write!(f, "; {failed} experiments failed") } else { Ok(()) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::reproduce::{Claim, Experiment, Outcome};

    #[test]
    fn long_cells_wrap_and_no_word_is_lost() {
        assert_eq!(wrap("a bb ccc", 4), ["a bb", "ccc"]);
        assert_eq!(wrap("μ abcdefgh i", 3), ["μ", "abc", "def", "gh", "i"]);
        assert_eq!(wrap("", 3), [""]);
    }

    #[test]
    fn every_claim_has_its_row_and_the_last_line_counts() {
        fn run() -> Result<Outcome, String> {
            Ok(Outcome::default())
        }
        let claims = vec![
            Claim::new("one thing", "1 N", "2 N".into(), false, "because of that"),
            Claim::better("another", "3 N".into(), true, ""),
        ];
        let outcome = Ok(Outcome { claims, pictures: vec![] });
        let done = [Done { experiment: Experiment { figure: "1.1", title: "", run }, outcome }];
        let text = text(&done);
        let lines: Vec<&str> = text.lines().map(str::trim).collect();
        assert!(lines[2].starts_with("1.1") && lines[2].ends_with("differs"), "{text}");
        assert_eq!(lines[3], "because of that");
        assert!(lines[4].starts_with("another") && lines[4].ends_with("better"), "{text}");
        assert!(lines[6].contains("0 hold and 1 differ") && lines[6].contains("1 are better"), "{text}");
    }
}
