//! Is an axle sliding?
//!
//! A slip angle larger than the force accounts for has two explanations: the filter is off, or the axle is near its
//! limit, where any slip angle goes with the same force. In the first case the excess scatters about zero, sometimes
//! wider than the filter believes (a banked curve begins); in the second it may have any positive size. Bayes's rule
//! weighs both; the belief over the friction gives the prior of sliding.
//!
//! While an axle slides, its equation says nothing of motion and stiffness.

/// Tuned with the tests `campaign` and `long_drives`.
struct Tuning {
    /// However narrow the belief is, an axle may have stopped to slide.
    likeliest: f64,
    /// Share of the filter's errors that are larger than it believes, and how much larger.
    wrong: (f64, f64),
    /// Sliding means that the slip angle is larger than straight by this share of it at least …
    least: f64,
    /// … and by no more than this, rad.
    largest: f64,
}

const TUNING: Tuning = Tuning { likeliest: 0.9, wrong: (0.05, 5.0), least: 0.4, largest: 0.3 };

/// As likely as this, sliding is taken for true. Statistical: one in ten is taken wrongly, if the belief over the
/// friction is right.
pub const SURE: f64 = 0.9;

/// One axle's slip angle against what its force accounts for.
#[derive(Clone, Copy, Debug)]
pub struct Excess {
    /// Slip angle less that by the force, rad, positive where it is too large.
    pub angle: f64,
    /// Its variance, rad².
    pub variance: f64,
    /// The slip angle by the stiffness alone, rad.
    pub straight: f64,
    /// How likely the friction is hardly more than what is in use.
    pub at_limit: f64,
}

/// How likely an axle slides.
#[derive(Clone, Copy, Debug, Default)]
pub struct Sliding {
    probability: f64,
}

impl Excess {
    /// Weighs both explanations: the probability that it is the tire, not the filter.
    pub fn sliding(&self) -> f64 {
        let std = self.variance.sqrt();
        let prior = self.at_limit.min(TUNING.likeliest);
        // Both distributions in round numbers: 0.4 is 1/√2π, the density of a normal one and the slope of its sum.
        let normal = |std: f64| (-0.5 * (self.angle / std).powi(2)).exp() * 0.4 / std;
        let (share, wider) = TUNING.wrong;
        let erring = (1.0 - share) * normal(std) + share * normal(wider * std);
        let beyond = (self.angle - TUNING.least * self.straight) / std;
        let sliding = (0.5 + 0.4 * beyond).clamp(0.0, 1.0) / TUNING.largest;
        let both = prior * sliding + (1.0 - prior) * erring;
        if both > 0.0 { prior * sliding / both } else { prior }
    }
}

impl Sliding {
    /// Takes what a window says; the probability of sliding.
    pub fn weigh(&mut self, excess: &Excess) -> f64 {
        self.probability = excess.sliding();
        self.probability
    }

    /// Is it sure enough?
    pub fn is_sure(&self) -> bool {
        self.probability > SURE
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn excess(angle: f64, at_limit: f64) -> Excess {
        Excess { angle, variance: 0.003_f64.powi(2), straight: 0.03, at_limit }
    }

    #[test]
    fn an_axle_slides_only_where_the_friction_may_be_used_up() {
        let mut sliding = Sliding::default();
        assert!(sliding.weigh(&excess(0.05, 1e-9)) < 1e-3);
        assert!(sliding.weigh(&excess(0.05, 0.5)) > 0.99 && sliding.is_sure());
        // It ends as soon as the force accounts for the slip angle.
        assert!(sliding.weigh(&excess(0.0, 0.9)) < 0.2);
        // The filter errs to either side, sliding is to one.
        assert!(sliding.weigh(&excess(-0.05, 0.5)) < 0.01);
    }
}
