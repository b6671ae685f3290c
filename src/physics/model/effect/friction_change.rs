//! Patches of another friction.

use super::{Acting, Course, Disturbance, Effect, Kind, Now, SearchHints, Setting, grip};

/// The share of the contact that lies on the other surface varies, the same at all wheels.
#[derive(Clone, Debug, PartialEq)]
struct FrictionChange {
    inverse: f64,
    share: Course,
}

/// See [`super::KINDS`].
pub static KIND: Kind = Kind {
    name: "friction_change",
    words: "change of friction",
    about: "for a while the road has another friction",
    equation: "1/μ = (1 − s)/μ_plain + s/friction at all wheels; a linear tire becomes a magic formula (C \
               = 1.35, E = −0.3)",
    source: "thesis 4.3; friction of two surfaces side by side",
    place: "the tires' forces",
    to_tell_apart: "braking and turning on the patch with at least half of its friction, both ways round: \
                    below that the two surfaces feel alike",
    channels: &[],
    parameters: &[grip::friction("friction", "friction")],
    course: Some(Disturbance { settings: &[&[2.0], &[5.0]], is_slippery: true, ..grip::PATCH }),
    search: SearchHints::USUAL,
    make: |setting: &Setting<'_>| {
        Box::new(FrictionChange { inverse: setting.values[0].recip(), share: setting.course.clone() })
    },
};

impl Effect for FrictionChange {
    fn act(&self, now: &Now<'_>, _states: &[f64], on: &mut Acting) {
        grip::mix(on, self.share.at(now), [self.inverse; 4]);
    }
}

#[cfg(test)]
mod tests {
    use super::super::bench::{Bench, constant};
    use super::*;

    #[test]
    fn on_the_patch_the_friction_is_the_patchs() {
        let bench = Bench::driving(20.0);
        let on = bench.acted(&*constant(&KIND, &[0.3], 1.0), &[]);
        assert!(on.contact.iter().all(|contact| (contact.friction_x - 0.3).abs() < 1e-12));
        assert!(on.contact.iter().all(|contact| (contact.friction_y - 0.3).abs() < 1e-12));
        assert_eq!(bench.acted(&*constant(&KIND, &[0.3], 0.0), &[]), bench.plain());
    }
}
