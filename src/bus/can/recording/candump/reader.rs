//! Reads a log of any size in constant memory.

use std::fs::File;
use std::io::{self, Read};
use std::path::Path;

use memchr::memchr;

use super::line::{self, Line};
use super::{Compression, Damage, LogError, LogStats, usual};
use crate::can::Frame;
use crate::can::recording::{Content, LONGEST_LINE, unpack};

/// Bytes read at a time.
const BUFFER: usize = LONGEST_LINE;

/// Reads frames from a candump log: a file, gzip or zstd, or anything else that can be read. (Recordings of any
/// format: [`recording::Reader`](crate::can::recording::Reader).)
///
/// Damaged lines are skipped and counted ([`LogStats`]); only a failing or broken source is an error.
/// Memory does not depend on the length of the log or of its lines, and nothing is allocated per line.
pub struct Reader {
    name: String,
    source: Box<dyn Read + Send>,
    compression: Compression,
    buffer: Box<[u8]>,
    /// The unread bytes are `buffer[start..end]`, of which those before `searched` have no newline.
    start: usize,
    searched: usize,
    end: usize,
    state: State,
    /// The beginning of the current line did not fit and is gone.
    in_long_line: bool,
    interface: String,
    second: usual::Second,
    stats: LogStats,
}

/// How far the source is.
enum State {
    More,
    /// Nothing more comes; what is in the buffer is still to be delivered.
    Ended,
    /// It failed; the same, then the error.
    Failed(LogError),
}

impl Reader {
    /// Opens a recording; `-` is the standard input. gzip and zstd are recognized by their content.
    ///
    /// # Errors
    /// If it cannot be opened or is evidently no candump log.
    pub fn open(path: &Path) -> Result<Self, LogError> {
        if path.as_os_str() == "-" {
            return Self::from_read(Box::new(io::stdin()), "standard input");
        }
        let name = path.display().to_string();
        match File::open(path) {
            Ok(file) => Self::from_read(Box::new(file), &name),
            Err(source) => Err(LogError::Open { name, source }),
        }
    }

    /// Reads from anything; `name` stands in messages.
    ///
    /// # Errors
    /// If its first bytes cannot be read or are evidently no candump log.
    pub fn from_read(source: Box<dyn Read + Send>, name: &str) -> Result<Self, LogError> {
        let name = name.to_owned();
        let (source, content) = match unpack(source) {
            Ok(unpacked) => unpacked,
            Err(source) => return Err(LogError::Read { name, line: 0, source }),
        };
        match content {
            Content::Blf => Err(LogError::OtherFormat { name, format: "a Vector BLF recording" }),
            Content::Mf4 => Err(LogError::OtherFormat { name, format: "an ASAM MDF recording" }),
            Content::Other(format) => Err(LogError::OtherFormat { name, format }),
            Content::Log(compression) => Ok(Self::of_unpacked(source, name, compression)),
        }
    }

    /// Reads what is known to be a candump log and no longer packed.
    pub(in crate::can) fn of_unpacked(
        source: Box<dyn Read + Send>,
        name: String,
        compression: Compression,
    ) -> Self {
        Self {
            name,
            source,
            compression,
            buffer: vec![0; BUFFER].into_boxed_slice(),
            start: 0,
            searched: 0,
            end: 0,
            state: State::More,
            in_long_line: false,
            interface: String::new(),
            second: usual::Second::default(),
            stats: LogStats::default(),
        }
    }

    /// The file's name as it stands in messages.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// How the file is packed.
    pub fn compression(&self) -> Compression {
        self.compression
    }

    /// The interface of the frame delivered last.
    pub fn interface(&self) -> &str {
        &self.interface
    }

    /// What was seen so far; after the last frame, of the whole log.
    pub fn stats(&self) -> &LogStats {
        &self.stats
    }

    /// The next frame, or `None` at the end.
    ///
    /// # Errors
    /// If the source fails or its compression is broken. What could be read has been delivered before,
    /// and the error comes once: after it there is only `None`.
    #[inline]
    pub fn next_frame(&mut self) -> Result<Option<Frame>, LogError> {
        // Between two lines, most of the time.
        if self.searched == self.start
            && !self.in_long_line
            && let Some(usual) = usual::parse(&self.buffer[self.start..self.end], &mut self.second)
            && follow(&mut self.interface, usual.interface)
        {
            self.start += usual.length;
            self.searched = self.start;
            self.stats.lines += 1;
            self.stats.frame(usual.time);
            return Ok(Some(usual.frame()));
        }
        self.next_of_any()
    }

