//! GIVEN estimates WHEN they are published THEN every field comes back from the frame, what is not known
//! as not available, and every frame is protected.

use gripd::can::{CanId, Frame, FrameKind};
use gripd::dbc::Database;
use gripd::estimates::{Estimate, Friction, Motion, MuSource, State};
use gripd::signals::e2e;
use gripd::signals::publish::{
    BUILT_IN_DBC, IdConfig, PublishConfig, PublishError, Publisher, built_in_database,
};
use gripd::{Estimates, Faults, Micros};
use proptest::prelude::*;
use testing::allocator::{Asked, asked_by};

fn database() -> Database {
    built_in_database().unwrap()
}

fn publisher() -> Publisher {
    Publisher::new(&database(), &PublishConfig::default()).unwrap()
}

fn frames(publisher: &mut Publisher, estimates: &Estimates) -> Vec<Frame> {
    let mut frames = Vec::new();
    publisher.publish(Micros(1_000), estimates, &mut |frame| frames.push(*frame));
    frames
}

/// Without the last digits that a product of binary fractions leaves.
fn rounded(value: f64) -> f64 {
    (value * 1e9).round() / 1e9
}

/// The value of a published field; `None` if it is the code for not available.
fn field(frames: &[Frame], name: &str) -> Option<f64> {
    let database = database();
    let (message, signal) = database.signal(name).unwrap();
    let frame = frames.iter().find(|frame| frame.id == message.id).unwrap();
    let bits = signal.bits(frame.data()).unwrap();
    if signal.value_name(bits) == Some("not_available") { None } else { Some(rounded(signal.physical(bits))) }
}

fn publish(estimates: &Estimates, name: &str) -> Option<f64> {
    field(&frames(&mut publisher(), estimates), name)
}

fn estimate(value: f64, std: f64, age_s: f64) -> Option<Estimate> {
    Some(Estimate { value, std, age_s })
}

/// Everything known, every value different.
fn full() -> Estimates {
    Estimates {
        state: State::Degraded,
        friction: Friction {
            max: Some(0.85),
            low: Some(0.7),
            high: Some(1.1),
            used: Some(0.302),
            source: MuSource::Brush,
            valid: true,
            age_s: Some(3.2),
            ..Friction::default()
        },
        motion: Motion {
            speed: Some(27.35),
            lateral_velocity: Some(-0.46),
            sideslip: Some(-0.0165),
            slip_angle_front: Some(0.021),
            slip_angle_rear: Some(-0.0045),
            valid: true,
        },
        slope: [estimate(41.125, 1.5, 2.0), estimate(39.5, 2.25, 7.0), None, None],
        slip_offset: [estimate(-0.0123, 0.0002, 2.0), estimate(0.0087, 0.00035, 2.0), None, None],
        slope_valid: true,
        cornering: [estimate(11.53, 0.31, 4.0), estimate(13.02, 0.44, 9.0)],
        cornering_valid: true,
        excitation_long: 0.42,
        excitation_lat: 1.0,
        surface_changes: 3,
        faults: Faults::TIMEOUT | Faults::CONFIG,
        dropped_frames: 17,
        ..Estimates::default()
    }
}

