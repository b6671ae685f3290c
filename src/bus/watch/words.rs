//! Names and numbers of the interface in plain words.

use physics::estimates::{MuSource, State};
use physics::{Faults, Quantity};

/// What a fault means, in a few words; of several, what the lowest means.
pub fn fault_words(fault: Faults) -> &'static str {
    let Some(first) = fault.iter().next() else { return "none" };
    match first {
        Faults::TIMEOUT => "an input has not come for too long",
        Faults::NOT_AVAILABLE => "an input says itself that it is not valid",
        Faults::RANGE => "an input is outside what can be",
        Faults::RATE => "an input jumps faster than it can",
        Faults::STUCK => "an input stands still and should not",
        Faults::CHECKSUM => "an input frame has a wrong checksum",
        Faults::COUNTER => "an input's counter stands still or jumps",
        Faults::FRAME => "an input frame has the wrong length or kind",
        Faults::TIME => "the frames' clock jumps",
        Faults::WHEEL_MISMATCH => "one wheel contradicts the others",
        Faults::MOTION_MISMATCH => "yaw rate, steering, wheels contradict each other",
        Faults::BUS_DOWN => "the interface is down or gone",
        Faults::BUS_ERROR => "the CAN controller reports errors",
        Faults::DROPPED => "frames were lost before they were read",
        Faults::INCONSISTENT => "an estimator contradicts its own uncertainty",
        Faults::CONFIG => "a new configuration or saved state was refused",
        Faults::FOREIGN_SENDER => "another node sends gripd's own messages",
        Faults::SENT_TWICE => "an input comes too often: two nodes send it",
        Faults::ENDING => "gripd has ended",
        _ => "unknown",
    }
}

/// What the service's state means.
pub fn state_words(state: Option<State>) -> &'static str {
    match state {
        Some(State::Starting) => "starting: no sample yet",
        Some(State::Running) => "running: all required inputs are there",
        Some(State::Degraded) => "degraded: a required input is missing or doubtful",
        Some(State::NoInput) => "no input: nothing usable comes from the bus",
        None => "unknown",
    }
}

/// Where the friction comes from.
pub fn source_words(source: Option<MuSource>) -> &'static str {
    match source {
        Some(MuSource::None) => "nothing tells it yet",
        Some(MuSource::LowerBound) => "at least what was used",
        Some(MuSource::SlopeMap) => "mapped from the slip slope",
        Some(MuSource::Brush) => "bend of the slip curve",
        Some(MuSource::Joint) => "tires bend sideways",
        Some(MuSource::Abs) => "an ABS braking",
        Some(MuSource::Limit) => "spinning wheels",
        None => "unknown",
    }
}

/// What a quantity is called where there is little room.
pub fn quantity_label(quantity: Quantity) -> &'static str {
    match quantity {
        Quantity::WheelSpeedFl => "wheel FL",
        Quantity::WheelSpeedFr => "wheel FR",
        Quantity::WheelSpeedRl => "wheel RL",
        Quantity::WheelSpeedRr => "wheel RR",
        Quantity::YawRate => "yaw rate",
        Quantity::LateralAcceleration => "lat. acc.",
        Quantity::SteeringWheelAngle => "steering",
        Quantity::LongitudinalAcceleration => "long. acc.",
        Quantity::DriveTorque => "drive tq.",
        Quantity::BrakeTorque => "brake tq.",
        Quantity::BrakePressure => "brake pr.",
        Quantity::VehicleSpeed => "speed",
        Quantity::BrakeActive => "braking",
        Quantity::AbsActive => "ABS",
    }
}

/// How people read a quantity: factor from SI, unit, decimals.
pub fn quantity_shown(quantity: Quantity) -> (f64, &'static str, usize) {
    let degrees = 180.0 / std::f64::consts::PI;
    match quantity {
        Quantity::YawRate => (degrees, "°/s", 2),
        Quantity::SteeringWheelAngle => (degrees, "°", 1),
        Quantity::VehicleSpeed => (3.6, "km/h", 1),
        Quantity::DriveTorque | Quantity::BrakeTorque => (1.0, "N m", 0),
        Quantity::BrakePressure => (1.0, "bar", 1),
        Quantity::BrakeActive | Quantity::AbsActive => (1.0, "", 0),
        other => (1.0, other.unit(), 2),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn everything_has_words() {
        for fault in Faults::all().iter() {
            assert_ne!(fault_words(fault), "unknown", "{fault:?}");
        }
        assert!(Quantity::ALL.iter().all(|quantity| quantity_label(*quantity).chars().count() <= 10));
    }
}
