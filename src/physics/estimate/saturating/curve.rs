//! Normalized tire curves, as tables: force / limit against stiffness × slip angle / limit, and its slope.
//!
//! All have the slope 1 at zero. Their shapes cover what tires have (methods.md §2): the brush, which bends early, and
//! two magic formulas, of which the sharper one stays straight longest and falls beyond its peak.

use crate::model::tire::{Brush, MagicFormula, Tire};
use crate::model::tire::{Curve as _, Shape as _};

/// How many shapes.
pub const SHAPES: usize = 3;
/// Steps of a table in a unit of the argument.
const STEPS_PER_UNIT: f64 = 20.0;
/// Its length: far beyond all peaks.
const LENGTH: usize = 241;

/// Shape and curvature of the magic formulas. Physical: between the ends that Bakker, Nyborg and Pacejka (1987) have for
/// lateral and longitudinal forces.
const FORMULAS: [(f64, f64); 2] = [(1.4, -0.2), (1.55, -0.9)];

/// The curves.
#[derive(Clone, Debug)]
pub struct Curves {
    table: Box<[[(f64, f64); LENGTH]; SHAPES]>,
}

impl Curves {
    /// Works the tables out.
    pub fn new() -> Self {
        let tires = [
            Tire::Brush(Brush),
            Tire::MagicFormula(MagicFormula { shape: FORMULAS[0].0, curvature: FORMULAS[0].1 }),
            Tire::MagicFormula(MagicFormula { shape: FORMULAS[1].0, curvature: FORMULAS[1].1 }),
        ];
        let at = |tire: Tire, place: usize| {
            let slip = place as f64 / STEPS_PER_UNIT;
            (tire.force(1.0, 1.0, slip), tire.slope(1.0, 1.0, slip))
        };
        Self { table: Box::new(tires.map(|tire| std::array::from_fn(|place| at(tire, place)))) }
    }

    /// Force and slope at this argument.
    pub fn at(&self, shape: usize, slip: f64) -> (f64, f64) {
        let place = (slip.abs() * STEPS_PER_UNIT).min((LENGTH - 2) as f64 + 0.999);
        let step = place as usize;
        let beyond = place - step as f64;
        let table = &self.table[shape];
        let ((force, slope), (next_force, next_slope)) = (table[step], table[step + 1]);
        let force = force + beyond * (next_force - force);
        (force.copysign(slip), slope + beyond * (next_slope - slope))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tables_are_the_curves() {
        let curves = Curves::new();
        for (shape, (c, curvature)) in [(1, FORMULAS[0]), (2, FORMULAS[1])] {
            let formula = MagicFormula { shape: c, curvature };
            for slip in [-3.3, -0.41, 0.0, 0.77, 1.6, 9.97] {
                let (force, slope) = curves.at(shape, slip);
                assert!((force - formula.force(1.0, 1.0, slip)).abs() < 1e-3, "{shape} {slip}");
                assert!((slope - formula.slope(1.0, 1.0, slip)).abs() < 3e-3, "{shape} {slip}");
            }
        }
        let (force, slope) = curves.at(0, -50.0);
        assert!((force + 1.0).abs() < 1e-12 && slope.abs() < 1e-12);
        assert!((curves.at(0, 1e-3).1 - 1.0).abs() < 1e-2);
    }
}
