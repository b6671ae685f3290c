//! The faults of the list: what each does to a drive, and what is to be told of it.

pub mod content;
pub mod frame;
pub mod sensor;
pub mod timing;

use gripd::can::Frame;
use gripd::model::Reading;
use gripd::{Faults, Micros};

/// When the fault begins and when it is over, s.
pub const FROM: f64 = 10.0;
pub const UNTIL: f64 = 15.0;

pub struct Case {
    pub name: &'static str,
    pub fault: Fault,
    /// When it is over, s.
    pub until: f64,
    /// All that is told of it.
    pub told: Faults,
    /// The longest that it may take until it is told, and afterwards until all is well again, s.
    pub within: (f64, f64),
    /// What may be flagged valid and yet be far from what it is without the fault.
    pub weak: &'static [&'static str],
}

impl Case {
    /// Told at once, over at once, and nothing wrong is valid.
    pub const PLAIN: Self = Self {
        name: "",
        fault: Fault::Frames(|frames| frames),
        until: UNTIL,
        told: Faults::empty(),
        within: (0.05, 0.1),
        weak: &[],
    };
}

/// Where it comes in.
pub enum Fault {
    /// Into what the sensors say.
    Sensors(fn(&mut Vec<Reading>)),
    /// Onto the bus.
    Frames(fn(Vec<Frame>) -> Vec<Frame>),
}

/// Is it while the fault lasts?
pub fn meanwhile(time: Micros) -> bool {
    (FROM..UNTIL).contains(&time.seconds())
}

/// The same at another time.
pub fn at(frame: &Frame, time: Micros) -> Frame {
    let mut moved = *frame;
    moved.time = time;
    moved
}
