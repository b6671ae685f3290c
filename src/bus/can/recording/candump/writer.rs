//! Writes a log as `candump -L` would; a file appears under its name only when it is complete.

use std::io::Write;
use std::path::Path;

use super::LogError;
use crate::can::Frame;
use crate::can::candump_line::{push_rest, push_stamp};
use crate::can::recording::TextOutput;
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
