//! Where in the records of a file CAN frames are: groups and channels by the names of ASAM's bus logging.

use super::block::{Block, Blocks};
use crate::can::recording::LogError;

/// So many groups and channels a file may have; more run in a circle.
const MOST: usize = 1 << 16;

/// A record has this many bytes at most; those of frames have less than 200.
const LARGEST_RECORD: usize = 1 << 20;

/// What the records of a group are.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// `CAN_DataFrame`.
    Data,
    /// `CAN_RemoteFrame`.
    Remote,
    /// `CAN_ErrorFrame`.
    Error,
    /// Data of variable length for another group.
    Variable,
    /// Nothing of ours.
    Other,
}

/// A number in a record.
#[derive(Clone, Copy, Debug)]
pub struct Field {
    /// Where it begins.
    pub byte: usize,
    /// At which bit of that byte.
    pub bit: u32,
    /// How many bits it has, 64 at most.
    pub bits: u32,
    /// Highest byte first.
    pub big_endian: bool,
    /// A floating-point number.
    pub float: bool,
    /// It has a sign.
    pub signed: bool,
}

/// Where the data of a frame are.
#[derive(Clone, Copy, Debug)]
pub enum Place {
    /// In the record: from where, how many bytes at most.
    Record(usize, usize),
    /// At an offset in the data behind a link (of blocks, or of another group's records).
    Elsewhere(Field, u64),
}

/// The clock of a group: `offset + factor × count` seconds.
#[derive(Clone, Copy, Debug)]
pub struct Clock {
    /// The count.
    pub field: Field,
    /// s.
    pub offset: f64,
    /// s.
    pub factor: f64,
}

/// Records of one kind.
#[derive(Clone, Debug)]
pub struct Group {
    /// Where its block is.
    pub at: u64,
    /// The number before each record of files with several kinds.
    pub record_id: u64,
    /// Bytes in a record, without that number.
    pub size: usize,
    /// What its records are.
    pub kind: Kind,
    /// When.
    pub clock: Option<Clock>,
    /// The members of the frame.
    pub members: Members,
}

/// The members of a frame, as far as a file has them.
#[derive(Clone, Debug, Default)]
pub struct Members {
    /// `ID`.
    pub id: Option<Field>,
    /// `IDE`.
    pub extended: Option<Field>,
    /// `DLC`.
    pub code: Option<Field>,
    /// `DataLength`.
    pub length: Option<Field>,
    /// `DataBytes`.
    pub data: Option<Place>,
    /// `BusChannel`.
    pub channel: Option<Field>,
    /// `EDL`.
    pub fd: Option<Field>,
    /// `BRS`.
    pub bit_rate_switch: Option<Field>,
    /// `ESI`.
    pub error_state: Option<Field>,
}

/// Groups whose records lie in the same data.
#[derive(Debug)]
pub struct DataGroup {
    /// The link to them.
    pub data: u64,
    /// Bytes of the number before each record.
    pub id_size: usize,
    /// The groups.
    pub groups: Vec<Group>,
}

/// All data groups that have CAN frames, from the first one on.
pub fn read(file: &Blocks, first: u64) -> Result<Vec<DataGroup>, LogError> {
    let mut found = Vec::new();
    let mut seen = 0;
    let mut next = first;
    while next != 0 {
        let block = file.expect(next, b"DG")?;
        next = block.link(0);
        let id_size = usize::from(block.u8(0));
        let mut groups = Vec::new();
        let mut group = block.link(1);
        while group != 0 {
            count(file, &mut seen, group)?;
            let block = file.expect(group, b"CG")?;
            group = block.link(0);
            groups.push(read_group(file, &block, &mut seen)?);
        }
        let has_frames = |group: &Group| matches!(group.kind, Kind::Data | Kind::Remote | Kind::Error);
        if !groups.iter().any(has_frames) {
            count(file, &mut seen, block.at)?;
            continue;
        }
        if !matches!(id_size, 0 | 1 | 2 | 4 | 8) || (id_size == 0 && groups.len() > 1) {
            return Err(file.broken(block.at, "records have an impossible identifier"));
        }
        count(file, &mut seen, block.at)?;
        found.push(DataGroup { data: block.link(2), id_size, groups });
    }
    Ok(found)
}

fn count(file: &Blocks, seen: &mut usize, at: u64) -> Result<(), LogError> {
    *seen += 1;
    if *seen > MOST { Err(file.broken(at, "groups or channels have no end")) } else { Ok(()) }
}

