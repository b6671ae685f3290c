//! Texts line by line, in memory that does not depend on them, and the frames of their grammar.

use std::io::{self, BufRead, BufReader, Read};

use memchr::memchr;

use super::{About, Compression, Damage, LONGEST_LINE, LogError, Source};
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
    lines: Lines,
    grammar: G,
    about: About,
}

impl<G: Grammar> TextReader<G> {
    /// Reads what is no longer packed.
    pub fn new(source: Box<dyn Read + Send>, name: String, compression: Compression, grammar: G) -> Self {
        let lines = Lines::new(source, compression);
        Self { lines, grammar, about: About::of(name) }
    }
}

impl<G: Grammar> Source for TextReader<G> {
    fn next_frame(&mut self) -> Result<Option<Frame>, LogError> {
        loop {
            match self.lines.next() {
                Ok(Next::End) => return Ok(None),
                Ok(Next::TooLong) => {
                    self.about.stats.lines += 1;
                    self.about.stats.skipped(Damage::LongLine);
                }
                Ok(Next::Line) => {
                    self.about.stats.lines += 1;
                    match self.grammar.line(self.lines.line().trim_ascii()) {
                        Ok(Entry::Frame(..)) if self.lines.ended => self.about.stats.skipped(Damage::NoEnd),
                        Ok(Entry::Frame(channel, frame)) => {
                            return Ok(Some(self.about.delivered(channel, frame)));
                        }
                        Ok(Entry::Other) => self.about.stats.others += 1,
                        Ok(Entry::Blank) => self.about.stats.blank_lines += 1,
                        Err(reason) => self.about.stats.skipped(reason),
                    }
                }
                Err(error) => {
                    return Err(LogError::of_read(
                        &self.about.name,
                        self.lines.compression,
                        self.about.stats.lines,
                        error,
                    ));
                }
            }
        }
    }

    fn about(&self) -> &About {
        &self.about
    }
}

/// A source line by line.
struct Lines {
    source: BufReader<Box<dyn Read + Send>>,
    compression: Compression,
    /// How many bytes of the source's buffer the line is, if it is there as a whole.
    in_buffer: Option<usize>,
    /// Bytes of the buffer that were the line read last, its end among them.
    used: usize,
    /// A line that lies across the ends of buffers.
    pieces: Vec<u8>,
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
        Self { source, compression, in_buffer: None, used: 0, pieces: Vec::new(), ended: false }
    }

    /// The line read last.
    fn line(&self) -> &[u8] {
        match self.in_buffer {
            Some(length) => self.source.buffer().get(..length).unwrap_or_default(),
            None => &self.pieces,
        }
    }

    /// Reads the next line. An error comes once; the line it interrupts is lost, for better no frame than a
    /// shortened one.
    fn next(&mut self) -> io::Result<Next> {
        self.source.consume(std::mem::take(&mut self.used));
        self.in_buffer = None;
        self.pieces.clear();
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
            let newline = memchr(b'\n', bytes);
            if let Some(newline) = newline
                && self.pieces.is_empty()
                && !too_long
            {
                // It stays where it is until the next one is asked for.
                (self.in_buffer, self.used) = (Some(newline), newline + 1);
                return Ok(Next::Line);
            }
            let piece = &bytes[..newline.unwrap_or(bytes.len())];
            too_long |= self.pieces.len() + piece.len() > LONGEST_LINE;
            if too_long {
                self.pieces.clear();
            } else {
                self.pieces.extend_from_slice(piece);
            }
            self.ended = bytes.is_empty();
            let used = newline.map_or(bytes.len(), |place| place + 1);
            self.source.consume(used);
            if newline.is_some() {
                return Ok(if too_long { Next::TooLong } else { Next::Line });
            }
        }
        Ok(match (too_long, self.pieces.is_empty()) {
            (true, _) => Next::TooLong,
            (_, false) => Next::Line,
            _ => Next::End,
        })
    }
}
