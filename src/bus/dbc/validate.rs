//! From what a file says to what can be decoded. Whatever cannot is left out with a warning.

use std::collections::{HashMap, HashSet};
use std::sync::Arc;

use can_dbc::{MultiplexIndicator, NumericValue, SignalExtendedValueType, ValueType};

use super::codec::{ByteOrder, Codec, ValueKind};
use super::error::Warning;
use super::extract::Extractor;
use super::load::{MuxRow, RawMessage, RawSignal, Source, can_id};
use super::message::Message;
use super::mux::{Condition, Mux};
use super::signal::Signal;
use crate::can::CanId;

/// Something that is in the file by name but cannot be used.
#[derive(Clone, Debug)]
pub(super) struct Skipped {
    /// Name of the message.
    pub message: String,
    /// Name of the signal; `None` if the whole message was skipped.
    pub signal: Option<String>,
    /// Where and why.
    pub warning: Warning,
}

/// What is left of a file.
#[derive(Default)]
pub(super) struct Validated {
    pub messages: Vec<Message>,
    pub skipped: Vec<Skipped>,
    pub warnings: Vec<Warning>,
}

/// Checks everything that decoding relies on.
pub(super) fn validate(mut source: Source, file: &Arc<str>) -> Validated {
    let mut result = Validated { warnings: std::mem::take(&mut source.warnings), ..Validated::default() };
    for lost in std::mem::take(&mut source.lost) {
        let (message, signal) = match lost.message {
            Some(message) => (message, Some(lost.name)),
            None => (lost.name, None),
        };
        // A signal is looked up under its message's final name.
        let message = long_name(&source, lost.raw_id.and_then(can_id), message);
        result.skipped.push(Skipped { message, signal, warning: lost.warning });
    }
    let messages = std::mem::take(&mut source.messages);
    let mut validator = Validator { source, file: file.clone(), result };
    validator.warn_of_strangers(&messages);
    let (mut ids, mut names) = (HashMap::new(), HashMap::new());
    for raw in messages {
        let (line, raw_id) = (raw.line, raw.raw_id);
        let name = long_name(&validator.source, can_id(raw_id), raw.name.clone());
        let Some(id) = can_id(raw_id) else {
            let kind = if raw_id & (1 << 31) == 0 { "a standard (11-bit)" } else { "an extended (29-bit)" };
            let why = format!(
                "identifier {raw_id} (0x{raw_id:X}) is wider than {kind} identifier can be; \
                 extended identifiers are marked by bit 31"
            );
            validator.skip_message(line, name, &why);
            continue;
        };
        if raw.size > 64 {
            let why = format!("{} bytes are more than the 64 of a CAN FD frame", raw.size);
            validator.skip_message(line, name, &why);
        } else if let Some(first) = ids.get(&id) {
            let why = format!("identifier {id} is already taken by the message of line {first}");
            validator.skip_message(line, name, &why);
        } else if let Some(first) = names.get(&name) {
            let why = format!("its name is already taken by the message of line {first}");
            validator.skip_message(line, name, &why);
        } else {
            ids.insert(id, line);
            names.insert(name.clone(), line);
            validator.message(id, name, raw);
        }
    }
    validator.result.warnings.sort_by_key(|warning| warning.line);
    validator.result
}

fn long_name(source: &Source, id: Option<CanId>, short: String) -> String {
    id.and_then(|id| source.long_message_names.get(&id)).cloned().unwrap_or(short)
}

struct Validator {
    source: Source,
    file: Arc<str>,
    result: Validated,
}

/// A signal that can be decoded on its own, before multiplexing is settled.
struct Candidate {
    short_name: String,
    signal: Signal,
    indicator: MultiplexIndicator,
}

impl Validator {
    fn warn(&mut self, line: usize, message: String) -> Warning {
        let warning = Warning { file: self.file.clone(), line, message };
        self.result.warnings.push(warning.clone());
        warning
    }

    fn skip_message(&mut self, line: usize, name: String, why: &str) {
        let warning = self.warn(line, format!("message `{name}` skipped: {why}"));
        self.result.skipped.push(Skipped { message: name, signal: None, warning });
    }

    fn skip_signal(&mut self, line: usize, message: &str, signal: String, why: &str) {
        let warning = self.warn(line, format!("signal `{message}.{signal}` skipped: {why}"));
        self.result.skipped.push(Skipped { message: message.to_owned(), signal: Some(signal), warning });
    }

