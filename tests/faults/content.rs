//! Frames that are whole and say nothing, or say it twice, or say it wrong.

use gripd::can::Frame;
use gripd::signals::e2e;
use gripd::{Config, Faults};

use super::car;
use super::case::{self, Case, Fault};
use super::frame::instead;

const INERTIAL: u32 = 0x1B0;

/// The frame with other bytes; `sealed` with the checksum that these ask for.
fn changed(frame: &Frame, sealed: bool, change: impl FnOnce(&mut [u8])) -> Vec<Frame> {
    let mut data = [0; 8];
    let data = &mut data[..frame.data().len()];
    data.copy_from_slice(frame.data());
    change(data);
    if sealed {
        data[0] = e2e::profile_1_crc(INERTIAL as u16, data, 0);
    }
    vec![Frame::new(frame.time, frame.id, frame.kind, data).unwrap()]
}

#[test]
fn faults_of_content() {
    let cases = [
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
    ];
    case::check(&car::config(), car::readings(), &cases);
}

/// The demo's car with a steering angle in floating point and a brake pressure on a page of its own.
fn other_car() -> (Config, tempfile::TempDir) {
    let folder = tempfile::tempdir().unwrap();
    let dbc = std::fs::read_to_string(car::project("dbc/demo.dbc")).unwrap();
    let edits = [
        ("STEERING: 4 EPS", "STEERING: 8 EPS"),
        ("Angle : 0|16@1- (0.1,0) [-1000|1000] \"deg\"", "Angle : 0|32@1- (1,0) [0|0] \"deg\""),
        ("AngleValid : 16|1", "AngleValid : 32|1"),
        (" SG_ BrakePressure :", " SG_ Page M : 40|4@1+ (1,0) [0|15] \"\" GATEWAY\n SG_ BrakePressure m1 :"),
    ];
    let dbc = edits.iter().fold(dbc, |dbc, (was, is)| {
        assert_eq!(dbc.matches(was).count(), 1, "{was}");
        dbc.replace(was, is)
    });
    let file = folder.path().join("car.dbc");
    std::fs::write(&file, dbc + "\nSIG_VALTYPE_ 448 Angle : 1;\n").unwrap();
    (car::with(&[("../dbc/demo.dbc", file.to_str().unwrap())]), folder)
}

#[test]
fn faults_of_floating_point_and_multiplexed_content() {
    let cases = [
        Case {
            name: "not a number in a floating-point signal",
            fault: Fault::Frames(|frames| {
                instead(frames, 0x1C0, |f| {
                    changed(f, false, |d| d[..4].copy_from_slice(&f32::NAN.to_le_bytes()))
                })
            }),
            told: Faults::NOT_AVAILABLE,
            ..Case::PLAIN
        },
        Case {
            name: "a page that does not come (multiplexed brake pressure)",
            fault: Fault::Frames(|frames| instead(frames, 0x1D0, |f| changed(f, false, |d| d[5] = 0))),
            told: Faults::TIMEOUT,
            within: (0.3, 0.1),
            ..Case::PLAIN
        },
    ];
    let (config, _folder) = other_car();
    case::check(&config, car::readings(), &cases);
}
