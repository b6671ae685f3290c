//! Files of ASAM MDF 4.10: sorted, finished, each group's records in transposed and compressed blocks.
//!
//! Blocks link by where they are, so the data come first, while they come, then the blocks that describe them, and at
//! the end, in the room kept for them, identification and header.

use std::io::{self, Seek, SeekFrom, Write};

use flate2::write::ZlibEncoder;

use physics::Micros;

/// Where the header is, behind the identification.
const HEADER: u64 = 64;
/// Bytes of the header.
const HEADER_SIZE: u64 = 24 + 6 * 8 + 32;
/// Bytes of records in a block, about.
const BLOCK: usize = 1 << 20;
/// Bytes of the time, which each record begins with: microseconds since the start of the file.
pub const TIME: usize = 8;

/// What the bytes of a channel are.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// A number without a sign, lowest byte first.
    Unsigned,
    /// A floating-point number, lowest byte first.
    Real,
    /// A text in UTF-8, zeros behind it.
    Text,
    /// Bytes.
    Bytes,
}

impl Kind {
    fn number(self) -> u8 {
        match self {
            Self::Unsigned => 0,
            Self::Real => 4,
            Self::Text => 7,
            Self::Bytes => 10,
        }
    }
}

/// A channel of a group.
pub struct Channel {
    /// Its name.
    pub name: String,
    /// Its unit; empty if it has none.
    pub unit: String,
    /// What its bytes are.
    pub kind: Kind,
    /// Where in the record they begin.
    pub byte: usize,
    /// How many they are.
    pub size: usize,
    /// The bit, of those behind all values, that says that there is no value.
    pub invalid: Option<u32>,
}

/// What a group of records is.
pub struct Group {
    /// Its name.
    pub name: String,
    /// The frame of a CAN bus that the channels are the members of; if there is none, they are signals.
    pub frame: Option<&'static str>,
    /// The channels, besides the time.
    pub channels: Vec<Channel>,
    /// Bytes of a record but for the bits that tell which values are not there.
    pub size: usize,
    /// Bytes of these bits.
    pub invalid_size: usize,
}

/// The records of a group, as far as they came.
pub struct Records {
    size: usize,
    rows: Vec<u8>,
    count: u64,
    /// Blocks that are written: where, how many bytes were before.
    blocks: Vec<(u64, u64)>,
    written: u64,
}

impl Records {
    /// Of a group.
    pub fn of(group: &Group) -> Self {
        let size = group.size + group.invalid_size;
        Self { size, rows: Vec::new(), count: 0, blocks: Vec::new(), written: 0 }
    }

    /// Takes a record, which has the group's size.
    ///
    /// # Errors
    /// If the output fails.
    pub fn push<W: Write + Seek>(&mut self, record: &[u8], file: &mut MdfFile<W>) -> io::Result<()> {
        debug_assert_eq!(record.len(), self.size);
        self.rows.extend_from_slice(record);
        self.count += 1;
        if self.rows.len() >= BLOCK { self.write(file) } else { Ok(()) }
    }

    fn write<W: Write + Seek>(&mut self, file: &mut MdfFile<W>) -> io::Result<()> {
        if self.rows.is_empty() {
            return Ok(());
        }
        let rows = self.rows.len() / self.size;
        // Columns one after the other are alike within, and pack better.
        let mut turned = vec![0; self.rows.len()];
        for (row, bytes) in self.rows.chunks_exact(self.size).enumerate() {
            for (column, byte) in bytes.iter().enumerate() {
                turned[column * rows + row] = *byte;
            }
        }
        let mut encoder = ZlibEncoder::new(Vec::new(), flate2::Compression::default());
        encoder.write_all(&turned)?;
        let packed = encoder.finish()?;
        const TRANSPOSED: u8 = 1;
        let mut data = vec![b'D', b'T', TRANSPOSED, 0];
        data.extend((self.size as u32).to_le_bytes());
        data.extend((self.rows.len() as u64).to_le_bytes());
        data.extend((packed.len() as u64).to_le_bytes());
        data.extend(packed);
        let at = file.block(b"DZ", &[], &data)?;
        self.blocks.push((at, self.written));
        self.written += self.rows.len() as u64;
        self.rows.clear();
        Ok(())
    }

