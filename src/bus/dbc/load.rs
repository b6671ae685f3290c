//! Bytes to an unvalidated file: text decoding, and `can-dbc` statement by statement.

use std::borrow::Cow;
use std::collections::HashMap;
use std::io::{self, Read};
use std::path::Path;
use std::sync::Arc;

use can_dbc::{AttributeDefinition, AttributeValue, AttributeValueType, Dbc};
use can_dbc::{SignalExtendedValueType, ValueDescription};

use super::error::{DbcError, Warning};
use super::lines::{Statement, raw_id, statements};
use crate::can::CanId;

/// No real DBC file comes near this, MiB.
const LARGEST_FILE_MIB: u64 = 64;
/// The attributes that are looked at.
const ATTRIBUTES: [&str; 4] =
    ["\"VFrameFormat\"", "\"SystemMessageLongSymbol\"", "\"SystemSignalLongSymbol\"", "\"GenMsgCycleTime\""];
const CYCLE_TIME: &str = "GenMsgCycleTime";
/// So many lines that make no sense are named one by one.
const STRAYS_NAMED: usize = 10;

/// A message as written, with its signals in file order.
pub(super) struct RawMessage {
    pub line: usize,
    pub raw_id: u64,
    pub name: String,
    pub size: u64,
    pub signals: Vec<RawSignal>,
}

/// A signal as written.
pub(super) struct RawSignal {
    pub line: usize,
    pub signal: can_dbc::Signal,
}

/// A signal or message that could not even be parsed.
pub(super) struct Lost {
    /// The identifier of the message.
    pub raw_id: Option<u64>,
    /// The message's name, if a signal was lost.
    pub message: Option<String>,
    /// Its own name, if that much was readable.
    pub name: String,
    pub warning: Warning,
}

/// One row of a `SG_MUL_VAL_` statement.
pub(super) struct MuxRow {
    pub line: usize,
    pub selector: String,
    pub ranges: Vec<(u64, u64)>,
}

type SignalKey = (CanId, String);

/// Everything of a file that decoding depends on.
#[derive(Default)]
pub(super) struct Source {
    pub messages: Vec<RawMessage>,
    pub lost: Vec<Lost>,
    pub values: HashMap<SignalKey, Vec<(i64, String)>>,
    pub comments: HashMap<SignalKey, String>,
    pub floats: HashMap<SignalKey, (usize, SignalExtendedValueType)>,
    pub mux: HashMap<SignalKey, Vec<MuxRow>>,
    pub long_message_names: HashMap<CanId, String>,
    pub long_signal_names: HashMap<SignalKey, String>,
    pub frame_formats: HashMap<CanId, String>,
    pub cycles_ms: HashMap<CanId, f64>,
    pub warnings: Vec<Warning>,
}

/// The identifier that a DBC number means: bit 31 marks an extended one. `None` if it is wider than
/// its kind allows.
pub(super) fn can_id(raw: u64) -> Option<CanId> {
    let raw = u32::try_from(raw).ok()?;
    match raw & (1 << 31) {
        0 => CanId::standard(raw),
        mark => CanId::extended(raw & !mark),
    }
}

/// Reads a file, within reason.
pub(super) fn read(path: &Path) -> Result<Vec<u8>, DbcError> {
    let file = || path.display().to_string();
    let failed = |source: io::Error| DbcError::Read { file: file(), source };
    let limit = LARGEST_FILE_MIB << 20;
    let mut bytes = Vec::new();
    crate::plain_file::open(path).map_err(failed)?.take(limit + 1).read_to_end(&mut bytes).map_err(failed)?;
    if bytes.len() as u64 > limit {
        return Err(DbcError::TooLarge { file: file(), limit_mib: LARGEST_FILE_MIB });
    }
    Ok(bytes)
}

