//! The front wheels toe in.

use super::{Acting, Effect, Kind, Now, Scale, SearchHints, Setting, Spec};

/// Each front wheel is turned inwards.
#[derive(Clone, Copy, Debug, PartialEq)]
struct WheelAlignment {
    toe: f64,
}

/// See [`super::KINDS`].
pub static KIND: Kind = Kind {
    name: "wheel_alignment",
    words: "wheel alignment",
    about: "the front wheels are not parallel: each is turned inwards (or outwards)",
    equation: "δ_left = δ − toe, δ_right = δ + toe, forces turned with the wheels",
    source: "suspension geometry",
    place: "front tires' slip angle",
    to_tell_apart: "hard turns to both sides and a long coast-down: unequally loaded tires make toe-in \
                    felt as a steering that depends on the square of the lateral acceleration, and it \
                    drags",
    channels: &[],
    parameters: &[Spec {
        name: "toe_rad",
        words: "toe",
        unit: "rad",
        scale: Scale::Linear,
        mean: 0.0,
        std: 0.005,
        bounds: (-0.05, 0.05),
        step: 0.0005,
        model_error: Spec::MODEL_ERROR,
        is_main: true,
    }],
    course: None,
    search: SearchHints::USUAL,
    make: |setting: &Setting<'_>| Box::new(WheelAlignment { toe: setting.values[0] }),
};

impl Effect for WheelAlignment {
    fn act(&self, _now: &Now<'_>, _states: &[f64], on: &mut Acting) {
        on.toe[0] -= self.toe;
        on.toe[1] += self.toe;
    }
}

#[cfg(test)]
mod tests {
    use super::super::bench::{Bench, simple};
    use super::*;

    #[test]
    fn each_front_wheel_is_turned_inwards() {
        let on = Bench::driving(20.0).acted(&*simple(&KIND, &[0.003]), &[]);
        assert_eq!(on.toe, [-0.003, 0.003, 0.0, 0.0]);
    }
}
