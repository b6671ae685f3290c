//! The kernel's frame layouts, `struct can_frame` and `struct canfd_frame` of `linux/can.h`.
//!
//! ```text
//! classic, 16 bytes:  id (4, native order)  length  –      –  raw length code  data (8)
//! FD,      72 bytes:  id (4, native order)  length  flags  –  –                data (64)
//! ```

use super::{CanId, Frame, FrameKind};
use physics::Micros;

/// Size of a classic frame.
pub(super) const CLASSIC: usize = 16;
/// Size of an FD frame.
pub(super) const FD: usize = 72;
const DATA: usize = 8;

/// Marks in the upper bits of the identifier.
pub(super) const EXTENDED: u32 = 1 << 31;
pub(super) const REMOTE: u32 = 1 << 30;
pub(super) const ERROR: u32 = 1 << 29;

/// Flags of an FD frame. The third is the kernel's mark of every FD frame, and candump prints it.
const BIT_RATE_SWITCH: u8 = 1;
const ERROR_STATE: u8 = 2;
const FD_FORMAT: u8 = 4;

/// The kind of an FD frame with these flags; other flags mean nothing to us.
#[inline]
pub(super) fn fd_kind(flags: u8) -> FrameKind {
    FrameKind::Fd { bit_rate_switch: flags & BIT_RATE_SWITCH != 0, error_state: flags & ERROR_STATE != 0 }
}

/// The flags of an FD frame; `None` for any other kind.
#[inline]
pub(super) fn fd_flags(kind: FrameKind) -> Option<u8> {
    let FrameKind::Fd { bit_rate_switch, error_state } = kind else { return None };
    let mark = |set, flag| if set { flag } else { 0 };
    Some(FD_FORMAT | mark(bit_rate_switch, BIT_RATE_SWITCH) | mark(error_state, ERROR_STATE))
}

/// The identifier as the kernel wants it, with its mark but without the frame's kind.
pub(super) fn kernel_id(id: CanId) -> u32 {
    if id.is_extended() { id.number() | EXTENDED } else { id.number() }
}

/// A frame from the kernel's bytes, whose number tells the layout; `None` if that is no frame that
/// can exist on a bus (virtual buses let one send an FD frame of 9 bytes).
pub(super) fn decode(bytes: &[u8], time: Micros) -> Option<Frame> {
    let is_fd = match bytes.len() {
        CLASSIC => false,
        FD => true,
        _ => return None,
    };
    let [a, b, c, d, length, flags, ..] = *bytes else { return None };
    let marked = u32::from_ne_bytes([a, b, c, d]);
    let length = usize::from(length);
    if marked & ERROR != 0 {
        let class = CanId::extended(marked & CanId::MAX_EXTENDED)?;
        return Frame::new(time, class, FrameKind::Error, bytes.get(DATA..DATA + length)?).ok();
    }
    let id = if marked & EXTENDED != 0 {
        CanId::extended(marked & CanId::MAX_EXTENDED)?
    } else {
        CanId::standard(marked & CanId::MAX_STANDARD)?
    };
    if marked & REMOTE != 0 && !is_fd {
        return Frame::remote(time, id, length).ok();
    }
    let kind = if is_fd { fd_kind(flags) } else { FrameKind::Data };
    Frame::new(time, id, kind, bytes.get(DATA..DATA + length)?).ok()
}

/// The kernel's bytes of a frame: the first so many of the array.
pub(super) fn encode(frame: &Frame) -> ([u8; FD], usize) {
    let mut bytes = [0; FD];
    let mark = match frame.kind {
        FrameKind::Remote => REMOTE,
        FrameKind::Error => ERROR,
        FrameKind::Data | FrameKind::Fd { .. } => 0,
    };
    // Of an error frame the number is its class; it has no identifier to be extended.
    let id = if frame.kind == FrameKind::Error { frame.id.number() } else { kernel_id(frame.id) };
    bytes[..4].copy_from_slice(&(id | mark).to_ne_bytes());
    bytes[4] = frame.length() as u8;
    bytes[DATA..DATA + frame.data().len()].copy_from_slice(frame.data());
    match fd_flags(frame.kind) {
        Some(flags) => {
            bytes[5] = flags;
            (bytes, FD)
        }
        None => (bytes, CLASSIC),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_kind_survives_the_way_through_the_kernel() {
        let (standard, extended) = (CanId::standard(0x123).unwrap(), CanId::extended(0x123).unwrap());
        let fd = FrameKind::Fd { bit_rate_switch: true, error_state: false };
        for frame in [
            Frame::data_frame(Micros(5), standard, &[1, 2, 3]).unwrap(),
            Frame::data_frame(Micros(5), extended, &[]).unwrap(),
            Frame::remote(Micros(5), extended, 8).unwrap(),
            Frame::new(Micros(5), standard, fd, &[9; 64]).unwrap(),
            Frame::new(Micros(5), CanId::extended(0x40).unwrap(), FrameKind::Error, &[0; 8]).unwrap(),
        ] {
            let (bytes, size) = encode(&frame);
            assert_eq!(decode(&bytes[..size], Micros(5)), Some(frame));
        }
    }

    #[test]
    fn what_cannot_be_on_a_bus_is_no_frame() {
        let mut bytes = [0; FD];
        bytes[4] = 9;
        assert_eq!(decode(&bytes, Micros(0)), None, "FD has no length 9");
        bytes[4] = 200;
        assert_eq!(decode(&bytes, Micros(0)), None, "longer than the layout");
        assert_eq!(decode(&bytes[..CLASSIC], Micros(0)), None);
        assert_eq!(decode(&bytes[..20], Micros(0)), None, "no layout of that size");
    }
}
