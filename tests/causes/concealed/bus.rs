//! From channels to a candump log: frames at their own rates and phases, one clock that runs a little wrong.

use std::fmt::Write;

use super::dice::Dice;
use super::hidden::{CHANNELS, Hidden};
use super::physics::{Moment, STEP};
use super::sensors::{Chain, NOISE};

/// The network's description, the same for every recording.
pub const DBC: &str = r#"VERSION "1"

NS_ :

BS_:

BU_: ESP EPS PT

BO_ 416 WHEELS: 8 ESP
 SG_ WS_FL : 0|16@1+ (0.0078125,0) [0|511.9] "rad/s" PT
 SG_ WS_FR : 16|16@1+ (0.0078125,0) [0|511.9] "rad/s" PT
 SG_ WS_RL : 32|16@1+ (0.0078125,0) [0|511.9] "rad/s" PT
 SG_ WS_RR : 48|16@1+ (0.0078125,0) [0|511.9] "rad/s" PT

BO_ 432 INERTIAL: 8 ESP
 SG_ YAW_RATE : 0|16@1- (0.0001,0) [-3.27|3.27] "rad/s" PT
 SG_ ACC_LAT : 16|16@1- (0.005,0) [-30|30] "m/s^2" PT
 SG_ ACC_LON : 32|16@1- (0.005,0) [-30|30] "m/s^2" PT
 SG_ INERTIAL_CNT : 48|4@1+ (1,0) [0|15] "" PT

BO_ 448 STEERING: 4 EPS
 SG_ SW_ANGLE : 0|16@1- (0.00174533,0) [-57|57] "rad" PT
 SG_ STEERING_CNT : 16|4@1+ (1,0) [0|15] "" PT

BO_ 464 DRIVE: 6 PT
 SG_ DRIVE_TORQUE : 0|16@1- (0.5,0) [-16000|16000] "Nm" ESP
 SG_ BRAKE_PRESSURE : 16|12@1+ (0.1,0) [0|400] "bar" ESP
 SG_ DRIVE_CNT : 28|4@1+ (1,0) [0|15] "" ESP

CM_ SG_ 464 DRIVE_TORQUE "total wheel torque of the driven axle, brakes not included";
CM_ SG_ 416 WS_FL "ISO axes: x forward, y left, yaw positive to the left";
"#;

/// How often frames come, and how.
#[derive(Clone, Debug)]
pub struct Timing {
    /// Of the wheels', the inertial unit's, the steering's and the drive's frames, s.
    pub period: [f64; 4],
    /// Frames are stamped together, so far apart, s; 0: each when it comes.
    pub batch: f64,
    /// Steps of each channel's readings, where coarser than the bus has them.
    pub coarse: [f64; CHANNELS],
}

impl Default for Timing {
    fn default() -> Self {
        Self { period: [0.020, 0.010, 0.010, 0.020], batch: 0.0, coarse: [0.0; CHANNELS] }
    }
}

/// Seconds since 1970 of the start of every log.
const EPOCH: f64 = 1_770_000_000.0;

/// The log of a drive.
pub fn candump(moments: &[Moment], seconds: f64, hidden: &Hidden, chain: &Chain, dice: &mut Dice) -> String {
    let skew = 1.0 + dice.between(-1e-4, 1e-4);
    let Timing { period, batch, coarse } = &chain.timing;
    let frames = [0x1A0u32, 0x1B0, 0x1C0, 0x1D0].into_iter().zip(*period);
    let mut sent: Vec<(f64, u32, [u8; 8], usize)> = Vec::new();
    for (id, period) in frames {
        let phase = dice.between(0.0, period);
        let read = |channel: usize, t: f64, scale: f64, noise: &mut Dice| -> i64 {
            let shown = chain.shows(moments, STEP, hidden, channel, t) + chain.colour[channel].at(t);
            let value = shown + NOISE[channel] * noise.normal();
            let step = coarse[channel];
            let value = if step > 0.0 { (value / step).round() * step } else { value };
            (value / scale).round() as i64
        };
        let mut counter = 0u8;
        for k in 0.. {
            let t = phase + period * f64::from(k);
            if t > seconds - 0.02 {
                break;
            }
            let mut data = [0u8; 8];
            let mut put =
                |at: usize, code: i64| data[at..at + 2].copy_from_slice(&(code as u16).to_le_bytes());
            let length = match id {
                0x1A0 => {
                    for wheel in 0..4 {
                        put(2 * wheel, read(wheel, t, 0.007_812_5, dice).clamp(0, 65_535));
                    }
                    8
                }
                0x1B0 => {
                    put(0, read(4, t, 0.0001, dice));
                    put(2, read(5, t, 0.005, dice));
                    put(4, read(6, t, 0.005, dice));
                    data[6] = counter;
                    8
                }
                0x1C0 => {
                    put(0, read(7, t, 0.001_745_33, dice));
                    data[2] = counter;
                    4
                }
                _ => {
                    put(0, read(8, t, 0.5, dice));
                    let pressure = read(9, t, 0.1, dice).clamp(0, 4095);
                    put(2, pressure | i64::from(counter) << 12);
                    6
                }
            };
            counter = (counter + 1) % 16;
            let stamp = t * skew + dice.between(0.0, 0.0003);
            let stamp = EPOCH + if *batch > 0.0 { (stamp / batch).ceil() * batch } else { stamp };
            sent.push((stamp, id, data, length));
        }
    }
    sent.sort_by(|x, y| x.0.total_cmp(&y.0));
    let mut text = String::with_capacity(sent.len() * 48);
    for (stamp, id, data, length) in sent {
        let _ = write!(text, "({stamp:.6}) vcan0 {id:03X}#");
        for byte in &data[..length] {
            let _ = write!(text, "{byte:02X}");
        }
        text.push('\n');
    }
    text
}
