//! Cuts the text of a DBC file into statements that know their line.
//!
//! The parser proper (`can-dbc`) keeps no positions and gives up a whole file for one bad line. So it
//! is given one statement at a time: what it refuses is lost alone, and every message and signal has
//! a line to be named by.

/// The keyword of a line that may have begun a statement but has none.
const NOT_UNDERSTOOD: &str = "?";

/// One statement: a `BO_` or `SG_` line, or anything else up to its semicolon.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Statement<'a> {
    /// First word.
    pub keyword: &'a str,
    /// Line of the first word, counted from 1.
    pub line: usize,
    /// From the first word to the end, with the semicolon.
    pub text: &'a str,
}

/// A line that is part of no statement.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Stray {
    /// Counted from 1.
    pub line: usize,
    /// Why.
    pub reason: &'static str,
}

/// What a text consists of.
#[derive(Debug, Default)]
pub(super) struct Statements<'a> {
    /// In the order of the text.
    pub statements: Vec<Statement<'a>>,
    /// Lines that could not be understood.
    pub strays: Vec<Stray>,
    /// Was there any DBC keyword at all?
    pub any_keyword: bool,
}

/// Statements that end at a semicolon. The dead ones of the format are here too, lest they be strays.
const TO_SEMICOLON: [&str; 25] = [
    "CM_",
    "BA_",
    "BA_DEF_",
    "BA_DEF_DEF_",
    "BA_REL_",
    "BA_DEF_REL_",
    "BA_DEF_DEF_REL_",
    "BA_SGTYPE_",
    "BA_DEF_SGTYPE_",
    "VAL_",
    "VAL_TABLE_",
    "SIG_VALTYPE_",
    "SG_MUL_VAL_",
    "SIG_GROUP_",
    "SIG_TYPE_REF_",
    "SIGTYPE_VALTYPE_",
    "SGTYPE_",
    "SGTYPE_VAL_",
    "BO_TX_BU_",
    "EV_",
    "EV_DATA_",
    "ENVVAR_DATA_",
    "CAT_DEF_",
    "CAT_",
    "FILTER",
];

/// A quoted text is taken as never closed beyond this length, so that a forgotten quotation mark costs
/// one statement and not the rest of the file.
const LONGEST_TEXT: usize = 64 * 1024;

fn is_keyword(word: &str) -> bool {
    matches!(word, "VERSION" | "NS_" | "BS_" | "BU_" | "BO_" | "SG_") || TO_SEMICOLON.contains(&word)
}

fn first_word(text: &str) -> &str {
    let text = text.trim_start_matches([' ', '\t']);
    let end = text.find(|c: char| !(c.is_ascii_alphanumeric() || c == '_')).unwrap_or(text.len());
    &text[..end]
}

/// Cuts a text into statements. Never fails; what makes no sense becomes a stray.
pub(super) fn statements(text: &str) -> Statements<'_> {
    let mut found = Statements::default();
    let (mut at, mut line) = (0, 1);
    // Lists of symbols and nodes may go on over the next lines.
    let (mut in_symbols, mut in_nodes) = (false, false);
    while at < text.len() {
        let rest = &text[at..];
        let length = rest.find('\n').unwrap_or(rest.len());
        let whole_line = &rest[..length];
        let content = whole_line.trim_matches([' ', '\t', '\r']);
        let word = first_word(content);
        let mut taken = length;
        if content.is_empty() || content.starts_with("//") {
            // Neither ends a list.
        } else if in_symbols && content == word {
            // `NS_` lists keywords, each alone on its line, where it says nothing.
        } else if !is_keyword(word) {
            let goes_on = in_nodes && whole_line.starts_with([' ', '\t']);
            if !goes_on {
                found.strays.push(Stray { line, reason: "not a DBC statement, ignored" });
                // It may have been the head of a message: the signals below it are not those of the
                // message above. A damaged signal line, which these marks give away, parts nothing.
                if !content.contains(['@', '|']) {
                    found.statements.push(Statement { keyword: NOT_UNDERSTOOD, line, text: content });
                }
            }
        } else {
            found.any_keyword = true;
            (in_symbols, in_nodes) = (word == "NS_", word == "BU_");
            if TO_SEMICOLON.contains(&word) {
                let indent = whole_line.len() - whole_line.trim_start_matches([' ', '\t']).len();
                match statement_length(&rest[indent..]) {
                    Some(end) => {
                        let text = &rest[indent..indent + end];
                        found.statements.push(Statement { keyword: word, line, text });
                        taken = indent + end;
                    }
                    None => {
                        let reason = "a quoted text is not closed, statement ignored";
                        found.strays.push(Stray { line, reason });
                    }
                }
            } else if matches!(word, "BO_" | "SG_") {
                found.statements.push(Statement { keyword: word, line, text: content });
            }
        }
        line += rest[..taken].bytes().filter(|b| *b == b'\n').count();
        at += taken;
        // To the next line; what follows a semicolon on the same line is a line of its own.
        if text.as_bytes().get(at) == Some(&b'\n') {
            at += 1;
            line += 1;
        }
    }
    found
}

