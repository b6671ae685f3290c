//! Air drag beyond what the vehicle table has.

use super::{Acting, Effect, Kind, Needs, Now, Scale, SearchHints, Setting, Spec};

/// A force against the motion with the square of the speed.
#[derive(Clone, Copy, Debug, PartialEq)]
struct AirDrag {
    coefficient: f64,
}

/// See [`super::KINDS`].
pub static KIND: Kind = Kind {
    name: "air_drag",
    words: "air drag",
    about: "air drag beyond what the vehicle table has",
    equation: "F_x = − c v_x |v_x|",
    source: "thesis 4.4, C_AIR",
    place: "longitudinal force balance",
    to_tell_apart: "coasting down from high speed on a level road, both ways: air drag grows with the \
                    square of the speed, rolling resistance hardly, a grade not at all and changes its \
                    sign on the way back",
    channels: &[],
    parameters: &[Spec {
        name: "drag_coefficient_kg_per_m",
        words: "drag coefficient",
        unit: "kg/m",
        scale: Scale::Linear,
        mean: 0.0,
        std: 0.35,
        bounds: (-0.5, 3.0),
        step: 0.05,
        model_error: Spec::MODEL_ERROR,
        is_main: true,
    }],
    course: None,
    search: SearchHints { needs: Needs::KnownTorque, every_car_has: true, ..SearchHints::USUAL },
    make: |setting: &Setting<'_>| Box::new(AirDrag { coefficient: setting.values[0] }),
};

impl Effect for AirDrag {
    fn act(&self, _now: &Now<'_>, _states: &[f64], on: &mut Acting) {
        on.body.drag += self.coefficient;
    }
}

#[cfg(test)]
mod tests {
    use super::super::bench::{Bench, simple};
    use super::*;

    #[test]
    fn it_is_against_the_motion_and_quadratic() {
        let bench = Bench::driving(20.0);
        let (plain, on) = (bench.plain().body, bench.acted(&*simple(&KIND, &[0.3]), &[]).body);
        for speed in [10.0, 20.0, -10.0f64] {
            let more = on.resistance(speed) - plain.resistance(speed);
            assert!((more - 0.3 * speed * speed.abs()).abs() < 1e-9, "{speed}");
        }
    }
}
