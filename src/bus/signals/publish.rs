//! Estimates to frames: the output DBC decides where each value goes, this room what it is.
//!
//! Messages and signals are matched by name, so an integrator can move them to other identifiers and
//! other bits in an output DBC of their own. A value that is absent, not finite, or beyond what its
//! bits can carry is sent as the code that the value table calls `not_available` (NaN in a float
//! signal); only ages and counts stay at their highest code instead.

mod config;
mod fields;
mod incoming;
mod slot;

use thiserror::Error;

pub use config::{ExplicitId, IdConfig, PublishConfig};
pub use incoming::{Incoming, Refused};

use self::fields::{MESSAGES, MessageFields, Needs, Source};
use self::slot::Slot;
use super::e2e;
use crate::can::{CanId, Frame, FrameKind};
use crate::dbc::{Codec, Database, DbcError, Message, Warning};
use physics::{Estimates, Micros};

/// The output DBC that is used where the configuration names none; `dbc/gripd.dbc` in the sources.
pub const BUILT_IN_DBC: &str = include_str!("../../../dbc/gripd.dbc");

/// What [`BUILT_IN_DBC`] is called in warnings and errors.
pub const BUILT_IN_NAME: &str = "gripd.dbc (built in)";

/// Lengths that an FD frame can have.
const FD_LENGTHS: [usize; 7] = [12, 16, 20, 24, 32, 48, 64];

/// The built-in output DBC, loaded.
///
/// # Errors
/// None that a test has not excluded.
pub fn built_in_database() -> Result<Database, DbcError> {
    Database::parse(BUILT_IN_DBC.as_bytes(), BUILT_IN_NAME)
}

/// Why nothing can be published: everything that is wrong at once.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
#[error("{}", .0.iter().map(ToString::to_string).collect::<Vec<_>>().join("\n"))]
pub struct PublishError(pub Vec<PublishProblem>);

/// One thing that is wrong with `[publish]` or with the output DBC.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
pub enum PublishProblem {
    /// The period makes no sense.
    #[error("publish.period_ms = {0}: must be 1 to 10000")]
    Period(u32),
    /// A name that is no message of the published interface.
    #[error("publish.{key}: `{name}` is no message of gripd; there are {}", names())]
    UnknownMessage {
        /// The key.
        key: &'static str,
        /// The name.
        name: String,
    },
    /// A number that is no identifier.
    #[error("publish.ids.{name}: {number:#X} is no {kind} identifier")]
    Id {
        /// The message.
        name: String,
        /// The number.
        number: u32,
        /// Standard or extended.
        kind: &'static str,
    },
    /// Two messages with one identifier.
    #[error("publish.ids: {first} and {second} would both have the identifier {id}")]
    SameId {
        /// The identifier.
        id: CanId,
        /// One message.
        first: String,
        /// The other.
        second: String,
    },
    /// The output DBC has none of the messages.
    #[error("the output DBC has none of the messages to publish; there are {}", names())]
    Nothing,
    /// A signal of the output DBC that cannot carry what its name says.
    #[error("{place}: signal `{signal}` {reason}")]
    Signal {
        /// File and line.
        place: String,
        /// MESSAGE.Signal.
        signal: String,
        /// What is wrong and what to do.
        reason: String,
    },
}

fn names() -> String {
    MESSAGES.map(|message| message.name).join(", ")
}

/// Turns estimates into protected frames.
#[derive(Clone, Debug)]
pub struct Publisher {
    messages: Vec<Compiled>,
    ids: Vec<CanId>,
    period: Micros,
    warnings: Vec<Warning>,
}

/// One message, ready to be filled.
#[derive(Clone, Debug)]
struct Compiled {
    name: &'static str,
    id: CanId,
    kind: FrameKind,
    /// Bytes on the bus.
    length: usize,
    /// Bytes that the DBC knows, which the checksum covers.
    protected: usize,
    /// Values first, then the flags that depend on them.
    slots: Vec<CompiledSlot>,
    counter_codec: Option<Codec>,
    /// The byte of the checksum.
    crc: Option<usize>,
    counter: u8,
}

#[derive(Clone, Debug)]
struct CompiledSlot {
    slot: Slot,
    /// Bit of this signal among those of its message.
    own: u16,
    /// For a flag: the signals it vouches for, and whether one of them is enough.
    needs: u16,
    any: bool,
}

