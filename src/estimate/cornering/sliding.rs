//! Is an axle sliding?
//!
//! A slip angle larger than the force accounts for has two explanations: the filter errs, or the axle is near its
//! limit, where any slip angle goes with the same force. Under the first the excess is normally distributed about
//! zero, under the second it may be anything above. Both are weighed by Bayes's rule; sliding goes on for a while,
//! and begins only where as much friction is in use as was ever known to be there.
//!
//! While an axle slides, its equation says nothing of motion and stiffness. But it tells the friction: more than is
//! in use by a little only.

use super::bend::Bend;

/// Friction between two bounds, by an axle that slides sideways.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LateralLimit {
    /// In use.
    pub low: f64,
    /// More than this the slip angle would have fetched from the road.
    pub high: f64,
}

/// One axle's slip angle against what its force accounts for.
#[derive(Clone, Copy, Debug)]
pub struct Excess {
    /// Slip angle less that by the force, rad, positive where it is too large.
    pub angle: f64,
    /// Its variance, rad².
    pub variance: f64,
    /// The slip angle by the stiffness alone, rad.
    pub straight: f64,
    /// The force in use over the friction known to be there.
    pub of_known: f64,
}

/// How likely an axle slides.
#[derive(Clone, Copy, Debug, Default)]
pub struct Sliding {
    probability: f64,
}

impl Sliding {
    /// From one window to the next it begins, or goes on, with these probabilities.
    const BEGINS: f64 = 0.05;
    const GOES_ON: f64 = 0.7;
    /// It can begin from this share of the friction known, surely from the second on.
    const FROM_SHARE: (f64, f64) = (0.6, 0.8);
    /// Sliding means that the slip angle is larger than straight by this share of it at least …
    const LEAST: f64 = 0.4;
    /// … and by no more than this, rad.
    const LARGEST: f64 = 0.3;
    /// As likely as this, it is taken for true.
    const SURE: f64 = 0.9;

    /// Weighs both explanations; the probability of sliding.
    pub fn weigh(&mut self, excess: &Excess) -> f64 {
        let std = excess.variance.sqrt();
        let (from, to) = Self::FROM_SHARE;
        let goes = if self.probability > 0.5 { Self::GOES_ON } else { Self::BEGINS };
        let prior = goes * ((excess.of_known - from) / (to - from)).clamp(0.0, 1.0);
        let normalized = excess.angle / std;
        let erring = (-0.5 * normalized * normalized).exp() * 0.4 / std;
        let beyond = (excess.angle - Self::LEAST * excess.straight) / std;
        let sliding = (0.5 + 0.4 * beyond).clamp(0.0, 1.0) / Self::LARGEST;
        let both = prior * sliding + (1.0 - prior) * erring;
        self.probability = if both > 0.0 { prior * sliding / both } else { prior };
        self.probability
    }

    /// Is it sure enough?
    pub fn is_sure(&self) -> bool {
        self.probability > Self::SURE
    }
}

/// What the friction is by an axle that slides with this force in use, from `least` to `most` times as far as its
/// stiffness has it.
pub fn limit(used: f64, (least, most): (f64, f64), tires: &Bend) -> Option<LateralLimit> {
    /// With less bend the bound would be too far off to be of use.
    const LEAST_BEND: f64 = 1.4;
    (least > LEAST_BEND).then(|| LateralLimit { low: used, high: used / tires.least_share(least, most) })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn excess(angle: f64, of_known: f64) -> Excess {
        Excess { angle, variance: 0.003_f64.powi(2), straight: 0.03, of_known }
    }

    #[test]
    fn an_axle_slides_only_where_all_that_is_known_is_in_use() {
        let mut sliding = Sliding::default();
        for _ in 0..10 {
            assert!(sliding.weigh(&excess(0.05, 0.5)) < 1e-9);
        }
        assert!(sliding.weigh(&excess(0.05, 1.0)) > 0.99 && sliding.is_sure());
        // It ends as soon as the force accounts for the slip angle.
        assert!(sliding.weigh(&excess(0.0, 1.0)) < 0.1);
        // The filter errs to either side, sliding is to one.
        assert!(sliding.weigh(&excess(-0.05, 1.0)) < 0.01);
    }

    #[test]
    fn what_is_used_at_twice_the_slip_is_nearly_all_there_is() {
        let tires = Bend::new();
        let found = limit(0.3, (2.0, 3.0), &tires).unwrap();
        assert!(found.low == 0.3 && (0.3..0.33).contains(&found.high), "{found:?}");
        assert_eq!(limit(0.3, (1.2, 3.0), &tires), None);
    }
}
