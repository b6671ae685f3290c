//! The errors of a single channel, each as it comes in cars.

use gripd::model::Reading;
use gripd::{Micros, Quantity, Sensors};
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;
use rand_distr::{Distribution, StandardNormal};

/// What is wrong with it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Fault {
    Scale(f64),
    Offset,
    DelayMs(i64),
    Frozen,
    Noise,
    Swapped,
}

impl Fault {
    pub const ALL: [Self; 8] = [
        Self::Scale(0.8),
        Self::Scale(1.2),
        Self::Offset,
        Self::DelayMs(100),
        Self::DelayMs(300),
        Self::Frozen,
        Self::Noise,
        Self::Swapped,
    ];

    pub fn name(self) -> String {
        match self {
            Self::Scale(by) => format!("× {by}"),
            Self::Offset => "offset".into(),
            Self::DelayMs(ms) => format!("{ms} ms late"),
            Self::Frozen => "frozen".into(),
            Self::Noise => "noise × 5".into(),
            Self::Swapped => "swapped".into(),
        }
    }
}

/// When it is, s from the drive's start.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct When {
    pub name: &'static str,
    pub from_s: f64,
    pub to_s: f64,
}

impl When {
    pub const ALL: [Self; 3] = [
        Self { name: "from the start", from_s: 0.0, to_s: f64::INFINITY },
        Self { name: "at 30 s", from_s: 30.0, to_s: f64::INFINITY },
        Self { name: "for 10 s", from_s: 30.0, to_s: 40.0 },
    ];
}

/// A channel, an offset that one sees on real cars, and the one that it is mistaken for.
pub const CHANNELS: [(Quantity, f64, Quantity); 8] = [
    (Quantity::WheelSpeedFl, 1.0, Quantity::WheelSpeedFr),
    (Quantity::WheelSpeedRl, 1.0, Quantity::WheelSpeedRr),
    (Quantity::YawRate, 0.05, Quantity::LateralAcceleration),
    (Quantity::LateralAcceleration, 1.0, Quantity::LongitudinalAcceleration),
    (Quantity::SteeringWheelAngle, 0.2, Quantity::YawRate),
    (Quantity::LongitudinalAcceleration, 0.5, Quantity::LateralAcceleration),
    (Quantity::DriveTorque, 200.0, Quantity::BrakePressure),
    (Quantity::BrakePressure, 5.0, Quantity::DriveTorque),
];

/// The drive with the fault in it. Times count from the first reading.
pub fn spoiled(readings: &[Reading], channel: Quantity, fault: Fault, when: When) -> Vec<Reading> {
    let start = readings[0].time;
    let (_, offset, other) = CHANNELS[CHANNELS.iter().position(|(q, ..)| *q == channel).unwrap()];
    let meanwhile = |time: Micros| (when.from_s..when.to_s).contains(&(time - start).seconds());
    let mut random = ChaCha8Rng::seed_from_u64(27);
    let more_noise = 24.0_f64.sqrt() * Sensors::default().noise_std(channel);
    let mut held = None;
    let mut spoiled = readings.to_vec();
    for reading in &mut spoiled {
        if !meanwhile(reading.time) {
            continue;
        }
        if fault == Fault::Swapped {
            if reading.quantity == channel {
                reading.quantity = other;
            } else if reading.quantity == other {
                reading.quantity = channel;
            }
            continue;
        }
        if reading.quantity != channel {
            continue;
        }
        match fault {
            Fault::Scale(by) => reading.value *= by,
            Fault::Offset => reading.value += offset,
            Fault::DelayMs(ms) => reading.time = reading.time + Micros::from_millis(ms),
            Fault::Frozen => reading.value = *held.get_or_insert(reading.value),
            Fault::Noise => {
                let normal: f64 = StandardNormal.sample(&mut random);
                reading.value += more_noise * normal;
            }
            Fault::Swapped => {}
        }
    }
    spoiled.sort_by_key(|reading| reading.time);
    spoiled
}
