//! Tires of unequal radius.

use super::{Acting, Effect, Kind, Now, SearchHints, Setting, Spec, Usual};

/// Each wheel's rolling radius, relative to the one of the vehicle table.
#[derive(Clone, Copy, Debug, PartialEq)]
struct TireRadius {
    relative_difference: [f64; 4],
}

/// Of one wheel.
const fn difference(name: &'static str, words: &'static str) -> Spec {
    Spec { std: 0.01, bounds: (-0.2, 0.2), step: 0.001, ..Spec::ratio(name, words) }
}

/// Wear, load and pressure make tires of one set differ by some tenths of a per cent: what is wrong with a wheel is more.
const USUAL: Usual = Usual { of: None, bounds: (-0.003, 0.003) };

/// See [`super::KINDS`].
pub static KIND: Kind = Kind {
    name: "tire_radius",
    words: "unequal tire radii",
    about: "the tires' rolling radii differ: pressure, wear, a spare wheel",
    equation: "r_i = r (1 + e_i)",
    source: "v = r ω",
    place: "the wheels' rolling",
    to_tell_apart: "rolling freely straight ahead for a minute at steady speed: the wheel speeds differ by \
                    the same ratio at every speed and torque",
    channels: &[],
    parameters: &[
        difference("relative_difference_fl", "radius, front left wheel"),
        difference("relative_difference_fr", "radius, front right wheel"),
        difference("relative_difference_rl", "radius, rear left wheel"),
        difference("relative_difference_rr", "radius, rear right wheel"),
    ],
    course: None,
    search: SearchHints { each_number_alone: true, usual: Some(USUAL), ..SearchHints::USUAL },
    make: |setting: &Setting<'_>| {
        Box::new(TireRadius { relative_difference: std::array::from_fn(|i| setting.values[i]) })
    },
};

impl Effect for TireRadius {
    fn act(&self, _now: &Now<'_>, _states: &[f64], on: &mut Acting) {
        for (radius, relative) in on.radius.iter_mut().zip(self.relative_difference) {
            *radius *= 1.0 + relative;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::bench::{Bench, simple};
    use super::*;

    #[test]
    fn each_wheel_has_its_own() {
        let on = Bench::driving(20.0).acted(&*simple(&KIND, &[0.01, 0.0, -0.02, 0.0]), &[]);
        let expected = [0.31 * 1.01, 0.31, 0.31 * 0.98, 0.31];
        for (radius, expected) in on.radius.into_iter().zip(expected) {
            assert!((radius - expected).abs() < 1e-12);
        }
    }
}
