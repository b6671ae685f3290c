//! The records of a data group as frames.

use std::collections::VecDeque;

use super::block::Blocks;
use super::data::Stream;
use super::layout::{DataGroup, Field, Group, Kind, Place};
use crate::can::recording::bytes::{array, u32_at};
use crate::can::recording::{Damage, LogError, data_frame, error_frame, fd_length, identifier, remote_frame};
use crate::can::{Frame, FrameKind};
use physics::Micros;

/// Records that wait for data which lie elsewhere, and data that wait for their record, at most.
const WAITING: usize = 1 << 12;
/// Data of variable length that are longer than this are of no CAN frame.
const LONGEST: usize = 64;

/// What a record turned out to be.
#[derive(Debug)]
pub enum Record {
    /// A frame on a channel.
    Frame(u32, Frame),
    /// Of no bus of ours.
    Other,
    /// Damaged.
    Damaged(Damage),
}

/// Reads the records of a data group.
pub struct Records {
    stream: Stream,
    id_size: usize,
    groups: Vec<Sorted>,
    /// Records whose data may still be to come, in the order of the file.
    waiting: VecDeque<Waiting>,
    start_ns: i64,
    ended: bool,
}

/// A group and its own data of variable length.
struct Sorted {
    group: Group,
    /// Where those are in blocks of their own.
    data: Option<Stream>,
    /// Or the group whose records they are, by its place in the list.
    from: Option<usize>,
    /// Of a group of data: how many bytes of them have come, and those that nobody has taken.
    seen: u64,
    kept: VecDeque<(u64, Bytes)>,
}

/// Data of a frame.
#[derive(Clone, Copy, Debug)]
struct Bytes {
    length: usize,
    bytes: [u8; LONGEST],
}

/// A record without its data: where they are (the group, the offset).
struct Waiting {
    head: Result<Head, Damage>,
    data: Option<(usize, u64)>,
    found: Option<Bytes>,
}

/// A frame without its data.
#[derive(Clone, Copy)]
struct Head {
    channel: u32,
    kind: FrameKind,
    time: Micros,
    id: crate::can::CanId,
    /// Bytes of data, if the record says so.
    length: Option<usize>,
}

impl Records {
    /// Of a data group; times count from `start_ns` (since 1970).
    pub fn new(file: &Blocks, data_group: DataGroup, start_ns: i64) -> Result<Self, LogError> {
        let places: Vec<u64> = data_group.groups.iter().map(|group| group.at).collect();
        let mut groups = Vec::new();
        for group in data_group.groups {
            let (mut data, mut from) = (None, None);
            if let Some(Place::Elsewhere(_, link)) = group.members.data {
                from = places.iter().position(|place| *place == link);
                if from.is_none() {
                    data = Some(Stream::new(file, link)?);
                }
            }
            groups.push(Sorted { group, data, from, seen: 0, kept: VecDeque::new() });
        }
        let stream = Stream::new(file, data_group.data)?;
        let waiting = VecDeque::new();
        Ok(Self { stream, id_size: data_group.id_size, groups, waiting, start_ns, ended: false })
    }

    /// The block within which the file ends.
    pub fn cut_off(&self) -> Option<u64> {
        self.stream.cut_off()
    }

    /// The next record; `None` at the end.
    ///
    /// # Errors
    /// If the file is broken; what was before has been given out, and there is nothing more.
    pub fn next(&mut self, file: &Blocks) -> Result<Option<Record>, LogError> {
        loop {
            if self.waiting.front().is_some_and(Waiting::is_ready)
                || self.waiting.len() > WAITING
                || (self.ended && !self.waiting.is_empty())
            {
                return Ok(self.waiting.pop_front().map(Waiting::finish));
            }
            if self.ended {
                return Ok(None);
            }
            match self.read(file) {
                Ok(Some(record)) => return Ok(Some(record)),
                Ok(None) => {}
                Err(error) => {
                    self.ended = true;
                    return Err(error);
                }
            }
        }
    }

