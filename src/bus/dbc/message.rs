//! One message: an identifier, a length, and the signals in it.

use std::sync::Arc;

use super::signal::Signal;
use crate::can::CanId;
use physics::Micros;

/// A validated message. All its signals can be decoded.
#[derive(Clone, Debug, PartialEq)]
pub struct Message {
    /// Name; the long one where the file gives one.
    pub name: String,
    /// Identifier.
    pub id: CanId,
    /// Payload bytes, 0–64.
    pub length: usize,
    /// Goes as an FD frame: longer than 8 bytes, or marked so by the file.
    pub is_fd: bool,
    /// `GenMsgCycleTime`, where the file gives one to this very message.
    pub cycle: Option<Micros>,
    /// In the order of the file.
    pub signals: Vec<Signal>,
    /// The file it comes from.
    pub file: Arc<str>,
    /// Line in the file, counted from 1.
    pub line: usize,
}

impl Message {
    /// The signal of this name.
    pub fn signal(&self, name: &str) -> Option<&Signal> {
        self.signals.iter().find(|signal| signal.name == name)
    }
}
