//! The friction ellipse (thesis 4.15).

use super::{Contact, Curve, Real, Tire};

/// How much of the ellipse holds below the limit, where one force takes from the other: 0 nothing is taken, 1 a whole
/// ellipse.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct EllipseFactors {
    /// Of the force across, by the force along.
    pub across: f64,
    /// Of the force along, by the force across that the slip angle alone would give.
    pub along: f64,
}

impl EllipseFactors {
    /// The share of the force across that is left at this force along / load.
    #[inline]
    pub fn left_across(&self, tire: &Tire, contact: &Contact, x: f64) -> f64 {
        if self.across == 0.0 {
            return 1.0;
        }
        left(self.across * x / limit(tire, contact.friction_x))
    }

    /// The share of the force along that is left at this slip angle, rad. `curve` is what forces at pure slip are read
    /// from: the tire itself, or a table of it.
    #[inline]
    pub fn left_along(&self, tire: &Tire, curve: &impl Curve, contact: &Contact, slip_angle: f64) -> f64 {
        if self.along == 0.0 {
            return 1.0;
        }
        let y = tire.across(curve, contact, 0.0, slip_angle);
        left(self.along * y / limit(tire, contact.friction_y))
    }
}

/// What a force is measured against, per load: a linear tire has no limit.
#[inline]
fn limit(tire: &Tire, friction: f64) -> f64 {
    if matches!(tire, Tire::Linear(_)) || friction.is_infinite() { 1.0 } else { friction }
}

/// Scales a pair of forces / normal load back onto the ellipse (x/μ_x)² + (y/μ_y)² = 1 if it lies
/// outside; its direction stays.
#[inline(always)]
pub fn scaled_back<T: Real>(contact: &Contact<T>, [x, y]: [T; 2]) -> [T; 2] {
    let (ex, ey) = (x / contact.friction_x, y / contact.friction_y);
    let used = ex * ex + ey * ey;
    if used.is_at_most(T::constant(1.0)) {
        return [x, y];
    }
    let used = used.sqrt();
    [x / used, y / used]
}

/// Share of the lateral force that is left, at least, squared: a spinning wheel still has some.
const LEAST_LEFT_SQUARED: f64 = 1e-4;

/// The share of the force across that is left where this share of the force along is used.
#[inline(always)]
pub fn left<T: Real>(used: T) -> T {
    (-(used * used) + 1.0).at_least(T::constant(LEAST_LEFT_SQUARED)).sqrt()
}

/// Both forces of a curve as if each slip were alone, scaled back together.
#[inline(always)]
pub(super) fn pair<T: Real>(curve: &impl Curve<T>, contact: &Contact<T>, slip: T, slip_angle: T) -> [T; 2] {
    let x = curve.force(contact.stiffness_x, contact.friction_x, slip);
    let y = curve.force(contact.stiffness_y, contact.friction_y, slip_angle);
    scaled_back(contact, [x, y])
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::tire::{Linear, MagicFormula};

    #[test]
    fn below_the_limit_each_force_takes_its_share_of_the_other() {
        let (tire, linear) =
            (Tire::MagicFormula(MagicFormula { shape: 1.3, curvature: -0.5 }), Tire::Linear(Linear));
        let contact = Contact { stiffness_x: 30.0, stiffness_y: 12.0, friction_x: 0.9, friction_y: 0.8 };
        let both = EllipseFactors { across: 0.6, along: 0.5 };
        let close =
            |value: f64, expected: f64| assert!((value - expected).abs() < 1e-12, "{value} {expected}");
        close(both.left_across(&tire, &contact, 0.45), (1.0f64 - 0.3 * 0.3).sqrt());
        let y = tire.lateral(&contact, 0.05);
        close(both.left_along(&tire, &tire, &contact, 0.05), (1.0 - (0.5 * y / 0.8).powi(2)).sqrt());
        // Without a limit a force is measured against the load.
        close(both.left_along(&linear, &linear, &contact, 0.05), (1.0f64 - 0.3 * 0.3).sqrt());
        let none = EllipseFactors::default();
        assert_eq!(
            [none.left_across(&tire, &contact, 0.8), none.left_along(&tire, &tire, &contact, 0.1)],
            [1.0; 2]
        );
    }

    #[test]
    fn inside_untouched_outside_onto_it() {
        let contact = Contact { stiffness_x: 50.0, stiffness_y: 12.0, friction_x: 1.0, friction_y: 0.5 };
        assert_eq!(scaled_back(&contact, [0.6, 0.2]), [0.6, 0.2]);
        let [x, y] = scaled_back(&contact, [1.0, 0.5]);
        assert!((x * x + 4.0 * y * y - 1.0).abs() < 1e-12);
        assert!((y / x - 0.5).abs() < 1e-12);
    }
}
