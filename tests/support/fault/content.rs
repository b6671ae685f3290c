//! Frames that are whole and say nothing, or say it twice, or say it wrong.

use gripd::Faults;
use gripd::can::Frame;
use gripd::signals::e2e;

use super::frame::{INERTIAL, instead};
use super::{Case, Fault};

/// The frame with other bytes; `sealed` with the checksum that these ask for.
pub fn changed(frame: &Frame, sealed: bool, change: impl FnOnce(&mut [u8])) -> Vec<Frame> {
    let mut data = [0; 8];
    let data = &mut data[..frame.data().len()];
    data.copy_from_slice(frame.data());
    change(data);
    if sealed {
        data[0] = e2e::profile_1_crc(INERTIAL as u16, data, 0);
    }
    vec![Frame::new(frame.time, frame.id, frame.kind, data).unwrap()]
}

/// All of them.
pub fn cases() -> Vec<Case> {
    vec![
        Case {
            name: "a wheel speed that is coded as not available",
            fault: Fault::Frames(|frames| {
                instead(frames, 0x1A0, |f| changed(f, false, |d| d[..2].fill(0xFF)))
            }),
            told: Faults::NOT_AVAILABLE,
            ..Case::PLAIN
        },
        Case {
            name: "a quality bit that denies the steering angle",
            fault: Fault::Frames(|frames| instead(frames, 0x1C0, |f| changed(f, false, |d| d[2] &= !1))),
            told: Faults::NOT_AVAILABLE,
            ..Case::PLAIN
        },
        Case {
            name: "wrong checksums",
            fault: Fault::Frames(|frames| instead(frames, INERTIAL, |f| changed(f, false, |d| d[0] ^= 0x55))),
            told: Faults::CHECKSUM | Faults::TIMEOUT,
            ..Case::PLAIN
        },
        Case {
            name: "a counter that stands still",
            fault: Fault::Frames(|frames| {
                instead(frames, INERTIAL, |f| changed(f, true, |d| d[1] = d[1] & 0xF0 | 3))
            }),
            told: Faults::COUNTER | Faults::TIMEOUT,
            within: (0.15, 0.1),
            ..Case::PLAIN
        },
        Case {
            name: "a counter that jumps",
            fault: Fault::Frames(|frames| {
                instead(frames, INERTIAL, |f| {
                    changed(f, true, |d| d[1] = d[1] & 0xF0 | ((d[1] & 15) * 7 % 15))
                })
            }),
            told: Faults::COUNTER,
            ..Case::PLAIN
        },
        Case {
            name: "a counter that counts to 15 where 14 is its last",
            fault: Fault::Frames(|frames| {
                let mut counter = 0;
                let count = std::cell::RefCell::new(&mut counter);
                instead(frames, INERTIAL, |f| {
                    let mut counter = count.borrow_mut();
                    **counter = (**counter + 1) % 16;
                    changed(f, true, |d| d[1] = d[1] & 0xF0 | **counter)
                })
            }),
            told: Faults::COUNTER,
            within: (0.25, 0.1),
            ..Case::PLAIN
        },
        Case {
            name: "every frame twice",
            fault: Fault::Frames(|frames| instead(frames, INERTIAL, |f| vec![*f, *f])),
            told: Faults::COUNTER,
            ..Case::PLAIN
        },
    ]
}