/// UTF-8, or else Windows-1252, which is what the usual editors write.
pub(super) fn text(bytes: &[u8]) -> Cow<'_, str> {
    let bytes = bytes.strip_prefix(b"\xEF\xBB\xBF").unwrap_or(bytes);
    let text = match std::str::from_utf8(bytes) {
        Ok(text) => Cow::Borrowed(text),
        Err(_) => Cow::Owned(bytes.iter().map(|b| windows_1252(*b)).collect()),
    };
    if text.contains('\r') && !text.contains('\n') { Cow::Owned(text.replace('\r', "\n")) } else { text }
}

/// Codes 0x80–0x9F; all others are Latin-1. The five that Windows-1252 leaves open stay what they are.
const WINDOWS_1252: [char; 32] = [
    '€', '\u{81}', '‚', 'ƒ', '„', '…', '†', '‡', 'ˆ', '‰', 'Š', '‹', 'Œ', '\u{8D}', 'Ž', '\u{8F}', '\u{90}',
    '‘', '’', '“', '”', '•', '–', '—', '˜', '™', 'š', '›', 'œ', '\u{9D}', 'ž', 'Ÿ',
];

fn windows_1252(byte: u8) -> char {
    match byte {
        0x80..=0x9F => WINDOWS_1252[usize::from(byte - 0x80)],
        _ => char::from(byte),
    }
}

/// Parses every statement on its own; what cannot be parsed becomes a warning.
///
/// # Errors
/// If there is no DBC statement at all.
pub(super) fn parse(text: &str, file: &Arc<str>) -> Result<Source, DbcError> {
    let found = statements(text);
    if !found.any_keyword {
        return Err(DbcError::NotDbc { file: file.to_string() });
    }
    let mut reader = Reader { file: file.clone(), source: Source::default(), formats: Vec::new() };
    for stray in found.strays.iter().take(STRAYS_NAMED) {
        reader.warn(stray.line, stray.reason.to_owned());
    }
    if let Some(next) = found.strays.get(STRAYS_NAMED) {
        let more = found.strays.len() - STRAYS_NAMED;
        reader.warn(next.line, format!("{more} more lines like these ignored from here on"));
    }
    let mut rest = found.statements.as_slice();
    while let [first, after @ ..] = rest {
        rest = after;
        match first.keyword {
            "BO_" => {
                let signals = rest.iter().take_while(|s| s.keyword == "SG_").count();
                let (signals, after) = rest.split_at(signals);
                rest = after;
                reader.message(first, signals);
            }
            "SG_" => reader.warn(first.line, "signal outside of any message, ignored".to_owned()),
            _ => reader.attachment(first),
        }
    }
    Ok(reader.source)
}

struct Reader {
    file: Arc<str>,
    source: Source,
    /// Names of the frame formats, in the order of their numbers.
    formats: Vec<String>,
}

impl Reader {
    fn warn(&mut self, line: usize, message: String) {
        self.source.warnings.push(Warning { file: self.file.clone(), line, message });
    }

    fn lose(&mut self, statement: &Statement, raw_id: Option<u64>, message: Option<&str>, why: &str) {
        let name = name_of(statement.text);
        let what = if message.is_some() { "signal" } else { "message" };
        let message_text = format!("{what} `{name}` skipped: {why}");
        let warning = Warning { file: self.file.clone(), line: statement.line, message: message_text };
        self.source.warnings.push(warning.clone());
        self.source.lost.push(Lost { raw_id, message: message.map(str::to_owned), name, warning });
    }

