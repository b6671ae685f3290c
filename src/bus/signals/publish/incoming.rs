//! The way back: a published message as whoever receives it checks and reads it.

use super::Publisher;
use super::e2e;
use super::fields::{MESSAGES, MessageFields, Source};
use super::slot::NOT_AVAILABLE;
use crate::can::{CanId, Frame, FrameKind};
use crate::dbc::{Codec, Database, Message, Signal};

/// One published message, ready to be received.
#[derive(Clone, Debug)]
pub struct Incoming {
    name: &'static str,
    id: CanId,
    /// Bytes that the DBC knows, which the checksum covers.
    length: usize,
    is_fd: bool,
    signals: Vec<Readable>,
    counter: Option<Codec>,
    /// The byte of the checksum.
    crc: Option<usize>,
}

#[derive(Clone, Debug)]
struct Readable {
    name: &'static str,
    signal: Signal,
    /// From SI to the DBC's unit.
    factor: f64,
    not_available: Option<u64>,
}

/// Why a frame is not believed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Refused {
    /// It is a remote request, too short, or FD where it should not be (or the other way round).
    Shape,
    /// Its checksum is another one.
    Checksum,
}

impl Publisher {
    /// The messages that it sends, for a receiver of them. `database` is the one that it was made with.
    pub fn incoming(&self, database: &Database) -> Vec<Incoming> {
        let pair = |compiled: &super::Compiled| {
            let message = database.message(compiled.name)?;
            let fields = MESSAGES.iter().find(|fields| fields.name == compiled.name)?;
            Some(Incoming {
                name: compiled.name,
                id: compiled.id,
                length: compiled.protected,
                is_fd: matches!(compiled.kind, FrameKind::Fd { .. }),
                signals: readable(message, fields),
                counter: compiled.counter_codec,
                crc: compiled.crc,
            })
        };
        self.messages.iter().filter_map(pair).collect()
    }
}

fn readable(message: &Message, fields: &MessageFields) -> Vec<Readable> {
    let pair = |field: &super::fields::Field| {
        let signal = message.signal(field.name)?.clone();
        let factor = match field.source {
            Source::Number(_) | Source::Age(_) => field.quantity.factor_to(&signal.unit)?,
            Source::Count(_) | Source::Flag(..) | Source::Choice(..) | Source::Bits(_) => 1.0,
        };
        let not_available = signal.value_named(NOT_AVAILABLE);
        Some(Readable { name: field.name, signal, factor, not_available })
    };
    fields.fields.iter().filter_map(pair).collect()
}

impl Incoming {
    /// The message's name.
    pub fn name(&self) -> &'static str {
        self.name
    }

    /// The identifier that it comes with.
    pub fn id(&self) -> CanId {
        self.id
    }

    /// Its counter, if it has one and the frame is sound.
    ///
    /// # Errors
    /// If the frame must not be believed.
    pub fn check(&self, frame: &Frame) -> Result<Option<u8>, Refused> {
        let data = frame.data();
        if !frame.is_data() || frame.is_fd() != self.is_fd || data.len() < self.length {
            return Err(Refused::Shape);
        }
        if let Some(byte) = self.crc {
            let covered = data.get(..self.length).ok_or(Refused::Shape)?;
            let right = e2e::profile_1_crc(self.id.number() as u16, covered, byte);
            if data.get(byte) != Some(&right) {
                return Err(Refused::Checksum);
            }
        }
        Ok(self.counter.and_then(|codec| codec.bits(data)).map(|bits| bits as u8))
    }

    /// A number, in SI; `None` where it is not available, or the message has no such signal.
    pub fn number(&self, frame: &Frame, signal: &str) -> Option<f64> {
        let Readable { signal, factor, not_available, .. } = self.find(signal)?;
        let bits = signal.bits(frame.data())?;
        let value = signal.physical(bits) / factor;
        (Some(bits) != *not_available && value.is_finite()).then_some(value)
    }

    /// What the value table calls it; `None` where it has no name for it.
    pub fn word(&self, frame: &Frame, signal: &str) -> Option<&str> {
        let signal = &self.find(signal)?.signal;
        signal.value_name(signal.bits(frame.data())?)
    }

    fn find(&self, name: &str) -> Option<&Readable> {
        self.signals.iter().find(|readable| readable.name == name)
    }
}

#[cfg(test)]
mod tests {
    use super::super::{PublishConfig, built_in_database};
    use super::*;
    use physics::estimates::{Friction, MuSource};
    use physics::{Estimates, Micros};

    fn published(estimates: &Estimates) -> (Vec<Incoming>, Vec<Frame>) {
        let database = built_in_database().unwrap();
        let mut publisher = Publisher::new(&database, &PublishConfig::default()).unwrap();
        let mut frames = Vec::new();
        publisher.publish(Micros(0), estimates, &mut |frame| frames.push(*frame));
        (publisher.incoming(&database), frames)
    }

    #[test]
    fn what_was_sent_is_read() {
        let friction =
            Friction { max: Some(0.5), low: Some(0.4), source: MuSource::Brush, ..Friction::default() };
        let (messages, frames) =
            published(&Estimates { friction, excitation_long: 0.25, ..Estimates::default() });
        assert_eq!(messages.len(), frames.len());
        for (message, frame) in messages.iter().zip(&frames) {
            assert_eq!((message.id(), message.check(frame)), (frame.id, Ok(Some(0))));
        }
        let (friction, status) = (&messages[0], &messages[5]);
        assert_eq!(friction.number(&frames[0], "MuMax"), Some(0.5));
        assert_eq!(friction.number(&frames[0], "MuMaxHigh"), None, "not available");
        assert_eq!(friction.word(&frames[0], "MuSource"), Some("brush"));
        assert_eq!(friction.number(&frames[0], "Nothing"), None);
        // Sent as 25 %.
        assert_eq!(status.number(&frames[5], "ExcitationLong"), Some(0.25));
    }

    #[test]
    fn what_is_not_sound_is_refused() {
        let (messages, frames) = published(&Estimates::default());
        let friction = &messages[0];
        let mut data = frames[0].data().to_vec();
        data[3] ^= 1;
        let of = |data: &[u8]| Frame::data_frame(Micros(0), friction.id(), data).unwrap();
        assert_eq!(friction.check(&of(&data)), Err(Refused::Checksum));
        assert_eq!(friction.check(&of(&data[..7])), Err(Refused::Shape));
        let remote = Frame::remote(Micros(0), friction.id(), 8).unwrap();
        assert_eq!(friction.check(&remote), Err(Refused::Shape));
        let fd = FrameKind::Fd { bit_rate_switch: false, error_state: false };
        let fd = Frame::new(Micros(0), friction.id(), fd, frames[0].data()).unwrap();
        assert_eq!(friction.check(&fd), Err(Refused::Shape));
    }
}