impl Publisher {
    /// Fits the published interface to an output DBC.
    ///
    /// # Errors
    /// Everything that is wrong with the configuration or the DBC.
    pub fn new(database: &Database, config: &PublishConfig) -> Result<Self, PublishError> {
        let mut problems = Vec::new();
        let mut warnings = Vec::new();
        if !(1..=10_000).contains(&config.period_ms) {
            problems.push(PublishProblem::Period(config.period_ms));
        }
        check_names(config, &mut problems);
        let mut messages: Vec<Compiled> = Vec::new();
        let mut taken: Vec<(CanId, &str)> = Vec::new();
        let wanted = |name: &str| config.messages.as_ref().is_none_or(|m| m.iter().any(|m| m == name));
        for fields in MESSAGES.iter().filter(|fields| config.enabled && wanted(fields.name)) {
            let Some(message) = database.message(fields.name) else {
                warnings.push(Warning {
                    file: database.messages().first().map_or_else(|| "output DBC".into(), |m| m.file.clone()),
                    line: 1,
                    message: format!("no message `{}`; it will not be published", fields.name),
                });
                continue;
            };
            let id = match config.ids.get(fields.name).map(|own| (own, own.id())) {
                None => message.id,
                Some((_, Some(id))) => id,
                Some((own, None)) => {
                    problems.push(no_id(fields.name, *own));
                    continue;
                }
            };
            if let Some((_, first)) = taken.iter().find(|(other, _)| *other == id) {
                let (first, second) = ((*first).to_owned(), fields.name.to_owned());
                problems.push(PublishProblem::SameId { id, first, second });
            }
            taken.push((id, fields.name));
            messages.push(Compiled::new(message, fields, id, &mut warnings, &mut problems));
        }
        if config.enabled && taken.is_empty() && problems.is_empty() {
            problems.push(PublishProblem::Nothing);
        }
        if !problems.is_empty() {
            return Err(PublishError(problems));
        }
        let ids = messages.iter().map(|message| message.id).collect();
        let period = Micros::from_millis(i64::from(config.period_ms));
        Ok(Self { messages, ids, period, warnings })
    }

    /// Identifiers of the frames it sends. Frames with these that come back are not input.
    pub fn ids(&self) -> &[CanId] {
        &self.ids
    }

    /// Time between two rounds.
    pub fn period(&self) -> Micros {
        self.period
    }

    /// Is there an FD frame among those it sends?
    pub fn needs_fd(&self) -> bool {
        self.messages.iter().any(|message| matches!(message.kind, FrameKind::Fd { .. }))
    }

    /// What of the output DBC is not used, and what of the interface it lacks. What was wrong with the
    /// file itself is in [`Database::warnings`].
    pub fn warnings(&self) -> &[Warning] {
        &self.warnings
    }

    /// Goes on counting where another publisher of the same messages is, so that receivers see no jump.
    pub fn follow(&mut self, before: &Publisher) {
        for message in &mut self.messages {
            if let Some(other) = before.messages.iter().find(|other| other.name == message.name) {
                message.counter = other.counter;
            }
        }
    }

    /// Emits one frame per message, stamped `time`. Allocates nothing.
    pub fn publish(&mut self, time: Micros, estimates: &Estimates, emit: &mut impl FnMut(&Frame)) {
        for message in &mut self.messages {
            if let Some(frame) = message.fill(time, estimates) {
                emit(&frame);
            }
        }
    }
}

fn check_names(config: &PublishConfig, problems: &mut Vec<PublishProblem>) {
    let selected = config.messages.iter().flatten().map(|name| ("messages", name));
    let renumbered = config.ids.keys().map(|name| ("ids", name));
    for (key, name) in selected.chain(renumbered) {
        if MESSAGES.iter().all(|message| message.name != name) {
            problems.push(PublishProblem::UnknownMessage { key, name: name.clone() });
        }
    }
}

fn no_id(name: &str, id: IdConfig) -> PublishProblem {
    let (number, kind) = match id {
        IdConfig::Number(number) => (number, "CAN"),
        IdConfig::Explicit(ExplicitId { id, extended: true }) => (id, "extended (29-bit)"),
        IdConfig::Explicit(ExplicitId { id, extended: false }) => (id, "standard (11-bit)"),
    };
    PublishProblem::Id { name: name.to_owned(), number, kind }
}

