//! What the tests of the `signals` room share: a small car on a bus, and the recordings, where present.

use gripd::can::candump::Reader;
use gripd::can::{CanId, Frame};
use gripd::dbc::Database;
use gripd::signals::{Inputs, Sampler, SignalsConfig};
use gripd::{Micros, Sample};

/// A small car: wheels in km/h, an ESP message with sign and quality bits, steering in two parts.
pub const DBC: &str = r#"VERSION ""

BU_: CAR

BO_ 416 WHEELS: 8 CAR
 SG_ FL : 0|16@1+ (0.01,0) [0|0] "km/h" CAR
 SG_ FR : 16|16@1+ (0.01,0) [0|0] "km/h" CAR
 SG_ RL : 32|16@1+ (0.01,0) [0|0] "km/h" CAR
 SG_ RR : 48|16@1+ (0.01,0) [0|0] "km/h" CAR

BO_ 257 ESP: 8 CAR
 SG_ Crc : 0|8@1+ (1,0) [0|0] "" CAR
 SG_ Counter : 8|4@1+ (1,0) [0|0] "" CAR
 SG_ YawQuality : 12|1@1+ (1,0) [0|0] "" CAR
 SG_ YawSign : 13|1@1+ (1,0) [0|0] "" CAR
 SG_ AccQuality : 14|2@1+ (1,0) [0|0] "" CAR
 SG_ Yaw : 16|14@1+ (0.01,0) [0|0] "deg/s" CAR
 SG_ AccLat : 32|12@1- (0.01,0) [0|0] "m/s^2" CAR
 SG_ AccLon : 44|12@1- (0.01,0) [0|0] "g" CAR

BO_ 2566849536 STEERING: 4 CAR
 SG_ Coarse : 3|12@0- (1.5,0) [0|0] "deg" CAR
 SG_ Fine : 23|4@0- (0.1,0) [0|0] "deg" CAR

BO_ 464 MUXED: 4 CAR
 SG_ Page M : 0|8@1+ (1,0) [0|0] "" CAR
 SG_ Pressure m0 : 8|16@1+ (0.1,0) [0|0] "bar" CAR
 SG_ Abs m1 : 8|1@1+ (1,0) [0|0] "" CAR
 SG_ Nameless m2 : 8|16@1+ (1,0) [0|0] "" CAR

VAL_ 257 AccLat -2048 "SNA" -2047 "NoFault" ;
"#;

/// The mapping of the required quantities.
pub const SIGNALS: &str = r#"
wheel_speed_fl = "WHEELS.FL"
wheel_speed_fr = "WHEELS.FR"
wheel_speed_rl = "WHEELS.RL"
wheel_speed_rr = "WHEELS.RR"
yaw_rate = { signal = "ESP.Yaw", sign = "ESP.YawSign", valid = "ESP.YawQuality" }
lateral_acceleration = "ESP.AccLat"
steering_wheel_angle = { sum = ["STEERING.Coarse", "STEERING.Fine"] }
"#;

pub const RADIUS: f64 = 0.3;
pub const WHEELS: u32 = 416;
pub const ESP: u32 = 257;
pub const MUXED: u32 = 464;
pub const STEERING: u32 = 0x18FF_0400;

pub fn database() -> Database {
    let database = Database::parse(DBC.as_bytes(), "small.dbc").unwrap();
    assert_eq!(database.warnings(), &[]);
    database
}

pub fn config(text: &str) -> SignalsConfig {
    toml::from_str(text).unwrap()
}

/// A sampler for the required quantities and what `more` adds.
pub fn sampler(more: &str) -> Sampler {
    let config = config(&format!("{SIGNALS}{more}"));
    let inputs = Inputs::compile(&config, &database(), RADIUS).unwrap();
    Sampler::new(inputs, &config.sampling)
}

/// The mapping without the line of one quantity.
pub fn signals_without(quantity: &str) -> String {
    SIGNALS.lines().filter(|line| !line.starts_with(quantity)).map(|line| format!("{line}\n")).collect()
}

pub fn frame(ms: f64, id: u32, data: &[u8]) -> Frame {
    Frame::data_frame(Micros((ms * 1000.0) as i64), CanId::standard(id).unwrap(), data).unwrap()
}

/// All wheels at the same speed.
pub fn wheels(ms: f64, kmh: f64) -> Frame {
    let raw = ((kmh * 100.0).round() as u16).to_le_bytes();
    frame(ms, WHEELS, &[raw[0], raw[1], raw[0], raw[1], raw[0], raw[1], raw[0], raw[1]])
}

pub fn esp(ms: f64, yaw_degrees: f64, lateral: f64) -> Frame {
    let mut data = [0; 8];
    let yaw = (yaw_degrees.abs() * 100.0).round() as u16;
    data[1] = u8::from(yaw_degrees < 0.0) << 5;
    data[2..4].copy_from_slice(&yaw.to_le_bytes());
    let lateral = (lateral * 100.0).round() as i16;
    data[4] = lateral as u8;
    data[5] = (lateral >> 8) as u8 & 15;
    frame(ms, ESP, &data)
}

pub fn steering(ms: f64, coarse: i16, fine: i8) -> Frame {
    let raw = (coarse as u16) & 0xFFF;
    let data = [(raw >> 8) as u8, raw as u8, (fine as u8) << 4, 0];
    Frame::data_frame(Micros((ms * 1000.0) as i64), CanId::extended(STEERING).unwrap(), &data).unwrap()
}

/// Pushes frames and collects all samples; with `flush`, those at the end too.
pub fn run(sampler: &mut Sampler, frames: &[Frame], flush: bool) -> Vec<Sample> {
    let mut samples = Vec::new();
    for frame in frames {
        sampler.push(frame);
        samples.extend(std::iter::from_fn(|| sampler.next_sample()));
    }
    if flush {
        sampler.flush();
        samples.extend(std::iter::from_fn(|| sampler.next_sample()));
    }
    samples
}

/// The frames of a gzipped candump log.
pub fn recording(path: &std::path::Path) -> Vec<Frame> {
    let mut reader = Reader::open(path).unwrap();
    let frames = std::iter::from_fn(|| reader.next_frame().unwrap()).collect();
    assert_eq!(reader.stats().skipped_lines, 0);
    frames
}
