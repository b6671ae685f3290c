//! Tires whose force along is given, by a torque: what they transmit across, and at which slip they do.

use super::{Brush, Contact, Curve, Real, Tire, ellipse};

impl<T: Real> Tire<T> {
    /// Lateral force / load at a slip angle, rad, of a tire that transmits `x` along, too. `curve` is what its force at pure
    /// slip is read from: the tire itself, or a table of it.
    #[inline(always)]
    pub fn across(&self, curve: &impl Curve<T>, contact: &Contact<T>, x: T, slip_angle: T) -> T {
        match self {
            Self::Linear(_) => self.lateral(contact, slip_angle),
            // Which needs no search.
            Self::Brush(_) if x == T::constant(0.0) => self.lateral(contact, slip_angle),
            Self::Brush(brush) => {
                let slip = brush.slip_at(contact, x, slip_angle);
                brush.combined(contact, slip, slip_angle)[1]
            }
            Self::PiecewiseLinear(_) | Self::MagicFormula(_) => {
                let y = curve.force(contact.stiffness_y, contact.friction_y, slip_angle);
                let left = left_across(contact, x);
                y.at_most(left).at_least(-left)
            }
        }
    }

    /// The slip at which a tire at this slip angle, rad, transmits `x` along: [`Tire::combined`] the other way round.
    #[inline(always)]
    pub fn slip_at(&self, contact: &Contact<T>, x: T, slip_angle: T) -> T {
        let alone = |x: T| self.slip(contact.stiffness_x, contact.friction_x, x);
        match self {
            Self::Linear(_) => alone(x),
            Self::PiecewiseLinear(_) | Self::MagicFormula(_) => {
                let y = self.lateral(contact, slip_angle).abs();
                let left = left_across(contact, x);
                // Beyond, both were scaled back onto the ellipse: so much it was before.
                alone(if y.is_at_most(left) { x } else { x * y / left })
            }
            Self::Brush(brush) => brush.slip_at(contact, x, slip_angle),
        }
    }
}

/// The friction ellipse: force / load that is left across at `x` along.
#[inline(always)]
fn left_across<T: Real>(contact: &Contact<T>, x: T) -> T {
    ellipse::left(x / contact.friction_x) * contact.friction_y
}

/// At the limit, where slips are no function of forces any more, derivatives do not grow beyond all bounds.
const MOST_AGAIN: f64 = 0.95;

impl Brush {
    /// The slip at which [`Brush::combined`] has this force along; at most 1.
    ///
    /// x divided by the secant stiffness at a slip is a slip nearer to it: again and again, the way it goes extrapolated
    /// (Aitken). A hundredth of a per cent in the mean, 2 % at nine tenths of the friction.
    #[inline(always)]
    pub fn slip_at<T: Real>(&self, contact: &Contact<T>, x: T, slip_angle: T) -> T {
        let plain = Contact {
            stiffness_x: contact.stiffness_x.value(),
            stiffness_y: contact.stiffness_y.value(),
            friction_x: contact.friction_x.value(),
            friction_y: contact.friction_y.value(),
        };
        let nearer = |slip: f64| self.nearer(&plain, x.value(), slip_angle.value(), slip);
        let first = x.value() / plain.stiffness_x;
        let second = nearer(first);
        let third = nearer(second);
        let (one, two) = (second - first, third - second);
        let limit = if (two - one).abs() > 1e-12 { third - two * two / (two - one) } else { third };
        let last = self.nearer(contact, x, slip_angle, limit);
        // From there on it would go this share of the way again and again: so would its derivatives.
        let again = if one.abs() > 1e-12 { (two / one).clamp(0.0, MOST_AGAIN) } else { 0.0 };
        let one = T::constant(1.0);
        last.map(last.value(), 1.0 / (1.0 - again)).at_most(one).at_least(-one)
    }

    /// A slip nearer to the one at which the force along is `x`.
    #[inline(always)]
    fn nearer<T: Real>(&self, contact: &Contact<T>, x: T, slip_angle: T, slip: f64) -> T {
        // At no slip the secant is the tangent, and beyond 1 nothing changes.
        let slip = slip.abs().clamp(1e-6, 1.0).copysign(slip);
        let [along, _] = self.combined(contact, T::constant(slip), slip_angle);
        x * slip / along
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::Dual;
    use crate::model::tire::{Linear, MagicFormula, PiecewiseLinear};
    use proptest::prelude::*;

    const TIRES: [Tire; 4] = [
        Tire::Linear(Linear),
        Tire::PiecewiseLinear(PiecewiseLinear),
        Tire::Brush(Brush),
        Tire::MagicFormula(MagicFormula { shape: 1.3, curvature: -0.5 }),
    ];

    fn contact(friction: f64) -> Contact {
        Contact { stiffness_x: 30.0, stiffness_y: 12.0, friction_x: friction, friction_y: friction }
    }

    proptest! {
        #[test]
        fn at_its_slip_a_tire_transmits_what_was_given(
            index in 0..TIRES.len(), friction in 0.7..1.1f64, share in -0.7..0.7f64, angle in -0.03..0.03f64,
        ) {
            let (tire, contact, x) = (TIRES[index], contact(friction), share * friction);
            let combined = tire.combined(&contact, tire.slip_at(&contact, x, angle), angle);
            prop_assert!((combined[0] - x).abs() < 5e-3 * friction, "{combined:?} {x}");
            prop_assert!((combined[1] - tire.across(&tire, &contact, x, angle)).abs() < 5e-3 * friction);
        }

        #[test]
        fn a_brush_knows_how_its_slip_changes(share in -0.6..0.6f64, angle in -0.03..0.03f64) {
            let slip = |share: f64, angle: f64| Brush.slip_at(&contact(0.9), 0.9 * share, angle);
            let h = 1e-6;
            let by = [
                (slip(share + h, angle) - slip(share - h, angle)) / (2.0 * h),
                (slip(share, angle + h) - slip(share, angle - h)) / (2.0 * h),
            ];
            let contact = Contact {
                stiffness_x: Dual::<2>::constant(30.0),
                stiffness_y: Dual::constant(12.0),
                friction_x: Dual::constant(0.9),
                friction_y: Dual::constant(0.9),
            };
            let exact = Brush.slip_at(&contact, Dual::variable(share, 0) * 0.9, Dual::variable(angle, 1));
            for (by, exact) in by.into_iter().zip(exact.by) {
                prop_assert!((by - exact).abs() < 0.05 * (0.03 + exact.abs()), "{by} {exact}");
            }
        }
    }
}
