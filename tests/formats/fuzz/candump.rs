//! Recordings.

use std::io::Cursor;

use gripd::can::candump::{LogStats, Reader, write_line};
use gripd::can::{ErrorReport, Frame};

use super::mutate::Mutator;
use super::run::{Input, corpus, fuzz, known};
use testing::dice::Dice;

const WORDS: [&str; 12] =
    ["(1.5) ", " can0 ", "#", "##", "#R", "##1", "DROPCOUNT: 5", " T", " R", "20000040#", "7FF", "1FFFFFFF#"];

fn read(text: &[u8]) -> Option<(Vec<Frame>, LogStats)> {
    let mut reader = Reader::from_read(Box::new(Cursor::new(text.to_vec())), "fuzz.log").ok()?;
    let mut frames = Vec::new();
    // An error comes once and ends it: a broken archive.
    while let Ok(Some(frame)) = reader.next_frame() {
        frames.push(frame);
    }
    Some((frames, reader.stats().clone()))
}

/// What can be read can be written and read again; each line is a frame, damaged, or nothing.
fn check(text: &[u8]) {
    let Some((frames, stats)) = read(text) else { return };
    assert!(stats.frames as usize == frames.len() && stats.frames + stats.skipped_lines <= stats.lines);
    let lines = 1..=stats.lines;
    assert!(stats.first_skipped.iter().all(|skipped| lines.contains(&skipped.line)), "{stats:?}");
    let mut written = Vec::new();
    frames.iter().for_each(|frame| write_line(&mut written, "can0", frame));
    let again = read(&written).unwrap();
    assert!(frames == again.0 && again.1.skipped_lines == 0, "{frames:?}\n{again:?}");
    for report in frames.iter().filter_map(ErrorReport::from_frame) {
        assert!(!report.to_string().is_empty());
    }
}

#[test]
fn recordings() {
    known("candump", check);
    let seeds: Vec<Vec<u8>> = corpus("candump").into_iter().map(|(_, text)| text).collect();
    let mutator = Mutator { seeds: &seeds, words: &WORDS, longest: 4000 };
    fuzz("candump", 2000, |dice| mutator.make(dice), |text| check(text));
}

/// Lines that do not depend on each other, read in one go.
struct Lines(Vec<u8>);

impl Lines {
    const COUNT: u64 = 200;
}

impl Input for Lines {
    fn bytes(&self) -> Vec<u8> {
        self.0.clone()
    }

    fn count(&self) -> u64 {
        Self::COUNT
    }
}

#[test]
fn lines() {
    let text = corpus("candump").into_iter().find(|(name, _)| name.ends_with(".log")).unwrap().1;
    let seeds: Vec<Vec<u8>> = text.split(|byte| *byte == b'\n').map(<[u8]>::to_vec).collect();
    let mutator = Mutator { seeds: &seeds, words: &WORDS, longest: 200 };
    let make = |dice: &mut Dice| {
        // The first one is good, so that the text is a recording.
        let mut text = b"(0.0) can0 123#00".to_vec();
        for _ in 0..Lines::COUNT {
            text.push(b'\n');
            text.extend(mutator.make(dice));
        }
        Lines(text)
    };
    fuzz("lines", 1000, make, |lines| check(&lines.0));
}
