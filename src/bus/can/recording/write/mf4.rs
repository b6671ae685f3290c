//! ASAM MF4 with bus logging: a group of records for each kind of frame, named by the standard for bus logging.

use std::fs::File;
use std::io::{self, BufWriter};
use std::path::Path;

use super::binary::BinaryFile;
use super::loss::Loss;
use super::mdf::{Channel, Group, Kind, MdfFile, Records, TIME};
use super::start::Start;
use super::{Sink, loss_of_error};
use crate::can::recording::{LogError, fd_code};
use crate::can::{Frame, FrameKind};

/// Writes records of four groups: data frames of classic CAN, of CAN FD, remote requests, errors.
pub struct Mf4 {
    file: BinaryFile,
    output: MdfFile<BufWriter<File>>,
    start: Start,
    groups: [(Group, Option<Records>); 4],
    record: Vec<u8>,
}

/// Bytes of the members that all frames have: `BusChannel` to `ESI`.
const MEMBERS: [(&str, usize); 9] = [
    ("BusChannel", 1),
    ("ID", 4),
    ("IDE", 1),
    ("DLC", 1),
    ("DataLength", 1),
    ("Dir", 1),
    ("EDL", 1),
    ("BRS", 1),
    ("ESI", 1),
];

fn group(name: &str, frame: &'static str, data: usize) -> Group {
    let mut byte = TIME;
    let mut channels = Vec::new();
    let mut add = |name: &str, kind, size| {
        channels.push(Channel { name: name.into(), unit: String::new(), kind, byte, size, invalid: None });
        byte += size;
    };
    MEMBERS.iter().for_each(|(name, size)| add(name, Kind::Unsigned, *size));
    if data > 0 {
        add("DataBytes", Kind::Bytes, data);
    }
    Group { name: name.into(), frame: Some(frame), channels, size: byte, invalid_size: 0 }
}

impl Mf4 {
    /// Creates the file.
    pub fn create(path: &Path) -> Result<Self, LogError> {
        let (file, output) = BinaryFile::create(path)?;
        let output = file.check(MdfFile::new(output))?;
        let groups = [
            group("CAN", "CAN_DataFrame", 8),
            group("CAN FD", "CAN_DataFrame", 64),
            group("CAN remote requests", "CAN_RemoteFrame", 0),
            group("CAN errors", "CAN_ErrorFrame", 0),
        ];
        let groups = groups.map(|group| (group, None));
        Ok(Self { file, output, start: Start::default(), groups, record: Vec::new() })
    }
}

impl Sink for Mf4 {
    fn frame(&mut self, channel: u8, frame: &Frame) -> Result<Option<Loss>, LogError> {
        let since = match self.start.since(frame.time) {
            Ok(since) => since,
            // The clock has a sign.
            Err(Loss::BeforeStart) => frame.time - self.start.time(),
            Err(loss) => return Ok(Some(loss)),
        };
        let (place, code) = match frame.kind {
            FrameKind::Data => (0, frame.length() as u8),
            FrameKind::Fd { .. } => (1, fd_code(frame.length())),
            FrameKind::Remote => (2, frame.length() as u8),
            FrameKind::Error => (3, 0),
        };
        let fd = match frame.kind {
            FrameKind::Fd { bit_rate_switch, error_state } => [true, bit_rate_switch, error_state],
            _ => [false; 3],
        };
        let data = if frame.kind == FrameKind::Error { &[] } else { frame.data() };
        let (group, records) = &mut self.groups[place];
        let record = &mut self.record;
        record.clear();
        record.extend(since.0.to_le_bytes());
        record.push(channel);
        record.extend(frame.id.number().to_le_bytes());
        record.extend([u8::from(frame.id.is_extended()), code, data.len() as u8, 0]);
        record.extend(fd.map(u8::from));
        record.extend_from_slice(data);
        record.resize(group.size, 0);
        let written = records.get_or_insert_with(|| Records::of(group)).push(record, &mut self.output);
        self.file.check(written)?;
        Ok(loss_of_error(frame))
    }

    fn finish(self: Box<Self>) -> Result<(), LogError> {
        let Self { file, mut output, groups, start, .. } = *self;
        let end = || -> io::Result<()> {
            for (place, (group, records)) in groups.into_iter().enumerate() {
                // Without any frame the file is a recording still.
                let none = (place == 0).then(|| Records::of(&group));
                if let Some(records) = records.or(none) {
                    output.group(&group, records)?;
                }
            }
            output.finish(start.time()).map(drop)
        };
        file.commit(end())
    }
}