fn read_group(file: &Blocks, block: &Block, seen: &mut usize) -> Result<Group, LogError> {
    const VARIABLE: u16 = 1;
    let size = u64::from(block.u32(24)) + u64::from(block.u32(28));
    let mut group = Group {
        at: block.at,
        record_id: block.u64(0),
        size: size as usize,
        kind: Kind::Other,
        clock: None,
        members: Members::default(),
    };
    if block.u16(16) & VARIABLE != 0 {
        group.kind = Kind::Variable;
        return Ok(group);
    }
    channels(file, block.link(1), &mut group, seen, 0)?;
    if group.size > LARGEST_RECORD || group.size == 0 {
        return Err(file.broken(block.at, "a group's records have an impossible size"));
    }
    Ok(group)
}

/// Takes up what channels say, from the first one on, and their members'.
fn channels(
    file: &Blocks,
    first: u64,
    group: &mut Group,
    seen: &mut usize,
    depth: usize,
) -> Result<(), LogError> {
    const MASTER: u8 = 2;
    let mut next = first;
    while next != 0 {
        count(file, seen, next)?;
        let channel = file.expect(next, b"CN")?;
        next = channel.link(0);
        if channel.u8(0) == MASTER {
            group.clock = clock(file, &channel)?;
            continue;
        }
        let name = file.text(channel.link(2))?;
        let (frame, member) = name.split_once('.').unwrap_or((&name, ""));
        let kind = match frame {
            "CAN_DataFrame" => Some(Kind::Data),
            "CAN_RemoteFrame" => Some(Kind::Remote),
            "CAN_ErrorFrame" => Some(Kind::Error),
            _ => None,
        };
        if let Some(kind) = kind {
            group.kind = kind;
        }
        // Some writers leave the frame's name out of its members' names.
        let member = if kind.is_none() && depth > 0 { frame } else { member };
        if kind.is_some() || depth > 0 {
            take_up(&channel, member, &mut group.members);
        }
        let is_structure = channel.link(1) != 0 && depth < 2;
        if is_structure && &file.head(channel.link(1))?.id == b"CN" {
            channels(file, channel.link(1), group, seen, depth + 1)?;
        }
    }
    Ok(())
}

fn take_up(channel: &Block, member: &str, members: &mut Members) {
    let number = field(channel);
    match member {
        "ID" => members.id = number,
        "IDE" => members.extended = number,
        "DLC" => members.code = number,
        "DataLength" => members.length = number,
        "DataBytes" => members.data = place(channel),
        "BusChannel" => members.channel = number,
        "EDL" => members.fd = number,
        "BRS" => members.bit_rate_switch = number,
        "ESI" => members.error_state = number,
        _ => {}
    }
}

/// `type (1) synchronization (1) kind of data (1) bit (1) byte (4) bits (4) …`.
fn field(channel: &Block) -> Option<Field> {
    let kind = channel.u8(2);
    let field = Field {
        byte: channel.u32(4) as usize,
        bit: u32::from(channel.u8(3)),
        bits: channel.u32(8),
        big_endian: matches!(kind, 1 | 3 | 5),
        float: matches!(kind, 4 | 5),
        signed: matches!(kind, 2 | 3),
    };
    (kind <= 5 && (1..=64).contains(&field.bits) && field.bit < 8).then_some(field)
}

fn place(channel: &Block) -> Option<Place> {
    const VARIABLE: u8 = 1;
    let (byte, bits) = (channel.u32(4) as usize, channel.u32(8));
    if channel.u8(0) != VARIABLE {
        return Some(Place::Record(byte, (bits / 8) as usize));
    }
    let offset = Field { byte, bit: 0, bits: bits.min(64), big_endian: false, float: false, signed: false };
    (bits > 0).then_some(Place::Elsewhere(offset, channel.link(5)))
}

/// `None` for a clock that is not in the records, or whose numbers mean something else than seconds.
fn clock(file: &Blocks, channel: &Block) -> Result<Option<Clock>, LogError> {
    let Some(field) = field(channel) else { return Ok(None) };
    let (mut offset, mut factor) = (0.0, 1.0);
    if channel.link(4) != 0 {
        let conversion = file.expect(channel.link(4), b"CC")?;
        match conversion.u8(0) {
            0 => {}
            1 => {
                offset = f64::from_bits(conversion.u64(24));
                factor = f64::from_bits(conversion.u64(32));
            }
            _ => return Ok(None),
        }
    }
    let is_seconds = channel.u8(1) == 1;
    Ok((is_seconds && offset.is_finite() && factor.is_finite()).then_some(Clock { field, offset, factor }))
}
