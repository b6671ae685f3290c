//! Makes MF4 files of one data group: sorted or not, with data in the records or elsewhere.

use std::io::Write;

/// Blocks one after the other; a link is where a block begins.
pub struct Mf4 {
    pub bytes: Vec<u8>,
}

/// A member of `CAN_DataFrame`: its name, type of channel, kind of data, byte, bit, bits, data link.
pub type Member<'a> = (&'a str, u8, u8, u32, u8, u32, u64);

/// The frame's members where a record has all of them: 8 bytes of time, channel, identifier, length, flags.
pub const MEMBERS: [Member; 6] = [
    ("BusChannel", 0, 0, 8, 0, 8, 0),
    ("ID", 0, 0, 9, 0, 29, 0),
    ("IDE", 0, 0, 12, 7, 1, 0),
    ("DataLength", 0, 0, 13, 0, 7, 0),
    ("EDL", 0, 0, 13, 7, 1, 0),
    ("DLC", 0, 0, 14, 0, 4, 0),
];

impl Mf4 {
    /// With room for identification and header.
    pub fn new(magic: &[u8; 8]) -> Self {
        let mut bytes = magic.to_vec();
        bytes.extend(b"4.10    gripd   ");
        bytes.resize(64, 0);
        let mut file = Self { bytes };
        // 9 October 2025, 08:53:20.
        let mut data = 1_760_000_000_000_000_000_u64.to_le_bytes().to_vec();
        data.resize(32, 0);
        file.block(b"HD", &[0; 6], &data);
        file
    }

    pub fn block(&mut self, id: &[u8; 2], links: &[u64], data: &[u8]) -> u64 {
        while !self.bytes.len().is_multiple_of(8) {
            self.bytes.push(0);
        }
        let at = self.bytes.len() as u64;
        self.bytes.extend([b'#', b'#', id[0], id[1], 0, 0, 0, 0]);
        self.bytes.extend((24 + 8 * links.len() as u64 + data.len() as u64).to_le_bytes());
        self.bytes.extend((links.len() as u64).to_le_bytes());
        links.iter().for_each(|link| self.bytes.extend(link.to_le_bytes()));
        self.bytes.extend(data);
        at
    }

    pub fn text(&mut self, text: &str) -> u64 {
        self.block(b"TX", &[], &[text.as_bytes(), &[0]].concat())
    }

    fn channel(&mut self, next: u64, members: u64, name: &str, about: Member, conversion: u64) -> u64 {
        let name = self.text(name);
        let (_, kind, data_kind, byte, bit, bits, link) = about;
        let mut data = vec![kind, u8::from(kind == 2), data_kind, bit];
        data.extend(byte.to_le_bytes());
        data.extend(bits.to_le_bytes());
        data.resize(72, 0);
        self.block(b"CN", &[next, members, name, 0, conversion, link, 0, 0], &data)
    }

    /// Channels of a group: a clock that counts microseconds, and a frame of these members.
    pub fn frame_channels(&mut self, frame: &str, members: &[Member]) -> u64 {
        let mut first = 0;
        for about in members.iter().rev() {
            first = self.channel(first, 0, &format!("{frame}.{}", about.0), *about, 0);
        }
        let frame = self.channel(0, first, frame, ("", 0, 10, 8, 0, 64, 0), 0);
        let mut linear = vec![1, 0, 0, 0, 0, 0, 2, 0];
        linear.resize(24, 0);
        linear.extend(0_f64.to_le_bytes());
        linear.extend(1e-6_f64.to_le_bytes());
        let conversion = self.block(b"CC", &[0; 4], &linear);
        self.channel(frame, 0, "Timestamp", ("", 2, 0, 0, 0, 64, 0), conversion)
    }

    pub fn group(&mut self, next: u64, channels: u64, id: u64, flags: u16, size: u32) -> u64 {
        let mut data = id.to_le_bytes().to_vec();
        data.extend([0; 8]);
        data.extend(flags.to_le_bytes());
        data.extend([0; 6]);
        data.extend(size.to_le_bytes());
        data.extend([0; 4]);
        self.block(b"CG", &[next, channels, 0, 0, 0, 0], &data)
    }