    /// The next frame of whatever lines there are, and of those that are not in the buffer yet.
    fn next_of_any(&mut self) -> Result<Option<Frame>, LogError> {
        loop {
            let Some(text) = self.next_line()? else { return Ok(None) };
            self.stats.lines += 1;
            let line = &self.buffer[text.0..text.1];
            match line::parse(line) {
                Ok(Line::Frame { interface, frame }) => {
                    if !follow(&mut self.interface, interface) {
                        self.stats.skipped(Damage::BadInterface);
                        continue;
                    }
                    self.stats.frame(frame.time);
                    return Ok(Some(frame));
                }
                Ok(Line::Blank) => self.stats.blank_lines += 1,
                Ok(Line::Xl) => self.stats.xl_frames += 1,
                Ok(Line::Dropped(count)) => self.stats.dropped = self.stats.dropped.saturating_add(count),
                Err(reason) => self.stats.skipped(reason),
            }
        }
    }

    /// Where the next line lies in the buffer (from, to); `None` at the end.
    fn next_line(&mut self) -> Result<Option<(usize, usize)>, LogError> {
        loop {
            if let Some(newline) = memchr(b'\n', &self.buffer[self.searched..self.end]) {
                let line = (self.start, self.searched + newline);
                self.start = line.1 + 1;
                self.searched = self.start;
                if self.in_long_line {
                    self.end_long_line();
                    continue;
                }
                return Ok(Some(line));
            }
            self.searched = self.end;
            match self.state {
                State::More => self.refill(),
                State::Ended => return Ok(self.last_line()),
                State::Failed(_) => {
                    // The last line may lack its end: better no frame than a shortened one.
                    self.start = self.end;
                    self.in_long_line = false;
                    match std::mem::replace(&mut self.state, State::Ended) {
                        State::Failed(error) => return Err(error),
                        _ => return Ok(None),
                    }
                }
            }
        }
    }

    /// What is left at the end of the source: a last line without newline, or nothing.
    fn last_line(&mut self) -> Option<(usize, usize)> {
        if std::mem::take(&mut self.in_long_line) {
            self.end_long_line();
            self.start = self.end;
        }
        let line = (self.start, self.end);
        self.start = self.end;
        (line.0 < line.1).then_some(line)
    }

    fn end_long_line(&mut self) {
        self.in_long_line = false;
        self.stats.lines += 1;
        self.stats.skipped(Damage::LongLine);
    }

    /// Reads some more bytes behind those that are there.
    fn refill(&mut self) {
        if self.start > 0 {
            self.buffer.copy_within(self.start..self.end, 0);
            self.end -= self.start;
            self.start = 0;
        }
        if self.end == self.buffer.len() {
            // A line that fills the whole buffer: forget it, but remember that it is not over.
            self.in_long_line = true;
            self.end = 0;
        }
        self.searched = self.end;
        match self.source.read(&mut self.buffer[self.end..]) {
            Ok(0) => self.state = State::Ended,
            Ok(count) => self.end += count,
            Err(error) if error.kind() == io::ErrorKind::Interrupted => {}
            Err(error) => self.state = State::Failed(self.failure(error)),
        }
    }

    /// Says what a failed read means.
    fn failure(&self, source: io::Error) -> LogError {
        // The lines still in the buffer will be delivered before the error.
        let waiting = self.buffer[self.start..self.end].iter().filter(|byte| **byte == b'\n').count();
        LogError::of_read(&self.name, self.compression, self.stats.lines + waiting as u64, source)
    }
}

/// Takes over the interface's name where it changed; `false` if it is no text.
#[inline]
fn follow(name: &mut String, interface: &[u8]) -> bool {
    if name.as_bytes() == interface {
        return true;
    }
    let Ok(text) = str::from_utf8(interface) else { return false };
    name.clear();
    name.push_str(text);
    true
}
