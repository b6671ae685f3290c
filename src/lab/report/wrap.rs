//! Words in lines that a terminal has room for.

/// Columns of a terminal that is not wide.
pub const WIDTH: usize = 100;

/// Words in lines, the first one behind `begin`, the others `indent` columns to the right.
pub fn wrapped(begin: &str, indent: usize, words: &str) -> String {
    let mut text = String::new();
    let mut line = begin.to_owned();
    let mut is_empty = true;
    for word in words.split_whitespace() {
        if !is_empty && line.chars().count() + 1 + word.chars().count() > WIDTH {
            text += line.trim_end();
            text.push('\n');
            line = " ".repeat(indent);
            is_empty = true;
        }
        if !is_empty {
            line.push(' ');
        }
        line += word;
        is_empty = false;
    }
    text + line.trim_end() + "\n"
}