    /// What remains, and the list of the blocks: the link to it.
    fn end<W: Write + Seek>(&mut self, file: &mut MdfFile<W>) -> io::Result<u64> {
        self.write(file)?;
        if self.blocks.is_empty() {
            return Ok(0);
        }
        let links: Vec<u64> = [0].into_iter().chain(self.blocks.iter().map(|(at, _)| *at)).collect();
        let mut data = vec![0; 4];
        data.extend((self.blocks.len() as u32).to_le_bytes());
        self.blocks.iter().for_each(|(_, before)| data.extend(before.to_le_bytes()));
        let list = file.block(b"DL", &links, &data)?;
        // Flags, how it is compressed.
        file.block(b"HL", &[list], &[0, 0, 1, 0, 0, 0, 0, 0])
    }
}

/// A file being written.
pub struct MdfFile<W> {
    output: W,
    at: u64,
    /// Groups that are described: the link to the group, to its records.
    groups: Vec<(u64, u64)>,
}

impl<W: Write + Seek> MdfFile<W> {
    /// With room for what comes at the end.
    ///
    /// # Errors
    /// If the output fails.
    pub fn new(mut output: W) -> io::Result<Self> {
        output.write_all(&[0; (HEADER + HEADER_SIZE) as usize])?;
        Ok(Self { output, at: HEADER + HEADER_SIZE, groups: Vec::new() })
    }

    /// Writes a block: the link to it.
    fn block(&mut self, id: &[u8; 2], links: &[u64], data: &[u8]) -> io::Result<u64> {
        let padding = (8 - self.at % 8) % 8;
        self.output.write_all(&[0; 7][..padding as usize])?;
        self.at += padding;
        let at = self.at;
        let bytes = block_bytes(id, links, data);
        self.output.write_all(&bytes)?;
        self.output.write_all(data)?;
        self.at += (bytes.len() + data.len()) as u64;
        Ok(at)
    }

    /// A text; nothing for an empty one.
    fn text(&mut self, id: &[u8; 2], text: &str) -> io::Result<u64> {
        if text.is_empty() {
            return Ok(0);
        }
        // Ends with zeros, at a multiple of eight bytes.
        let mut data = text.as_bytes().to_vec();
        data.resize(data.len() / 8 * 8 + 8, 0);
        self.block(id, &[], &data)
    }

    /// Describes a group whose records have all come.
    ///
    /// # Errors
    /// If the output fails.
    pub fn group(&mut self, group: &Group, mut records: Records) -> io::Result<()> {
        let data = records.end(self)?;
        let mut members = 0;
        for channel in group.channels.iter().rev() {
            members = self.channel(group, channel, members)?;
        }
        let first = match group.frame {
            None => members,
            Some(name) => {
                let mut about = channel_data(0, Kind::Bytes, TIME, group.size - TIME, BUS_EVENT, 0);
                about.resize(72, 0);
                let name = self.text(b"TX", name)?;
                self.block(b"CN", &[0, members, name, 0, 0, 0, 0, 0], &about)?
            }
        };
        let time = self.time(first)?;
        let source = if group.frame.is_some() { self.can_bus()? } else { 0 };
        let name = self.text(b"TX", &group.name)?;
        const OF_A_BUS: u16 = 0b110;
        let mut about = 0_u64.to_le_bytes().to_vec();
        about.extend(records.count.to_le_bytes());
        about.extend(if group.frame.is_some() { OF_A_BUS } else { 0 }.to_le_bytes());
        // What separates the names of a frame and its members.
        about.extend(u16::from(b'.').to_le_bytes());
        about.extend([0; 4]);
        about.extend((group.size as u32).to_le_bytes());
        about.extend((group.invalid_size as u32).to_le_bytes());
        let at = self.block(b"CG", &[0, time, name, source, 0, 0], &about)?;
        self.groups.push((at, data));
        Ok(())
    }

    fn channel(&mut self, group: &Group, channel: &Channel, next: u64) -> io::Result<u64> {
        let name = match group.frame {
            Some(frame) => format!("{frame}.{}", channel.name),
            None => channel.name.clone(),
        };
        let (name, unit) = (self.text(b"TX", &name)?, self.text(b"TX", &channel.unit)?);
        let of_bus = if group.frame.is_some() { BUS_EVENT } else { 0 };
        let flags = of_bus | if channel.invalid.is_some() { MAY_BE_INVALID } else { 0 };
        let invalid = channel.invalid.unwrap_or(0);
        let mut about = channel_data(0, channel.kind, channel.byte, channel.size, flags, invalid);
        about.resize(72, 0);
        self.block(b"CN", &[next, 0, name, 0, 0, 0, unit, 0], &about)
    }

