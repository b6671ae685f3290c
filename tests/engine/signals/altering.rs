//! Quantities changed in frames that were recorded.

use gripd::can::{CanId, Frame};
use gripd::dbc::Database;
use gripd::signals::{Alterer, SignalsConfig};
use gripd::{Micros, Quantity};
use testing::small_car::{
    ESP, MUXED, RADIUS, SIGNALS, WHEELS, config, database, esp, frame, steering, wheels,
};

type Change<'c> = &'c dyn Fn(Quantity, Micros, f64) -> f64;

/// What frames become; those that stay as they are are none.
fn altered(signals: &SignalsConfig, frames: &[Frame], change: Change<'_>) -> (Alterer, Vec<Option<Frame>>) {
    let mut alterer = Alterer::compile(signals, &database(), RADIUS).unwrap();
    frames.iter().for_each(|frame| alterer.look(frame, change));
    alterer.looked(1);
    let made = frames.iter().map(|frame| alterer.alter(frame, change)).collect();
    (alterer, made)
}

/// Only this quantity, by a function of its value.
fn only(quantity: Quantity, of: impl Fn(f64) -> f64) -> impl Fn(Quantity, Micros, f64) -> f64 {
    move |asked, _, value| if asked == quantity { of(value) } else { value }
}

fn raw(frame: &Frame, signal: &str) -> i64 {
    database().signal(signal).unwrap().1.raw(frame.data()).unwrap()
}

#[test]
fn what_is_not_wanted_otherwise_is_not_touched() {
    let frames =
        [wheels(0.0, 50.0), esp(5.0, -3.17, 1.23), steering(7.0, 33, -4), frame(8.0, 0x7FF, &[1, 2])];
    let (alterer, made) = altered(&config(SIGNALS), &frames, &|_, _, value| value);
    assert!(made.iter().all(Option::is_none));
    assert_eq!((alterer.frames(), alterer.of(Quantity::YawRate).readings), (0, 1));
}

#[test]
fn a_value_is_changed_to_the_nearest_raw_unit_and_no_other_bit() {
    let (before, change) = (esp(0.0, 12.0, 1.5), only(Quantity::YawRate, |yaw| yaw - 0.3));
    let (alterer, made) = altered(&config(SIGNALS), &[before], &change);
    let after = made[0].unwrap();
    // 12° less 0.3 rad are −5.189°: magnitude and sign bit.
    assert_eq!((raw(&after, "ESP.Yaw"), raw(&after, "ESP.YawSign")), (519, 1));
    assert_eq!(raw(&after, "ESP.AccLat"), raw(&before, "ESP.AccLat"));
    assert_eq!((after.time, after.id, after.length()), (before.time, before.id, before.length()));
    let of = alterer.of(Quantity::YawRate);
    assert!((of.wanted_rms() - 0.3).abs() < 1e-12 && (of.rms() - 0.3).abs() < of.step && of.clipped == 0);
    let two_parts = only(Quantity::SteeringWheelAngle, |angle| angle + 4.0_f64.to_radians());
    let (_, made) = altered(&config(SIGNALS), &[steering(0.0, 10, 2)], &two_parts);
    let after = made[0].unwrap();
    assert_eq!(
        (raw(&after, "STEERING.Coarse"), raw(&after, "STEERING.Fine")),
        (13, -3),
        "15.2° + 4° = 19.2°"
    );
}

#[test]
fn what_is_not_available_stays_so_and_what_does_not_fit_is_counted() {
    let mut missing = [0; 8];
    missing[4..6].copy_from_slice(&(-2048_i16).to_le_bytes());
    missing[5] &= 15;
    let invalid = {
        let mut data = [0; 8];
        data[1] = 1 << 4;
        frame(2.0, ESP, &data)
    };
    let frames = [frame(0.0, ESP, &missing), invalid, esp(4.0, 0.0, 15.0), frame(6.0, ESP, &[1; 5])];
    let change = |quantity, _, value| match quantity {
        Quantity::LateralAcceleration => value + 10.0,
        Quantity::YawRate => value + 0.1,
        _ => value,
    };
    let (alterer, made) = altered(&config(SIGNALS), &frames, &change);
    assert_eq!(raw(&made[0].unwrap(), "ESP.AccLat"), -2048, "not available");
    assert_eq!(raw(&made[1].unwrap(), "ESP.Yaw"), 0, "its quality bit says no");
    assert_eq!(raw(&made[2].unwrap(), "ESP.AccLat"), 2047, "25 m/s² are more than its twelve bits have");
    assert_eq!(made[3], None, "too short for the message");
    let of = alterer.of(Quantity::LateralAcceleration);
    assert_eq!((of.readings, of.changed, of.clipped), (2, 2, 1));
    assert!(of.kept() < 0.95);
}

