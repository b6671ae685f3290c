//! Leaning, the accelerometer feels gravity.

use super::roll::{self, Roll};
use super::{Effect, Felt, Kind, Now, Readings, Scale, SearchHints, Setting, Spec};
use crate::Quantity;
use crate::model::GRAVITY;

/// The accelerometer leans with the body.
#[derive(Clone, Copy, Debug, PartialEq)]
struct BodyRoll {
    roll: Roll,
}

/// See [`super::KINDS`].
pub static KIND: Kind = Kind {
    name: "body_roll",
    words: "body roll at the accelerometer",
    about: "leaning out of a turn, the body tilts the accelerometer, which then feels gravity, too",
    equation: "a_y,read = a_y + g φ,  φ̈ = ω² (k a_y − φ) − 2 ζ ω φ̇",
    source: "rigid-body kinematics; roll as a mass on springs",
    place: "the lateral accelerometer",
    to_tell_apart: "steering steps and a sine sweep through the roll frequency (1 to 2 Hz): the roll angle \
                    is late and resonates, a wrong scale of the sensor is not and does not",
    channels: &[],
    parameters: &[
        Spec {
            name: "roll_gain_rad_per_mps2",
            words: "roll per lateral acceleration",
            unit: "rad/(m/s²)",
            scale: Scale::Linear,
            mean: 0.0,
            std: 0.006,
            bounds: (-0.005, 0.03),
            step: 0.0005,
            model_error: Spec::MODEL_ERROR,
            is_main: true,
        },
        roll::FREQUENCY,
        roll::DAMPING,
    ],
    course: None,
    search: SearchHints { every_car_has: true, ..SearchHints::USUAL },
    make: |setting: &Setting<'_>| {
        let [gain, frequency, damping] = std::array::from_fn(|i| setting.values[i]);
        Box::new(BodyRoll { roll: Roll { gain, frequency, damping } })
    },
};

impl Effect for BodyRoll {
    fn states(&self) -> usize {
        2
    }

    fn state_names(&self) -> &'static [&'static str] {
        &["angle", "rate"]
    }

    fn begin(&self, now: &Now<'_>, states: &mut [f64]) {
        self.roll.begin(now.ay, states);
    }

    fn rates(&self, _now: &Now<'_>, felt: &Felt, states: &[f64], rates: &mut [f64]) {
        self.roll.rates(felt.ay, states, rates);
    }

    fn sense(&self, _now: &Now<'_>, _felt: &Felt, states: &[f64], readings: &mut Readings) {
        let Some(angle) = states.first() else { return };
        readings[Quantity::LateralAcceleration as usize] += GRAVITY * angle;
    }
}

#[cfg(test)]
mod tests {
    use super::super::bench::{Bench, simple};
    use super::*;

    #[test]
    fn in_a_steady_left_turn_it_reads_too_much() {
        let mut bench = Bench::driving(20.0);
        bench.now.ay = 5.0;
        let effect = simple(&KIND, &[0.006, 9.0, 0.3]);
        let states = bench.begun(&*effect);
        let mut readings = [0.0; Quantity::COUNT];
        effect.sense(&bench.now, &Felt::default(), &states, &mut readings);
        assert!((readings[Quantity::LateralAcceleration as usize] - 9.81 * 0.03).abs() < 1e-12);
        assert_eq!(bench.acted(&*effect, &states), bench.plain(), "the car itself does not notice");
    }
}