    /// The time of a group's records: the channel that all others go by.
    fn time(&mut self, next: u64) -> io::Result<u64> {
        const MASTER: u8 = 2;
        const LINEAR: [u8; 8] = [1, 0, 0, 0, 0, 0, 2, 0];
        let mut linear = LINEAR.to_vec();
        linear.extend([0; 16]);
        linear.extend(0_f64.to_le_bytes());
        linear.extend(1e-6_f64.to_le_bytes());
        let conversion = self.block(b"CC", &[0; 4], &linear)?;
        let (name, unit) = (self.text(b"TX", "t")?, self.text(b"TX", "s")?);
        let mut about = channel_data(MASTER, Kind::Unsigned, 0, TIME, 0, 0);
        // It has a sign.
        about[2] = 2;
        about.resize(72, 0);
        self.block(b"CN", &[next, 0, name, 0, conversion, 0, unit, 0], &about)
    }

    /// Where a group's records come from.
    fn can_bus(&mut self) -> io::Result<u64> {
        const BUS: u8 = 2;
        const CAN: u8 = 2;
        let name = self.text(b"TX", "CAN")?;
        self.block(b"SI", &[name, name, 0], &[BUS, CAN, 0, 0, 0, 0, 0, 0])
    }

    /// Writes the rest; times count from `start`.
    ///
    /// # Errors
    /// If the output fails.
    pub fn finish(mut self, start: Micros) -> io::Result<W> {
        let mut next = 0;
        for (group, records) in std::mem::take(&mut self.groups).into_iter().rev() {
            next = self.block(b"DG", &[next, group, records, 0], &[0; 8])?;
        }
        // In UTC, without another zone.
        const ZONE_IS_KNOWN: u8 = 2;
        let mut time = (start.0.max(0).unsigned_abs().saturating_mul(1000)).to_le_bytes().to_vec();
        time.extend([0, 0, 0, 0, ZONE_IS_KNOWN, 0, 0, 0]);
        let version = env!("CARGO_PKG_VERSION");
        let tool = format!(
            "<FHcomment xmlns=\"http://www.asam.net/mdf/v4\"><TX>written</TX><tool_id>gripd</tool_id>\
             <tool_vendor>gripd</tool_vendor><tool_version>{version}</tool_version></FHcomment>"
        );
        let tool = self.text(b"MD", &tool)?;
        let history = self.block(b"FH", &[0, tool], &time)?;
        self.output.seek(SeekFrom::Start(0))?;
        self.output.write_all(b"MDF     4.10    gripd   \0\0\0\0\x9A\x01")?;
        self.output.write_all(&[0; 34])?;
        let mut header = time;
        header.resize(32, 0);
        self.output.write_all(&block_bytes(b"HD", &[next, history, 0, 0, 0, 0], &header))?;
        self.output.write_all(&header)?;
        self.output.flush()?;
        Ok(self.output)
    }
}

/// Marks of a channel.
const MAY_BE_INVALID: u32 = 2;
const BUS_EVENT: u32 = 1 << 10;

/// The beginning of a channel's data.
fn channel_data(of: u8, kind: Kind, byte: usize, size: usize, flags: u32, invalid: u32) -> Vec<u8> {
    let is_time = u8::from(of != 0);
    let mut data = vec![of, is_time, kind.number(), 0];
    for number in [byte as u32, 8 * size as u32, flags, invalid] {
        data.extend(number.to_le_bytes());
    }
    data
}

/// A block's header and links.
fn block_bytes(id: &[u8; 2], links: &[u64], data: &[u8]) -> Vec<u8> {
    let mut bytes = vec![b'#', b'#', id[0], id[1], 0, 0, 0, 0];
    let length = 24 + 8 * links.len() + data.len();
    bytes.extend((length as u64).to_le_bytes());
    bytes.extend((links.len() as u64).to_le_bytes());
    links.iter().for_each(|link| bytes.extend(link.to_le_bytes()));
    bytes
}
