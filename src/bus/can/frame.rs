//! One CAN frame: classic or FD, data, remote or error.

use std::fmt;

use thiserror::Error;

use physics::Micros;

/// A CAN identifier; standard and extended ones with the same number are different identifiers.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct CanId(u32);

impl CanId {
    /// Bit 31 marks an extended identifier, as in SocketCAN and in DBC files.
    const EXTENDED: u32 = 1 << 31;
    /// Largest standard (11-bit) identifier.
    pub const MAX_STANDARD: u32 = 0x7FF;
    /// Largest extended (29-bit) identifier.
    pub const MAX_EXTENDED: u32 = 0x1FFF_FFFF;

    /// A standard identifier; `None` if it does not fit 11 bits.
    #[inline]
    pub const fn standard(id: u32) -> Option<Self> {
        if id <= Self::MAX_STANDARD { Some(Self(id)) } else { None }
    }

    /// An extended identifier; `None` if it does not fit 29 bits.
    #[inline]
    pub const fn extended(id: u32) -> Option<Self> {
        if id <= Self::MAX_EXTENDED { Some(Self(id | Self::EXTENDED)) } else { None }
    }

    /// The identifier's number, without the mark of its kind.
    #[inline]
    pub const fn number(self) -> u32 {
        self.0 & !Self::EXTENDED
    }

    /// Has it 29 bits?
    #[inline]
    pub const fn is_extended(self) -> bool {
        self.0 & Self::EXTENDED != 0
    }
}

/// As in a candump line: three hexadecimal digits for a standard, eight for an extended identifier.
impl fmt::Display for CanId {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.is_extended() { write!(f, "{:08X}", self.number()) } else { write!(f, "{:03X}", self.0) }
    }
}

impl fmt::Debug for CanId {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{self}")
    }
}

/// What a frame is for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FrameKind {
    /// A classic data frame, up to 8 bytes.
    Data,
    /// A classic remote request: a length but no data.
    Remote,
    /// An FD data frame, up to 64 bytes.
    Fd {
        /// Data phase at the higher bit rate.
        bit_rate_switch: bool,
        /// The sender is error passive.
        error_state: bool,
    },
    /// The controller's report of an error; the number is SocketCAN's error class.
    Error,
}

/// Up to 64 bytes.
pub type Payload = [u8; 64];

/// A frame with the time it was received (or recorded, or is to be sent).
#[derive(Clone, Copy)]
pub struct Frame {
    /// Receive time.
    pub time: Micros,
    /// Identifier; for an error frame its class in the lower bits.
    pub id: CanId,
    /// Data, remote, FD or error.
    pub kind: FrameKind,
    length: u8,
    data: Payload,
}

/// A frame that CAN cannot carry.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
pub enum FrameError {
    /// More than 8 bytes in a classic frame.
    #[error("{0} bytes do not fit a classic frame (at most 8); is `fd = true` missing?")]
    TooLongForClassic(usize),
    /// A length that FD has no code for.
    #[error("{0} bytes are no FD length (0–8, 12, 16, 20, 24, 32, 48, 64)")]
    NotAnFdLength(usize),
}

impl Frame {
    /// A data, FD or error frame.
    ///
    /// # Errors
    /// If the kind cannot carry that many bytes.
    pub fn new(time: Micros, id: CanId, kind: FrameKind, data: &[u8]) -> Result<Self, FrameError> {
        let mut payload = [0; 64];
        match payload.get_mut(..data.len()) {
            Some(start) => start.copy_from_slice(data),
            None => return Err(too_long(kind, data.len())),
        }
        Self::from_payload(time, id, kind, payload, data.len())
    }

    /// As [`Frame::new`], for data that are already in place: the first `length` bytes of `data`.
    #[inline]
    pub(crate) fn from_payload(
        time: Micros,
        id: CanId,
        kind: FrameKind,
        data: Payload,
        length: usize,
    ) -> Result<Self, FrameError> {
        let fits = if matches!(kind, FrameKind::Fd { .. }) { is_fd_length(length) } else { length <= 8 };
        if fits {
            Ok(Self { time, id, kind, length: length as u8, data })
        } else {
            Err(too_long(kind, length))
        }
    }

