//! What can be wrong, as the bit field that the CSV carries. On the bus its lower 16 bits are `GRIP_STATUS.Faults`, those
//! above them `GRIP_STATUS_2.Faults`.

use bitflags::bitflags;

bitflags! {
    /// Faults seen since the last published status. Bit numbers are part of the published interface.
    #[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
    pub struct Faults: u32 {
        /// A configured quantity is older than its time-out.
        const TIMEOUT = 1 << 0;
        /// A value came as not available, or its quality bit denied it.
        const NOT_AVAILABLE = 1 << 1;
        /// A value is outside what the quantity can be.
        const RANGE = 1 << 2;
        /// A value changed faster than the quantity can.
        const RATE = 1 << 3;
        /// A value has not moved while others show that it must.
        const STUCK = 1 << 4;
        /// A checksum did not match; the frame was dropped.
        const CHECKSUM = 1 << 5;
        /// A message counter stood still or jumped.
        const COUNTER = 1 << 6;
        /// A needed identifier came with the wrong length or kind; the frame was dropped.
        const FRAME = 1 << 7;
        /// Frame time ran backwards or made a gap.
        const TIME = 1 << 8;
        /// One wheel's speed contradicts the others'.
        const WHEEL_MISMATCH = 1 << 9;
        /// Yaw rate, steering, wheel speeds and lateral acceleration contradict each other.
        const MOTION_MISMATCH = 1 << 10;
        /// The interface is down or gone.
        const BUS_DOWN = 1 << 11;
        /// The controller reported errors (error frames, bus-off).
        const BUS_ERROR = 1 << 12;
        /// The kernel or an own queue dropped frames.
        const DROPPED = 1 << 13;
        /// An estimator's innovations contradict its own uncertainty.
        const INCONSISTENT = 1 << 14;
        /// A reload was refused, or the saved state was not usable; the last good one is in use.
        const CONFIG = 1 << 15;
        /// Somebody else sends frames with an identifier that we publish on.
        const FOREIGN_SENDER = 1 << 16;
        /// A needed identifier comes much more often than it should: somebody else sends it, too.
        const SENT_TWICE = 1 << 17;
        /// The service ends: nothing follows.
        const ENDING = 1 << 18;
    }
}

impl Faults {
    /// How many bits there are.
    pub const COUNT: usize = 19;

    /// Names of the bits that are set, in bit order, lower case as in `--stats`.
    pub fn names(self) -> impl Iterator<Item = String> {
        self.iter_names().map(|(name, _)| name.to_ascii_lowercase())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_bits_are_those_below_their_count() {
        assert_eq!(Faults::all().bits(), (1 << Faults::COUNT) - 1);
        assert_eq!(Faults::all().names().count(), Faults::COUNT);
    }
}
