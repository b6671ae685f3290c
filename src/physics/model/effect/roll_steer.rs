//! Leaning, the body steers its front wheels. Positive is roll understeer: they turn out of the bend
//! (Gillespie 1992, ch. 6).

use super::roll::{self, Roll};
use super::{Acting, Effect, Felt, Kind, Now, Scale, SearchHints, Setting, Spec};

/// The suspension turns the front wheels with the roll angle.
#[derive(Clone, Copy, Debug, PartialEq)]
struct RollSteer {
    roll_steer: f64,
    roll: Roll,
}

/// See [`super::KINDS`].
pub static KIND: Kind = Kind {
    name: "roll_steer",
    words: "roll steer",
    about: "leaning in a turn, the suspension steers the front wheels (positive: out of it, understeer)",
    equation: "δ = δ_sw / i − c φ,  φ̈ = ω² (k a_y − φ) − 2 ζ ω φ̇",
    source: "Gillespie 1992, ch. 6 (roll steer); roll as a mass on springs",
    place: "front tires' slip angle",
    to_tell_apart: "as it is a softer or stiffer front axle in steady turns: steering steps and a sine \
                    sweep through the roll frequency (1 to 2 Hz), where the roll angle is late",
    channels: &[],
    parameters: &[
        Spec {
            name: "roll_steer_rad_per_rad",
            words: "steer angle per roll angle",
            unit: "rad/rad",
            scale: Scale::Linear,
            mean: 0.0,
            std: 0.1,
            bounds: (-1.0, 1.0),
            step: 0.02,
            model_error: Spec::MODEL_ERROR,
            is_main: true,
        },
        Spec {
            name: "roll_gain_rad_per_mps2",
            words: "roll per lateral acceleration",
            unit: "rad/(m/s²)",
            scale: Scale::Linear,
            mean: 0.006,
            std: 0.001,
            bounds: (0.001, 0.02),
            step: 0.0003,
            model_error: Spec::MODEL_ERROR,
            is_main: false,
        },
        roll::FREQUENCY,
        roll::DAMPING,
    ],
    course: None,
    search: SearchHints { every_car_has: true, ..SearchHints::USUAL },
    make: |setting: &Setting<'_>| {
        let roll = Roll { gain: setting.values[1], frequency: setting.values[2], damping: setting.values[3] };
        Box::new(RollSteer { roll_steer: setting.values[0], roll })
    },
};

impl Effect for RollSteer {
    fn states(&self) -> usize {
        2
    }

    fn state_names(&self) -> &'static [&'static str] {
        &["angle", "rate"]
    }

    fn begin(&self, now: &Now<'_>, states: &mut [f64]) {
        self.roll.begin(now.ay, states);
    }

    fn act(&self, _now: &Now<'_>, states: &[f64], on: &mut Acting) {
        let Some(angle) = states.first() else { return };
        on.toe[0] -= self.roll_steer * angle;
        on.toe[1] -= self.roll_steer * angle;
    }

    fn rates(&self, _now: &Now<'_>, felt: &Felt, states: &[f64], rates: &mut [f64]) {
        self.roll.rates(felt.ay, states, rates);
    }
}

#[cfg(test)]
mod tests {
    use super::super::bench::{Bench, simple};
    use super::*;

    #[test]
    fn in_a_steady_left_turn_it_steers_the_front_out_of_it_by_the_lean() {
        let mut bench = Bench::driving(20.0);
        bench.now.ay = 5.0;
        let effect = simple(&KIND, &[0.2, 0.006, 9.0, 0.3]);
        let states = bench.begun(&*effect);
        let toe = bench.acted(&*effect, &states).toe;
        assert!((toe[0] + 0.2 * 0.03).abs() < 1e-12 && toe[1] == toe[0] && toe[2] == 0.0);
        let felt = Felt { ay: 5.0, ..Felt::default() };
        assert!(bench.rates(&*effect, &felt, &states).iter().all(|rate| rate.abs() < 1e-12));
    }
}
