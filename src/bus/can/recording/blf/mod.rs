//! Vector's binary logging format: objects, most of them in compressed containers, across whose borders they may
//! lie.
//!
//! ```text
//! "LOGG"  header size (4)  …  start, a SYSTEMTIME, at 40            the file's header, usually 144 bytes
//! "LOBJ"  …  type 10  how compressed (2) – (6) size (4) – (4) data  a container, and so on
//! ```

mod object;

use std::io::{BufReader, Read};

use flate2::read::ZlibDecoder;

use self::object::{BASE, CONTAINER, Header, SIGNATURE};
use super::bytes::{u16_at, u32_at};
use super::{About, Compression, Damage, LogError, Source};
use crate::can::Frame;
use physics::Micros;
use physics::time::Date;

/// The part of the file's header that is read.
const FILE_HEADER: usize = 72;
/// Headers and objects that claim to be larger are damaged; no logger makes them so.
const LARGEST: usize = 1 << 24;
/// A container holds this at most, unpacked (loggers fill them with 128 KiB).
const UNPACKED: u64 = 1 << 26;
/// Objects begin at multiples of four, more or less: so many bytes between them are no damage.
const PADDING: u64 = 7;

/// Frames of a BLF file.
pub struct Reader {
    source: BufReader<Box<dyn Read + Send>>,
    compression: Compression,
    /// Bytes taken from the source.
    taken: u64,
    /// When the recording began.
    start: Micros,
    /// The unread objects are `objects[at..]`.
    objects: Vec<u8>,
    at: usize,
    /// What follows does not belong to the rest of `objects`: something between is lost.
    gap: bool,
    ended: bool,
    /// To be told when what came before it has been delivered.
    failure: Option<LogError>,
    about: About,
}

/// What comes next in the unpacked objects.
enum Next {
    Frame(u32, Frame),
    /// Nothing for now: the next one is not whole.
    More,
}

impl Reader {
    /// Reads what is no longer packed, from the file's header on.
    ///
    /// # Errors
    /// If there is no whole header.
    pub fn new(
        source: Box<dyn Read + Send>,
        name: String,
        compression: Compression,
    ) -> Result<Self, LogError> {
        let mut reader = Self {
            source: BufReader::with_capacity(1 << 16, source),
            compression,
            taken: 0,
            start: Micros(0),
            objects: Vec::new(),
            at: 0,
            gap: false,
            ended: false,
            failure: None,
            about: About::of(name),
        };
        let mut header = Vec::new();
        reader.take(FILE_HEADER, &mut header)?;
        let size = u32_at(&header, 4).and_then(|size| usize::try_from(size).ok()).unwrap_or(0);
        if header.len() < FILE_HEADER {
            return Err(reader.cut_off("its header", 0));
        }
        if !(FILE_HEADER..LARGEST).contains(&size) {
            return Err(LogError::Broken {
                name: reader.about.name,
                what: format!("a BLF header of {size} bytes cannot be"),
                byte: 4,
                to_do: "take another copy of the recording",
            });
        }
        reader.start = start(&header).unwrap_or_default();
        reader.take(size - FILE_HEADER, &mut Vec::new())?;
        Ok(reader)
    }

    /// Up to so many bytes of the source, appended; fewer at its end.
    fn take(&mut self, count: usize, bytes: &mut Vec<u8>) -> Result<usize, LogError> {
        match self.source.by_ref().take(count as u64).read_to_end(bytes) {
            Ok(count) => {
                self.taken += count as u64;
                Ok(count)
            }
            Err(error) => {
                self.ended = true;
                Err(LogError::of_read(&self.about.name, self.compression, self.about.stats.lines, error))
            }
        }
    }

    fn cut_off(&mut self, what: &'static str, byte: u64) -> LogError {
        self.ended = true;
        LogError::CutOff { name: self.about.name.clone(), what, byte }
    }

    /// The next frame among the objects that are unpacked.
    fn unpacked(&mut self) -> Next {
        loop {
            let rest = &self.objects[self.at..];
            if rest.len() < BASE {
                return Next::More;
            }
            let header = Header::read(rest).filter(|header| header.object_size <= LARGEST);
            let Some(header) = header else {
                if !self.find_object() {
                    return Next::More;
                }
                continue;
            };
            let Some(object) = rest.get(..header.object_size) else { return Next::More };
            self.about.stats.lines += 1;
            let found = object::frame(object, header, self.start);
            self.at += header.object_size;
            match found {
                Ok(Some((channel, frame))) => return Next::Frame(channel, frame),
                Ok(None) => self.about.stats.others += 1,
                Err(reason) => self.about.stats.skipped(reason),
            }
        }
    }

    /// Goes on at the next signature, or so far that none can be before. Was there one?
    fn find_object(&mut self) -> bool {
        let rest = &self.objects[self.at..];
        let from = usize::from(rest.starts_with(SIGNATURE));
        let found = rest[from..].windows(SIGNATURE.len()).position(|bytes| bytes == SIGNATURE);
        let skipped = from + found.unwrap_or((rest.len() - from).saturating_sub(SIGNATURE.len() - 1));
        if from > 0 || skipped as u64 > PADDING {
            self.about.stats.lines += 1;
            self.about.stats.skipped(Damage::NoObject);
        }
        self.at += skipped;
        found.is_some()
    }

