//! Patches on which the tires are less stiff.

use super::{Acting, Course, Disturbance, Effect, Kind, Now, Scale, SearchHints, Setting, Spec, grip};

/// The share of the contact that lies on a softer (or harder) surface varies.
#[derive(Clone, Debug, PartialEq)]
struct SurfaceStiffness {
    factor: f64,
    share: Course,
}

/// See [`super::KINDS`].
pub static KIND: Kind = Kind {
    name: "surface_stiffness",
    words: "surface that softens the tires",
    about: "for a while the road makes the tires less stiff, as gravel does, below any limit",
    equation: "C = C_plain (1 + s (f − 1)), along and across",
    source: "thesis 7.1: tire and road as springs in series",
    place: "the tires' stiffnesses",
    to_tell_apart: "gentle driving and braking on both surfaces (a tenth of the friction): stiffness is \
                    lost at once, friction only near the limit",
    channels: &[],
    parameters: &[Spec {
        name: "stiffness_factor",
        words: "stiffness factor",
        unit: "1",
        scale: Scale::Logarithmic,
        mean: 0.0,
        std: 0.5,
        bounds: (-3.0, 1.6),
        step: 0.05,
        model_error: Spec::MODEL_ERROR,
        is_main: true,
    }],
    course: Some(Disturbance { settings: &[&[-0.7], &[-1.6]], ..grip::PATCH }),
    search: SearchHints::USUAL,
    make: |setting: &Setting<'_>| {
        Box::new(SurfaceStiffness { factor: setting.values[0], share: setting.course.clone() })
    },
};

impl Effect for SurfaceStiffness {
    fn act(&self, now: &Now<'_>, _states: &[f64], on: &mut Acting) {
        let factor = 1.0 + self.share.at(now).clamp(0.0, 1.0) * (self.factor - 1.0);
        for contact in &mut on.contact {
            contact.stiffness_x *= factor;
            contact.stiffness_y *= factor;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::bench::{Bench, constant};
    use super::*;

    #[test]
    fn half_way_onto_gravel() {
        let on = Bench::driving(20.0).acted(&*constant(&KIND, &[0.5], 0.5), &[]);
        assert!((on.contact[0].stiffness_x - 37.5).abs() < 1e-12);
        assert!((on.contact[3].stiffness_y - 0.75 * 11.5).abs() < 1e-12);
        assert_eq!(on.contact[0].friction_x, 1.0);
    }
}
