//! A simulated bus, the same for all benchmarks.

use std::io::Cursor;

use gripd::Micros;
use gripd::can::candump::Reader;
use gripd::can::{CanId, Frame};

use crate::program::{gripd, project};

/// The frames of a candump log.
pub fn frames(text: &[u8]) -> Vec<Frame> {
    let mut reader = Reader::from_read(Box::new(Cursor::new(text.to_vec())), "bus").unwrap();
    std::iter::from_fn(|| reader.next_frame().unwrap()).collect()
}

/// One that nobody needs.
pub fn unneeded(number: usize, time: Micros) -> Frame {
    let id = CanId::standard(0x200 + (number as u32 * 37) % 0x400).unwrap();
    let data = (number as u64).wrapping_mul(0x9E37_79B9_7F4A_7C15).to_be_bytes();
    Frame::data_frame(time, id, &data).unwrap()
}

/// The demo drive of 120 s, and beside each of its frames one that nobody needs.
pub fn bus() -> Vec<Frame> {
    let mut simulate = gripd();
    simulate.args(["simulate", "-q"]).arg(project("config/scenarios/demo.toml")).args(["-o", "-"]);
    let drive = frames(&simulate.output().unwrap().stdout);
    let both = |(number, frame): (usize, &Frame)| [*frame, unneeded(number, frame.time)];
    drive.iter().enumerate().flat_map(both).collect()
}
