//! Recordings of every format.

use std::io::Cursor;
use std::sync::atomic::{AtomicU32, Ordering::Relaxed};
use std::{env, fs};

use gripd::can::Frame;
use gripd::can::candump::write_line;
use gripd::can::recording::{LogStats, Reader};

/// Reads everything; MF4 files have to be files.
pub fn read(bytes: &[u8]) -> Option<(Vec<Frame>, LogStats)> {
    let reader = if bytes.starts_with(b"MDF ") || bytes.starts_with(b"UnFin") {
        // Tests run side by side.
        static COUNT: AtomicU32 = AtomicU32::new(0);
        let name = format!("fuzz-{}-{}.mf4", std::process::id(), COUNT.fetch_add(1, Relaxed));
        let path = env::temp_dir().join(name);
        fs::write(&path, bytes).unwrap();
        let reader = Reader::open(&path);
        // It is open, and needs no name any more.
        fs::remove_file(&path).unwrap();
        reader
    } else {
        Reader::from_read(Box::new(Cursor::new(bytes.to_vec())), "fuzz")
    };
    let mut reader = match reader {
        Ok(reader) => reader,
        Err(error) => {
            assert!(!error.to_string().is_empty());
            return None;
        }
    };
    let mut frames = Vec::new();
    while let Ok(Some(frame)) = reader.next_frame() {
        assert!(reader.interface().starts_with("can") || reader.format().part() == "line");
        frames.push(frame);
    }
    assert!(matches!(reader.next_frame(), Ok(None)), "after the end or an error there is nothing");
    Some((frames, reader.stats().clone()))
}

/// What can be read is counted, and can be written as candump and read again.
pub fn check(bytes: &[u8]) {
    let Some((frames, stats)) = read(bytes) else { return };
    assert_eq!(stats.frames as usize, frames.len());
    assert!(stats.frames + stats.skipped_lines <= stats.lines, "{stats:?}");
    assert_eq!(stats.reasons.iter().map(|(_, count)| count).sum::<u64>(), stats.skipped_lines);
    let mut text = b"(0.0) can0 123#00\n".to_vec();
    frames.iter().for_each(|frame| write_line(&mut text, "can0", frame));
    let (again, stats) = read(&text).unwrap();
    assert!(again[1..] == frames && stats.skipped_lines == 0, "{frames:?}\n{again:?}");
}
