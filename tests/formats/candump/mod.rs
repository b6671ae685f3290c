//! Reading and writing candump logs: the whole grammar, damaged and endless input, packing.

mod grammar;
mod hard_input;
mod packed;
mod real_recordings;
mod writing;

use std::fs;
use std::io::{self, Cursor, Read, Write};
use std::os::unix::fs::FileTypeExt;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex};

use gripd::Micros;
use gripd::can::candump::{Compression, Damage, LogError, LogStats, Reader, Writer, write_line};
use gripd::can::{CanId, Frame, FrameKind};
use proptest::prelude::*;

fn read(text: impl Into<Vec<u8>>) -> (Vec<Frame>, LogStats) {
    let mut reader = Reader::from_read(Box::new(Cursor::new(text.into())), "test").unwrap();
    let mut frames = Vec::new();
    while let Some(frame) = reader.next_frame().unwrap() {
        frames.push(frame);
    }
    (frames, reader.stats().clone())
}

/// The only frame of a line.
#[track_caller]
fn one(line: &str) -> Frame {
    let (frames, stats) = read(line);
    assert_eq!(frames.len(), 1, "{line}: {stats:?}");
    frames[0]
}

#[track_caller]
fn damage(line: &str) -> Damage {
    let (frames, stats) = read(line);
    assert!(frames.is_empty(), "{line}: {frames:?}");
    assert_eq!(stats.skipped_lines, 1, "{line}");
    stats.first_skipped[0].reason
}

fn standard(number: u32) -> CanId {
    CanId::standard(number).unwrap()
}

fn extended(number: u32) -> CanId {
    CanId::extended(number).unwrap()
}

fn fd(bit_rate_switch: bool, error_state: bool) -> FrameKind {
    FrameKind::Fd { bit_rate_switch, error_state }
}