#[test]
fn every_field_comes_back() {
    let frames = frames(&mut publisher(), &full());
    assert_eq!(frames.len(), 7);
    assert!(frames.iter().all(|f| f.time == Micros(1_000) && f.kind == FrameKind::Data && f.length() == 8));
    let expected = [
        ("GRIP_FRICTION.MuMax", Some(0.85)),
        ("GRIP_FRICTION.MuMaxLow", Some(0.7)),
        ("GRIP_FRICTION.MuMaxHigh", Some(1.1)),
        ("GRIP_FRICTION.MuUsed", Some(0.302)),
        ("GRIP_FRICTION.MuSource", Some(3.0)),
        ("GRIP_FRICTION.MuValid", Some(1.0)),
        ("GRIP_FRICTION.MuAge", Some(3.2)),
        ("GRIP_STIFFNESS_LONG.SlopeFL", Some(41.125)),
        ("GRIP_STIFFNESS_LONG.SlopeFR", Some(39.5)),
        ("GRIP_STIFFNESS_LONG.SlopeRL", None),
        ("GRIP_STIFFNESS_LONG.SlopeRR", None),
        ("GRIP_STIFFNESS_LONG.SlopeStd", Some(2.25)),
        ("GRIP_STIFFNESS_LONG.SlopeValid", Some(1.0)),
        ("GRIP_SLIP_OFFSET.OffsetFL", Some(-0.0123)),
        ("GRIP_SLIP_OFFSET.OffsetFR", Some(0.0087)),
        ("GRIP_SLIP_OFFSET.OffsetRL", None),
        ("GRIP_SLIP_OFFSET.OffsetRR", None),
        ("GRIP_SLIP_OFFSET.OffsetStd", Some(0.00035)),
        ("GRIP_SLIP_OFFSET.SlopeAge", Some(7.0)),
        ("GRIP_STIFFNESS_LAT.CorneringFront", Some(11.53)),
        ("GRIP_STIFFNESS_LAT.CorneringRear", Some(13.02)),
        ("GRIP_STIFFNESS_LAT.CorneringStdFront", Some(0.31)),
        ("GRIP_STIFFNESS_LAT.CorneringStdRear", Some(0.44)),
        ("GRIP_STIFFNESS_LAT.CorneringValid", Some(1.0)),
        ("GRIP_STIFFNESS_LAT.CorneringAge", Some(9.0)),
        ("GRIP_MOTION.Speed", Some(27.35)),
        ("GRIP_MOTION.LateralVelocity", Some(-0.46)),
        ("GRIP_MOTION.Sideslip", Some(-0.0165)),
        ("GRIP_MOTION.SlipAngleFront", Some(0.021)),
        ("GRIP_MOTION.SlipAngleRear", Some(-0.0045)),
        ("GRIP_MOTION.MotionValid", Some(1.0)),
        ("GRIP_STATUS.State", Some(2.0)),
        ("GRIP_STATUS.ExcitationLong", Some(42.0)),
        ("GRIP_STATUS.ExcitationLat", Some(100.0)),
        ("GRIP_STATUS.SurfaceChanges", Some(3.0)),
        ("GRIP_STATUS.Faults", Some(32769.0)),
        ("GRIP_STATUS.DroppedFrames", Some(17.0)),
        ("GRIP_STATUS_2.Faults", Some(0.0)),
    ];
    for (name, value) in expected {
        assert_eq!(field(&frames, name), value, "{name}");
    }
    // The list above is the whole interface.
    let signals: usize = database().messages().iter().map(|m| m.signals.len() - 2).sum();
    assert_eq!(signals, expected.len());
}

#[test]
fn nothing_known_is_not_available_and_never_valid() {
    let mut estimates = Estimates::default();
    estimates.friction.valid = true;
    estimates.motion.valid = true;
    estimates.slope_valid = true;
    estimates.cornering_valid = true;
    let frames = frames(&mut publisher(), &estimates);
    for message in database().messages() {
        for signal in message.signals.iter().filter(|s| s.value_named("not_available").is_some()) {
            let name = format!("{}.{}", message.name, signal.name);
            let known = ["ExcitationLong", "ExcitationLat", "SurfaceChanges"].contains(&signal.name.as_str());
            assert_eq!(field(&frames, &name), known.then_some(0.0), "{name}");
        }
    }
    for flag in [
        "GRIP_FRICTION.MuValid",
        "GRIP_STIFFNESS_LONG.SlopeValid",
        "GRIP_STIFFNESS_LAT.CorneringValid",
        "GRIP_MOTION.MotionValid",
    ] {
        assert_eq!(field(&frames, flag), Some(0.0), "{flag}");
    }
}

#[test]
fn what_the_bits_cannot_carry_is_not_available_and_withdraws_the_flag() {
    let with = |max| {
        let mut estimates = full();
        estimates.friction.max = Some(max);
        let frames = frames(&mut publisher(), &estimates);
        (field(&frames, "GRIP_FRICTION.MuMax"), field(&frames, "GRIP_FRICTION.MuValid"))
    };
    assert_eq!(with(0.0), (Some(0.0), Some(1.0)));
    assert_eq!(with(2.044), (Some(2.044), Some(1.0)));
    for max in [2.046, 3.0, -0.1, f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
        assert_eq!(with(max), (None, Some(0.0)), "{max}");
    }
}

