//! A limit of the tires' force, as one over the friction: zero is no limit.

use super::{Acting, Disturbance, Scale, Spec};
use crate::model::tire::{MagicFormula, Tire};

/// The curve of a linear tire once it has a limit: shape and curvature of a usual passenger car tire.
const USUAL: MagicFormula = MagicFormula { shape: 1.35, curvature: -0.3 };

/// A friction of the road under this name: searched by one over it, without limit at 0.
pub(super) const fn friction(name: &'static str, words: &'static str) -> Spec {
    Spec {
        name,
        words,
        unit: "1",
        scale: Scale::Inverse,
        mean: 0.0,
        std: 1.5,
        bounds: (0.0, 33.0),
        step: 0.5,
        model_error: Spec::MODEL_ERROR,
        is_main: true,
    }
}

/// How much of the road is another one, as a share.
pub(super) const PATCH: Disturbance =
    Disturbance { rms_name: "share_rms", words: "share rms", length_s: 3.0, sign: 1.0, ..Disturbance::USUAL };

/// Below this a tire counts as unlimited.
const UNLIMITED: f64 = 1e-6;

/// One over the friction of each wheel, along and across; zero for linear tires.
pub(super) fn inverse(on: &Acting) -> [[f64; 2]; 4] {
    match on.tire {
        Tire::Linear(_) => [[0.0; 2]; 4],
        _ => on.contact.map(|contact| [contact.friction_x.recip(), contact.friction_y.recip()]),
    }
}

/// Sets the friction of each wheel by one over it, along and across. A linear tire takes a magic
/// formula's curve with the first limit it gets.
pub(super) fn limit(on: &mut Acting, inverse: [[f64; 2]; 4]) {
    if matches!(on.tire, Tire::Linear(_)) {
        if inverse.as_flattened().iter().all(|inverse| *inverse <= UNLIMITED) {
            return;
        }
        on.tire = Tire::MagicFormula(USUAL);
    }
    for (contact, [along, across]) in on.contact.iter_mut().zip(inverse) {
        contact.friction_x = along.max(UNLIMITED).recip();
        contact.friction_y = across.max(UNLIMITED).recip();
    }
}

/// Sets the friction of each wheel by what covers a `share` (0–1) of its contact: there one over the
/// friction is `other`, beside it what it was.
pub(super) fn mix(on: &mut Acting, share: f64, other: [f64; 4]) {
    let share = share.clamp(0.0, 1.0);
    if share == 0.0 {
        return;
    }
    let mut mixed = inverse(on);
    for (wheel, other) in mixed.iter_mut().zip(other) {
        *wheel = wheel.map(|own| (1.0 - share) * own + share * other);
    }
    limit(on, mixed);
}

#[cfg(test)]
mod tests {
    use super::super::bench::Bench;
    use super::*;
    use crate::model::tire::Linear;

    #[test]
    fn a_linear_tire_stays_linear_without_a_limit_and_nearly_so_with_a_high_one() {
        let mut on = Bench::driving(20.0).plain();
        on.tire = Tire::Linear(Linear);
        limit(&mut on, [[0.0; 2]; 4]);
        assert_eq!(on.tire, Tire::Linear(Linear));
        limit(&mut on, [[1e-4, 1e-4], [0.0; 2], [0.0; 2], [0.0; 2]]);
        let force = on.tire.lateral(&on.contact[0], 0.1);
        assert!((force - 1.15).abs() < 1e-6, "{force}");
        assert!((on.tire.lateral(&on.contact[1], 0.1) - 1.15).abs() < 1e-9);
    }

    #[test]
    fn half_covered_is_half_way_in_one_over_the_friction() {
        let mut on = Bench::driving(20.0).plain();
        mix(&mut on, 0.5, [5.0, 5.0, 1.0, 1.0]);
        assert!((on.contact[0].friction_y - 1.0 / 3.0).abs() < 1e-12);
        assert!((on.contact[2].friction_x - 1.0).abs() < 1e-12);
    }
}