    /// Reads a record; one that must wait, or that others must wait for, is kept.
    fn read(&mut self, file: &Blocks) -> Result<Option<Record>, LogError> {
        let at = self.stream.place();
        let mut place = 0;
        if self.id_size > 0 {
            let Some(bytes) = self.stream.peek(file, self.id_size)? else {
                self.ended = true;
                return Ok(None);
            };
            let id = bytes.iter().rev().fold(0, |id, byte| id << 8 | u64::from(*byte));
            match self.groups.iter().position(|sorted| sorted.group.record_id == id) {
                Some(found) => place = found,
                None if file.unfinished => {
                    // Room that the recorder had not filled yet.
                    self.ended = true;
                    return Ok(None);
                }
                None => {
                    let what = format!("record {at}: there is no group {id}");
                    return Err(file.broken(self.groups.first().map_or(0, |sorted| sorted.group.at), &what));
                }
            }
        }
        if self.groups.get(place).is_some_and(|sorted| sorted.group.kind == Kind::Variable) {
            self.read_variable(file, place)?;
            return Ok(None);
        }
        let Some(sorted) = self.groups.get_mut(place) else {
            self.ended = true;
            return Ok(None);
        };
        let (skip, size) = (self.id_size, sorted.group.size);
        let Some(bytes) = self.stream.peek(file, skip + size)? else {
            self.ended = true;
            return Ok(None);
        };
        let record = &bytes[skip..];
        if sorted.group.kind == Kind::Other {
            self.stream.advance(skip + size);
            return Ok(Some(Record::Other));
        }
        let head = sorted.head(record, self.start_ns);
        let mut waiting = Waiting { head, data: None, found: None };
        let elsewhere = sorted.group.kind == Kind::Data;
        match sorted.group.members.data.filter(|_| elsewhere) {
            Some(Place::Record(byte, length)) => {
                waiting.found =
                    Bytes::new(record.get(byte..).map_or(&[][..], |rest| &rest[..length.min(rest.len())]));
            }
            Some(Place::Elsewhere(field, _)) => {
                let offset = field.read(record).unwrap_or(u64::MAX);
                match (&mut sorted.data, sorted.from) {
                    (Some(data), _) => waiting.found = Bytes::of_stream(file, data, offset)?,
                    (None, Some(from)) => waiting.data = Some((from, offset)),
                    (None, None) => {}
                }
            }
            None => {}
        }
        self.stream.advance(skip + size);
        if let Some((from, offset)) = waiting.data
            && let Some(source) = self.groups.get_mut(from)
        {
            // What is before was taken, or is of nobody.
            while source.kept.front().is_some_and(|(place, _)| *place < offset) {
                source.kept.pop_front();
            }
            if source.kept.front().is_some_and(|(place, _)| *place == offset) {
                waiting.found = source.kept.pop_front().map(|(_, bytes)| bytes);
            } else if offset < source.seen {
                // They have come and gone.
                waiting.data = None;
            }
        }
        // Nearly always so.
        if self.waiting.is_empty() && waiting.is_ready() {
            return Ok(Some(waiting.finish()));
        }
        self.waiting.push_back(waiting);
        Ok(None)
    }

    /// A record of data: `length (4) bytes`.
    fn read_variable(&mut self, file: &Blocks, place: usize) -> Result<(), LogError> {
        let skip = self.id_size;
        let Some(length) = self.stream.peek(file, skip + 4)?.and_then(|bytes| u32_at(bytes, skip)) else {
            self.ended = true;
            return Ok(());
        };
        let length = length as usize;
        let data = if length <= LONGEST {
            let Some(bytes) = self.stream.peek(file, skip + 4 + length)? else {
                self.ended = true;
                return Ok(());
            };
            let data = Bytes::new(&bytes[skip + 4..]);
            self.stream.advance(skip + 4 + length);
            data
        } else {
            let end = self.stream.place() + (skip + 4 + length) as u64;
            if !self.stream.go_to(file, end)? {
                self.ended = true;
            }
            None
        };
        let Some(source) = self.groups.get_mut(place) else { return Ok(()) };
        let offset = source.seen;
        source.seen = source.seen.saturating_add(4 + length as u64);
        let Some(data) = data else { return Ok(()) };
        if let Some(waiting) =
            self.waiting.iter_mut().find(|w| w.found.is_none() && w.data == Some((place, offset)))
        {
            waiting.found = Some(data);
            return Ok(());
        }
        source.kept.push_back((offset, data));
        if source.kept.len() > WAITING {
            source.kept.pop_front();
        }
        Ok(())
    }
}

