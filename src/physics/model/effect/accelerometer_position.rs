//! The accelerometer does not sit at the centre of gravity.

use super::{Effect, Felt, Kind, Now, Readings, Scale, SearchHints, Setting, Spec};
use crate::Quantity;

/// A point `forward` m before the centre of gravity is accelerated by ṙ and r², too.
#[derive(Clone, Copy, Debug, PartialEq)]
struct AccelerometerPosition {
    forward: f64,
}

/// See [`super::KINDS`].
pub static KIND: Kind = Kind {
    name: "accelerometer_position",
    words: "place of the accelerometer",
    about: "the accelerometer sits ahead of (or behind) the centre of gravity and feels the car's turning",
    equation: "a_y = a_y,cg + d ṙ,  a_x = a_x,cg − d r²",
    source: "rigid-body kinematics",
    place: "the accelerometers",
    to_tell_apart: "quick steering at moderate speed (sine sweep to 2 Hz): the error follows the yaw acceleration, \
                    not the lateral acceleration",
    channels: &[],
    parameters: &[Spec {
        name: "forward_of_cg_m",
        words: "position ahead of the centre of gravity",
        unit: "m",
        scale: Scale::Linear,
        mean: 0.0,
        std: 0.5,
        bounds: (-4.0, 4.0),
        step: 0.1,
        model_error: Spec::MODEL_ERROR,
        is_main: true,
    }],
    course: None,
    search: SearchHints::USUAL,
    make: |setting: &Setting<'_>| Box::new(AccelerometerPosition { forward: setting.values[0] }),
};

impl Effect for AccelerometerPosition {
    fn sense(&self, now: &Now<'_>, felt: &Felt, _states: &[f64], readings: &mut Readings) {
        let yaw_rate = now.velocity.yaw_rate;
        readings[Quantity::LateralAcceleration as usize] += self.forward * felt.yaw_acceleration;
        readings[Quantity::LongitudinalAcceleration as usize] -= self.forward * yaw_rate * yaw_rate;
    }
}

#[cfg(test)]
mod tests {
    use super::super::bench::Bench;
    use super::*;

    #[test]
    fn ahead_of_the_centre_it_is_thrown_outwards_and_pulled_back() {
        let mut bench = Bench::driving(20.0);
        bench.now.velocity.yaw_rate = 0.5;
        let felt = Felt { yaw_acceleration: 2.0, ..Felt::default() };
        let readings = bench.sensed(&KIND, &[0.4], None, &felt);
        assert!((readings[Quantity::LateralAcceleration as usize] - 0.8).abs() < 1e-12);
        assert!((readings[Quantity::LongitudinalAcceleration as usize] + 0.1).abs() < 1e-12);
    }
}
