//! The steering gear does not turn the road wheels in proportion.

use super::{Acting, Effect, Kind, Now, Scale, SearchHints, Setting, Spec};

/// A ratio that varies with the steering wheel's angle.
#[derive(Clone, Copy, Debug, PartialEq)]
struct SteeringRatio {
    curvature: f64,
}

/// What is left of the ratio at least.
const SMALLEST_SHARE: f64 = 0.2;

/// See [`super::KINDS`].
pub static KIND: Kind = Kind {
    name: "steering_ratio",
    words: "varying steering ratio",
    about: "the steering ratio varies with the steering wheel angle",
    equation: "i = i0 (1 − c δ_sw²)",
    source: "progressive steering gear",
    place: "the steering",
    to_tell_apart: "slow driving with large steering wheel angles, both ways, beside gentle curves at \
                    speed: the error depends on the angle of the steering wheel alone, at every speed",
    channels: &[],
    parameters: &[Spec {
        name: "curvature_per_rad2",
        words: "curvature of the ratio",
        unit: "1/rad²",
        scale: Scale::Linear,
        mean: 0.0,
        std: 0.15,
        bounds: (-1.0, 1.0),
        step: 0.02,
        // Curvatures that were put into real drives come out 30 % large (`concealed_in_real_drives`).
        model_error: 0.2,
        is_main: true,
    }],
    course: None,
    search: SearchHints::USUAL,
    make: |setting: &Setting<'_>| Box::new(SteeringRatio { curvature: setting.values[0] }),
};

impl Effect for SteeringRatio {
    fn act(&self, _now: &Now<'_>, _states: &[f64], on: &mut Acting) {
        let share = 1.0 - self.curvature * on.steering_wheel * on.steering_wheel;
        on.steering_ratio *= share.max(SMALLEST_SHARE);
    }
}

#[cfg(test)]
mod tests {
    use super::super::bench::{Bench, simple};
    use super::*;

    #[test]
    fn away_from_the_middle_it_becomes_more_direct_on_both_sides() {
        let mut bench = Bench::driving(5.0);
        bench.now.steering_ratio = 15.0;
        let effect = simple(&KIND, &[0.1]);
        for angle in [2.0, -2.0] {
            bench.now.steering_wheel = angle;
            assert!((bench.acted(&*effect, &[]).steering_ratio - 9.0).abs() < 1e-12);
        }
        bench.now.steering_wheel = 5.0;
        assert!((bench.acted(&*effect, &[]).steering_ratio - 3.0).abs() < 1e-12, "never through zero");
    }
}
