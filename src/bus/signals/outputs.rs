//! From values to frames through the same mapping: what a simulated car sends.

use super::compile::Compiler;
use super::config::SignalsConfig;
use super::error::{Problems, SignalsError};
use super::mapping::MessageInput;
use crate::can::{Frame, FrameKind, Payload};
use crate::dbc::Database;
use physics::{Micros, Quantity, Sample};

/// The inverse of [`super::Inputs`]: puts quantities into the frames that the mapping takes them from,
/// each message with its own period and phase, counters counting and checksums right.
#[derive(Clone, Debug)]
pub struct Outputs {
    messages: Vec<Sender>,
}

#[derive(Clone, Debug)]
struct Sender {
    message: MessageInput,
    period: Micros,
    phase: Micros,
    /// Time of the last frame, or the call before the first one.
    last: Option<Micros>,
    counter: u64,
}

impl Outputs {
    /// A period that suits chassis messages.
    const PERIOD: Micros = Micros::from_millis(10);

    /// Compiles the mapping for sending. Every message is sent each 10 ms until
    /// [`Outputs::set_period`] says otherwise.
    ///
    /// # Errors
    /// All that is wrong with the mapping. Other than for [`super::Inputs`], no quantity is required.
    pub fn compile(
        config: &SignalsConfig,
        database: &Database,
        wheel_radius_m: f64,
    ) -> Result<Self, SignalsError> {
        let mut compiler = Compiler::new(database, wheel_radius_m, Problems::default());
        let messages = compiler.messages(config);
        for message in &messages {
            if conflict(message) {
                compiler.problems.add(
                    format!(
                        "signals.{}",
                        message.mappings.first().map_or("", |mapping| mapping.quantity.name())
                    ),
                    format!(
                        "{}: quantities of one frame need different multiplexer values; that cannot be sent",
                        message.name
                    ),
                );
            }
        }
        compiler.problems.finish()?;
        let sender =
            |message| Sender { message, period: Self::PERIOD, phase: Micros(0), last: None, counter: 0 };
        Ok(Self { messages: messages.into_iter().map(sender).collect() })
    }

    /// Names of the messages, by identifier.
    pub fn messages(&self) -> impl Iterator<Item = &str> {
        self.messages.iter().map(|sender| sender.message.name.as_str())
    }

    /// Is the quantity in one of the messages?
    pub fn has(&self, quantity: Quantity) -> bool {
        self.messages.iter().flat_map(|sender| &sender.message.mappings).any(|m| m.quantity == quantity)
    }

    /// Sends a message at multiples of `period` plus `phase`. Returns whether there is such a message.
    pub fn set_period(&mut self, message: &str, period: Micros, phase: Micros) -> bool {
        match self.messages.iter_mut().find(|sender| sender.message.name == message) {
            Some(sender) => {
                sender.period = Micros(period.0.max(1));
                sender.phase = Micros(phase.0.rem_euclid(sender.period.0));
                true
            }
            None => false,
        }
    }

    /// Emits the frames that are due at the values' time, in the order of their identifiers; each bears
    /// the time at which it was due.
    ///
    /// Call it with time increasing, at least once per period of any message: of several times of sending
    /// that have passed, only the last is served.
    /// A quantity without a value goes out as not available; where the message has no way to say so, the
    /// message is not sent.
    pub fn send(&mut self, values: &Sample, emit: &mut impl FnMut(&Frame)) {
        for sender in &mut self.messages {
            if let Some(frame) = sender.frame(values) {
                emit(&frame);
            }
        }
    }
}

impl Outputs {
    /// Emits now, whatever their periods, the messages that carry any of these quantities: for a
    /// source that has its own times.
    pub fn send_updated(&mut self, updated: &[Quantity], values: &Sample, emit: &mut impl FnMut(&Frame)) {
        for sender in &mut self.messages {
            let carries = |quantity| sender.message.mappings.iter().any(|m| m.quantity == quantity);
            if updated.iter().any(|quantity| carries(*quantity))
                && let Some(frame) = sender.make(values.time, values)
            {
                emit(&frame);
            }
        }
    }
}

impl Sender {
    /// The frame that is due, if one is.
    fn frame(&mut self, values: &Sample) -> Option<Frame> {
        let time = self.last_due(values.time);
        let before = self.last.replace(time);
        if before.map_or(time != values.time, |before| time <= before) {
            return None;
        }
        self.make(time, values)
    }

    /// The newest time of sending that is not in the future.
    fn last_due(&self, now: Micros) -> Micros {
        Micros(now.0.saturating_sub((now - self.phase).0.rem_euclid(self.period.0)))
    }

    fn make(&mut self, time: Micros, values: &Sample) -> Option<Frame> {
        let mut payload: Payload = [0; 64];
        let data = &mut payload[..self.message.length];
        for mapping in &self.message.mappings {
            if !mapping.write(data, values.get(mapping.quantity)) {
                return None;
            }
        }
        for gate in &self.message.gates {
            gate.quality.write(data, values.get(gate.quantity).is_some());
        }
        if let Some(counter) = &self.message.counter {
            counter.write(data, self.counter);
            self.counter = counter.next(self.counter);
        }
        if let Some(checksum) = &self.message.checksum {
            checksum.write(data);
        }
        let kind = if self.message.is_fd || self.message.length > 8 {
            FrameKind::Fd { bit_rate_switch: true, error_state: false }
        } else {
            FrameKind::Data
        };
        // The DBC allows no length that the kind cannot carry, but for FD lengths between two codes.
        let length = (self.message.length..=64)
            .find(|length| Frame::new(time, self.message.id, kind, &payload[..*length]).is_ok())?;
        Frame::new(time, self.message.id, kind, &payload[..length]).ok()
    }
}

/// Does writing one quantity switch another out of the frame?
fn conflict(message: &MessageInput) -> bool {
    let mut payload: Payload = [0; 64];
    let data = &mut payload[..message.length];
    for mapping in &message.mappings {
        mapping.write(data, Some(0.0));
    }
    message.mappings.iter().flat_map(|mapping| &mapping.parts).any(|part| !part.mux.is_active(data))
}
