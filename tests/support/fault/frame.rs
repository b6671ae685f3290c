//! Frames that are not what the DBC says, and frames that are none of ours.

use gripd::Faults;
use gripd::can::{CanId, Frame, FrameKind};

use super::{Case, Fault, meanwhile};

/// The message of the inertial sensors.
pub const INERTIAL: u32 = 0x1B0;

/// Each frame of a message, while the fault lasts, made into others.
pub fn instead(frames: Vec<Frame>, id: u32, made: impl Fn(&Frame) -> Vec<Frame>) -> Vec<Frame> {
    let of = |frame: &Frame| frame.id.number() == id && frame.is_data() && meanwhile(frame.time);
    frames.into_iter().flat_map(|frame| if of(&frame) { made(&frame) } else { vec![frame] }).collect()
}

fn with(frame: &Frame, kind: FrameKind, data: &[u8]) -> Frame {
    Frame::new(frame.time, frame.id, kind, data).unwrap()
}

const FD: FrameKind = FrameKind::Fd { bit_rate_switch: true, error_state: false };

/// All of them.
pub fn cases() -> Vec<Case> {
    let lost = Faults::FRAME | Faults::TIMEOUT;
    vec![
        Case {
            name: "a message too short",
            fault: Fault::Frames(|frames| {
                instead(frames, INERTIAL, |f| vec![with(f, f.kind, &f.data()[..6])])
            }),
            told: lost,
            ..Case::PLAIN
        },
        Case {
            name: "a message longer than the DBC has it",
            fault: Fault::Frames(|frames| {
                instead(frames, 0x1C0, |f| vec![with(f, f.kind, &[f.data(), &[0xFF; 4]].concat())])
            }),
            ..Case::PLAIN
        },
        Case {
            name: "remote requests in a message's place",
            fault: Fault::Frames(|frames| {
                instead(frames, INERTIAL, |f| vec![Frame::remote(f.time, f.id, 8).unwrap()])
            }),
            told: lost,
            ..Case::PLAIN
        },
        Case {
            name: "FD frames on a classic identifier",
            fault: Fault::Frames(|frames| instead(frames, INERTIAL, |f| vec![with(f, FD, f.data())])),
            ..Case::PLAIN
        },
        Case {
            name: "the same identifier, extended, with other contents",
            fault: Fault::Frames(|frames| {
                instead(frames, INERTIAL, |f| {
                    let other = CanId::extended(INERTIAL).unwrap();
                    vec![*f, Frame::data_frame(f.time, other, &[0xAA; 8]).unwrap()]
                })
            }),
            ..Case::PLAIN
        },
        Case {
            name: "error frames between the others",
            fault: Fault::Frames(|frames| {
                instead(frames, INERTIAL, |f| {
                    let class = CanId::extended(0x88).unwrap();
                    vec![*f, Frame::new(f.time, class, FrameKind::Error, &[0; 8]).unwrap()]
                })
            }),
            told: Faults::BUS_ERROR,
            ..Case::PLAIN
        },
        Case {
            name: "own messages come back",
            fault: Fault::Frames(|frames| {
                instead(frames, INERTIAL, |f| {
                    let own = (0x6A0..=0x6A6).map(|id| CanId::standard(id).unwrap());
                    let echo = own.map(|id| Frame::data_frame(f.time, id, &[0xFF; 8]).unwrap());
                    std::iter::once(*f).chain(echo).collect()
                })
            }),
            ..Case::PLAIN
        },
    ]
}
