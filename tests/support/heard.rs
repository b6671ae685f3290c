//! What another node hears of the service: its frames, taken apart.

use std::collections::BTreeMap;
use std::sync::OnceLock;

use gripd::can::Frame;
use gripd::dbc::Database;
use gripd::service::Sink;
use gripd::signals::{e2e, publish};
use gripd::{Estimates, Faults, Sample};

/// Everything that an engine hands on.
#[derive(Default)]
pub struct Heard {
    pub samples: Vec<Sample>,
    pub estimates: Vec<Estimates>,
    pub frames: Vec<Frame>,
}

impl Sink for Heard {
    fn estimates(&mut self, sample: &Sample, estimates: &Estimates) {
        self.samples.push(*sample);
        self.estimates.push(*estimates);
    }

    fn publish(&mut self, frame: &Frame) {
        self.frames.push(*frame);
    }
}

fn layout() -> &'static Database {
    static LAYOUT: OnceLock<Database> = OnceLock::new();
    LAYOUT.get_or_init(|| publish::built_in_database().unwrap())
}

/// The bits of a signal of a published frame.
pub fn bits(frame: &Frame, signal: &str) -> u64 {
    let message = layout().messages().iter().find(|message| message.id == frame.id).unwrap();
    message.signal(signal).unwrap().bits(frame.data()).unwrap()
}

/// Does it say that it has no value for a signal?
pub fn is_not_available(frame: &Frame, signal: &str) -> bool {
    let message = layout().messages().iter().find(|message| message.id == frame.id).unwrap();
    let signal = message.signal(signal).unwrap();
    signal.bits(frame.data()) == signal.value_named("not_available")
}

/// The frames of one message.
pub fn of<'a>(frames: &'a [Frame], message: &str) -> impl Iterator<Item = &'a Frame> {
    let id = layout().message(message).unwrap().id;
    frames.iter().filter(move |frame| frame.id == id)
}

/// The faults that each status frame tells.
pub fn faults(frames: &[Frame]) -> Vec<Faults> {
    let status = of(frames, "GRIP_STATUS");
    status.map(|frame| Faults::from_bits_retain(bits(frame, "Faults") as u32)).collect()
}

/// What every receiver checks: each message's counter counts, and each checksum is right.
#[track_caller]
pub fn protected(frames: &[Frame]) {
    let mut counters = BTreeMap::new();
    for frame in frames {
        let crc = e2e::profile_1_crc(frame.id.number() as u16, frame.data(), 0);
        assert_eq!(bits(frame, "Crc"), u64::from(crc), "{frame:?}");
        let counter = bits(frame, "Counter") as u8;
        if let Some(before) = counters.insert(frame.id, counter) {
            assert_eq!(counter, e2e::next_counter(before), "{frame:?}");
        }
    }
}
