//! A sensor with a wrong scale.

use super::{Effect, Felt, Kind, Now, Readings, Recorded, Scale, SearchHints, Setting, Spec, Usual, channel};
use crate::Quantity;

/// A sensor reads too much in proportion.
#[derive(Clone, Copy, Debug, PartialEq)]
struct SensorScale {
    quantity: Option<Quantity>,
    relative_error: f64,
}

/// The scale of the steering wheel's angle is the steering ratio, that of wheel speeds the tires' radii.
const STEERING_AND_WHEELS: &[Quantity] = &[
    Quantity::SteeringWheelAngle,
    Quantity::WheelSpeedFl,
    Quantity::WheelSpeedFr,
    Quantity::WheelSpeedRl,
    Quantity::WheelSpeedRr,
];

/// Bodies dive and squat by up to 3.5° per g (Reimpell, The Automotive Chassis, ch. 6.3), those of vans with their height by
/// three tenths more: so much gravity the accelerometer feels along the car, and reads up to 7.9 % too much.
const PITCH: Usual = Usual { of: Some(Quantity::LongitudinalAcceleration), bounds: (0.0, 0.079) };

/// See [`super::KINDS`].
pub static KIND: Kind = Kind {
    name: "sensor_scale",
    words: "wrong scale of {a sensor}",
    about: "a sensor reads too much (or too little) in proportion",
    equation: "y = x (1 + e)",
    source: "signal chain",
    place: "a sensor",
    to_tell_apart: "steady turns (steady braking) of several strengths, both ways: the error is in \
                    proportion to the reading, at every speed and frequency",
    channels: channel::MEASURED,
    parameters: &[Spec {
        name: "relative_error",
        words: "error of the scale",
        unit: "1",
        scale: Scale::Linear,
        mean: 0.0,
        std: 0.05,
        bounds: (-0.9, 4.0),
        step: 0.01,
        model_error: Spec::MODEL_ERROR,
        is_main: true,
    }],
    course: None,
    // Maps tell torques, and pads change: a scale of theirs that is off by less is nobody's mistake.
    search: SearchHints {
        not_of: STEERING_AND_WHEELS,
        least_of_torque: Some(0.01),
        usual: Some(PITCH),
        ..SearchHints::USUAL
    },
    make: |setting: &Setting<'_>| {
        Box::new(SensorScale { quantity: setting.quantity(), relative_error: setting.values[0] })
    },
};

impl Effect for SensorScale {
    fn sense(&self, _now: &Now<'_>, _felt: &Felt, _states: &[f64], readings: &mut Readings) {
        if let Some(quantity) = self.quantity {
            readings[quantity as usize] *= 1.0 + self.relative_error;
        }
    }

    fn undo(&self, _t: f64, recorded: &mut Recorded) {
        if let Some(value) = self.quantity.and_then(|quantity| recorded.get_mut(quantity)) {
            *value /= 1.0 + self.relative_error;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::Course;
    use super::super::bench::{Bench, made, undoes};
    use super::*;

    #[test]
    fn it_multiplies_its_own_channel() {
        let bench = Bench::driving(20.0);
        let effect = made(&KIND, &[0.1], Some(Quantity::YawRate.into()), &Course::None);
        let mut readings = [2.0; Quantity::COUNT];
        effect.sense(&bench.now, &Felt::default(), &[], &mut readings);
        assert!((readings[Quantity::YawRate as usize] - 2.2).abs() < 1e-12);
        assert_eq!(readings.iter().filter(|reading| **reading == 2.0).count(), Quantity::COUNT - 1);
    }

    #[test]
    fn what_it_does_to_inputs_is_undone() {
        undoes(&KIND, &[0.1], &Course::None);
    }
}