#[test]
fn signed_limits_keep_clear_of_the_code_for_not_available() {
    let with = |value| {
        let mut estimates = full();
        estimates.motion.lateral_velocity = Some(value);
        publish(&estimates, "GRIP_MOTION.LateralVelocity")
    };
    assert_eq!(with(10.22), Some(10.22));
    assert_eq!(with(-10.22), Some(-10.22));
    assert_eq!((with(-10.24), with(10.24), with(-99.0)), (None, None, None));
}

#[test]
fn ages_and_counts_stay_at_their_highest_code() {
    let age = |age: f64| {
        let mut estimates = full();
        estimates.friction.age_s = Some(age);
        estimates.slope[0] = estimate(40.0, 1.0, age);
        estimates.cornering[1] = estimate(12.0, 1.0, age);
        let frames = frames(&mut publisher(), &estimates);
        ["GRIP_FRICTION.MuAge", "GRIP_SLIP_OFFSET.SlopeAge", "GRIP_STIFFNESS_LAT.CorneringAge"]
            .map(|name| field(&frames, name))
    };
    assert_eq!(age(25.3), [Some(25.3), Some(25.0), Some(25.0)]);
    assert_eq!(age(1e6), [Some(25.4), Some(62.0), Some(126.0)]);
    assert_eq!(age(f64::NAN), [None; 3]);
    assert_eq!(age(-1.0), [None, Some(7.0), Some(4.0)]);
    let count = |changes, dropped| {
        let estimates = Estimates { surface_changes: changes, dropped_frames: dropped, ..full() };
        let frames = frames(&mut publisher(), &estimates);
        ["GRIP_STATUS.SurfaceChanges", "GRIP_STATUS.DroppedFrames"].map(|name| field(&frames, name).unwrap())
    };
    assert_eq!(count(253, 254), [253.0, 254.0]);
    assert_eq!(count(255, 255), [254.0, 255.0]);
    assert_eq!(count(u32::MAX, u64::MAX), [254.0, 255.0]);
}

#[test]
fn every_frame_is_counted_and_protected() {
    let mut publisher = publisher();
    let mut counters = Vec::new();
    for _ in 0..31 {
        for frame in frames(&mut publisher, &full()) {
            let data = frame.data();
            assert_eq!(data[0], e2e::profile_1_crc(frame.id.number() as u16, data, 0));
            if frame.id.number() == 0x6A0 {
                counters.push(data[1] & 0x0F);
            }
        }
    }
    let expected: Vec<u8> = (0..31).map(|n| n % 15).collect();
    assert_eq!(counters, expected);
}

#[test]
fn the_layout_is_what_integrators_were_told() {
    let frames = frames(&mut publisher(), &Estimates::default());
    let text: Vec<String> = frames.iter().map(|f| format!("{} {:02X?}", f.id, &f.data()[1..])).collect();
    assert_eq!(text[0], "6A0 [F0, FF, FF, FF, FF, 0F, FF]");
    assert_eq!(text[1], "6A1 [F0, FF, FF, FF, FF, FF, 7F]");
    assert_eq!(text[2], "6A2 [00, 20, 80, 00, 02, F8, FF]");
    assert_eq!(text[5], "6A5 [00, 00, 00, 00, 00, 00, 00]");
    assert_eq!(text[6], "6A6 [00, 00, 00, 00, 00, 00, 00]");
}

#[test]
fn publishing_allocates_nothing() {
    let mut publisher = publisher();
    let mut known = full();
    // Errors on the way must not allocate either.
    known.motion.speed = Some(1e9);
    let mut sum = 0_u64;
    let asked = asked_by(|| {
        for n in 0..1000 {
            let estimates = if n % 2 == 0 { &known } else { &Estimates::default() };
            publisher.publish(Micros(n), estimates, &mut |frame| sum += u64::from(frame.data()[0]));
        }
    });
    assert_eq!(asked, Asked::default());
    assert!(sum > 0);
    assert!(asked_by(|| drop(std::hint::black_box(Box::new(0)))).requests > 0, "the counter counts");
}