    /// A classic data frame of the first `length` of these bytes, the others being zero.
    #[inline]
    pub fn of_eight(time: Micros, id: CanId, bytes: [u8; 8], length: usize) -> Self {
        let mut data = [0; 64];
        data[..8].copy_from_slice(&bytes);
        Self { time, id, kind: FrameKind::Data, length: length.min(8) as u8, data }
    }

    /// A classic data frame.
    ///
    /// # Errors
    /// If there are more than 8 bytes.
    pub fn data_frame(time: Micros, id: CanId, data: &[u8]) -> Result<Self, FrameError> {
        Self::new(time, id, FrameKind::Data, data)
    }

    /// A remote request for `length` bytes.
    ///
    /// # Errors
    /// If more than 8 bytes are asked for.
    pub fn remote(time: Micros, id: CanId, length: usize) -> Result<Self, FrameError> {
        if length > 8 {
            return Err(FrameError::TooLongForClassic(length));
        }
        Ok(Self { time, id, kind: FrameKind::Remote, length: length as u8, data: [0; 64] })
    }

    /// The bytes; none for a remote request.
    #[inline]
    pub fn data(&self) -> &[u8] {
        if self.kind == FrameKind::Remote { &[] } else { &self.data[..usize::from(self.length).min(64)] }
    }

    /// The first eight bytes, whatever the length: what is beyond it means nothing.
    #[inline]
    pub(super) fn first_eight(&self) -> [u8; 8] {
        let [a, b, c, d, e, f, g, h, ..] = self.data;
        [a, b, c, d, e, f, g, h]
    }

    /// Bytes carried, or asked for by a remote request.
    pub fn length(&self) -> usize {
        usize::from(self.length)
    }

    /// Does it carry data (classic or FD)?
    pub fn is_data(&self) -> bool {
        matches!(self.kind, FrameKind::Data | FrameKind::Fd { .. })
    }

    /// Is it an FD frame?
    pub fn is_fd(&self) -> bool {
        matches!(self.kind, FrameKind::Fd { .. })
    }
}

#[cold]
fn too_long(kind: FrameKind, length: usize) -> FrameError {
    match kind {
        FrameKind::Fd { .. } => FrameError::NotAnFdLength(length),
        _ => FrameError::TooLongForClassic(length),
    }
}

/// Lengths that the FD length code can express.
fn is_fd_length(length: usize) -> bool {
    matches!(length, 0..=8 | 12 | 16 | 20 | 24 | 32 | 48 | 64)
}

impl PartialEq for Frame {
    fn eq(&self, other: &Self) -> bool {
        (self.time, self.id, self.kind, self.length) == (other.time, other.id, other.kind, other.length)
            && self.data() == other.data()
    }
}

impl fmt::Debug for Frame {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "({}) {} {:?} [{}] {:02X?}", self.time, self.id, self.kind, self.length, self.data())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn same_number_standard_and_extended_are_different() {
        assert_ne!(CanId::standard(0x123), CanId::extended(0x123));
        assert_eq!(CanId::standard(0x800), None);
        assert_eq!(CanId::extended(0x2000_0000), None);
    }

    #[test]
    fn lengths_that_can_cannot_carry_are_refused() -> Result<(), FrameError> {
        let id = CanId::standard(1).unwrap();
        let fd = FrameKind::Fd { bit_rate_switch: false, error_state: false };
        assert_eq!(Frame::data_frame(Micros(0), id, &[0; 9]), Err(FrameError::TooLongForClassic(9)));
        assert_eq!(Frame::new(Micros(0), id, fd, &[0; 9]), Err(FrameError::NotAnFdLength(9)));
        assert_eq!(Frame::new(Micros(0), id, fd, &[7; 64])?.data(), &[7; 64]);
        assert_eq!(Frame::remote(Micros(0), id, 8)?.data(), &[] as &[u8]);
        Ok(())
    }
}