    /// Appends a data group, as the first one of the file.
    pub fn data_group(&mut self, group: u64, data: u64, id_size: u8) {
        let next = u64::from_le_bytes(self.bytes[88..96].try_into().unwrap());
        let at = self.block(b"DG", &[next, group, data, 0], &[id_size, 0, 0, 0, 0, 0, 0, 0]);
        self.bytes[88..96].copy_from_slice(&at.to_le_bytes());
    }

    /// Compressed data, transposed in records of so many bytes if that is not zero.
    pub fn compressed(&mut self, id: &[u8; 2], data: &[u8], columns: usize) -> u64 {
        let mut turned = data.to_vec();
        if let Some(rows) = data.len().checked_div(columns) {
            for row in 0..rows {
                for column in 0..columns {
                    turned[column * rows + row] = data[row * columns + column];
                }
            }
        }
        let mut encoder = flate2::write::ZlibEncoder::new(Vec::new(), flate2::Compression::fast());
        encoder.write_all(&turned).unwrap();
        let packed = encoder.finish().unwrap();
        let mut block = vec![id[0], id[1], u8::from(columns > 0), 0];
        block.extend((columns as u32).to_le_bytes());
        block.extend((data.len() as u64).to_le_bytes());
        block.extend((packed.len() as u64).to_le_bytes());
        block.extend(packed);
        self.block(b"DZ", &[], &block)
    }

    /// Blocks of data as one, through a header and two lists.
    pub fn list(&mut self, blocks: &[u64]) -> u64 {
        let (first, rest) = blocks.split_at(blocks.len() / 2);
        let last = self.block(b"DL", &[&[0], rest].concat(), &[0; 16]);
        let list = self.block(b"DL", &[&[last], first].concat(), &[0; 16]);
        self.block(b"HL", &[list], &[0; 8])
    }
}

/// What comes before the data of a record: time in µs, channel, identifier (extended above 7FF), length.
pub fn head(us: u64, channel: u8, id: u32, length: u8, fd: bool) -> Vec<u8> {
    let mut record = us.to_le_bytes().to_vec();
    record.push(channel);
    let extended = if id > 0x7FF { 1 << 31 } else { 0 };
    record.extend((id | extended).to_le_bytes());
    record.push(length | if fd { 0x80 } else { 0 });
    record.push(length.min(15));
    record
}

/// Not finished, not sorted, data in a group of their own: as loggers write it. `data_first`: before their record.
pub fn unsorted(frames: &[(u64, u32, Vec<u8>)], data_first: bool) -> Vec<u8> {
    let mut file = Mf4::new(b"UnFinMF ");
    let variable = file.group(0, 0, 2, 1, 0);
    let mut members = MEMBERS.to_vec();
    members.push(("DataBytes", 1, 10, 15, 0, 64, variable));
    let channels = file.frame_channels("CAN_DataFrame", &members);
    let group = file.group(variable, channels, 1, 2, 23);
    let mut records = Vec::new();
    let mut offset = 0_u64;
    for (us, id, data) in frames {
        let mut record = vec![1];
        record.extend(head(*us, 1, *id, data.len() as u8, data.len() > 8));
        record.extend(offset.to_le_bytes());
        let mut bytes = vec![2];
        bytes.extend((data.len() as u32).to_le_bytes());
        bytes.extend(data);
        offset += 4 + data.len() as u64;
        let both = if data_first { [bytes, record] } else { [record, bytes] };
        records.extend(both.concat());
    }
    let data = file.bytes.len().div_ceil(8) * 8 + 56 + 8;
    file.data_group(group, data as u64, 1);
    // The last block, whose length nobody came to write.
    let at = file.block(b"DT", &[], &[]);
    let link = file.bytes.len();
    assert_eq!(at, data as u64, "the link to the data of {link} bytes");
    file.bytes.extend(records);
    file.bytes
}