#[test]
fn identifiers_and_messages_are_chosen_in_the_configuration() {
    let config: PublishConfig = toml::from_str(
        "messages = [\"GRIP_FRICTION\", \"GRIP_STATUS\"]\nids = { GRIP_FRICTION = 0x18FF1234, GRIP_STATUS = 0x7A0 }",
    )
    .unwrap();
    let mut publisher = Publisher::new(&database(), &config).unwrap();
    let ids = [CanId::extended(0x18FF_1234).unwrap(), CanId::standard(0x7A0).unwrap()];
    assert_eq!(publisher.ids(), ids);
    assert_eq!(publisher.period(), Micros(20_000));
    let frames = frames(&mut publisher, &full());
    assert_eq!(frames.iter().map(|f| f.id).collect::<Vec<_>>(), ids);
    assert_eq!(frames[0].data()[0], e2e::profile_1_crc(0x1234, frames[0].data(), 0));
    let off = PublishConfig { enabled: false, ..PublishConfig::default() };
    assert_eq!(Publisher::new(&database(), &off).unwrap().ids(), []);
}

#[test]
fn everything_wrong_in_the_configuration_is_said_at_once() {
    let mut config = PublishConfig { period_ms: 0, ..PublishConfig::default() };
    config.messages = Some(vec!["GRIP_FRICTION".into(), "GRIP_MOTION".into(), "GRIP_FICTION".into()]);
    config.ids.insert("GRIP_FRICTION".into(), IdConfig::Number(0x6A4));
    config.ids.insert("GRIP_STATE".into(), IdConfig::Number(1));
    let error = Publisher::new(&database(), &config).unwrap_err().to_string();
    for part in [
        "publish.period_ms = 0",
        "publish.messages: `GRIP_FICTION`",
        "publish.ids: `GRIP_STATE`",
        "GRIP_FRICTION and GRIP_MOTION would both have the identifier 6A4",
    ] {
        assert!(error.contains(part), "{error}");
    }
}

/// An integrator's own output: FD, Motorola, other units, floats, one message only.
const OWN: &str = r#"
BO_ 2566843904 GRIP_FRICTION: 16 GW
 SG_ MuUsed : 7|16@0+ (0.01,0) [0|0] "%" X
 SG_ MuAge : 32|32@1- (1,0) [0|0] "ms" X
 SG_ MuMax : 23|8@0+ (0.01,0) [0|0] "" X
 SG_ MuValid : 24|1@1+ (1,0) [0|0] "" X
 SG_ Spare : 100|8@1+ (1,0) [0|0] "" X
 SG_ Counter : 64|4@1+ (1,0) [0|14] "" X
 SG_ Crc : 79|8@0+ (1,0) [0|0] "" X
BO_ 100 GRIP_MOTION: 8 GW
 SG_ Speed : 0|16@1+ (0.01,0) [0|0] "km/h" X
 SG_ Sideslip : 16|16@1- (0.01,0) [0|0] "deg" X
SIG_VALTYPE_ 2566843904 MuAge : 1;
VAL_ 2566843904 MuUsed 65535 "not_available" ;
VAL_ 2566843904 MuMax 0 "not_available" ;
VAL_ 100 Speed 65535 "not_available" ;
VAL_ 100 Sideslip -32768 "not_available" ;
"#;

#[test]
fn an_own_output_dbc_may_lay_out_the_fields_otherwise() {
    let database = Database::parse(OWN.as_bytes(), "own.dbc").unwrap();
    let mut publisher = Publisher::new(&database, &PublishConfig::default()).unwrap();
    assert!(publisher.needs_fd());
    let warnings: Vec<String> = publisher.warnings().iter().map(ToString::to_string).collect();
    for part in [
        "own.dbc:2: message `GRIP_FRICTION` has no signal `MuMaxLow`",
        "own.dbc:7: signal `GRIP_FRICTION.Spare` is not gripd's; sent as 0",
        "own.dbc:10: message `GRIP_MOTION` goes without Crc or Counter",
        "no message `GRIP_STATUS`",
    ] {
        assert!(warnings.iter().any(|w| w.contains(part)), "{part}: {warnings:?}");
    }
    let value = |frames: &[Frame], name: &str| {
        let (message, signal) = database.signal(name).unwrap();
        rounded(signal.decode(frames.iter().find(|f| f.id == message.id).unwrap().data()).unwrap())
    };
    let known = frames(&mut publisher, &full());
    assert!(known[0].is_fd() && known[0].length() == 16);
    assert_eq!(value(&known, "GRIP_FRICTION.MuUsed"), 30.2);
    assert_eq!(value(&known, "GRIP_FRICTION.MuAge"), 3200.0);
    assert_eq!(value(&known, "GRIP_FRICTION.MuMax"), 0.85);
    assert_eq!(value(&known, "GRIP_MOTION.Speed"), 98.46);
    assert_eq!(value(&known, "GRIP_MOTION.Sideslip"), -0.95);
    assert_eq!(known[0].data()[9], e2e::profile_1_crc(known[0].id.number() as u16, known[0].data(), 9));
    let unknown = frames(&mut publisher, &Estimates::default());
    assert!(value(&unknown, "GRIP_FRICTION.MuAge").is_nan(), "a float says it by not-a-number");
    assert_eq!(value(&unknown, "GRIP_FRICTION.MuMax"), 0.0);
    assert_eq!(value(&unknown, "GRIP_FRICTION.Counter"), 1.0);
}

