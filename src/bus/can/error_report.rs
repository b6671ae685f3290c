//! What an error frame says, in words. Layout: `linux/can/error.h`.

use std::fmt;

use bitflags::bitflags;

use super::{Frame, FrameKind};
use physics::Micros;

bitflags! {
    /// What the error frame is about; several can come at once.
    #[derive(Clone, Copy, Debug, PartialEq, Eq)]
    pub struct ErrorClass: u32 {
        /// Sending timed out.
        const TX_TIMEOUT = 0x001;
        /// Another node's frame had priority.
        const LOST_ARBITRATION = 0x002;
        /// The controller's state changed, or it lost frames.
        const CONTROLLER = 0x004;
        /// The protocol was violated on the bus.
        const PROTOCOL = 0x008;
        /// The transceiver's wires.
        const TRANSCEIVER = 0x010;
        /// No node acknowledged.
        const NO_ACK = 0x020;
        /// The controller left the bus after too many errors.
        const BUS_OFF = 0x040;
        /// A bus error (many controllers send one per bad frame).
        const BUS_ERROR = 0x080;
        /// The controller is back after having been off.
        const RESTARTED = 0x100;
        /// The error counters are filled in.
        const COUNTERS = 0x200;
        const _ = !0;
    }
}

/// Fault confinement state of the controller, ISO 11898-1.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum BusState {
    /// Takes part normally.
    Active,
    /// An error counter has passed 96.
    Warning,
    /// An error counter has passed 127: it must not disturb others any more.
    Passive,
    /// The transmit counter has passed 255: neither sends nor receives.
    Off,
}

/// An error frame, taken apart.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ErrorReport {
    /// When it came.
    pub time: Micros,
    /// What it is about.
    pub class: ErrorClass,
    /// The details, whose meaning depends on the class.
    pub data: [u8; 8],
}

/// Names of the bits of the controller byte, from the lowest.
const CONTROLLER: [&str; 7] = [
    "receive overflow",
    "transmit overflow",
    "receive warning",
    "transmit warning",
    "receive passive",
    "transmit passive",
    "error active again",
];
const PROTOCOL: [&str; 8] = [
    "bit error",
    "form error",
    "stuff error",
    "dominant bit not sent",
    "recessive bit not sent",
    "overload",
    "error active",
    "while sending",
];

impl ErrorReport {
    /// Takes an error frame apart; `None` for any other frame.
    pub fn from_frame(frame: &Frame) -> Option<Self> {
        if frame.kind != FrameKind::Error {
            return None;
        }
        let mut data = [0; 8];
        for (to, from) in data.iter_mut().zip(frame.data()) {
            *to = *from;
        }
        Some(Self { time: frame.time, class: ErrorClass::from_bits_retain(frame.id.number()), data })
    }

    /// The controller's state, if the frame tells of a change.
    pub fn bus_state(&self) -> Option<BusState> {
        if self.class.contains(ErrorClass::BUS_OFF) {
            return Some(BusState::Off);
        }
        if self.class.contains(ErrorClass::RESTARTED) {
            return Some(BusState::Active);
        }
        if !self.class.contains(ErrorClass::CONTROLLER) {
            return None;
        }
        match self.data[1] {
            bits if bits & 0x30 != 0 => Some(BusState::Passive),
            bits if bits & 0x0C != 0 => Some(BusState::Warning),
            bits if bits & 0x40 != 0 => Some(BusState::Active),
            _ => None,
        }
    }

    /// Transmit and receive error counter of the controller, where it gives them.
    pub fn counters(&self) -> Option<(u8, u8)> {
        // Older drivers fill them in without the mark.
        let given = self.class.contains(ErrorClass::COUNTERS) || self.data[6] != 0 || self.data[7] != 0;
        given.then_some((self.data[6], self.data[7]))
    }
}

