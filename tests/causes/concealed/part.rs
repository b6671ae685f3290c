//! A part of a report: one description, written as markdown and as JSON.

use serde_json::{Value, json};

use super::share::Share;

/// One value of a table.
pub enum Cell {
    Text(String),
    Share(Share),
    /// A number with so many decimals, if there is one.
    Number(Option<f64>, usize),
}

impl Cell {
    fn markdown(&self) -> String {
        match self {
            Cell::Text(text) => text.clone(),
            Cell::Share(share) => share.to_string(),
            Cell::Number(Some(x), digits) => format!("{x:.digits$}"),
            Cell::Number(None, _) => "–".into(),
        }
    }

    fn json(&self) -> Value {
        match self {
            Cell::Text(text) => json!(text),
            Cell::Share(share) => share.to_json(),
            Cell::Number(x, _) => json!(x),
        }
    }
}

/// A part: a heading, what it says, columns and rows.
pub struct Part {
    pub key: &'static str,
    pub heading: String,
    pub columns: Vec<&'static str>,
    pub rows: Vec<Vec<Cell>>,
}

impl Part {
    /// A list of rows, each with its columns' names.
    pub fn json(&self) -> Value {
        let row = |row: &Vec<Cell>| -> Value {
            self.columns.iter().zip(row).map(|(column, cell)| ((*column).to_owned(), cell.json())).collect()
        };
        self.rows.iter().map(row).collect()
    }
}

/// Words in a cell.
pub fn text(s: impl Into<String>) -> Cell {
    Cell::Text(s.into())
}

/// The mean of what there is.
pub fn mean(list: impl IntoIterator<Item = f64>) -> Option<f64> {
    let list: Vec<f64> = list.into_iter().collect();
    (!list.is_empty()).then(|| list.iter().sum::<f64>() / list.len() as f64)
}

/// The median of what there is.
pub fn median(list: impl IntoIterator<Item = f64>) -> Option<f64> {
    let mut list: Vec<f64> = list.into_iter().collect();
    list.sort_by(f64::total_cmp);
    let n = list.len();
    (n > 0).then(|| 0.5 * (list[(n - 1) / 2] + list[n / 2]))
}

/// A share, its value and Wilson's interval in per cent, as three cells.
pub fn full(share: Share) -> Vec<Cell> {
    let (low, high) = share.interval();
    let value = (share.of > 0).then(|| 100.0 * share.value());
    vec![
        Cell::Share(share),
        Cell::Number(value, 1),
        text(format!("{:.1} – {:.1}", 100.0 * low, 100.0 * high)),
    ]
}

/// A row from pieces.
pub fn joined(parts: impl IntoIterator<Item = Vec<Cell>>) -> Vec<Cell> {
    parts.into_iter().flatten().collect()
}

/// As markdown.
pub fn markdown(parts: &[Part]) -> String {
    let mut page = String::new();
    for part in parts {
        page.push_str(&format!("## {}\n\n| {} |\n|", part.heading, part.columns.join(" | ")));
        page.push_str(&"---|".repeat(part.columns.len()));
        page.push('\n');
        for row in &part.rows {
            let cells: Vec<String> = row.iter().map(Cell::markdown).collect();
            page.push_str(&format!("| {} |\n", cells.join(" | ")));
        }
        page.push('\n');
    }
    page
}