impl Bytes {
    fn new(from: &[u8]) -> Option<Self> {
        let mut bytes = [0; LONGEST];
        let length = from.len().min(LONGEST);
        bytes[..length].copy_from_slice(&from[..length]);
        Some(Self { length, bytes })
    }

    /// At an offset in a stream of `length (4) bytes`.
    fn of_stream(file: &Blocks, data: &mut Stream, offset: u64) -> Result<Option<Self>, LogError> {
        if !data.go_to(file, offset)? {
            return Ok(None);
        }
        let Some(length) = data.peek(file, 4)?.and_then(|bytes| u32_at(bytes, 0)) else { return Ok(None) };
        let length = length as usize;
        if length > LONGEST {
            return Ok(None);
        }
        Ok(data.peek(file, 4 + length)?.and_then(|bytes| Self::new(&bytes[4..])))
    }
}

impl Waiting {
    /// Nothing is still to come.
    fn is_ready(&self) -> bool {
        self.data.is_none() || self.found.is_some()
    }

    /// With what is known now.
    fn finish(self) -> Record {
        let frame = self.head.and_then(|head| {
            let frame = match head.kind {
                FrameKind::Error => error_frame(head.time)?,
                FrameKind::Remote => remote_frame(head.time, head.id, head.length.unwrap_or(0))?,
                FrameKind::Data | FrameKind::Fd { .. } => {
                    let length = head.length;
                    let data = match self.found {
                        Some(data) => data,
                        None if length == Some(0) => Bytes { length: 0, bytes: [0; LONGEST] },
                        None => return Err(Damage::NoData),
                    };
                    let length = length.unwrap_or(data.length);
                    if length > data.length {
                        return Err(Damage::BadBytes);
                    }
                    data_frame(head.time, head.id, head.kind, &data.bytes[..length])?
                }
            };
            Ok((head.channel, frame))
        });
        match frame {
            Ok((channel, frame)) => Record::Frame(channel, frame),
            Err(reason) => Record::Damaged(reason),
        }
    }
}

impl Sorted {
    /// What a record says but for its data.
    fn head(&self, record: &[u8], start_ns: i64) -> Result<Head, Damage> {
        let members = &self.group.members;
        let number = |field: Option<Field>| field.and_then(|field| field.read(record));
        let is_set = |field: Option<Field>| number(field).is_some_and(|value| value != 0);
        let clock = self.group.clock.ok_or(Damage::BadTime)?;
        let seconds = clock.offset + clock.factor * clock.field.real(record).ok_or(Damage::ShortObject)?;
        // Until the year 33658, as candump logs.
        if seconds.is_nan() || seconds.abs() >= 1e12 {
            return Err(Damage::BadTime);
        }
        // Whole seconds apart, so that the product has all the digits there are.
        let whole = seconds.floor();
        let rest_ns = start_ns.rem_euclid(1000) + ((seconds - whole) * 1e9).round() as i64;
        let start_us = start_ns.div_euclid(1000);
        let time = Micros(start_us + (whole as i64) * Micros::PER_SECOND + (rest_ns + 500).div_euclid(1000));
        let channel = number(members.channel).map_or(0, |channel| u32::try_from(channel).unwrap_or(u32::MAX));
        if self.group.kind == Kind::Error {
            let id = identifier(0, true)?;
            return Ok(Head { channel, kind: FrameKind::Error, time, id, length: None });
        }
        const EXTENDED: u64 = 1 << 31;
        let id = number(members.id).ok_or(Damage::BadNumber)?;
        let marked = id & EXTENDED != 0;
        let plain = u32::try_from(id & !EXTENDED).map_err(|_| Damage::BadNumber)?;
        let extended = match members.extended {
            Some(field) => field.read(record).is_some_and(|value| value != 0),
            None => marked || plain > crate::can::CanId::MAX_STANDARD,
        };
        let id = identifier(plain, extended)?;
        let code = number(members.code).and_then(|code| u32::try_from(code).ok());
        let length = number(members.length).map(|length| usize::try_from(length).unwrap_or(usize::MAX));
        let (kind, length) = if self.group.kind == Kind::Remote {
            // It asks for data and has none: the code tells how many.
            (FrameKind::Remote, code.map(|code| code as usize).or(length))
        } else if is_set(members.fd) {
            let kind = FrameKind::Fd {
                bit_rate_switch: is_set(members.bit_rate_switch),
                error_state: is_set(members.error_state),
            };
            (kind, length.or_else(|| code.and_then(fd_length)))
        } else {
            (FrameKind::Data, length.or_else(|| code.map(|code| code.min(8) as usize)))
        };
        Ok(Head { channel, kind, time, id, length })
    }
}

