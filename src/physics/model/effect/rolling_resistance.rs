//! Rolling resistance beyond what the vehicle table has: at each wheel, so that free ones slip for it, too.

use super::{Acting, Effect, Kind, Needs, Now, Scale, SearchHints, Setting, Spec};
use crate::model::wheel::reference_speed;

/// A moment against each wheel's rolling in proportion to its load.
#[derive(Clone, Copy, Debug, PartialEq)]
struct RollingResistance {
    coefficient: f64,
}

/// See [`super::KINDS`].
pub static KIND: Kind = Kind {
    name: "rolling_resistance",
    words: "rolling resistance",
    about: "rolling resistance beyond what the vehicle table has",
    equation: "M_i = − c F_z,i r sgn v_x",
    source: "ISO 28580; Coulomb friction (thesis 3.2)",
    place: "longitudinal force balance",
    to_tell_apart: "coasting down slowly on a level road, both ways: rolling resistance is the same at \
                    every speed, air drag is not, and a grade changes its sign on the way back",
    channels: &[],
    parameters: &[Spec {
        name: "coefficient",
        words: "coefficient",
        unit: "1",
        scale: Scale::Linear,
        mean: 0.0,
        std: 0.012,
        bounds: (-0.02, 0.1),
        step: 0.002,
        model_error: Spec::MODEL_ERROR,
        is_main: true,
    }],
    course: None,
    search: SearchHints { needs: Needs::KnownTorque, every_car_has: true, ..SearchHints::USUAL },
    make: |setting: &Setting<'_>| Box::new(RollingResistance { coefficient: setting.values[0] }),
};

impl Effect for RollingResistance {
    fn act(&self, now: &Now<'_>, _states: &[f64], on: &mut Acting) {
        // Vanishes smoothly at standstill.
        let rolls = now.velocity.vx / reference_speed(now.velocity.vx);
        for (brake, load) in on.brake.iter_mut().zip(on.load) {
            *brake += self.coefficient * load * rolls;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::bench::{Bench, simple};
    use super::*;

    #[test]
    fn it_is_against_the_motion_and_the_same_at_every_speed() {
        for speed in [5.0, 40.0, -5.0f64] {
            let on = Bench::driving(speed).acted(&*simple(&KIND, &[0.01]), &[]);
            for (brake, load) in on.brake.into_iter().zip(on.load) {
                assert!((brake - 0.01 * load * speed.signum()).abs() < 1e-9, "{speed}");
            }
        }
    }
}
