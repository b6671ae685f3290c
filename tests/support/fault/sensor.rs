//! Sensors that are broken, mounted wrongly, or late.

use gripd::model::Reading;
use gripd::{Faults, Micros, Quantity};

use super::{Case, FROM, Fault, meanwhile};

/// Each value of a quantity, while the fault lasts, by another.
fn each(readings: &mut [Reading], quantity: Quantity, change: impl Fn(f64, f64) -> f64) {
    for reading in readings.iter_mut().filter(|r| r.quantity == quantity && meanwhile(r.time)) {
        reading.value = change(reading.time.seconds() - FROM, reading.value);
    }
}

/// All that any car can have on any road.
pub fn cases() -> Vec<Case> {
    use Quantity::*;
    vec![
        Case {
            name: "a yaw rate that stands still",
            fault: Fault::Sensors(|r| each(r, YawRate, |_, _| 0.05)),
            told: Faults::STUCK,
            within: (5.0, 0.3),
            ..Case::PLAIN
        },
        Case {
            name: "single spikes of the yaw rate",
            fault: Fault::Sensors(|r| {
                each(r, YawRate, |t, value| if t % 0.5 < 0.01 { value + 3.0 } else { value });
            }),
            told: Faults::RATE,
            ..Case::PLAIN
        },
        Case {
            name: "a lateral acceleration that drifts by 0.1 m/s² a second",
            fault: Fault::Sensors(|r| each(r, LateralAcceleration, |t, value| value + 0.1 * t)),
            ..Case::PLAIN
        },
        Case {
            name: "a yaw rate with a step of 2°/s",
            fault: Fault::Sensors(|r| each(r, YawRate, |_, value| value + 0.035)),
            ..Case::PLAIN
        },
        Case {
            name: "a yaw rate with the wrong sign",
            fault: Fault::Sensors(|r| each(r, YawRate, |_, value| -value)),
            told: Faults::MOTION_MISMATCH,
            within: (5.0, 5.0),
            weak: &["friction"],
            ..Case::PLAIN
        },
        Case {
            name: "front wheels left and right swapped",
            fault: Fault::Sensors(|r| {
                for reading in r.iter_mut().filter(|reading| meanwhile(reading.time)) {
                    reading.quantity = match reading.quantity {
                        WheelSpeedFl => WheelSpeedFr,
                        WheelSpeedFr => WheelSpeedFl,
                        other => other,
                    };
                }
            }),
            ..Case::PLAIN
        },
        Case {
            name: "a wheel that reads zero",
            fault: Fault::Sensors(|r| each(r, WheelSpeedRl, |_, _| 0.0)),
            told: Faults::WHEEL_MISMATCH | Faults::RATE,
            within: (0.5, 1.1),
            ..Case::PLAIN
        },
        Case {
            name: "a steering angle in steps of 2°",
            fault: Fault::Sensors(|r| {
                let step = 2f64.to_radians();
                each(r, SteeringWheelAngle, |_, value| (value / step).round() * step);
            }),
            ..Case::PLAIN
        },
        Case {
            name: "a yaw rate 100 ms late",
            fault: Fault::Sensors(|r| {
                for reading in r.iter_mut().filter(|r| r.quantity == YawRate && meanwhile(r.time)) {
                    reading.time = reading.time + Micros::from_millis(100);
                }
            }),
            within: (0.0, 0.2),
            ..Case::PLAIN
        },
    ]
}

/// For a car that all but stops: wheel sensors that read nothing below walking pace.
pub fn slow_wheels() -> Vec<Case> {
    vec![Case {
        name: "wheel speeds that cut in at 2.75 m/s",
        fault: Fault::Sensors(|readings| {
            for reading in readings.iter_mut().filter(|reading| reading.quantity.wheel().is_some()) {
                if reading.value * 0.31 < 2.75 {
                    reading.value = 0.0;
                }
            }
        }),
        ..Case::PLAIN
    }]
}
