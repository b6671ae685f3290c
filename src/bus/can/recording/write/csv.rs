//! python-can's CSV, the data in base64.

use super::loss::Loss;
use super::{Sink, loss_of_error};
use crate::can::recording::digits::{push_decimal, push_seconds, push_short_hexadecimal};
use crate::can::recording::{LogError, TextOutput};
use crate::can::{Frame, FrameKind};

/// Writes a line for each frame.
pub struct Csv {
    output: TextOutput,
    line: Vec<u8>,
}

impl Csv {
    /// Writes the names of the columns.
    pub fn new(mut output: TextOutput) -> Result<Self, LogError> {
        output.write(b"timestamp,arbitration_id,extended,remote,error,dlc,data\n")?;
        Ok(Self { output, line: Vec::new() })
    }
}

impl Sink for Csv {
    fn frame(&mut self, channel: u8, frame: &Frame) -> Result<Option<Loss>, LogError> {
        let (line, is_error) = (&mut self.line, frame.kind == FrameKind::Error);
        line.clear();
        push_seconds(line, frame.time);
        line.extend_from_slice(b",0x");
        push_short_hexadecimal(line, frame.id.number());
        for set in [frame.id.is_extended(), frame.kind == FrameKind::Remote, is_error] {
            line.extend_from_slice(if set { b",1" } else { b",0" });
        }
        line.push(b',');
        push_decimal(line, frame.length() as u64);
        line.push(b',');
        push_base64(line, frame.data());
        line.push(b'\n');
        self.output.write(line)?;
        Ok(match frame.kind {
            FrameKind::Fd { bit_rate_switch, error_state } => {
                let reads_the_same = frame.length() > 8 && !bit_rate_switch && !error_state;
                (!reads_the_same).then_some(Loss::FdMarks)
            }
            _ => loss_of_error(frame),
        }
        .or((channel != 0).then_some(Loss::Interface)))
    }

    fn finish(self: Box<Self>) -> Result<(), LogError> {
        self.output.finish()
    }
}

/// As RFC 4648 has it, with its padding.
fn push_base64(line: &mut Vec<u8>, bytes: &[u8]) {
    const DIGITS: &[u8; 64] = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    for group in bytes.chunks(3) {
        let byte = |place: usize| u32::from(group.get(place).copied().unwrap_or(0));
        let bits = byte(0) << 16 | byte(1) << 8 | byte(2);
        for place in 0..4 {
            let digit = DIGITS[(bits >> (18 - 6 * place) & 0x3F) as usize];
            line.push(if place > group.len() { b'=' } else { digit });
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn base64_is_that_of_the_rfc() {
        for (bytes, expected) in
            [("", ""), ("f", "Zg=="), ("fo", "Zm8="), ("foo", "Zm9v"), ("foobar", "Zm9vYmFy")]
        {
            let mut text = Vec::new();
            push_base64(&mut text, bytes.as_bytes());
            assert_eq!(String::from_utf8(text).unwrap(), expected);
        }
    }
}
