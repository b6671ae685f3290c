//! A log again with other bytes in some of its frames: every other line, and the rest of these, as it was to the byte.

use std::io::{BufRead, BufReader, Read};
use std::path::Path;

use super::LogError;
use super::line::{self, Line};
use crate::can::Frame;
use crate::can::recording::{Content, LONGEST_LINE, TextOutput, unpack};

/// Writes a log again. `change` says what a frame becomes: one of the same identifier and length, or none where it stays
/// as it is. (gzip and zstd around the log that is read are recognized; that which is written is packed as its name says.)
///
/// # Errors
/// If the log cannot be read to its end, or the other not be written; then there is no file of its name.
pub fn rewrite(
    from: &Path,
    to: &Path,
    mut change: impl FnMut(&Frame) -> Option<Frame>,
) -> Result<(), LogError> {
    let name = from.display().to_string();
    let failed = |line: u64| {
        let name = name.clone();
        move |source| LogError::Read { name, line, source }
    };
    let file = std::fs::File::open(from).map_err(|source| LogError::Open { name: name.clone(), source })?;
    let (source, content) = unpack(Box::new(file)).map_err(failed(0))?;
    if !matches!(content, Content::Log(_)) {
        return Err(LogError::OtherFormat { name, format: "a recording of another format" });
    }
    let mut source = BufReader::with_capacity(1 << 16, source);
    let mut output = TextOutput::create(to)?;
    let (mut text, mut number) = (Vec::new(), 0);
    // The beginning of the line was too long for any frame.
    let mut goes_on = false;
    loop {
        text.clear();
        let most = LONGEST_LINE as u64;
        let read = source.by_ref().take(most).read_until(b'\n', &mut text).map_err(failed(number))?;
        if read == 0 {
            return output.finish();
        }
        number += 1;
        let is_whole = !std::mem::replace(&mut goes_on, text.last() != Some(&b'\n') && read as u64 == most);
        if is_whole
            && let Ok(Line::Frame { interface, frame }) = line::parse(text.strip_suffix(b"\n").unwrap_or(&text))
            // As the reader of logs has it.
            && str::from_utf8(interface).is_ok()
            && let Some(changed) = change(&frame)
        {
            put(&mut text, &changed);
        }
        output.write(&text)?;
    }
}

/// Puts a frame's bytes in the place of those that the line has, digit by digit.
fn put(text: &mut [u8], frame: &Frame) {
    let Some(mark) = text.iter().position(|byte| *byte == b'#') else { return };
    // Behind the second mark of an FD frame stand its flags.
    let begin = mark + if frame.is_fd() { 3 } else { 1 };
    let digits = text.iter_mut().skip(begin).filter(|byte| byte.is_ascii_hexdigit());
    let nibbles = frame.data().iter().flat_map(|byte| [byte >> 4, byte & 15]);
    for (digit, nibble) in digits.zip(nibbles) {
        let is_small = digit.is_ascii_lowercase();
        let upper = b"0123456789ABCDEF"[usize::from(nibble)];
        *digit = if is_small { upper.to_ascii_lowercase() } else { upper };
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn rewritten(text: &str, change: impl FnMut(&Frame) -> Option<Frame>) -> String {
        let folder = tempfile::tempdir().unwrap();
        let (from, to) = (folder.path().join("a.log"), folder.path().join("b.log"));
        std::fs::write(&from, text).unwrap();
        rewrite(&from, &to, change).unwrap();
        std::fs::read_to_string(&to).unwrap()
    }

    const LINES: &str = "# a comment\n(1.5) can0  123#01020304\r\n damage\n(2.000001) vcan1 12345678##1a0.b1.c2 T\n\
                         (3.0) can0 123#R4\n(4.0) can0 123#ffee";

    #[test]
    fn what_is_not_changed_is_as_it_was() {
        assert_eq!(rewritten(LINES, |_| None), LINES);
    }

    #[test]
    fn only_the_digits_of_the_bytes_are_exchanged() {
        let inverted = |frame: &Frame| {
            let data: Vec<u8> = frame.data().iter().map(|byte| !byte).collect();
            Frame::new(frame.time, frame.id, frame.kind, &data).ok().filter(|_| frame.is_data())
        };
        let expected =
            LINES.replace("#01020304", "#FEFDFCFB").replace("a0.b1.c2", "5F.4E.3D").replace("#ffee", "#0011");
        // A digit that was none of the small letters comes as a capital one.
        assert_eq!(rewritten(LINES, inverted).to_uppercase(), expected.to_uppercase());
    }
}
