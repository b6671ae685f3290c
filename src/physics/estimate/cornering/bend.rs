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
//! The shape of the car's tires is not known. These two are the straightest and the roundest usual ones: the
//! estimates use the first, bounds of the friction the second. Beyond its peak a curve falls, the more the larger its
//! shape factor: a tire that slides far may have had more friction than it uses now.

/// Shape factor of the magic formula. Physical: near the 1.3 of Bakker, Nyborg and Pacejka (1987) for lateral
/// forces.
const SHAPE: f64 = 1.4;

/// That of the tire that falls most. Physical: theirs for longitudinal forces.
const FALLING: f64 = 1.65;

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

    /// What share of its friction a tire uses at least that slips `least` to `most` times as far as its stiffness
    /// has it.
    pub fn least_share(&self, least: f64, most: f64) -> f64 {
        let rising = self.most.partition_point(|bend| *bend < least).min(STEPS) as f64 / STEPS as f64;
        rising.min(Self::fallen_share(most))
    }

    /// What is left of the friction beyond the peak.
    fn fallen_share(bend: f64) -> f64 {
        let share = |slip: f64| (FALLING * (slip / FALLING).atan()).sin();
        // Slip over share rises with the slip; its inverse by bisection between the peak and far beyond.
        let (mut low, mut high) = (2.5, 100.0);
        for _ in 0..20 {
            let middle = 0.5 * (low + high);
            *(if middle / share(middle) < bend { &mut low } else { &mut high }) = middle;
        }
        share(low)
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
            assert!((bend.least_share(most, most) - share).abs() < 0.011, "{share}");
            assert!(bend.least_share(least, most) <= share + 0.011);
        }
        assert_eq!(bend.least_share(1.0, 1.0), 0.0);
    }

    #[test]
    fn far_beyond_the_peak_less_is_left() {
        let (bend, falling) = (Bend::new(), MagicFormula { shape: FALLING, curvature: 0.0 });
        for slip in [4.0, 8.0, 20.0] {
            let force = falling.force(1.0, 1.0, slip);
            assert!((bend.least_share(slip / force, slip / force) - force).abs() < 1e-3, "{slip}");
        }
    }
}
