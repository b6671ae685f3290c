//! Texts line by line, in memory that does not depend on them, and the frames of their grammar.

use std::io::{self, BufRead, BufReader, Read};

use super::{Compression, Damage, Interface, LONGEST_LINE, LogError, LogStats, Source};
use crate::can::Frame;

/// What a line says.
pub enum Entry {
    /// A frame on channel `canN`.
    Frame(u32, Frame),
    /// Understood, but no frame.
    Other,
    /// Blank, a comment, or a header.
    Blank,
}

/// What the lines of a format mean; remembers what headers said.
pub trait Grammar: Send {
    /// Takes a line apart, which has no end and no blanks around it.
    fn line(&mut self, line: &[u8]) -> Result<Entry, Damage>;
}

/// Frames of a text.
pub struct TextReader<G> {
    name: String,
    lines: Lines,
    grammar: G,
    interface: Interface,
    stats: LogStats,
}

impl<G: Grammar> TextReader<G> {
    /// Reads what is no longer packed.
    pub fn new(source: Box<dyn Read + Send>, name: String, compression: Compression, grammar: G) -> Self {
        let lines = Lines::new(source, compression);
        Self { name, lines, grammar, interface: Interface::default(), stats: LogStats::default() }
    }
}

impl<G: Grammar> Source for TextReader<G> {
    fn next_frame(&mut self) -> Result<Option<Frame>, LogError> {
        loop {
            match self.lines.next() {
                Ok(Next::End) => return Ok(None),
                Ok(Next::TooLong) => {
                    self.stats.lines += 1;
                    self.stats.skipped(Damage::LongLine);
                }
                Ok(Next::Line) => {
                    self.stats.lines += 1;
                    match self.grammar.line(self.lines.line.trim_ascii()) {
                        Ok(Entry::Frame(..)) if self.lines.ended => self.stats.skipped(Damage::NoEnd),
                        Ok(Entry::Frame(channel, frame)) => {
                            self.interface.set(channel);
                            self.stats.frame(frame.time);
                            return Ok(Some(frame));
                        }
                        Ok(Entry::Other) => self.stats.others += 1,
                        Ok(Entry::Blank) => self.stats.blank_lines += 1,
                        Err(reason) => self.stats.skipped(reason),
                    }
                }
                Err(error) => {
                    return Err(LogError::of_read(
                        &self.name,
                        self.lines.compression,
                        self.stats.lines,
                        error,
                    ));
                }
            }
        }
    }

    fn interface(&self) -> &str {
        &self.interface.name
    }

    fn stats(&self) -> &LogStats {
        &self.stats
    }

    fn name(&self) -> &str {
        &self.name
    }
}

/// A source line by line.
struct Lines {
    source: BufReader<Box<dyn Read + Send>>,
    compression: Compression,
    /// The line read last.
    line: Vec<u8>,
    ended: bool,
}

/// What was found.
enum Next {
    Line,
    TooLong,
    End,
}

impl Lines {
    fn new(source: Box<dyn Read + Send>, compression: Compression) -> Self {
        let source = BufReader::with_capacity(1 << 16, source);
        Self { source, compression, line: Vec::new(), ended: false }
    }

    /// Reads the next line. An error comes once; the line it interrupts is lost, for better no frame than a
    /// shortened one.
    fn next(&mut self) -> io::Result<Next> {
        self.line.clear();
        let mut too_long = false;
        while !self.ended {
            let bytes = match self.source.fill_buf() {
                Ok(bytes) => bytes,
                Err(error) if error.kind() == io::ErrorKind::Interrupted => continue,
                Err(error) => {
                    self.ended = true;
                    return Err(error);
                }
            };
            let newline = bytes.iter().position(|byte| *byte == b'\n');
            let piece = &bytes[..newline.unwrap_or(bytes.len())];
            too_long |= self.line.len() + piece.len() > LONGEST_LINE;
            if too_long {
                self.line.clear();
            } else {
                self.line.extend_from_slice(piece);
            }
            self.ended = bytes.is_empty();
            let used = newline.map_or(bytes.len(), |place| place + 1);
            self.source.consume(used);
            if newline.is_some() {
                return Ok(if too_long { Next::TooLong } else { Next::Line });
            }
        }
        Ok(match (too_long, self.line.is_empty()) {
            (true, _) => Next::TooLong,
            (_, false) => Next::Line,
            _ => Next::End,
        })
    }
}
