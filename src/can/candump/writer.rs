//! Writes a log as `candump -L` would; a file appears under its name only when it is complete.

use std::io::{self, BufWriter, Write};
use std::path::Path;

use flate2::write::GzEncoder;

use super::LogError;
use super::digits::{to_decimal, to_hexadecimal};
use crate::Micros;
use crate::can::wire::{ERROR, fd_flags};
use crate::can::{Frame, FrameKind};
use crate::new_file::NewFile;

/// Writes frames as candump lines.
///
/// A file is written aside, under a hidden name in the same folder, and takes its own name in
/// [`Writer::finish`]. A writer that is dropped before leaves whatever was there untouched.
pub struct Writer {
    name: String,
    interface: String,
    sink: Sink,
    line: Vec<u8>,
    file: Option<NewFile>,
}

type Output = BufWriter<Box<dyn Write + Send>>;

/// Where the text goes, perhaps packed.
enum Sink {
    Plain(Output),
    Gzip(GzEncoder<Output>),
    Zstd(zstd::Encoder<'static, Output>),
}

impl Writer {
    /// Writes to anything, for frames of `interface`.
    pub fn new(output: impl Write + Send + 'static, interface: &str) -> Self {
        let sink = Sink::Plain(buffered(Box::new(output)));
        Self { name: "output".into(), interface: interface.into(), sink, line: Vec::new(), file: None }
    }

    /// Creates a file; `-` is the standard output. A name in `.gz` or `.zst` is packed accordingly.
    ///
    /// What exists under that name and is no ordinary file (a pipe, a terminal) is written directly.
    ///
    /// # Errors
    /// If the file cannot be created in its folder.
    pub fn create(path: &Path, interface: &str) -> Result<Self, LogError> {
        if path.as_os_str() == "-" {
            return Ok(Self { name: "standard output".into(), ..Self::new(io::stdout(), interface) });
        }
        Self::create_file(path, interface)
            .map_err(|source| LogError::Open { name: path.display().to_string(), source })
    }

    fn create_file(path: &Path, interface: &str) -> io::Result<Self> {
        let file = NewFile::create(path)?;
        let output = buffered(Box::new(file.writer()?));
        let sink = match path.extension().and_then(|extension| extension.to_str()) {
            Some("gz") => Sink::Gzip(GzEncoder::new(output, flate2::Compression::default())),
            Some("zst") => Sink::Zstd(zstd::Encoder::new(output, zstd::DEFAULT_COMPRESSION_LEVEL)?),
            _ => Sink::Plain(output),
        };
        let (name, interface) = (path.display().to_string(), interface.to_owned());
        Ok(Self { name, interface, sink, line: Vec::new(), file: Some(file) })
    }

    /// Writes a frame of the writer's interface.
    ///
    /// # Errors
    /// If the output fails.
    pub fn write(&mut self, frame: &Frame) -> Result<(), LogError> {
        self.line.clear();
        write_line(&mut self.line, &self.interface, frame);
        self.put_line()
    }

    /// Writes a frame of another interface.
    ///
    /// # Errors
    /// If the output fails.
    pub fn write_as(&mut self, interface: &str, frame: &Frame) -> Result<(), LogError> {
        self.line.clear();
        write_line(&mut self.line, interface, frame);
        self.put_line()
    }

    fn put_line(&mut self) -> Result<(), LogError> {
        let result = self.sink.as_write().write_all(&self.line);
        self.check(result)
    }

    /// Hands on what is still in the buffer, so that a reader of a pipe sees it now.
    ///
    /// # Errors
    /// If the output fails.
    pub fn flush(&mut self) -> Result<(), LogError> {
        let result = self.sink.as_write().flush();
        self.check(result)
    }

    /// Writes the rest, makes sure it is on the disk, and gives the file its name.
    ///
    /// # Errors
    /// If any of this fails; then the file that was there before is still there.
    pub fn finish(self) -> Result<(), LogError> {
        let Self { name, sink, file, .. } = self;
        sink.finish()
            .and_then(|()| file.map_or(Ok(()), NewFile::commit))
            .map_err(|source| LogError::Write { name, source })
    }

    fn check(&self, result: io::Result<()>) -> Result<(), LogError> {
        result.map_err(|source| LogError::Write { name: self.name.clone(), source })
    }
}

fn buffered(output: Box<dyn Write + Send>) -> Output {
    BufWriter::with_capacity(1 << 16, output)
}

impl Sink {
    fn as_write(&mut self) -> &mut dyn Write {
        match self {
            Sink::Plain(output) => output,
            Sink::Gzip(encoder) => encoder,
            Sink::Zstd(encoder) => encoder,
        }
    }

    /// Ends the compressed stream and empties the buffer.
    fn finish(self) -> io::Result<()> {
        match self {
            Sink::Plain(output) => output,
            Sink::Gzip(encoder) => encoder.finish()?,
            Sink::Zstd(encoder) => encoder.finish()?,
        }
        .flush()
    }
}

/// Appends a frame as `candump -L` would print it, with a newline.
///
/// Seconds are not padded to ten digits (candump pads, which shows before September 2001 only).
pub fn write_line(text: &mut Vec<u8>, interface: &str, frame: &Frame) {
    text.push(b'(');
    write_stamp(text, frame.time);
    text.extend_from_slice(b") ");
    text.extend_from_slice(interface.as_bytes());
    text.push(b' ');
    let number = frame.id.number();
    match frame.kind {
        FrameKind::Error => write_hex(text, number | ERROR, 8),
        _ if frame.id.is_extended() => write_hex(text, number, 8),
        _ => write_hex(text, number, 3),
    }
    text.push(b'#');
    if frame.kind == FrameKind::Remote {
        text.push(b'R');
        if frame.length() > 0 {
            write_hex(text, frame.length() as u32, 1);
        }
    } else if let Some(flags) = fd_flags(frame.kind) {
        text.push(b'#');
        write_hex(text, u32::from(flags), 1);
    }
    let (fours, rest) = frame.data().as_chunks::<4>();
    for &bytes in fours {
        text.extend_from_slice(&to_hexadecimal(bytes));
    }
    for &byte in rest {
        write_hex(text, u32::from(byte), 2);
    }
    text.push(b'\n');
}

/// `digits` hexadecimal digits, upper case.
#[inline]
fn write_hex(text: &mut Vec<u8>, value: u32, digits: u32) {
    const UPPER: &[u8; 16] = b"0123456789ABCDEF";
    for place in (0..digits).rev() {
        text.push(UPPER[(value >> (4 * place) & 0xF) as usize]);
    }
}

/// `seconds.micros`.
fn write_stamp(text: &mut Vec<u8>, time: Micros) {
    if time.0 < 0 {
        text.push(b'-');
    }
    let micros = time.0.unsigned_abs();
    let seconds = micros / 1_000_000;
    let fraction = to_decimal((micros % 1_000_000) as u32);
    if seconds < 100_000_000 {
        let digits = to_decimal(seconds as u32);
        let zeros = digits.iter().take(7).take_while(|digit| **digit == b'0').count();
        text.extend_from_slice(&digits[zeros..]);
    } else {
        // A day of this century has ten digits; whatever there are above eight goes before them.
        write_decimal(text, seconds / 100_000_000);
        text.extend_from_slice(&to_decimal((seconds % 100_000_000) as u32));
    }
    text.push(b'.');
    text.extend_from_slice(&fraction[2..]);
}

/// A number's digits.
fn write_decimal(text: &mut Vec<u8>, number: u64) {
    if number >= 10 {
        write_decimal(text, number / 10);
    }
    text.push(b'0' + (number % 10) as u8);
}