    /// A `BO_` statement with the `SG_` statements below it.
    fn message(&mut self, head: &Statement, below: &[Statement]) {
        let raw_id = raw_id(head.text);
        if name_of(head.text) == "VECTOR__INDEPENDENT_SIG_MSG" {
            return; // a drawer for signals that belong to no message
        }
        let all: String = std::iter::once(head).chain(below).flat_map(|s| [s.text, "\n"]).collect();
        let together = parse_message(&all).filter(|m| m.signals.len() == below.len());
        let (message, signals) = match together {
            Some(mut message) => {
                let signals = std::mem::take(&mut message.signals);
                let signals = below.iter().zip(signals).map(|(s, signal)| RawSignal { line: s.line, signal });
                (message, signals.collect())
            }
            // Something in it is wrong: find out what, line by line.
            None => match Dbc::try_from(format!("{}\n", head.text).as_str()) {
                Ok(dbc) if dbc.messages.len() == 1 => {
                    let Some(message) = dbc.messages.into_iter().next() else { return };
                    let signals = below.iter().filter_map(|s| self.signal(raw_id, &message.name, s));
                    let signals = signals.collect();
                    (message, signals)
                }
                other => {
                    let why = other.err().map_or("not understood".to_owned(), |e| explain(&e));
                    return self.lose(head, raw_id, None, &why);
                }
            },
        };
        let Some(raw_id) = raw_id else {
            return self.lose(head, None, None, "no identifier");
        };
        let (name, size) = (message.name, message.size);
        self.source.messages.push(RawMessage { line: head.line, raw_id, name, size, signals });
    }

    /// A `SG_` statement on its own, under a makeshift message.
    fn signal(&mut self, raw_id: Option<u64>, message: &str, statement: &Statement) -> Option<RawSignal> {
        let text = format!("BO_ 0 M: 8 Vector__XXX\n{}\n", statement.text);
        let why = match Dbc::try_from(text.as_str()) {
            Ok(dbc) => {
                if let Some(signal) =
                    dbc.messages.into_iter().next().and_then(|m| m.signals.into_iter().next())
                {
                    return Some(RawSignal { line: statement.line, signal });
                }
                "not understood".to_owned()
            }
            Err(error) => explain(&error),
        };
        self.lose(statement, raw_id, Some(message), &why);
        None
    }

    /// Any statement that says something about a message or signal.
    fn attachment(&mut self, statement: &Statement) {
        let text = statement.text;
        if statement.keyword == "CM_" {
            self.source.comments.extend(comment(text));
            return;
        }
        let wanted = match statement.keyword {
            "VAL_" | "SIG_VALTYPE_" | "SG_MUL_VAL_" => true,
            "BA_DEF_" => text.contains("\"VFrameFormat\""),
            "BA_" => ATTRIBUTES.iter().any(|attribute| text.contains(attribute)),
            _ => false,
        };
        if !wanted {
            return;
        }
        // can-dbc cuts identifiers that are too wide: what belongs to such a message must not be taken
        // for another's.
        let id = raw_id(text).and_then(can_id);
        match Dbc::try_from(format!("{text}\n").as_str()) {
            Ok(dbc) => self.attach(statement.line, id, dbc),
            Err(error) => self.warn(
                statement.line,
                format!("{} statement ignored: {}", statement.keyword, explain(&error)),
            ),
        }
    }

