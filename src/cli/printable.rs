//! What others have named must not steer the terminal: units and names of a DBC, values of a TOML file, file names.

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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_what_steers_is_written_otherwise() {
        let text = printable("km/h° \u{1b}[31m\u{9b}2J\r\t\u{202e}x\n");
        assert_eq!(text, "km/h° \\u{1b}[31m\\u{9b}2J\\u{d}\\u{9}\\u{202e}x\n");
    }
}
