//! Vector's binary logging format: objects of 1 (CAN), 73 (errors) and 100 (CAN FD), in zlib containers of 128 KiB.
//!
//! What is known of the format is told with its reader; counts and sizes are put into the header at the end.

use std::fs::File;
use std::io::{self, BufWriter, Seek, SeekFrom, Write};
use std::path::Path;

use flate2::write::ZlibEncoder;

use super::binary::BinaryFile;
use super::loss::Loss;
use super::start::Start;
use super::{Sink, loss_of_error};
use crate::can::recording::{LogError, fd_code};
use crate::can::{Frame, FrameKind};
use physics::Micros;
use physics::time::Date;

/// Bytes of the file's header.
const FILE_HEADER: usize = 144;
/// Bytes of objects in a container, unpacked.
const CONTAINER: usize = 1 << 17;
/// Bytes of an object's header.
const OBJECT_HEADER: usize = 32;
/// Bytes before the data of a container.
const CONTAINER_HEADER: usize = 32;

/// Writes a container of objects at a time.
pub struct Blf {
    file: BinaryFile,
    output: BufWriter<File>,
    start: Start,
    last: Micros,
    /// Objects that are not written yet.
    objects: Vec<u8>,
    count: u32,
    /// Bytes of the file, and what they would be if nothing were compressed.
    size: u64,
    unpacked: u64,
}

impl Blf {
    /// With room for the header.
    pub fn create(path: &Path) -> Result<Self, LogError> {
        let (file, mut output) = BinaryFile::create(path)?;
        file.check(output.write_all(&[0; FILE_HEADER]))?;
        let (size, unpacked) = (FILE_HEADER as u64, FILE_HEADER as u64);
        let (start, last) = (Start::default(), Micros(0));
        Ok(Self { file, output, start, last, objects: Vec::new(), count: 0, size, unpacked })
    }

    /// Packs and writes the first so many bytes of the objects.
    fn container(&mut self, count: usize) -> io::Result<()> {
        const ZLIB: u16 = 2;
        // As loggers do: a tenth larger, in a third of the time.
        let mut encoder = ZlibEncoder::new(Vec::new(), flate2::Compression::fast());
        encoder.write_all(&self.objects[..count])?;
        let packed = encoder.finish()?;
        let mut header = base_header(16, CONTAINER_HEADER + packed.len(), 10).to_vec();
        header.extend(ZLIB.to_le_bytes());
        header.extend([0; 6]);
        header.extend((count as u32).to_le_bytes());
        header.extend([0; 4]);
        self.output.write_all(&header)?;
        self.output.write_all(&packed)?;
        let padding = (header.len() + packed.len()) % 4;
        self.output.write_all(&[0; 3][..padding])?;
        self.size += (header.len() + packed.len() + padding) as u64;
        self.unpacked += (CONTAINER_HEADER + count) as u64;
        self.objects.drain(..count);
        Ok(())
    }

    /// What the file is, in 144 bytes.
    fn header(&self) -> Vec<u8> {
        let mut header = b"LOGG".to_vec();
        header.extend((FILE_HEADER as u32).to_le_bytes());
        // Written by another application than Vector's, in the binary format of version 2.6.8.1.
        header.extend([5, 0, 0, 0, 2, 6, 8, 1]);
        header.extend(self.size.to_le_bytes());
        header.extend(self.unpacked.to_le_bytes());
        header.extend(self.count.to_le_bytes());
        header.extend([0; 4]);
        for date in [self.start.date(), Date::of(self.last).unwrap_or_default()] {
            let Date { year, month, day, hour, minute, second, milli } = date;
            for part in [year, month, date.weekday(), day, hour, minute, second, milli] {
                header.extend((part as u16).to_le_bytes());
            }
        }
        header.resize(FILE_HEADER, 0);
        header
    }

    fn end(&mut self) -> io::Result<()> {
        if !self.objects.is_empty() {
            self.container(self.objects.len())?;
        }
        self.output.seek(SeekFrom::Start(0))?;
        self.output.write_all(&self.header())?;
        self.output.flush()
    }
}

impl Sink for Blf {
    fn frame(&mut self, channel: u8, frame: &Frame) -> Result<Option<Loss>, LogError> {
        let since = match self.start.since(frame.time) {
            Ok(since) => since,
            Err(loss) => return Ok(Some(loss)),
        };
        // 584 years of nanoseconds.
        let Some(ns) = since.0.unsigned_abs().checked_mul(1000) else { return Ok(Some(Loss::NoDate)) };
        self.last = self.last.max(frame.time);
        self.count = self.count.wrapping_add(1);
        object(&mut self.objects, u16::from(channel) + 1, ns, frame);
        while self.objects.len() >= CONTAINER {
            let written = self.container(CONTAINER);
            self.file.check(written)?;
        }
        Ok(loss_of_error(frame))
    }

    fn finish(mut self: Box<Self>) -> Result<(), LogError> {
        let ended = self.end();
        self.file.commit(ended)
    }
}

/// The part of the header that all objects have.
fn base_header(size: usize, object_size: usize, kind: u32) -> [u8; 16] {
    let mut header = *b"LOBJ\0\0\x01\0\0\0\0\0\0\0\0\0";
    header[4..6].copy_from_slice(&(size as u16).to_le_bytes());
    header[8..12].copy_from_slice(&(object_size as u32).to_le_bytes());
    header[12..].copy_from_slice(&kind.to_le_bytes());
    header
}

/// Appends the object of a frame.
fn object(objects: &mut Vec<u8>, channel: u16, ns: u64, frame: &Frame) {
    const NANOSECONDS: u32 = 2;
    const REMOTE: u8 = 0x80;
    const EXTENDED: u32 = 1 << 31;
    let id = if frame.id.is_extended() { frame.id.number() | EXTENDED } else { frame.id.number() };
    let mut body = [0; 84];
    body[..2].copy_from_slice(&channel.to_le_bytes());
    let (kind, size) = match frame.kind {
        FrameKind::Error => (73, 32),
        FrameKind::Fd { bit_rate_switch, error_state } => {
            body[3] = fd_code(frame.length());
            body[4..8].copy_from_slice(&id.to_le_bytes());
            body[13] = 1 | u8::from(bit_rate_switch) << 1 | u8::from(error_state) << 2;
            body[14] = frame.length() as u8;
            body[20..20 + frame.data().len()].copy_from_slice(frame.data());
            (100, 84)
        }
        FrameKind::Data | FrameKind::Remote => {
            body[2] = if frame.kind == FrameKind::Remote { REMOTE } else { 0 };
            body[3] = frame.length() as u8;
            body[4..8].copy_from_slice(&id.to_le_bytes());
            body[8..8 + frame.data().len()].copy_from_slice(frame.data());
            (1, 16)
        }
    };
    objects.extend(base_header(OBJECT_HEADER, OBJECT_HEADER + size, kind));
    objects.extend(NANOSECONDS.to_le_bytes());
    objects.extend([0; 4]);
    objects.extend(ns.to_le_bytes());
    objects.extend_from_slice(&body[..size]);
}
