//! Patches of another friction, not the same left and right.

use super::{Acting, Course, Disturbance, Effect, Kind, Now, SearchHints, Setting, grip};

/// The same share of all contacts lies on another surface, which differs from side to side.
#[derive(Clone, Debug, PartialEq)]
struct FrictionSplit {
    /// Left, right.
    inverse: [f64; 2],
    share: Course,
}

/// See [`super::KINDS`].
pub static KIND: Kind = Kind {
    name: "friction_split",
    words: "friction unequal left and right",
    about: "for a while the road has another friction, and not the same left and right",
    equation: "1/μ = (1 − s)/μ_plain + s/friction_left (right) at the left (right) wheels; a linear tire \
               becomes a magic formula (C = 1.35, E = −0.3)",
    source: "thesis 4.3; friction of two surfaces side by side",
    place: "the tires' forces",
    to_tell_apart: "braking straight ahead on the patch: unequal friction turns the car, equal friction \
                    does not",
    channels: &[],
    parameters: &[
        grip::friction("friction_left", "friction at the left"),
        grip::friction("friction_right", "friction at the right"),
    ],
    course: Some(Disturbance {
        settings: &[&[2.0, 0.0], &[0.0, 2.0], &[5.0, 0.0], &[0.0, 5.0]],
        is_slippery: true,
        ..grip::PATCH
    }),
    search: SearchHints::USUAL,
    make: |setting: &Setting<'_>| {
        let inverse = std::array::from_fn(|side| setting.values[side].recip());
        Box::new(FrictionSplit { inverse, share: setting.course.clone() })
    },
};

impl Effect for FrictionSplit {
    fn act(&self, now: &Now<'_>, _states: &[f64], on: &mut Acting) {
        let [left, right] = self.inverse;
        grip::mix(on, self.share.at(now), [left, right, left, right]);
    }
}

#[cfg(test)]
mod tests {
    use super::super::bench::{Bench, constant};
    use super::*;

    #[test]
    fn each_side_has_its_own() {
        let on = Bench::driving(20.0).acted(&*constant(&KIND, &[0.2, 0.8], 1.0), &[]);
        let friction = on.contact.map(|contact| contact.friction_y);
        for (friction, expected) in friction.into_iter().zip([0.2, 0.8, 0.2, 0.8]) {
            assert!((friction - expected).abs() < 1e-12);
        }
    }
}