    /// Reads the next object of the file, unpacked if it is a container; `false` at the end.
    fn refill(&mut self) -> Result<bool, LogError> {
        if std::mem::take(&mut self.gap) {
            self.at = self.objects.len();
        }
        self.objects.drain(..self.at);
        self.at = 0;
        let Some((header, bytes)) = self.outer_header()? else { return Ok(false) };
        let began = self.taken - BASE as u64;
        let size = header.object_size - BASE;
        if header.kind != CONTAINER {
            // Files without compression may do without containers.
            self.objects.extend_from_slice(&bytes);
            let mut objects = std::mem::take(&mut self.objects);
            let taken = self.take(size, &mut objects);
            self.objects = objects;
            if taken? < size {
                return Err(self.cut_off("an object", began));
            }
            return Ok(true);
        }
        let mut packed = Vec::new();
        let is_whole = self.take(size, &mut packed)? == size;
        let is_good = unpack(&packed, &mut self.objects);
        if !is_whole {
            // What could be unpacked comes first.
            return Err(self.cut_off("a container", began));
        }
        if !is_good {
            self.gap = true;
            self.about.stats.lines += 1;
            self.about.stats.skipped(Damage::BadContainer);
        }
        Ok(true)
    }

    /// The next header in the file, whatever lies before it; `None` at the end.
    fn outer_header(&mut self) -> Result<Option<(Header, Vec<u8>)>, LogError> {
        let mut bytes = Vec::with_capacity(BASE);
        let mut skipped = 0;
        loop {
            let missing = BASE - bytes.len();
            if self.take(missing, &mut bytes)? < missing {
                self.ended = true;
                if skipped > PADDING {
                    self.about.stats.lines += 1;
                    self.about.stats.skipped(Damage::NoObject);
                }
                if bytes.windows(SIGNATURE.len()).any(|bytes| bytes == SIGNATURE) {
                    let began = self.taken - bytes.len() as u64;
                    return Err(self.cut_off("the header of an object", began));
                }
                return Ok(None);
            }
            let header = Header::read(&bytes).filter(|header| header.object_size <= LARGEST);
            if let Some(header) = header {
                if skipped > PADDING {
                    // The object before is not whole, and does not go on here.
                    self.objects.clear();
                    self.about.stats.lines += 1;
                    self.about.stats.skipped(Damage::NoObject);
                }
                return Ok(Some((header, bytes)));
            }
            let next =
                bytes[1..].iter().position(|byte| *byte == SIGNATURE[0]).map_or(BASE, |place| place + 1);
            bytes.drain(..next);
            skipped += next as u64;
        }
    }

    /// At the end: an object that claims more than there is may have swallowed others.
    fn salvage(&mut self) -> bool {
        let rest = &self.objects[self.at..];
        let is_object = rest.len() >= BASE && rest.starts_with(SIGNATURE);
        is_object && rest[1..].windows(SIGNATURE.len()).any(|bytes| bytes == SIGNATURE) && self.find_object()
    }
}

impl Source for Reader {
    fn next_frame(&mut self) -> Result<Option<Frame>, LogError> {
        loop {
            if let Next::Frame(channel, frame) = self.unpacked() {
                return Ok(Some(self.about.delivered(channel, frame)));
            }
            if self.ended {
                if self.salvage() {
                    continue;
                }
                self.at = self.objects.len();
                return self.failure.take().map_or(Ok(None), Err);
            }
            match self.refill() {
                Ok(true) => {}
                Ok(false) => self.ended = true,
                Err(error) => {
                    self.ended = true;
                    self.failure = Some(error);
                }
            }
        }
    }

    fn about(&self) -> &About {
        &self.about
    }
}

/// Appends what a container holds, as far as that can be had; `false` if it is not all.
fn unpack(container: &[u8], objects: &mut Vec<u8>) -> bool {
    const STORED: u16 = 0;
    const ZLIB: u16 = 2;
    let (Some(method), Some(data)) = (u16_at(container, 0), container.get(16..)) else { return false };
    match method {
        STORED => {
            objects.extend_from_slice(data);
            true
        }
        ZLIB => {
            let read = ZlibDecoder::new(data).take(UNPACKED).read_to_end(objects);
            matches!(read, Ok(count) if (count as u64) < UNPACKED)
        }
        _ => false,
    }
}

/// When the recording began: year, month, day of the week, day, hour, minute, second, millisecond.
fn start(header: &[u8]) -> Option<Micros> {
    let part = |place: usize| u16_at(header, 40 + 2 * place).map(u32::from);
    Date {
        year: part(0)?,
        month: part(1)?,
        day: part(3)?,
        hour: part(4)?,
        minute: part(5)?,
        second: part(6)?,
        milli: part(7)?,
    }
    .micros()
}