#[test]
fn an_own_output_dbc_that_cannot_be_honest_is_refused() {
    let with = |from: &str, to: &str| -> PublishError {
        let text = BUILT_IN_DBC.replacen(from, to, 1);
        assert_ne!(text, BUILT_IN_DBC);
        let database = Database::parse(text.as_bytes(), "own.dbc").unwrap();
        Publisher::new(&database, &PublishConfig::default()).unwrap_err()
    };
    let cases = [
        ("VAL_ 1696 MuMax 1023 \"not_available\" ;", "", "has no code for a missing value"),
        ("5 \"abs\"", "", "has no code for `abs`"),
        ("\"m/s\"", "\"knots\"", "has the unit `knots`; understood are m/s, km/h or mph"),
        ("SG_ Faults : 40|16@1+", "SG_ Faults : 40|8@1+", "has 8 bits; the bit field needs 16"),
        ("SG_ Counter : 8|4", "SG_ Counter : 8|3", "has less than 4 bits"),
        ("SG_ Crc : 0|8", "SG_ Crc : 0|7", "must be the 8 bits of one byte"),
    ];
    for (from, to, expected) in &cases {
        let error = with(from, to).to_string();
        assert!(error.contains(expected) && error.starts_with("own.dbc:"), "{error}");
    }
    let nothing = Database::parse(b"BO_ 1 A: 8 X\n", "own.dbc").unwrap();
    assert!(Publisher::new(&nothing, &PublishConfig::default()).is_err());
}

#[test]
fn the_dbc_documents_every_fault_bit() {
    for (bit, (name, _)) in Faults::all().iter_names().enumerate() {
        // Sixteen in each of the two messages.
        let bit = bit % 16;
        assert!(BUILT_IN_DBC.contains(&format!("\nbit {bit} {name} ")), "bit {bit} {name}");
    }
}

#[test]
fn receivers_are_told_when_to_give_up_waiting() {
    for message in database().messages() {
        let id = message.id.number();
        for attribute in
            [format!("\"GenMsgCycleTime\" BO_ {id} 20;"), format!("\"GenMsgTimeout\" BO_ {id} 250;")]
        {
            assert!(BUILT_IN_DBC.contains(&attribute), "{}: {attribute}", message.name);
        }
    }
}

proptest! {
    #[test]
    fn a_published_number_is_within_half_a_step_or_not_available(value in -1e3..1e3_f64) {
        let mut estimates = full();
        estimates.friction.used = Some(value);
        estimates.motion.sideslip = Some(value / 1000.0);
        estimates.cornering[0] = estimate(value, 0.1, 0.0);
        let frames = frames(&mut publisher(), &estimates);
        for (name, value, step, low, high) in [
            ("GRIP_FRICTION.MuUsed", value, 0.002, 0.0, 2.044),
            ("GRIP_MOTION.Sideslip", value / 1000.0, 0.0005, -0.2555, 0.2555),
            ("GRIP_STIFFNESS_LAT.CorneringFront", value, 0.01, 0.0, 40.94),
        ] {
            match field(&frames, name) {
                Some(published) => prop_assert!((published - value).abs() <= step / 2.0 + 1e-9),
                None => prop_assert!(value < low - step * 0.499 || value > high + step * 0.499),
            }
        }
    }
}
