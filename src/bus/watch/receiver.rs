//! The published frames as a receiver takes them: checked, timed, and forgotten when they grow old.

use super::{Round, Traffic};
use crate::can::{CanId, Frame, FrameKind};
use crate::dbc::Database;
use crate::signals::e2e;
use crate::signals::publish::{Incoming, Publisher, Refused};
use physics::{Faults, Micros};

/// What can be said of a message at the moment.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Word {
    /// It has never come.
    Never,
    /// It comes as it should; so old is the newest.
    Fresh(Micros),
    /// Nothing has come for too long.
    Stale(Micros),
}

/// One message, and how it has come so far.
#[derive(Clone, Debug)]
pub struct Heard {
    message: Incoming,
    traffic: Traffic,
    /// The newest frame that was believed.
    newest: Option<Frame>,
    counter: Option<u8>,
    /// Frames whose checksum was wrong.
    pub crc_errors: u64,
    /// Sound frames whose counter stood still or jumped: something was repeated or lost.
    pub counter_errors: u64,
    /// Remote requests, and frames of another length or kind.
    pub misshapen: u64,
}

/// Receives what a publisher of the same configuration sends.
#[derive(Clone, Debug)]
pub struct Receiver {
    messages: Vec<Heard>,
    stale_after: Micros,
    /// Told since they were asked for.
    faults: Faults,
}

impl Receiver {
    /// So long nothing is stale, however often it should come, and an input's sample is one of this moment.
    pub const PATIENCE: Micros = Micros(250_000);
    /// A message is stale after so many periods without one.
    const PERIODS: i64 = 5;

    /// For the messages of this publisher, made with this database.
    pub fn new(publisher: &Publisher, database: &Database) -> Self {
        let heard = |message: Incoming| Heard {
            traffic: Traffic::new(message.name(), message.id()),
            message,
            newest: None,
            counter: None,
            crc_errors: 0,
            counter_errors: 0,
            misshapen: 0,
        };
        let stale_after = Micros(publisher.period().0.saturating_mul(Self::PERIODS)).max(Self::PATIENCE);
        let messages = publisher.incoming(database).into_iter().map(heard).collect();
        Self { messages, stale_after, faults: Faults::empty() }
    }

    /// Identifiers that it knows.
    pub fn ids(&self) -> impl Iterator<Item = CanId> + '_ {
        self.messages.iter().map(|heard| heard.message.id())
    }

    /// Each message, in the order they are sent.
    pub fn messages(&self) -> &[Heard] {
        &self.messages
    }

    /// Takes a frame, if it is one of these messages; believes it if it is sound.
    pub fn take(&mut self, frame: &Frame) -> bool {
        let Some(heard) = self.messages.iter_mut().find(|heard| heard.message.id() == frame.id) else {
            return false;
        };
        if frame.kind == FrameKind::Error {
            return false;
        }
        heard.traffic.count(frame.time);
        match heard.message.check(frame) {
            Err(Refused::Checksum) => heard.crc_errors += 1,
            Err(Refused::Shape) => heard.misshapen += 1,
            Ok(counter) => {
                // After a silence a sender may have begun anew: its counter tells nothing then.
                let follows = heard.newest.is_some_and(|before| frame.time - before.time <= self.stale_after);
                if let (true, Some(before), Some(now)) = (follows, heard.counter, counter)
                    && now != e2e::next_counter(before)
                {
                    heard.counter_errors += 1;
                }
                heard.counter = counter;
                heard.newest = Some(*frame);
                let mut status = Round::at(0.0);
                if heard.message.name().starts_with("GRIP_STATUS") {
                    status.read(&heard.message, frame);
                }
                self.faults |= status.faults;
            }
        }
        true
    }

    /// Faults that were told since this was asked last.
    pub fn take_faults(&mut self) -> Faults {
        std::mem::take(&mut self.faults)
    }

    /// How it is with a message.
    pub fn word(&self, heard: &Heard, now: Micros) -> Word {
        match heard.newest.map(|frame| (now - frame.time).max(Micros(0))) {
            None => Word::Never,
            Some(age) if age <= self.stale_after => Word::Fresh(age),
            Some(age) => Word::Stale(age),
        }
    }

    /// The same, of the message with this name; [`Word::Never`] also if it is not published at all.
    pub fn word_of(&self, name: &str, now: Micros) -> Word {
        let heard = self.messages.iter().find(|heard| heard.message.name() == name);
        heard.map_or(Word::Never, |heard| self.word(heard, now))
    }

    /// Has nothing come lately?
    pub fn is_silent(&self, now: Micros) -> bool {
        !self.messages.iter().any(|heard| matches!(self.word(heard, now), Word::Fresh(_)))
    }

    /// Has nothing ever come?
    pub fn is_unheard(&self) -> bool {
        self.messages.iter().all(|heard| heard.newest.is_none())
    }

    /// What is known now: nothing of what is stale.
    pub fn current(&self, now: Micros) -> Round {
        self.round(|heard| matches!(self.word(heard, now), Word::Fresh(_)))
    }

    /// What was said last, however long ago.
    pub fn last(&self) -> Round {
        self.round(|_| true)
    }

    fn round(&self, of: impl Fn(&Heard) -> bool) -> Round {
        let frames = || self.messages.iter().filter(|heard| of(heard));
        let newest = frames().filter_map(|heard| heard.newest).map(|frame| frame.time).max();
        let mut round = Round::at(newest.map_or(f64::NAN, Micros::seconds));
        for heard in frames() {
            if let Some(frame) = &heard.newest {
                round.read(&heard.message, frame);
            }
        }
        round
    }
}

impl Heard {
    /// The name that gripd gives the message.
    pub fn name(&self) -> &'static str {
        self.message.name()
    }

    /// Name, identifier, count and rate, frames that were not believed included.
    pub fn traffic(&self) -> &Traffic {
        &self.traffic
    }
}