    /// A float or multiplexing statement on a signal that is not there is probably meant for one that
    /// is, which would then be read wrongly.
    fn warn_of_strangers(&mut self, messages: &[RawMessage]) {
        let mut signals: HashMap<CanId, HashSet<&str>> = HashMap::new();
        for message in messages {
            if let Some(id) = can_id(message.raw_id) {
                signals.entry(id).or_default().extend(message.signals.iter().map(|s| s.signal.name.as_str()));
            }
        }
        let floats = self.source.floats.iter().map(|(key, (line, _))| ("SIG_VALTYPE_", *line, key));
        let rows = self.source.mux.iter();
        let rows = rows.flat_map(|(key, rows)| rows.iter().map(move |row| ("SG_MUL_VAL_", row.line, key)));
        let strangers: Vec<(usize, String)> = floats
            .chain(rows)
            .filter(|(_, _, (id, name))| signals.get(id).is_some_and(|known| !known.contains(name.as_str())))
            .map(|(keyword, line, (id, name))| {
                (line, format!("{keyword} statement ignored: message {id} has no signal `{name}`"))
            })
            .collect();
        for (line, message) in strangers {
            self.warn(line, message);
        }
    }

    fn message(&mut self, id: CanId, name: String, raw: RawMessage) {
        let length = raw.size as usize;
        let mut candidates: Vec<Candidate> = Vec::new();
        let mut lines = HashMap::new();
        for raw_signal in raw.signals {
            let line = raw_signal.line;
            let short_name = raw_signal.signal.name.clone();
            let key = (id, short_name.clone());
            let signal_name = self.source.long_signal_names.get(&key).cloned().unwrap_or(key.1);
            let problem = match lines.get(&signal_name) {
                Some(first) => Err(format!("its name is already taken by the signal of line {first}")),
                None => self.codec(id, &raw_signal, length),
            };
            match problem {
                Ok(codec) => {
                    lines.insert(signal_name.clone(), line);
                    let indicator = raw_signal.signal.multiplexer_indicator;
                    let signal = self.signal(id, signal_name, codec, raw_signal);
                    candidates.push(Candidate { short_name, signal, indicator });
                }
                Err(why) => self.skip_signal(line, &name, signal_name, &why),
            }
        }
        let signals = self.settle_mux(id, &name, candidates);
        let format = self.source.frame_formats.get(&id);
        let is_fd = length > 8 || format.is_some_and(|f| f.ends_with("CAN_FD"));
        let file = self.file.clone();
        let cycle = self.source.cycles_ms.get(&id).map(|cycle| physics::Micros::from_seconds(1e-3 * cycle));
        let line = raw.line;
        self.result.messages.push(Message { name, id, length, is_fd, cycle, signals, file, line });
    }

    /// How to decode the signal, or why that cannot be done.
    fn codec(&self, id: CanId, raw: &RawSignal, length: usize) -> Result<Codec, String> {
        let signal = &raw.signal;
        let (start, size) = (signal.start_bit, signal.size);
        if !(1..=64).contains(&size) {
            return Err(format!("a size of {size} bits is not within 1 to 64"));
        }
        let order = byte_order(signal);
        let Some(extractor) = Extractor::new(start, size, order, length) else {
            let order = if order == ByteOrder::Intel { "Intel" } else { "Motorola" };
            return Err(format!(
                "its {size} bits from start bit {start} ({order}) are not within the message's {length} bytes"
            ));
        };
        if !signal.factor.is_finite() || signal.factor == 0.0 {
            return Err(format!("a factor of {} carries no value", signal.factor));
        }
        if !signal.offset.is_finite() {
            return Err(format!("an offset of {} carries no value", signal.offset));
        }
        let kind = match self.source.floats.get(&(id, signal.name.clone())) {
            Some((line, SignalExtendedValueType::IEEEfloat32Bit)) if size != 32 => {
                return Err(format!("line {line} makes it a 32-bit float, but it has {size} bits"));
            }
            Some((line, SignalExtendedValueType::IEEEdouble64bit)) if size != 64 => {
                return Err(format!("line {line} makes it a 64-bit float, but it has {size} bits"));
            }
            Some((_, SignalExtendedValueType::IEEEfloat32Bit)) => ValueKind::Float32,
            Some((_, SignalExtendedValueType::IEEEdouble64bit)) => ValueKind::Float64,
            _ if signal.value_type == ValueType::Signed => ValueKind::Signed,
            _ => ValueKind::Unsigned,
        };
        Ok(Codec { extractor, kind, factor: signal.factor, offset: signal.offset })
    }

    fn signal(&mut self, id: CanId, name: String, codec: Codec, raw: RawSignal) -> Signal {
        let byte_order = byte_order(&raw.signal);
        let can_dbc::Signal { name: short, start_bit, size, min, max, unit, .. } = raw.signal;
        Signal {
            name,
            unit,
            factor: codec.factor,
            offset: codec.offset,
            min: number(min),
            max: number(max),
            // Both are within a message of 64 bytes by now.
            start_bit: start_bit as u16,
            size: size as u8,
            byte_order,
            line: raw.line,
            comment: self.source.comments.remove(&(id, short.clone())).unwrap_or_default(),
            values: self.source.values.remove(&(id, short)).unwrap_or_default(),
            codec,
            mux: Mux::default(),
        }
    }

