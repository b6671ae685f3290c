//! A stretch of good traffic, with everything that buses, gateways, clocks and sensors do to it.

use gripd::Micros;
use gripd::can::{CanId, Frame, FrameKind};

use crate::dice::Dice;

/// From a place of the drive on, a few hundred frames, some of them spoiled.
pub fn traffic(dice: &mut Dice, drive: &[Frame]) -> Vec<Frame> {
    let length = 50 + dice.below(400);
    let start = dice.below(drive.len() - length);
    let mut frames = drive[start..start + length].to_vec();
    let rarely = 1 << dice.below(9);
    for _ in 0..=frames.len() / rarely {
        spoil(dice, &mut frames);
    }
    frames
}

/// One thing goes wrong somewhere in it.
pub fn spoil(dice: &mut Dice, frames: &mut Vec<Frame>) {
    if frames.len() < 2 {
        return;
    }
    let (place, other) = (dice.below(frames.len()), dice.below(frames.len()));
    let frame = frames[place];
    match dice.below(12) {
        0 => drop(frames.remove(place)),
        1 => frames.insert(other, frame),
        2 => frames.swap(place, other),
        3 => drop(frames.drain(place..(place + dice.length(200)).min(frames.len() - 1))),
        4 => frames[place].time = Micros(dice.draw() as i64),
        // The clock is set for all that follows.
        5 => {
            let step = dice.number() * 10f64.powi(dice.below(7) as i32);
            frames[place..].iter_mut().for_each(|frame| frame.time = frame.time + Micros(step as i64));
        }
        6 => frames[place].time = frame.time + Micros(dice.length(2_000_000) as i64 - 1_000_000),
        7 => frames[place] = other_kind(dice, &frame),
        // The same bytes for a while: a frozen sensor, a gateway that repeats itself.
        8 => {
            let until = (place + dice.length(400)).min(frames.len());
            for later in frames[place..until].iter_mut().filter(|later| later.id == frame.id) {
                *later = at(later.time, &frame);
            }
        }
        _ => {
            let mut data = [0; 64];
            let length = frame.data().len();
            data[..length].copy_from_slice(frame.data());
            for _ in 0..=dice.below(3) {
                let byte = &mut data[dice.below(length.max(1))];
                *byte = *dice.of(&[0, 0xFF, 0x7F, 0x80, *byte ^ 1, *byte ^ 0x80, !*byte]);
            }
            frames[place] = Frame::new(frame.time, frame.id, frame.kind, &data[..length]).unwrap_or(frame);
        }
    }
}

/// The identifier as another kind of frame, or the frame with another identifier.
fn other_kind(dice: &mut Dice, frame: &Frame) -> Frame {
    let any: Vec<u8> = (0..64).map(|_| dice.draw() as u8).collect();
    let fd = FrameKind::Fd { bit_rate_switch: true, error_state: dice.once_in(2) };
    let made = match dice.below(6) {
        0 => Frame::remote(frame.time, frame.id, dice.below(9)),
        1 => Frame::new(frame.time, frame.id, fd, &any[..*dice.of(&[0, 8, 12, 64])]),
        2 => Frame::new(frame.time, frame.id, FrameKind::Error, &any[..8]),
        3 => Frame::data_frame(frame.time, frame.id, &any[..dice.below(9)]),
        4 => Frame::data_frame(
            frame.time,
            CanId::extended(frame.id.number()).unwrap_or(frame.id),
            frame.data(),
        ),
        _ => Frame::data_frame(
            frame.time,
            CanId::standard(dice.below(0x800) as u32).unwrap_or(frame.id),
            frame.data(),
        ),
    };
    made.unwrap_or(*frame)
}

/// The same at another time.
pub fn at(time: Micros, frame: &Frame) -> Frame {
    let mut moved = *frame;
    moved.time = time;
    moved
}