impl Field {
    /// Its bits as they are.
    pub fn read(&self, record: &[u8]) -> Option<u64> {
        let mask = u64::MAX >> (64 - self.bits.clamp(1, 64));
        // Nearly always there is a whole word.
        if !self.big_endian
            && self.bit + self.bits <= 64
            && let Some(word) = array::<8>(record, self.byte)
        {
            return Some(u64::from_le_bytes(word) >> self.bit & mask);
        }
        let count = ((self.bit + self.bits).div_ceil(8)) as usize;
        let bytes = record.get(self.byte..)?.get(..count)?;
        let push = |value: u128, byte: &u8| value << 8 | u128::from(*byte);
        let value =
            if self.big_endian { bytes.iter().fold(0, push) } else { bytes.iter().rev().fold(0, push) };
        Some((value >> self.bit) as u64 & mask)
    }

    /// As a number.
    fn real(&self, record: &[u8]) -> Option<f64> {
        if !self.float {
            let bits = self.read(record)?;
            let unused = 64 - self.bits.clamp(1, 64);
            return Some(if self.signed { ((bits << unused) as i64 >> unused) as f64 } else { bits as f64 });
        }
        let four = || array::<4>(record, self.byte);
        let eight = || array::<8>(record, self.byte);
        match (self.bits, self.big_endian) {
            (32, false) => four().map(f32::from_le_bytes).map(f64::from),
            (32, true) => four().map(f32::from_be_bytes).map(f64::from),
            (64, false) => eight().map(f64::from_le_bytes),
            (64, true) => eight().map(f64::from_be_bytes),
            _ => None,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn fields_are_bits_of_either_order() {
        let field = Field { byte: 1, bit: 0, bits: 12, big_endian: false, float: false, signed: false };
        assert_eq!(field.read(&[0, 0x34, 0x12]), Some(0x234));
        assert_eq!(Field { bit: 4, bits: 8, ..field }.read(&[0, 0x34, 0x12]), Some(0x23));
        assert_eq!(Field { big_endian: true, bits: 16, ..field }.read(&[0, 0x34, 0x12]), Some(0x3412));
        assert_eq!(field.read(&[0, 0x34]), None);
        let long = [0x34, 0x12, 3, 4, 5, 6, 7, 8, 9, 10];
        for (bit, bits, byte) in
            [(0, 12, 0), (4, 12, 0), (3, 7, 1), (0, 64, 0), (5, 59, 2), (1, 64, 0), (7, 64, 0)]
        {
            let field = Field { byte, bit, bits, ..field };
            let whole =
                u128::from_le_bytes(std::array::from_fn(|at| long.get(byte + at).copied().unwrap_or(0)));
            let expected = (whole >> bit) as u64 & (u64::MAX >> (64 - bits));
            assert_eq!(field.read(&long), Some(expected), "{field:?}");
        }
        let all = Field { byte: 0, bits: 64, ..field };
        assert_eq!(all.read(&[0xFF; 8]), Some(u64::MAX));
        assert_eq!(Field { signed: true, ..all }.real(&[0xFF; 8]), Some(-1.0));
        assert_eq!(Field { float: true, ..all }.real(&1.5_f64.to_le_bytes()), Some(1.5));
    }
}