impl Compiled {
    fn new(
        message: &Message,
        fields: &MessageFields,
        id: CanId,
        warnings: &mut Vec<Warning>,
        problems: &mut Vec<PublishProblem>,
    ) -> Self {
        let mut warn = |line: usize, text: String| {
            warnings.push(Warning { file: message.file.clone(), line, message: text });
        };
        let bit_of = |name: &str| fields.fields.iter().position(|f| f.name == name).map_or(0, |n| 1 << n);
        let mut slots = Vec::new();
        for field in fields.fields {
            let Some(signal) = message.signal(field.name) else {
                warn(message.line, format!("message `{}` has no signal `{}`", message.name, field.name));
                continue;
            };
            // Only what is in the frame can be vouched for.
            let bits = |names: &[&str]| {
                let there = names.iter().filter(|name| message.signal(name).is_some());
                there.fold(0, |bits, name| bits | bit_of(name))
            };
            let (needs, any) = match field.source {
                Source::Flag(_, Needs::All(names)) => (bits(names), false),
                Source::Flag(_, Needs::Any(names)) => (bits(names), true),
                _ => (0, false),
            };
            match Slot::new(message, signal, field) {
                Ok(slot) => slots.push(CompiledSlot { slot, own: bit_of(field.name), needs, any }),
                Err(problem) => problems.push(problem),
            }
        }
        slots.sort_by_key(|slot| slot.needs != 0);
        for signal in &message.signals {
            let known = fields.fields.iter().any(|field| field.name == signal.name);
            if !known && !matches!(signal.name.as_str(), "Crc" | "Counter") {
                warn(
                    signal.line,
                    format!("signal `{}.{}` is not gripd's; sent as 0", message.name, signal.name),
                );
            }
        }
        let counter_codec = protection(message, "Counter", problems, |codec| {
            (codec.extractor.size() < 4).then_some("has less than 4 bits")
        });
        let crc = protection(message, "Crc", problems, |codec| {
            crc_byte(codec).is_none().then_some("must be the 8 bits of one byte")
        });
        if counter_codec.is_none() || crc.is_none() {
            warn(message.line, format!("message `{}` goes without Crc or Counter", message.name));
        }
        let is_fd = message.is_fd;
        let kind = if is_fd {
            FrameKind::Fd { bit_rate_switch: false, error_state: false }
        } else {
            FrameKind::Data
        };
        let padded = FD_LENGTHS.into_iter().find(|length| *length >= message.length);
        let length = if message.length > 8 { padded.unwrap_or(64) } else { message.length };
        let crc = crc.as_ref().and_then(crc_byte);
        Self {
            name: fields.name,
            id,
            kind,
            length,
            protected: message.length,
            slots,
            counter_codec,
            crc,
            counter: 0,
        }
    }

    #[inline]
    fn fill(&mut self, time: Micros, estimates: &Estimates) -> Option<Frame> {
        let mut payload = [0; 64];
        if self.length <= 8 {
            let mut word = 0;
            self.signals(estimates, |codec, bits| word = codec.extractor.set_in_word(word, bits));
            payload[..8].copy_from_slice(&u64::to_le_bytes(word));
        } else {
            let mut fits = true;
            self.signals(estimates, |codec, bits| fits &= codec.extractor.set(&mut payload, bits));
            fits.then_some(())?;
        }
        if let Some(byte) = self.crc {
            // The data ID is the identifier's lower 16 bits.
            let crc = e2e::profile_1_crc(self.id.number() as u16, payload.get(..self.protected)?, byte);
            *payload.get_mut(byte)? = crc;
        }
        let frame = Frame::from_payload(time, self.id, self.kind, payload, self.length).ok()?;
        self.counter = e2e::next_counter(self.counter);
        Some(frame)
    }

    /// All signals but the checksum, and their bits.
    #[inline]
    fn signals(&self, estimates: &Estimates, mut put: impl FnMut(&Codec, u64)) {
        let mut available = 0;
        for CompiledSlot { slot, own, needs, any } in &self.slots {
            let (bits, there) = slot.bits(estimates);
            if there {
                available |= own;
            }
            let is_vouched_for = match (*needs, *any) {
                (0, _) => true,
                (needs, true) => available & needs != 0,
                (needs, false) => available & needs == needs,
            };
            put(&slot.codec, if is_vouched_for { bits } else { 0 });
        }
        if let Some(codec) = &self.counter_codec {
            put(codec, u64::from(self.counter));
        }
    }
}

/// The signal of this name that protects the message, if it is there and fit for it.
fn protection(
    message: &Message,
    name: &str,
    problems: &mut Vec<PublishProblem>,
    unfit: impl Fn(&Codec) -> Option<&'static str>,
) -> Option<Codec> {
    let signal = message.signal(name)?;
    let codec = signal.codec();
    if let Some(reason) = unfit(&codec) {
        problems.push(PublishProblem::Signal {
            place: format!("{}:{}", message.file, signal.line),
            signal: format!("{}.{name}", message.name),
            reason: reason.to_owned(),
        });
    }
    Some(codec)
}

/// The byte that a checksum fills; `None` if it is not exactly one.
fn crc_byte(codec: &Codec) -> Option<usize> {
    let mut probe = [0; 64];
    let whole = codec.extractor.size() == 8 && codec.extractor.set(&mut probe, 0xFF);
    let byte = probe.iter().position(|byte| *byte == 0xFF);
    byte.filter(|_| whole)
}
