//! A frame as a line of `candump -L`.

use physics::Micros;

use super::wire::{ERROR, fd_flags};
use super::words::{Words, to_hexadecimal};
use super::{Frame, FrameKind};

/// Appends a frame as `candump -L` would print it, with a newline.
///
/// Seconds are not padded to ten digits (candump pads, which shows before September 2001 only).
pub fn write_line(text: &mut Vec<u8>, interface: &str, frame: &Frame) {
    push_stamp(text, frame.time);
    push_rest(text, interface, frame);
}

pub(in crate::can) fn push_stamp(text: &mut Vec<u8>, time: Micros) {
    let mut stamp = Words::default();
    stamp.one(b'(').seconds(time).word(*b")       ", 2);
    text.extend_from_slice(stamp.text());
}

/// What comes after the stamp.
pub(in crate::can) fn push_rest(text: &mut Vec<u8>, interface: &str, frame: &Frame) {
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
