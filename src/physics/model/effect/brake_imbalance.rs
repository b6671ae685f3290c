//! The brakes of an axle do not brake alike.

use super::{Acting, Effect, Kind, Needs, Now, SearchHints, Setting, Spec, Usual};

/// Of each axle, front first: by how much more the left brake gives than the mean of both, relative to it.
#[derive(Clone, Copy, Debug, PartialEq)]
struct BrakeImbalance {
    left_more: [f64; 2],
}

/// Of one axle.
const fn left_more(name: &'static str, words: &'static str) -> Spec {
    Spec { std: 0.1, bounds: (-0.95, 0.95), step: 0.01, ..Spec::ratio(name, words) }
}

/// At its inspection a car fails from 0.18 on, where one brake gives less than 70 % of the other (Directive 2014/45/EU,
/// Annex I, 1.2.2): what is a fifth of that is nobody's fault.
const USUAL: Usual = Usual { of: None, bounds: (-0.035, 0.035) };

/// See [`super::KINDS`].
pub static KIND: Kind = Kind {
    name: "brake_imbalance",
    words: "brakes that pull to one side",
    about: "left and right brake of an axle do not give the same torque: a seized caliper, pads of two kinds, a wet disc",
    equation: "T_left = (1 + e) T, T_right = (1 − e) T of an axle's brakes",
    source: "disc brake: torque = pressure · area · 2 μ · effective radius",
    place: "yaw moment balance and the wheels' slip",
    to_tell_apart: "straight ahead with free hands, two stops from 80 km/h at moderate pressure; a cause in the \
                    steering or the tires pulls while rolling, too",
    channels: &[],
    parameters: &[
        left_more("left_more_front", "more at the left front brake"),
        left_more("left_more_rear", "more at the left rear brake"),
    ],
    course: None,
    // How axles share the braking is hardly known where no pressure is.
    search: SearchHints {
        needs: Needs::KnownTorque,
        each_number_alone: true,
        usual: Some(USUAL),
        ..SearchHints::USUAL
    },
    make: |setting: &Setting<'_>| {
        Box::new(BrakeImbalance { left_more: std::array::from_fn(|axle| setting.values[axle]) })
    },
};

impl Effect for BrakeImbalance {
    fn act(&self, _now: &Now<'_>, _states: &[f64], on: &mut Acting) {
        for (axle, left_more) in self.left_more.into_iter().enumerate() {
            on.brake_gain[2 * axle] *= 1.0 + left_more;
            on.brake_gain[2 * axle + 1] *= 1.0 - left_more;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::bench::{Bench, simple};
    use super::*;

    #[test]
    fn one_side_brakes_more_and_the_other_less() {
        let on = Bench::driving(20.0).acted(&*simple(&KIND, &[0.2, -0.1]), &[]);
        assert_eq!(on.brake_gain, [1.2, 0.8, 0.9, 1.1]);
    }
}