impl fmt::Display for ErrorReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mut separator = "";
        for class in self.class.iter() {
            if class == ErrorClass::COUNTERS {
                continue;
            }
            f.write_str(separator)?;
            separator = "; ";
            match class {
                ErrorClass::TX_TIMEOUT => f.write_str("transmission timed out")?,
                ErrorClass::LOST_ARBITRATION => match self.data[0] {
                    0 => f.write_str("arbitration lost")?,
                    bit => write!(f, "arbitration lost at bit {bit}")?,
                },
                ErrorClass::CONTROLLER => list(f, "controller", self.data[1], &CONTROLLER)?,
                ErrorClass::PROTOCOL => list(f, "protocol violation", self.data[2], &PROTOCOL)?,
                ErrorClass::TRANSCEIVER => write!(f, "transceiver: {}", wires(self.data[4]))?,
                ErrorClass::NO_ACK => f.write_str("no acknowledgement: is any other node there?")?,
                ErrorClass::BUS_OFF => f.write_str("bus off")?,
                ErrorClass::BUS_ERROR => f.write_str("bus error")?,
                ErrorClass::RESTARTED => f.write_str("restarted after bus off")?,
                unknown => write!(f, "unknown error class {:#X}", unknown.bits())?,
            }
        }
        if separator.is_empty() {
            f.write_str("error without a class")?;
        }
        match self.counters() {
            Some((transmit, receive)) => {
                write!(f, " (error counters: transmit {transmit}, receive {receive})")
            }
            None => Ok(()),
        }
    }
}

/// `title: the names of the bits that are set`.
fn list(f: &mut fmt::Formatter<'_>, title: &str, bits: u8, names: &[&str]) -> fmt::Result {
    f.write_str(title)?;
    let mut separator = ": ";
    for (place, name) in names.iter().enumerate() {
        if bits & (1 << place) != 0 {
            write!(f, "{separator}{name}")?;
            separator = ", ";
        }
    }
    Ok(())
}

fn wires(code: u8) -> &'static str {
    match code {
        0x04 => "CAN high: no wire",
        0x05 => "CAN high: short to battery",
        0x06 => "CAN high: short to supply",
        0x07 => "CAN high: short to ground",
        0x40 => "CAN low: no wire",
        0x50 => "CAN low: short to battery",
        0x60 => "CAN low: short to supply",
        0x70 => "CAN low: short to ground",
        0x80 => "CAN low: short to CAN high",
        _ => "unspecified",
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::can::CanId;

    fn report(class: u32, data: [u8; 8]) -> ErrorReport {
        let id = CanId::extended(class).unwrap();
        ErrorReport::from_frame(&Frame::new(Micros(1), id, FrameKind::Error, &data).unwrap()).unwrap()
    }

    #[test]
    fn states_are_told_apart() {
        assert_eq!(report(0x40, [0; 8]).bus_state(), Some(BusState::Off));
        assert_eq!(report(0x100, [0; 8]).bus_state(), Some(BusState::Active));
        assert_eq!(report(0x4, [0, 0x20, 0, 0, 0, 0, 0, 0]).bus_state(), Some(BusState::Passive));
        assert_eq!(report(0x4, [0, 0x04, 0, 0, 0, 0, 0, 0]).bus_state(), Some(BusState::Warning));
        assert_eq!(report(0x20, [0; 8]).bus_state(), None);
    }

    #[test]
    fn reads_as_a_sentence() {
        let text = report(0x224, [0, 0x10, 0, 0, 0, 0, 12, 135]).to_string();
        let expected = "controller: receive passive; no acknowledgement: is any other node there? \
                        (error counters: transmit 12, receive 135)";
        assert_eq!(text, expected);
        assert_eq!(report(0, [0; 8]).to_string(), "error without a class");
        assert_eq!(report(0x1000, [0; 8]).to_string(), "unknown error class 0x1000");
    }

    #[test]
    fn other_frames_are_no_reports() {
        let frame = Frame::data_frame(Micros(0), CanId::standard(0x40).unwrap(), &[]).unwrap();
        assert_eq!(ErrorReport::from_frame(&frame), None);
    }
}
