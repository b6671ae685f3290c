//! Vector's text format, as the newer versions of its tools write it: hexadecimal, times since the start.

use super::loss::Loss;
use super::start::Start;
use super::{Sink, loss_of_error};
use crate::can::recording::date::text;
use crate::can::recording::digits::{
    push_bytes, push_decimal, push_hexadecimal, push_seconds, push_short_hexadecimal,
};
use crate::can::recording::{LogError, TextOutput, fd_code};
use crate::can::{CanId, Frame, FrameKind};

/// Flags of a CANFD line.
const FD: u32 = 1 << 12;
const BIT_RATE_SWITCH: u32 = 1 << 13;
const ERROR_STATE: u32 = 1 << 14;

/// Writes a line for each frame.
pub struct Asc {
    output: TextOutput,
    start: Start,
    line: Vec<u8>,
    has_header: bool,
}

impl Asc {
    /// The header comes with the first frame, whose time it has.
    pub fn new(output: TextOutput) -> Self {
        Self { output, start: Start::default(), line: Vec::new(), has_header: false }
    }

    fn header(&mut self) -> Result<(), LogError> {
        self.has_header = true;
        let date = text(self.start.date());
        let text = format!(
            "date {date}\nbase hex  timestamps absolute\ninternal events logged\n// version 9.0.0\n\
             Begin Triggerblock {date}\n   0.000000 Start of measurement\n"
        );
        self.output.write(text.as_bytes())
    }
}

impl Sink for Asc {
    fn frame(&mut self, channel: u8, frame: &Frame) -> Result<Option<Loss>, LogError> {
        let since = match self.start.since(frame.time) {
            Ok(since) => since,
            Err(loss) => return Ok(Some(loss)),
        };
        if !self.has_header {
            self.header()?;
        }
        let line = &mut self.line;
        line.clear();
        line.extend_from_slice(b"   ");
        push_seconds(line, since);
        line.push(b' ');
        match frame.kind {
            FrameKind::Error => {
                push_channel(line, channel);
                line.extend_from_slice(b" ErrorFrame");
            }
            FrameKind::Fd { bit_rate_switch, error_state } => {
                line.extend_from_slice(b"CANFD ");
                push_channel(line, channel);
                line.extend_from_slice(b"Rx ");
                push_id(line, frame.id);
                for set in [bit_rate_switch, error_state] {
                    line.extend_from_slice(if set { b" 1" } else { b" 0" });
                }
                line.push(b' ');
                push_hexadecimal(line, fd_code(frame.length()).into(), 1);
                line.push(b' ');
                push_decimal(line, frame.length() as u64);
                push_bytes(line, frame.data());
                // Duration and bits, which are not known, the flags, checksum and bit timing.
                line.extend_from_slice(b" 0 0 ");
                let mark = |set, flag| if set { flag } else { 0 };
                let flags = FD | mark(bit_rate_switch, BIT_RATE_SWITCH) | mark(error_state, ERROR_STATE);
                push_hexadecimal(line, flags, 4);
                line.extend_from_slice(b" 0 0 0 0 0");
            }
            FrameKind::Data | FrameKind::Remote => {
                push_channel(line, channel);
                push_id(line, frame.id);
                let is_remote = frame.kind == FrameKind::Remote;
                line.extend_from_slice(if is_remote { b" Rx   r " } else { b" Rx   d " });
                push_decimal(line, frame.length() as u64);
                push_bytes(line, frame.data());
            }
        }
        line.push(b'\n');
        self.output.write(line)?;
        Ok(loss_of_error(frame))
    }

    fn finish(mut self: Box<Self>) -> Result<(), LogError> {
        if !self.has_header {
            self.header()?;
        }
        self.output.write(b"End TriggerBlock\n")?;
        self.output.finish()
    }
}

/// Counted from 1.
fn push_channel(line: &mut Vec<u8>, channel: u8) {
    push_decimal(line, u64::from(channel) + 1);
    line.push(b' ');
}

/// As many digits as it has; an `x` marks an extended one.
fn push_id(line: &mut Vec<u8>, id: CanId) {
    push_short_hexadecimal(line, id.number());
    if id.is_extended() {
        line.push(b'x');
    }
}
