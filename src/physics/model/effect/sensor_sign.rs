//! A sensor with the wrong sign.

use super::{Channel, Effect, Felt, Kind, Now, Readings, Recorded, SearchHints, Setting};
use crate::Quantity;

/// A sensor that is mounted, wired or described the wrong way round.
#[derive(Clone, Copy, Debug, PartialEq)]
struct SensorSign {
    quantity: Option<Quantity>,
}

/// What can be the wrong way round.
const SIGNED: &[Channel] = &[
    Channel::One(Quantity::YawRate),
    Channel::One(Quantity::LateralAcceleration),
    Channel::One(Quantity::LongitudinalAcceleration),
    Channel::One(Quantity::SteeringWheelAngle),
    Channel::One(Quantity::DriveTorque),
];

/// See [`super::KINDS`].
pub static KIND: Kind = Kind {
    name: "sensor_sign",
    words: "wrong sign of {a sensor}",
    about: "a sensor has the wrong sign",
    equation: "y = − x",
    source: "signal chain",
    place: "a sensor",
    to_tell_apart: "one left turn, one acceleration and one braking",
    channels: SIGNED,
    parameters: &[],
    course: None,
    search: SearchHints::USUAL,
    make: |setting: &Setting<'_>| Box::new(SensorSign { quantity: setting.quantity() }),
};

impl Effect for SensorSign {
    fn sense(&self, _now: &Now<'_>, _felt: &Felt, _states: &[f64], readings: &mut Readings) {
        if let Some(quantity) = self.quantity {
            readings[quantity as usize] = -readings[quantity as usize];
        }
    }

    fn undo(&self, _t: f64, recorded: &mut Recorded) {
        if let Some(value) = self.quantity.and_then(|quantity| recorded.get_mut(quantity)) {
            *value = -*value;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::Course;
    use super::super::bench::undoes;
    use super::*;

    #[test]
    fn what_it_does_to_inputs_is_undone() {
        undoes(&KIND, &[], &Course::None);
    }
}
