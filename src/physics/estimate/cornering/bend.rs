//! How far a tire's curve bends away from its tangent.
//!
//! A tire that uses the share y of its friction slips h(y) times as far as its stiffness alone has it for that
//! force (methods.md §2):
//!
//! ```text
//! magic formula, shape 1.4, no curvature    h = 1.4 tan(asin(y)/1.4) / y
//! brush                                     h = 3 (1 − ∛(1 − y)) / y
//! ```
//!
//! The shape of the car's tires is not known. These two are the straightest and the roundest usual ones.

/// Shape factor of the magic formula. Physical: near the 1.3 of Bakker, Nyborg and Pacejka (1987) for lateral
/// forces.
const SHAPE: f64 = 1.4;

/// Steps of the tables from 0 to full use.
const STEPS: usize = 100;

/// Tables of h.
#[derive(Clone, Debug)]
pub struct Bend {
    least: [f64; STEPS + 1],
    most: [f64; STEPS + 1],
}

impl Bend {
    /// Works the tables out.
    pub fn new() -> Self {
        let at = |step: usize| (step as f64 / STEPS as f64).max(1e-6);
        Self {
            least: std::array::from_fn(|step| SHAPE * (at(step).asin() / SHAPE).tan() / at(step)),
            most: std::array::from_fn(|step| 3.0 * (1.0 - (1.0 - at(step)).cbrt()) / at(step)),
        }
    }

    /// The straightest and the roundest tire's h at this share of the friction.
    pub fn at(&self, share: f64) -> [f64; 2] {
        let place = share.clamp(0.0, 1.0) * STEPS as f64;
        let step = (place as usize).min(STEPS - 1);
        let beyond = place - step as f64;
        [&self.least, &self.most].map(|table| table[step] + beyond * (table[step + 1] - table[step]))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::tire::{Brush, Curve, MagicFormula};

    #[test]
    fn it_is_the_inverse_of_both_curves() {
        let bend = Bend::new();
        let magic = MagicFormula { shape: SHAPE, curvature: 0.0 };
        for share in [0.1, 0.35, 0.6, 0.85, 0.95] {
            let [least, most] = bend.at(share);
            let force = [least, most].map(|bend| bend * share / 12.0);
            assert!((magic.force(12.0, 1.0, force[0]) - share).abs() < 2e-3, "{share}");
            assert!((Brush.force(12.0, 1.0, force[1]) - share).abs() < 2e-3, "{share}");
        }
    }
}