#[test]
fn a_multiplexed_value_is_changed_where_it_is() {
    let signals = config(&format!("{SIGNALS}brake_pressure = \"MUXED.Pressure\"\n"));
    let frames = [frame(0.0, MUXED, &[0, 100, 0, 7]), frame(1.0, MUXED, &[1, 1, 0, 7])];
    let (_, made) = altered(&signals, &frames, &only(Quantity::BrakePressure, |bar| 2.0 * bar));
    assert_eq!(made[0].unwrap().data(), [0, 200, 0, 7]);
    assert_eq!(made[1], None);
}

#[test]
fn the_counter_goes_on_and_the_checksum_is_right_again() {
    let signals = config(&SIGNALS.replace(
        "valid = \"ESP.YawQuality\" }",
        "counter = \"ESP.Counter\", crc = { signal = \"ESP.Crc\", kind = \"e2e_p01a\", data_id = 0x101 } }",
    ));
    let with_crc = |mut data: [u8; 8]| {
        data[0] = gripd::signals::e2e::profile_1_crc(0x101, &data, 0);
        frame(0.0, ESP, &data)
    };
    let mut data = [0; 8];
    data[1] = 5;
    let (right, mut wrong) = (with_crc(data), data);
    wrong[0] = right.data()[0] ^ 0x55;
    let frames = [right, frame(1.0, ESP, &wrong)];
    let (_, made) = altered(&signals, &frames, &only(Quantity::YawRate, |yaw| yaw + 0.2));
    let after = made[0].unwrap();
    let payload: [u8; 8] = after.data().try_into().unwrap();
    assert_eq!(with_crc(payload).data(), payload);
    assert_eq!((raw(&after, "ESP.Counter"), raw(&after, "ESP.Yaw")), (5, 1146));
    assert_eq!(made[1], None, "what nobody takes for right is not made right");
}

/// Toyota's speed message: its checksum is in the DBC's names only, and in the frames.
#[test]
fn a_checksum_that_is_not_configured_is_learned_of_the_frames() {
    const DBC: &str = "VERSION \"\"\n\nBU_: A\n\nBO_ 180 SPEED: 8 A\n SG_ SPEED : 47|16@0+ (0.01,0) [0|250] \"km/h\" A\n SG_ CHECKSUM : 63|8@0+ (1,0) [0|255] \"\" A\n\nBO_ 257 M: 8 A\n SG_ YAW : 0|16@1- (0.001,0) [0|0] \"rad/s\" A\n SG_ ANGLE : 16|16@1- (0.001,0) [0|0] \"rad\" A\n SG_ CRC : 56|8@1+ (1,0) [0|0] \"\" A\n";
    let database = Database::parse(DBC.as_bytes(), "toyota.dbc").unwrap();
    let signals =
        config("vehicle_speed = \"SPEED.SPEED\"\nyaw_rate = \"M.YAW\"\nsteering_wheel_angle = \"M.ANGLE\"\n");
    let sum = |data: &[u8]| data[..7].iter().fold(0xB4_u8 + 8, |sum, byte| sum.wrapping_add(*byte));
    let speed = |ms: f64, raw: u16| {
        let mut data = [0; 8];
        data[5..7].copy_from_slice(&raw.to_be_bytes());
        data[7] = sum(&data);
        frame(ms, 180, &data)
    };
    // A real frame of a real car.
    assert_eq!(sum(&[0, 0, 0, 0, 0x1D, 0x0B, 0x7A, 0]), 0x5E);
    let mut frames: Vec<Frame> = (0..40).map(|i| speed(f64::from(i), 3000 + 17 * i as u16)).collect();
    frames.push(frame(50.0, 257, &[1, 0, 0, 0, 0, 0, 0, 99]));
    let mut alterer = Alterer::compile(&signals, &database, RADIUS).unwrap();
    let change = |_, _, value: f64| 1.1 * value;
    frames.iter().for_each(|frame| alterer.look(frame, &change));
    let untold = alterer.looked(1);
    let made: Vec<Frame> = frames.iter().filter_map(|frame| alterer.alter(frame, &change)).collect();
    assert_eq!(made.len(), 40);
    assert!(made.iter().all(|frame| frame.data()[7] == sum(frame.data())));
    assert_eq!(made[0].data()[5..7], 3300_u16.to_be_bytes());
    let [(id, words)] = &untold[..] else { panic!("{untold:?}") };
    assert_eq!(*id, CanId::standard(257).unwrap());
    assert!(words.contains("M.CRC") && words.contains("stays as it was"), "{words}");
    assert!(!alterer.has_changed(*id) && alterer.has_changed(CanId::standard(180).unwrap()));
}

#[test]
fn wheels_in_kmh_are_changed_by_their_radius() {
    let (_, made) =
        altered(&config(SIGNALS), &[wheels(0.0, 90.0)], &only(Quantity::WheelSpeedRl, |w| w / 0.985));
    let after = made[0].unwrap();
    assert_eq!((raw(&after, "WHEELS.RL"), raw(&after, "WHEELS.RR")), (9137, 9000));
    assert_eq!(after.id, CanId::standard(WHEELS).unwrap());
}
