//! Objects: what a frame is in a BLF file.
//!
//! ```text
//! 0  "LOBJ"  header size (2)  header version (2)  object size (4)  type (4)
//! 16 flags (4)  …  time (8): version 1 at 24, version 2 too; then what the type has
//! ```

use crate::can::recording::bytes::{u16_at, u32_at, u64_at};
use crate::can::recording::{Damage, data_frame, error_frame, identifier, remote_frame};
use crate::can::{CanId, Frame, FrameKind};
use physics::Micros;

/// Begins every object.
pub const SIGNATURE: &[u8; 4] = b"LOBJ";
/// Bytes of the part of the header that all objects have.
pub const BASE: usize = 16;
/// A container of other objects.
pub const CONTAINER: u32 = 10;

/// Types of objects that are frames.
const CAN_MESSAGE: u32 = 1;
const CAN_ERROR: u32 = 2;
const CAN_ERROR_EXT: u32 = 73;
const CAN_MESSAGE2: u32 = 86;
const CAN_FD_MESSAGE: u32 = 100;
const CAN_FD_MESSAGE_64: u32 = 101;
const CAN_FD_ERROR_64: u32 = 104;

/// Times count 10 µs instead of nanoseconds.
const TEN_MICROS: u32 = 1;

/// The part of the header that all objects have.
#[derive(Clone, Copy, Debug)]
pub struct Header {
    /// Where what the type has begins.
    pub size: usize,
    /// Bytes of the object, the header among them.
    pub object_size: usize,
    /// What it is.
    pub kind: u32,
}

impl Header {
    /// `None` if it does not begin an object.
    pub fn read(bytes: &[u8]) -> Option<Self> {
        if !bytes.starts_with(SIGNATURE) {
            return None;
        }
        let header = Self {
            size: usize::from(u16_at(bytes, 4)?),
            object_size: usize::try_from(u32_at(bytes, 8)?).ok()?,
            kind: u32_at(bytes, 12)?,
        };
        (header.object_size >= BASE).then_some(header)
    }
}

/// The frame of an object and its channel, from 0; `None` if it is something else.
pub fn frame(object: &[u8], header: Header, start: Micros) -> Result<Option<(u32, Frame)>, Damage> {
    let read = match header.kind {
        CAN_MESSAGE | CAN_MESSAGE2 => classic,
        CAN_FD_MESSAGE => fd,
        CAN_FD_MESSAGE_64 => fd_64,
        CAN_ERROR | CAN_ERROR_EXT => error,
        CAN_FD_ERROR_64 => fd_error,
        _ => return Ok(None),
    };
    let (channel, frame) = time(object, start)
        .zip(object.get(header.size.max(BASE)..))
        .and_then(|(time, body)| read(time, body))
        .ok_or(Damage::ShortObject)?;
    // Channels are counted from 1.
    Ok(Some((channel.saturating_sub(1), frame?)))
}

fn time(object: &[u8], start: Micros) -> Option<Micros> {
    let (flags, count) = (u32_at(object, BASE)?, u64_at(object, 24)?);
    let count = i64::try_from(count).unwrap_or(i64::MAX);
    let micros =
        if flags == TEN_MICROS { count.saturating_mul(10) } else { count.saturating_add(500) / 1000 };
    Some(start + Micros(micros))
}

/// A channel and a frame, if the bytes are there.
type Found = Option<(u32, Result<Frame, Damage>)>;

/// The identifier, of which bit 31 marks an extended one.
fn id(body: &[u8], place: usize) -> Option<Result<CanId, Damage>> {
    const EXTENDED: u32 = 1 << 31;
    let marked = u32_at(body, place)?;
    Some(identifier(marked & !EXTENDED, marked & EXTENDED != 0))
}

/// `channel (2) flags (1) length (1) id (4) data (8)`.
fn classic(time: Micros, body: &[u8]) -> Found {
    const REMOTE: u8 = 0x80;
    let (channel, id) = (u16_at(body, 0)?, id(body, 4)?);
    let (flags, length) = (*body.get(2)?, usize::from(*body.get(3)?).min(8));
    let frame = if flags & REMOTE != 0 {
        id.and_then(|id| remote_frame(time, id, length))
    } else {
        let data = body.get(8..8 + length)?;
        id.and_then(|id| data_frame(time, id, FrameKind::Data, data))
    };
    Some((channel.into(), frame))
}

/// `channel (2) flags (1) length code (1) id (4) frame length (4) bits (1) FD flags (1) bytes (1) – (5) data`.
fn fd(time: Micros, body: &[u8]) -> Found {
    const REMOTE: u8 = 0x80;
    const IS_FD: u8 = 1;
    const BIT_RATE_SWITCH: u8 = 2;
    const ERROR_STATE: u8 = 4;
    let (channel, id) = (u16_at(body, 0)?, id(body, 4)?);
    let (flags, code, fd_flags) = (*body.get(2)?, usize::from(*body.get(3)?), *body.get(13)?);
    let length = usize::from(*body.get(14)?);
    let kind = if fd_flags & IS_FD != 0 {
        FrameKind::Fd {
            bit_rate_switch: fd_flags & BIT_RATE_SWITCH != 0,
            error_state: fd_flags & ERROR_STATE != 0,
        }
    } else {
        FrameKind::Data
    };
    let frame = if flags & REMOTE != 0 {
        id.and_then(|id| remote_frame(time, id, code))
    } else {
        let data = body.get(20..20 + length)?;
        id.and_then(|id| data_frame(time, id, kind, data))
    };
    Some((channel.into(), frame))
}

/// `channel (1) length code (1) bytes (1) – (1) id (4) frame length (4) flags (4) – (20) direction (1)
/// where other things begin (1) checksum (4) data`.
fn fd_64(time: Micros, body: &[u8]) -> Found {
    const REMOTE: u32 = 1 << 4;
    const IS_FD: u32 = 1 << 12;
    const BIT_RATE_SWITCH: u32 = 1 << 13;
    const ERROR_STATE: u32 = 1 << 14;
    const DATA: usize = 40;
    let (channel, id, flags) = (*body.first()?, id(body, 4)?, u32_at(body, 12)?);
    let (code, length) = (usize::from(*body.get(1)?), usize::from(*body.get(2)?));
    let there = body.get(DATA..)?;
    if flags & REMOTE != 0 {
        return Some((channel.into(), id.and_then(|id| remote_frame(time, id, code))));
    }
    if length > 64 {
        return Some((channel.into(), Err(Damage::TooLong)));
    }
    // Zeros at the end may be left out of the file; what follows the data is something else.
    let mut bytes = [0; 64];
    let count = length.min(there.len());
    bytes[..count].copy_from_slice(&there[..count]);
    let kind = if flags & IS_FD != 0 {
        FrameKind::Fd { bit_rate_switch: flags & BIT_RATE_SWITCH != 0, error_state: flags & ERROR_STATE != 0 }
    } else {
        FrameKind::Data
    };
    Some((channel.into(), id.and_then(|id| data_frame(time, id, kind, &bytes[..length]))))
}

/// `channel (2) …`.
fn error(time: Micros, body: &[u8]) -> Found {
    Some((u16_at(body, 0)?.into(), error_frame(time)))
}

/// `channel (1) …`.
fn fd_error(time: Micros, body: &[u8]) -> Found {
    Some(((*body.first()?).into(), error_frame(time)))
}
