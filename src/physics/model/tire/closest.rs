//! The magic formula that is most like another tire model, for those who know no other.

use super::{MagicFormula, Tire};

/// A magic formula in place of another model, with the same initial slope and the same limit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Closest {
    /// Shape and curvature.
    pub formula: MagicFormula,
    /// The largest difference of the forces, as a share of the friction; zero if it is the model itself. Beyond the
    /// friction the linear model has no limit, and there the difference has none, either.
    pub difference: f64,
}

impl Closest {
    /// Least squares over slips up to twice that at which all of a brush slides, with C at least 1: below that the
    /// force would not come to the friction. With x the slip by stiffness / friction all models but one have one curve
    /// without numbers, so two pairs serve for all cars (test `no_neighbour_is_closer`).
    const OF_BRUSH: Self =
        Self { formula: MagicFormula { shape: 1.3177, curvature: 0.3070 }, difference: 0.040 };
    const OF_PIECEWISE: Self =
        Self { formula: MagicFormula { shape: 1.1247, curvature: -4.534 }, difference: 0.089 };
}

impl Tire {
    /// The magic formula that is closest. The linear model is taken as far as its force is below the friction, as if it
    /// were constant beyond.
    pub fn closest_magic_formula(&self) -> Closest {
        match self {
            Self::MagicFormula(formula) => Closest { formula: *formula, difference: 0.0 },
            Self::Brush(_) => Closest::OF_BRUSH,
            Self::PiecewiseLinear(_) | Self::Linear(_) => Closest::OF_PIECEWISE,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::{Brush, Curve, Linear, PiecewiseLinear};
    use super::*;

    const SLIPS: usize = 600;

    /// Slip × stiffness / friction: up to 6.
    fn slips() -> impl Iterator<Item = f64> {
        (0..=SLIPS).map(|place| 6.0 * place as f64 / SLIPS as f64)
    }

    fn squares(tire: &Tire, formula: MagicFormula) -> f64 {
        slips().map(|slip| (tire.force(1.0, 1.0, slip) - formula.force(1.0, 1.0, slip)).powi(2)).sum()
    }

    #[test]
    fn no_neighbour_is_closer() {
        for tire in [Tire::Brush(Brush), Tire::PiecewiseLinear(PiecewiseLinear)] {
            let MagicFormula { shape, curvature } = tire.closest_magic_formula().formula;
            let least = squares(&tire, MagicFormula { shape, curvature });
            for (by_shape, by_curvature) in [(0.003, 0.0), (-0.003, 0.0), (0.0, 0.05), (0.0, -0.05)] {
                let other = MagicFormula { shape: shape + by_shape, curvature: curvature + by_curvature };
                assert!(squares(&tire, other) > least, "{tire:?} {other:?}");
            }
        }
    }

    #[test]
    fn the_difference_is_as_said() {
        for tire in [Tire::Brush(Brush), Tire::PiecewiseLinear(PiecewiseLinear)] {
            let closest = tire.closest_magic_formula();
            // Of a car's numbers, not of ones.
            let (stiffness, friction) = (12.0, 0.8);
            let difference = |x: f64| {
                let slip = x * friction / stiffness;
                let own = tire.force(stiffness, friction, slip);
                (own - closest.formula.force(stiffness, friction, slip)).abs() / friction
            };
            let largest = slips().map(difference).fold(0.0, f64::max);
            assert!((largest - closest.difference).abs() < 1e-3, "{tire:?}: {largest}");
        }
    }

    #[test]
    fn a_magic_formula_is_itself_and_a_line_is_one_up_to_its_limit() {
        let own = MagicFormula { shape: 1.5, curvature: -0.7 };
        assert_eq!(
            Tire::MagicFormula(own).closest_magic_formula(),
            Closest { formula: own, difference: 0.0 }
        );
        assert_eq!(Tire::Linear(Linear).closest_magic_formula(), Closest::OF_PIECEWISE);
    }
}