    /// Ties multiplexed signals to their selectors; those that cannot be tied are skipped.
    fn settle_mux(&mut self, id: CanId, message: &str, candidates: Vec<Candidate>) -> Vec<Signal> {
        let resolved: Vec<Result<Mux, String>> = {
            let resolver = Resolver { source: &self.source, id, candidates: &candidates };
            (0..candidates.len()).map(|index| resolver.mux(index)).collect()
        };
        let mut signals = Vec::with_capacity(candidates.len());
        for (candidate, mux) in candidates.into_iter().zip(resolved) {
            let mut signal = candidate.signal;
            match mux {
                Ok(mux) => {
                    signal.mux = mux;
                    signals.push(signal);
                }
                Err(why) => self.skip_signal(signal.line, message, signal.name, &why),
            }
        }
        signals
    }
}

/// The selector of a signal, as an index, and the values of it that switch the signal on.
struct Selection {
    selector: usize,
    ranges: Vec<(u64, u64)>,
}

/// Finds the selectors of the multiplexed signals of one message.
struct Resolver<'a> {
    source: &'a Source,
    id: CanId,
    candidates: &'a [Candidate],
}

impl Resolver<'_> {
    /// The chain of conditions of a signal, or why it cannot be followed.
    fn mux(&self, index: usize) -> Result<Mux, String> {
        let mut conditions = Vec::new();
        let mut seen = HashSet::from([index]);
        let mut at = index;
        while let Some(Selection { selector, ranges }) = self.selection(at)? {
            let chosen = &self.candidates[selector];
            if matches!(chosen.signal.codec.kind, ValueKind::Float32 | ValueKind::Float64) {
                return Err(format!("its selector `{}` is a float", chosen.signal.name));
            }
            if !seen.insert(selector) {
                return Err("its selectors select each other in a circle".to_owned());
            }
            conditions.push(Condition { selector: chosen.signal.codec.extractor, ranges });
            at = selector;
        }
        Ok(Mux::new(conditions))
    }

    /// What switches a signal on; `None` if nothing has to.
    fn selection(&self, index: usize) -> Result<Option<Selection>, String> {
        let candidate = &self.candidates[index];
        if let Some(rows) = self.source.mux.get(&(self.id, candidate.short_name.clone())) {
            return self.extended(rows).map(Some);
        }
        let value = match candidate.indicator {
            MultiplexIndicator::Plain | MultiplexIndicator::Multiplexor => return Ok(None),
            MultiplexIndicator::MultiplexedSignal(value) => value,
            MultiplexIndicator::MultiplexorAndMultiplexedSignal(value) => value,
        };
        let mut selectors = (0..self.candidates.len())
            .filter(|other| self.candidates[*other].indicator == MultiplexIndicator::Multiplexor);
        match (selectors.next(), selectors.next()) {
            (Some(selector), None) => Ok(Some(Selection { selector, ranges: vec![(value, value)] })),
            (None, _) => Err("it is multiplexed, but the message has no usable selector (M)".to_owned()),
            _ => {
                Err("the message has several selectors (M) and no SG_MUL_VAL_ says which is its own"
                    .to_owned())
            }
        }
    }

    /// A selector named by `SG_MUL_VAL_`; its ranges stand for all values, also the one after the `m`.
    fn extended(&self, rows: &[MuxRow]) -> Result<Selection, String> {
        let Some(first) = rows.first() else { return Err("no selector".to_owned()) };
        if let Some(other) = rows.iter().find(|row| row.selector != first.selector) {
            return Err(format!("lines {} and {} give it different selectors", first.line, other.line));
        }
        let found = self.candidates.iter().position(|c| c.short_name == first.selector);
        let Some(selector) = found else {
            return Err(format!(
                "line {} names `{}` as its selector, which is not in the message or not usable",
                first.line, first.selector
            ));
        };
        Ok(Selection { selector, ranges: rows.iter().flat_map(|row| row.ranges.iter().copied()).collect() })
    }
}

fn byte_order(signal: &can_dbc::Signal) -> ByteOrder {
    match signal.byte_order {
        can_dbc::ByteOrder::LittleEndian => ByteOrder::Intel,
        can_dbc::ByteOrder::BigEndian => ByteOrder::Motorola,
    }
}

fn number(value: NumericValue) -> f64 {
    match value {
        NumericValue::Uint(value) => value as f64,
        NumericValue::Int(value) => value as f64,
        NumericValue::Double(value) => value,
    }
}
