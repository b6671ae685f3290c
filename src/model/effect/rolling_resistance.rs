//! Rolling resistance beyond what the vehicle table has.

use super::{Acting, Effect, Kind, Now, Scale, Setting, Spec};

/// A force against the motion in proportion to the load.
#[derive(Clone, Copy, Debug, PartialEq)]
struct RollingResistance {
    coefficient: f64,
}

/// See [`super::KINDS`].
pub static KIND: Kind = Kind {
    name: "rolling_resistance",
    about: "rolling resistance beyond what the vehicle table has",
    equation: "F_x = − c m g sgn v_x",
    source: "Coulomb friction (thesis 3.2)",
    place: "longitudinal force balance",
    to_tell_apart: "coasting down slowly on a level road, both ways: rolling resistance is the same at \
                    every speed, air drag is not, and a grade changes its sign on the way back",
    channels: &[],
    parameters: &[Spec {
        name: "coefficient",
        unit: "1",
        scale: Scale::Linear,
        mean: 0.0,
        std: 0.012,
        bounds: (-0.02, 0.1),
        step: 0.002,
        is_main: true,
    }],
    course: None,
    make: |setting: &Setting<'_>| Box::new(RollingResistance { coefficient: setting.values[0] }),
};

impl Effect for RollingResistance {
    fn act(&self, _now: &Now<'_>, _states: &[f64], on: &mut Acting) {
        on.body.rolling_resistance += self.coefficient;
    }
}

#[cfg(test)]
mod tests {
    use super::super::bench::{Bench, simple};
    use super::*;

    #[test]
    fn it_is_against_the_motion_and_the_same_at_every_speed() {
        let bench = Bench::driving(20.0);
        let (plain, on) = (bench.plain().body, bench.acted(&*simple(&KIND, &[0.01]), &[]).body);
        for speed in [5.0, 40.0, -5.0f64] {
            let more = on.resistance(speed) - plain.resistance(speed);
            assert!((more - 0.01 * 1700.0 * 9.81 * speed.signum()).abs() < 1e-9, "{speed}");
        }
    }
}
