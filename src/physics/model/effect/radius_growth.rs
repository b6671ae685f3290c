//! Tires grow with the speed of their turning.

use super::{Acting, Effect, Kind, Now, Scale, SearchHints, Setting, Spec};

/// Centrifugal force makes the rolling radius grow.
#[derive(Clone, Copy, Debug, PartialEq)]
struct RadiusGrowth {
    relative_per_square: f64,
}

/// See [`super::KINDS`].
pub static KIND: Kind = Kind {
    name: "radius_growth",
    words: "tire radii that grow with speed",
    about: "the tires' rolling radius grows with the square of the speed",
    equation: "r = r0 (1 + c (r0 ω)²)",
    source: "centrifugal force on the belt",
    place: "the wheels' rolling",
    to_tell_apart: "speeds from walking pace to 50 m/s beside a true speed (satellite, measured distance): \
                    from wheel speeds alone it looks like resistance that grows with speed",
    channels: &[],
    parameters: &[Spec {
        name: "relative_per_mps_squared",
        words: "relative growth per speed squared",
        unit: "1/(m/s)²",
        scale: Scale::Linear,
        mean: 0.0,
        std: 1e-05,
        // Tires grow by some per mille at 50 m/s, those of race cars by some per cent; what presses a car down takes some per mille back.
        bounds: (-2e-6, 5e-5),
        step: 2e-06,
        model_error: Spec::MODEL_ERROR,
        is_main: true,
    }],
    course: None,
    search: SearchHints::USUAL,
    make: |setting: &Setting<'_>| Box::new(RadiusGrowth { relative_per_square: setting.values[0] }),
};

impl Effect for RadiusGrowth {
    fn act(&self, now: &Now<'_>, _states: &[f64], on: &mut Acting) {
        // Rolling, r ω is the speed: s = r / r0 = 1 + c v² / s², by steps; three leave a thousandth of it.
        let slow = self.relative_per_square * now.velocity.vx.powi(2);
        let share = (0..3).fold(1.0, |share: f64, _| 1.0 + slow / (share * share));
        on.radius = on.radius.map(|radius| share * radius);
    }
}

#[cfg(test)]
mod tests {
    use super::super::bench::{Bench, simple};
    use super::*;

    #[test]
    fn it_grows_with_the_square_of_how_fast_it_turns() {
        let radius = |speed: f64| {
            let bench = Bench::driving(speed);
            bench.acted(&*simple(&KIND, &[1e-5]), &[]).radius[3]
        };
        for speed in [20.0, 40.0] {
            let r = radius(speed);
            let turning = 0.31 * speed / r;
            assert!((r / 0.31 - (1.0 + 1e-5 * turning * turning)).abs() < 1e-6, "{speed}");
        }
        assert!(((radius(40.0) - 0.31) / (radius(20.0) - 0.31) - 3.9).abs() < 0.05);
    }
}