    fn attach(&mut self, line: usize, id: Option<CanId>, dbc: Dbc) {
        for definition in dbc.attribute_definitions {
            if let AttributeDefinition::Message(_, AttributeValueType::Enum(names)) = definition {
                self.formats = names;
            }
        }
        let Some(id) = id else { return };
        for description in dbc.value_descriptions {
            if let ValueDescription::Signal { name, value_descriptions, .. } = description {
                let values = value_descriptions.into_iter().map(|v| (v.id, v.description)).collect();
                self.source.values.insert((id, name), values);
            }
        }
        for row in dbc.signal_extended_value_type_list {
            self.source.floats.insert((id, row.signal_name), (line, row.signal_extended_value_type));
        }
        for row in dbc.extended_multiplex {
            let ranges = row.mappings.iter().map(|m| (m.min_value, m.max_value)).collect();
            let row_key = (id, row.signal_name);
            let row = MuxRow { line, selector: row.multiplexor_signal_name, ranges };
            self.source.mux.entry(row_key).or_default().push(row);
        }
        for attribute in dbc.attribute_values_message {
            match (attribute.name.as_str(), attribute.value) {
                ("VFrameFormat", AttributeValue::Uint(number)) => {
                    let name = usize::try_from(number).ok().and_then(|n| self.formats.get(n).cloned());
                    self.source.frame_formats.extend(name.map(|name| (id, name)));
                }
                ("VFrameFormat", AttributeValue::String(name)) => {
                    self.source.frame_formats.insert(id, name);
                }
                ("SystemMessageLongSymbol", AttributeValue::String(name)) => {
                    self.source.long_message_names.insert(id, name);
                }
                (CYCLE_TIME, value) => {
                    // Zero is what editors write where there is none.
                    let cycle = number(&value).filter(|cycle| (1.0..=60_000.0).contains(cycle));
                    self.source.cycles_ms.extend(cycle.map(|cycle| (id, cycle)));
                }
                _ => {}
            }
        }
        for attribute in dbc.attribute_values_signal {
            if let ("SystemSignalLongSymbol", AttributeValue::String(name)) =
                (attribute.name.as_str(), attribute.value)
            {
                self.source.long_signal_names.insert((id, attribute.signal_name), name);
            }
        }
    }
}

fn number(value: &AttributeValue) -> Option<f64> {
    match value {
        AttributeValue::Uint(number) => Some(*number as f64),
        AttributeValue::Int(number) => Some(*number as f64),
        AttributeValue::Double(number) => Some(*number),
        AttributeValue::String(_) => None,
    }
}

/// What a `CM_ SG_` statement says of which signal. Nothing is decoded by it, so that a damaged one is no
/// reason for a warning.
fn comment(statement: &str) -> Option<(SignalKey, String)> {
    let rest = statement.strip_prefix("CM_")?.trim_start().strip_prefix("SG_")?;
    let (head, words) = rest.split_once('"')?;
    let mut head = head.split_ascii_whitespace();
    let id = can_id(head.next()?.parse().ok()?)?;
    let name = head.next()?.to_owned();
    Some(((id, name), words.rsplit_once('"')?.0.replace("\\\"", "\"")))
}

fn parse_message(text: &str) -> Option<can_dbc::Message> {
    let dbc = Dbc::try_from(text).ok()?;
    let mut messages = dbc.messages.into_iter();
    messages.next().filter(|_| messages.next().is_none())
}

/// The name in a `BO_` or `SG_` line, as far as it can be told.
fn name_of(statement: &str) -> String {
    let skip = if statement.starts_with("BO_") { 2 } else { 1 };
    let word = statement.split_ascii_whitespace().nth(skip).unwrap_or("?");
    word.split(':').next().unwrap_or("?").chars().take(64).collect()
}

/// What the parser has to say, without its picture of the line.
fn explain(error: &can_dbc::DbcError) -> String {
    match error {
        can_dbc::DbcError::Pest(error) => format!("cannot be parsed: {}", error.variant.message()),
        other => format!("cannot be parsed: {other}"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn text_that_is_not_utf_8_is_windows_1252() {
        assert_eq!(text(b"\"\xB0C \x80\""), "\"°C €\"");
        assert_eq!(text("\u{FEFF}\"°C\"".as_bytes()), "\"°C\"");
        assert_eq!(text(b"a\rb"), "a\nb");
    }

    #[test]
    fn identifiers_wider_than_their_kind_are_none() {
        assert_eq!(can_id(0x7FF), CanId::standard(0x7FF));
        assert_eq!(can_id(0x800), None);
        assert_eq!(can_id(0x1E36_001E), None);
        assert_eq!(can_id(0x9E36_001E), CanId::extended(0x1E36_001E));
        assert_eq!(can_id(0xC000_0000), None);
        assert_eq!(can_id(1 << 32), None);
    }
}
