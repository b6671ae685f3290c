//! Writes a log as `candump -L` would; a file appears under its name only when it is complete.

use std::io::Write;
use std::path::Path;

use super::LogError;
use crate::can::digits::{Words, to_hexadecimal};
use crate::can::recording::TextOutput;
use crate::can::wire::{ERROR, fd_flags};
use crate::can::{Frame, FrameKind};
use physics::Micros;

/// Writes frames as candump lines.
///
/// A file is written aside, under a hidden name in the same folder, and takes its own name in
/// [`Writer::finish`]. A writer that is dropped before leaves whatever was there untouched.
pub struct Writer {
    interface: String,
    output: TextOutput,
    /// The line written last, and how much of it is the stamp.
    line: Vec<u8>,
    stamp: usize,
    /// The time it was for: all frames of a round have the same.
    time: Option<Micros>,
}

impl Writer {
    /// Writes to anything, for frames of `interface`.
    pub fn new(output: impl Write + Send + 'static, interface: &str) -> Self {
        Self::to(TextOutput::to(Box::new(output), "output"), interface)
    }

    /// Creates a file; `-` is the standard output. A name in `.gz` or `.zst` is packed accordingly.
    ///
    /// What exists under that name and is no ordinary file (a pipe, a terminal) is written directly.
    ///
    /// # Errors
    /// If the file cannot be created in its folder.
    pub fn create(path: &Path, interface: &str) -> Result<Self, LogError> {
        Ok(Self::to(TextOutput::create(path)?, interface))
    }

    fn to(output: TextOutput, interface: &str) -> Self {
        Self { interface: interface.to_owned(), output, line: Vec::new(), stamp: 0, time: None }
    }

    /// Writes a frame of the writer's interface.
    ///
    /// # Errors
    /// If the output fails.
    pub fn write(&mut self, frame: &Frame) -> Result<(), LogError> {
        self.begin_line(frame.time);
        push_rest(&mut self.line, &self.interface, frame);
        self.output.write(&self.line)
    }

    /// Writes a frame of another interface.
    ///
    /// # Errors
    /// If the output fails.
    pub fn write_as(&mut self, interface: &str, frame: &Frame) -> Result<(), LogError> {
        self.begin_line(frame.time);
        push_rest(&mut self.line, interface, frame);
        self.output.write(&self.line)
    }

    #[inline]
    fn begin_line(&mut self, time: Micros) {
        if self.time != Some(time) {
            self.line.clear();
            push_stamp(&mut self.line, time);
            (self.stamp, self.time) = (self.line.len(), Some(time));
        }
        self.line.truncate(self.stamp);
    }

    /// Hands on what is still in the buffer, so that a reader of a pipe sees it now.
    ///
    /// # Errors
    /// If the output fails.
    pub fn flush(&mut self) -> Result<(), LogError> {
        self.output.flush()
    }

    /// Writes the rest, makes sure it is on the disk, and gives the file its name.
    ///
    /// # Errors
    /// If any of this fails; then the file that was there before is still there.
    pub fn finish(self) -> Result<(), LogError> {
        self.output.finish()
    }
}

/// Appends a frame as `candump -L` would print it, with a newline.
///
/// Seconds are not padded to ten digits (candump pads, which shows before September 2001 only).
pub fn write_line(text: &mut Vec<u8>, interface: &str, frame: &Frame) {
    push_stamp(text, frame.time);
    push_rest(text, interface, frame);
}

fn push_stamp(text: &mut Vec<u8>, time: Micros) {
    let mut stamp = Words::default();
    stamp.one(b'(').seconds(time).word(*b")       ", 2);
    text.extend_from_slice(stamp.text());
}

/// What comes after the stamp.
fn push_rest(text: &mut Vec<u8>, interface: &str, frame: &Frame) {
    text.extend_from_slice(interface.as_bytes());
    let mut rest = Words::default();
    let number = frame.id.number();
    match frame.kind {
        FrameKind::Error => rest.one(b' ').hexadecimal(number | ERROR, 8),
        _ if frame.id.is_extended() => rest.one(b' ').hexadecimal(number, 8),
        _ => rest.one(b' ').hexadecimal(number, 3),
    };
    rest.one(b'#');
    if frame.kind == FrameKind::Remote {
        rest.one(b'R');
        if frame.length() > 0 {
            rest.hexadecimal(frame.length() as u32, 1);
        }
    } else if let Some(flags) = fd_flags(frame.kind) {
        rest.one(b'#').hexadecimal(u32::from(flags), 1);
    }
    let data = frame.data();
    if data.len() > 8 {
        text.extend_from_slice(rest.text());
        push_bytes(text, data);
        text.push(b'\n');
        return;
    }
    let [a, b, c, d, e, f, g, h] = frame.first_eight();
    rest.word(to_hexadecimal([a, b, c, d]), (2 * data.len()).min(8));
    rest.word(to_hexadecimal([e, f, g, h]), (2 * data.len()).saturating_sub(8));
    text.extend_from_slice(rest.one(b'\n').text());
}

/// Appends bytes of any number.
fn push_bytes(text: &mut Vec<u8>, bytes: &[u8]) {
    let (fours, rest) = bytes.as_chunks::<4>();
    for &bytes in fours {
        text.extend_from_slice(&to_hexadecimal(bytes));
    }
    let mut last = [0; 4];
    last[..rest.len()].copy_from_slice(rest);
    text.extend_from_slice(&to_hexadecimal(last)[..2 * rest.len()]);
}
