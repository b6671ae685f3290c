//! Tires grow with speed.

use super::{Acting, Effect, Kind, Now, Scale, Setting, Spec};

/// Centrifugal force makes the rolling radius grow.
#[derive(Clone, Copy, Debug, PartialEq)]
struct RadiusGrowth {
    relative_per_square: f64,
}

/// See [`super::KINDS`].
pub static KIND: Kind = Kind {
    name: "radius_growth",
    about: "the tires' rolling radius grows with the square of the speed",
    equation: "r = r0 (1 + c v_x²)",
    source: "centrifugal force on the belt",
    place: "the wheels' rolling",
    to_tell_apart: "speeds from walking pace to 50 m/s beside a true speed (satellite, measured distance): \
                    from wheel speeds alone it looks like resistance that grows with speed",
    channels: &[],
    parameters: &[Spec {
        name: "relative_per_mps_squared",
        unit: "1/(m/s)²",
        scale: Scale::Linear,
        mean: 0.0,
        std: 1e-05,
        bounds: (-0.0001, 0.0001),
        step: 2e-06,
        is_main: true,
    }],
    course: None,
    make: |setting: &Setting<'_>| Box::new(RadiusGrowth { relative_per_square: setting.values[0] }),
};

impl Effect for RadiusGrowth {
    fn act(&self, now: &Now<'_>, _states: &[f64], on: &mut Acting) {
        let speed = now.velocity.vx;
        on.radius = on.radius.map(|radius| radius * (1.0 + self.relative_per_square * speed * speed));
    }
}

#[cfg(test)]
mod tests {
    use super::super::bench::{Bench, simple};
    use super::*;

    #[test]
    fn it_grows_with_the_square() {
        let growth = |speed: f64| {
            let bench = Bench::driving(speed);
            bench.acted(&*simple(&KIND, &[1e-5]), &[]).radius[3] / 0.31 - 1.0
        };
        assert!((growth(20.0) - 0.004).abs() < 1e-12);
        assert!((growth(40.0) / growth(20.0) - 4.0).abs() < 1e-9);
    }
}
