//! Lines and tables, on a terminal no wider than it is.

use std::io::{self, Write};

use lab::report::{WIDTH, wrapped};

/// Where a report is written, and how wide it may be.
pub struct Layout<W> {
    out: W,
    /// On a terminal lines are broken; for programs each thing has a line of its own, however long.
    is_narrow: bool,
}

/// A column: its head, its width, and do its cells stand to the right?
pub type Column = (&'static str, usize, bool);

impl<W: Write> Layout<W> {
    /// On a terminal, or not.
    pub fn new(out: W, is_narrow: bool) -> Self {
        Self { out, is_narrow }
    }

    /// A line. What begins it stands for itself, and further lines are as far to the right as its text, and a little more.
    pub fn line(&mut self, text: &str) -> io::Result<()> {
        if !self.is_narrow || text.chars().count() <= WIDTH {
            return writeln!(self.out, "{text}");
        }
        let blank = text.chars().take_while(|letter| *letter == ' ').count();
        // A word with more room behind it than words have is what the line is about.
        let label = text[blank..].find("  ").filter(|end| !text[blank..blank + end].contains(' '));
        let words = match label {
            Some(end) => text[blank + end..].trim_start(),
            None => &text[blank..],
        };
        let begin = &text[..text.len() - words.len()];
        self.out.write_all(wrapped(begin, blank + 4, words).as_bytes())
    }

    /// An empty line.
    pub fn gap(&mut self) -> io::Result<()> {
        writeln!(self.out)
    }

    /// A table, each line behind so many blanks. Columns for which there is no room follow in a table of their own, with the
    /// first column again.
    pub fn table(&mut self, indent: usize, columns: &[Column], rows: &[Vec<String>]) -> io::Result<()> {
        // On a terminal a cell that is wider than its column widens it.
        let widened = |(place, (head, width, is_right)): (usize, &Column)| {
            let cells = rows.iter().filter_map(|row| row.get(place)).map(|cell| cell.chars().count());
            (*head, cells.chain([*width]).max().unwrap_or(*width), *is_right)
        };
        let widened: Vec<Column> = columns.iter().enumerate().map(widened).collect();
        let columns = if self.is_narrow { &widened } else { columns };
        let parts = if self.is_narrow { parts(indent, columns) } else { vec![(1..columns.len()).collect()] };
        for (number, part) in parts.iter().enumerate() {
            if number > 0 {
                self.gap()?;
            }
            let places = || std::iter::once(0).chain(part.iter().copied());
            let heads: Vec<String> = columns.iter().map(|(head, ..)| (*head).to_owned()).collect();
            for row in std::iter::once(&heads).chain(rows) {
                let mut line = " ".repeat(indent);
                for place in places() {
                    let (_, width, is_right) = columns[place];
                    let cell = row.get(place).map_or("", String::as_str);
                    line += &if is_right { format!("{cell:>width$} ") } else { format!("{cell:<width$} ") };
                }
                writeln!(self.out, "{}", line.trim_end())?;
            }
        }
        Ok(())
    }
}

/// Which columns beside the first have room together.
fn parts(indent: usize, columns: &[Column]) -> Vec<Vec<usize>> {
    let width = |place: usize| columns.get(place).map_or(0, |(_, width, _)| width + 1);
    let mut parts: Vec<Vec<usize>> = vec![Vec::new()];
    let mut used = indent + width(0);
    for place in 1..columns.len() {
        let has_room = used + width(place) <= WIDTH + 1;
        match parts.last_mut() {
            Some(part) if has_room || part.is_empty() => part.push(place),
            _ => {
                parts.push(vec![place]);
                used = indent + width(0);
            }
        }
        used += width(place);
    }
    parts
}

#[cfg(test)]
mod tests {
    use super::*;

    const COLUMNS: [Column; 4] =
        [("quantity", 26, false), ("signal", 40, false), ("frames", 30, true), ("checks", 30, false)];

    fn table(is_narrow: bool) -> String {
        let mut layout = Layout::new(Vec::new(), is_narrow);
        let row = ["yaw_rate", "A.B", "12", "none"].map(str::to_owned).to_vec();
        layout.table(2, &COLUMNS, &[row]).unwrap();
        String::from_utf8(layout.out).unwrap()
    }

    #[test]
    fn a_table_that_is_too_wide_goes_on_below() {
        let wide = table(false);
        assert_eq!(wide.lines().count(), 2);
        let narrow = table(true);
        assert!(narrow.lines().all(|line| line.chars().count() <= WIDTH), "{narrow}");
        assert_eq!(narrow.matches("yaw_rate").count(), 2, "{narrow}");
        assert!(narrow.contains("none") && narrow.contains("A.B"), "{narrow}");
    }

    #[test]
    fn a_cell_that_is_too_wide_makes_room_for_itself() {
        let mut layout = Layout::new(Vec::new(), true);
        let row = ["yaw_rate", &"M.Coarse + M.Fine ".repeat(4), "12", "none"].map(str::to_owned).to_vec();
        layout.table(2, &COLUMNS, &[row]).unwrap();
        let text = String::from_utf8(layout.out).unwrap();
        assert!(text.lines().all(|line| line.chars().count() <= WIDTH), "{text}");
        assert!(text.lines().next().unwrap().ends_with("signal"), "{text}");
    }

    #[test]
    fn a_long_line_is_broken_on_a_terminal_only() {
        let text = format!("    because  {}", "word ".repeat(40));
        for (is_narrow, lines) in [(false, 1), (true, 3)] {
            let mut layout = Layout::new(Vec::new(), is_narrow);
            layout.line(text.trim_end()).unwrap();
            let said = String::from_utf8(layout.out).unwrap();
            assert_eq!(said.lines().count(), lines, "{said}");
            assert!(said.starts_with("    because  word"), "{said}");
        }
    }
}
