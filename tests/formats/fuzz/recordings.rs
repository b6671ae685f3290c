//! Recordings beyond candump: every format, under mutations that know some of its words.

use std::fs;
use std::io::Cursor;
use std::path::Path;
use std::sync::atomic::{AtomicU32, Ordering::Relaxed};

use gripd::can::Frame;
use gripd::can::candump::write_line;
use gripd::can::recording::{LogStats, Reader};

use super::mutate::Mutator;
use super::run::{corpus, fuzz, known};

/// Reads everything; MF4 files have to be files.
fn read(bytes: &[u8]) -> Option<(Vec<Frame>, LogStats)> {
    let reader = if bytes.starts_with(b"MDF ") || bytes.starts_with(b"UnFin") {
        // Tests run side by side.
        static COUNT: AtomicU32 = AtomicU32::new(0);
        let name = format!("fuzz-{}-{}.mf4", std::process::id(), COUNT.fetch_add(1, Relaxed));
        let path = Path::new(env!("CARGO_TARGET_TMPDIR")).join(name);
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
fn check(bytes: &[u8]) {
    let Some((frames, stats)) = read(bytes) else { return };
    assert_eq!(stats.frames as usize, frames.len());
    assert!(stats.frames + stats.skipped_lines <= stats.lines, "{stats:?}");
    assert_eq!(stats.reasons.iter().map(|(_, count)| count).sum::<u64>(), stats.skipped_lines);
    let mut text = b"(0.0) can0 123#00\n".to_vec();
    frames.iter().for_each(|frame| write_line(&mut text, "can0", frame));
    let (again, stats) = read(&text).unwrap();
    assert!(again[1..] == frames && stats.skipped_lines == 0, "{frames:?}\n{again:?}");
}

/// Mutations of the corpus's files with that extension.
fn run(name: &str, extension: &str, words: &[&str], times: u64) {
    let files = corpus("recordings").into_iter().filter(|(name, _)| name.ends_with(extension));
    let seeds: Vec<Vec<u8>> = files.map(|(_, bytes)| bytes).collect();
    assert!(!seeds.is_empty());
    let mutator = Mutator { seeds: &seeds, words, longest: 20_000 };
    fuzz(name, times, |dice| mutator.make(dice), |bytes| check(bytes));
}

#[test]
fn recordings_as_they_are() {
    known("recordings", |bytes| {
        let (frames, stats) = read(bytes).unwrap();
        assert!(frames.len() >= 3 && stats.skipped_lines == 0, "{stats:?}");
        check(bytes);
    });
}

#[test]
fn asc() {
    let words = [
        "date ",
        "base dec",
        "relative",
        "CANFD ",
        " Rx ",
        " d 8 ",
        "ErrorFrame",
        "x ",
        "Begin Triggerblock ",
        "\r\n",
    ];
    run("asc", ".asc", &words, 2000);
}

#[test]
fn trc() {
    let words =
        [";$FILEVERSION=", ";$STARTTIME=", ";$COLUMNS=", "N,O,T,B,I,d,R,L,D", " DT ", " RTR", " FB ", "Rx"];
    run("trc", ".trc", &words, 2000);
}

#[test]
fn csv() {
    run("csv", ".csv", &["timestamp,arbitration_id,", "0x", "==", ",1,", "e-05", ",,"], 2000);
}

#[test]
fn blf() {
    run("blf", ".blf", &["LOBJ", "LOGG", "\0\0\0\0", "\u{7F}\u{7F}", "LOBJ\u{20}\0\u{1}\0"], 4000);
}

#[test]
fn mf4() {
    run(
        "mf4",
        ".mf4",
        &["##DG", "##CG", "##CN", "##DT", "##DZ", "##DL", "##HL", "\0\0\0\0\0\0\0\0", "CAN_DataFrame"],
        4000,
    );
}
