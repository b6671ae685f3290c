//! Recordings out, in every format that is read. (Times, channels: the table of [`recording`](super).)
//!
//! What a format cannot hold is counted with its reason ([`Loss`]), never left out silently.

mod asc;
mod binary;
mod blf;
mod channels;
mod csv;
mod loss;
pub mod mdf;
mod mf4;
mod start;
mod trc;

pub use loss::{Loss, Written};

use std::path::Path;

use self::channels::Channels;
use super::{BUS_ERROR, Format, LogError, TextOutput};
use crate::can::recording::candump;
use crate::can::{Frame, FrameKind};

/// Writes frames to a recording of any format, which is complete under its name or not there at all.
///
/// A file is written aside, under a hidden name in the same folder, and takes its own name in
/// [`Writer::finish`]. A writer that is dropped before leaves whatever was there untouched.
pub struct Writer {
    format: Format,
    interface: String,
    channels: Channels,
    written: Written,
    sink: Kind,
}

/// candump logs have everything that a frame has.
enum Kind {
    Candump(Box<candump::Writer>),
    Other(Box<dyn Sink>),
}

/// Something that takes frames: a writer of one format.
trait Sink: Send {
    /// Writes a frame of a channel (from 0); what is lost of it by the format's nature.
    fn frame(&mut self, channel: u8, frame: &Frame) -> Result<Option<Loss>, LogError>;
    /// Writes the rest, makes sure it is on the disk, and gives the file its name.
    fn finish(self: Box<Self>) -> Result<(), LogError>;
}

impl Writer {
    /// Creates a file for frames that are of `interface` if nothing else is said. `-` is the standard output, and a
    /// name in `.gz` or `.zst` is packed accordingly; both for texts only.
    ///
    /// # Errors
    /// If the file cannot be created in its folder, or is to be packed or streamed and of a format that is
    /// packed in itself and written here and there.
    pub fn create(path: &Path, format: Format, interface: &str) -> Result<Self, LogError> {
        if !format.is_text() && (path.as_os_str() == "-" || is_packed(path)) {
            return Err(LogError::NotAStream { name: path.display().to_string(), format });
        }
        let sink: Kind = match format {
            Format::Candump => Kind::Candump(Box::new(candump::Writer::create(path, interface)?)),
            Format::Asc => Kind::Other(Box::new(asc::Asc::new(TextOutput::create(path)?))),
            Format::Trc => Kind::Other(Box::new(trc::Trc::new(TextOutput::create(path)?))),
            Format::Csv => Kind::Other(Box::new(csv::Csv::new(TextOutput::create(path)?)?)),
            Format::Blf => Kind::Other(Box::new(blf::Blf::create(path)?)),
            Format::Mf4 => Kind::Other(Box::new(mf4::Mf4::create(path)?)),
        };
        let (interface, channels) = (interface.to_owned(), Channels::default());
        Ok(Self { format, interface, channels, written: Written::default(), sink })
    }

    /// Writes a frame of the writer's interface.
    ///
    /// # Errors
    /// If the output fails.
    #[inline]
    pub fn write(&mut self, frame: &Frame) -> Result<(), LogError> {
        let interface = std::mem::take(&mut self.interface);
        let result = self.write_as(&interface, frame);
        self.interface = interface;
        result
    }

    /// Writes a frame of another interface.
    ///
    /// # Errors
    /// If the output fails.
    pub fn write_as(&mut self, interface: &str, frame: &Frame) -> Result<(), LogError> {
        let loss = match &mut self.sink {
            Kind::Candump(writer) => {
                writer.write_as(interface, frame)?;
                None
            }
            Kind::Other(sink) => match self.channels.of(interface) {
                Some(channel) => sink.frame(channel, frame)?,
                None => Some(Loss::ManyInterfaces),
            },
        };
        self.written.frames += 1;
        if let Some(loss) = loss {
            self.written.lost(loss);
        }
        Ok(())
    }

    /// Writes the rest, makes sure it is on the disk, and gives the file its name. What was written, and what not.
    ///
    /// # Errors
    /// If any of this fails; then the file that was there before is still there.
    pub fn finish(self) -> Result<Written, LogError> {
        match self.sink {
            Kind::Candump(writer) => writer.finish()?,
            Kind::Other(sink) => sink.finish()?,
        }
        // CSV has not even numbers, which is counted.
        let renamed = if self.format == Format::Csv { Vec::new() } else { self.channels.renamed() };
        Ok(Written { renamed, ..self.written })
    }
}

/// By its name.
fn is_packed(path: &Path) -> bool {
    path.extension().is_some_and(|extension| extension == "gz" || extension == "zst")
}

/// Of an error frame there is only that there was one.
fn loss_of_error(frame: &Frame) -> Option<Loss> {
    let is_plain = frame.id.number() == BUS_ERROR && frame.length() == 0;
    (frame.kind == FrameKind::Error && !is_plain).then_some(Loss::ErrorClass)
}
