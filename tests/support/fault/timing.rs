//! Frames at the wrong time.

use gripd::can::Frame;
use gripd::{Faults, Micros};

use super::{Case, FROM, Fault, at, meanwhile};

/// All of them.
pub fn cases() -> Vec<Case> {
    vec![
        Case {
            name: "frames out of order by up to 15 ms",
            fault: Fault::Frames(|mut frames| {
                for pair in frames.chunks_mut(5).filter(|some| meanwhile(some[0].time)) {
                    pair.reverse();
                }
                frames
            }),
            told: Faults::COUNTER | Faults::TIME,
            ..Case::PLAIN
        },
        Case {
            name: "silence for five seconds",
            fault: Fault::Frames(|mut frames| {
                frames.retain(|frame| !meanwhile(frame.time));
                frames
            }),
            told: Faults::TIME | Faults::TIMEOUT,
            within: (5.1, 0.3),
            ..Case::PLAIN
        },
        Case {
            name: "bursts: a gateway that hands on every 100 ms",
            fault: Fault::Frames(|frames| {
                let hundred = Micros::from_millis(100);
                let late =
                    |f: &Frame| if meanwhile(f.time) { at(f, f.time.next_multiple_of(hundred)) } else { *f };
                let mut frames: Vec<Frame> = frames.iter().map(late).collect();
                frames.sort_by_key(|frame| frame.time);
                frames
            }),
            within: (0.0, 0.2),
            ..Case::PLAIN
        },
        Case {
            name: "a clock that is set back by three seconds",
            fault: Fault::Frames(|frames| {
                let back = |f: &Frame| {
                    if f.time.seconds() >= FROM { at(f, f.time - Micros::from_millis(3000)) } else { *f }
                };
                frames.iter().map(back).collect()
            }),
            told: Faults::TIME,
            until: FROM,
            ..Case::PLAIN
        },
        Case {
            name: "a message at a fifth of its rate",
            fault: Fault::Frames(|frames| {
                let kept =
                    |f: &Frame| f.id.number() != 0x1C0 || !meanwhile(f.time) || f.time.0 / 10_000 % 5 == 0;
                frames.into_iter().filter(kept).collect()
            }),
            within: (0.0, 0.1),
            ..Case::PLAIN
        },
        Case {
            name: "three messages at a half, a third and a fifth of their rate",
            fault: Fault::Frames(|frames| {
                let kept = |f: &Frame| {
                    let one_in = match f.id.number() {
                        0x1A0 => 2,
                        0x1D0 => 3,
                        0x1C0 => 5,
                        _ => 1,
                    };
                    !meanwhile(f.time) || f.time.0 / 10_000 % one_in == 0
                };
                frames.into_iter().filter(kept).collect()
            }),
            within: (0.0, 0.1),
            ..Case::PLAIN
        },
    ]
}