/// Length of the statement at the start of the text: to its semicolon, or to the next keyword at the
/// start of a line where the semicolon was forgotten. `None` if a quoted text never ends.
fn statement_length(text: &str) -> Option<usize> {
    let bytes = text.as_bytes();
    let mut at = 0;
    while at < bytes.len() {
        match bytes[at] {
            b';' => return Some(at + 1),
            b'"' => at += text_length(&bytes[at..])?,
            b'/' if bytes.get(at + 1) == Some(&b'/') => {
                at += bytes[at..].iter().position(|b| *b == b'\n').unwrap_or(bytes.len() - at);
            }
            b'\n' if is_keyword(first_word(&text[at + 1..])) => return Some(at),
            _ => at += 1,
        }
    }
    Some(bytes.len())
}

/// Length of the quoted text at the start, with both quotation marks.
///
/// A text over several lines after which there is no sensible continuation has not been closed: it
/// ran into the opening mark of the next one, and would swallow the statements between.
fn text_length(bytes: &[u8]) -> Option<usize> {
    let mut escaped = false;
    for (index, byte) in bytes.iter().enumerate().skip(1).take(LONGEST_TEXT) {
        match byte {
            b'"' if !escaped => {
                let (text, after) = bytes.split_at(index + 1);
                let next = after.iter().find(|b| !matches!(b, b' ' | b'\t' | b'\r'));
                let sensible =
                    next.is_none_or(|b| matches!(b, b';' | b',' | b'\n' | b'/' | b'+' | b'-' | b'0'..=b'9'));
                return (sensible || !text.contains(&b'\n')).then_some(index + 1);
            }
            b'\\' => escaped = !escaped,
            _ => escaped = false,
        }
    }
    None
}

/// The raw identifier that a statement on a message or signal begins with (for `BA_`, `CM_`: after
/// `BO_` or `SG_`). `None` if there is none.
pub(super) fn raw_id(text: &str) -> Option<u64> {
    let mut rest = text;
    if let Some(open) = text.find('"').filter(|_| text.starts_with("BA_")) {
        rest = &rest[open + text_length(&rest.as_bytes()[open..])?..];
    }
    rest.split_ascii_whitespace().take(3).find_map(|word| word.trim_end_matches(':').parse().ok())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn keywords(text: &str) -> Vec<(&str, usize)> {
        statements(text).statements.iter().map(|s| (s.keyword, s.line)).collect()
    }

    #[test]
    fn the_list_of_symbols_is_no_statement() {
        let text =
            "VERSION \"\"\n\nNS_ :\n\tCM_\n\tBA_DEF_\n\nBS_:\n\nBU_: A\n  B C\nBO_ 1 M: 8 A\n SG_ s : 0|1\n";
        assert_eq!(keywords(text), [("BO_", 11), ("SG_", 12)]);
        assert_eq!(statements(text).strays, []);
    }

    #[test]
    fn semicolons_and_keywords_in_texts_end_nothing() {
        let text = "CM_ \"a;\nBO_ 1 \\\" b\nc\";\nVAL_ 1 s 0 \"x\"\nCM_ \"y\"; CM_ \"z\";\n";
        assert_eq!(keywords(text), [("CM_", 1), ("VAL_", 4), ("CM_", 5), ("CM_", 5)]);
    }

    #[test]
    fn a_text_that_never_closes_costs_one_statement() {
        for next in ["VAL_ 1 s 0 \"x\" 1 \"y\";", "VAL_ 1 s 0 \"\";"] {
            let text = format!("CM_ \"open;\n{next}\nBO_ 1 M: 8 A\n");
            let found = statements(&text);
            assert_eq!(found.strays.iter().map(|s| s.line).collect::<Vec<_>>(), [1]);
            assert_eq!(keywords(&text), [("VAL_", 2), ("BO_", 3)]);
        }
        assert_eq!(statements("CM_ \"open").strays.len(), 1);
    }

    #[test]
    fn signals_below_a_damaged_head_do_not_join_the_message_above() {
        let text = "BO_ 1 M: 8 A\n SG_ a : 0|8\n G_ b : 0|8@1\n SG_ c : 0|8\nB0_ 2 N: 8 A\n SG_ d : 0|8\n";
        assert_eq!(keywords(text), [("BO_", 1), ("SG_", 2), ("SG_", 4), ("?", 5), ("SG_", 6)]);
    }

    #[test]
    fn what_is_not_a_statement_is_noted() {
        let found = statements("hello\n// fine\nBO_ 1 M: 8 A\nworld\n");
        assert_eq!(found.strays.iter().map(|s| s.line).collect::<Vec<_>>(), [1, 4]);
        assert!(found.any_keyword);
        assert!(!statements("hello").any_keyword);
    }

    #[test]
    fn identifiers_are_found_where_each_statement_has_them() {
        assert_eq!(raw_id("VAL_ 12 s 0 \"9\" ;"), Some(12));
        assert_eq!(raw_id("BA_ \"X 7\" SG_ 13 s 4;"), Some(13));
        assert_eq!(raw_id("BO_ 506855454 X: 8 A"), Some(506_855_454));
        assert_eq!(raw_id("VAL_ env 0 \"off\" ;"), Some(0));
    }
}
