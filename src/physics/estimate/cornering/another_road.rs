//! Is the car on another road by now?
//!
//! Another road begins without a sign where a car drives straight, and in gentle curves it shows late. So what the filter
//! has learned of the tires goes on beside another hypothesis: the stiffnesses have walked since. Both get the same
//! equations; how well they explain them weighs one against the other. Curves that agree with what was known keep it;
//! where nothing tells, the other hypothesis gains, and what is given out, the mean of both, becomes less sure.

use super::axle::AxleMonitor;
use super::equation::Equation;
use super::model::Walk;
use super::state::State;
use crate::filter::Innovation;

/// Tuned with the tests `campaign` (the drives 7001 to 7210 of `drives`), `faults` (the clip: a yaw rate that steps),
/// `accuracy`, and `long_drives` (together: a steering angle that drifts).
struct Tuning {
    /// Where nothing tells, either hypothesis becomes the other within this time, s.
    lasts_s: f64,
    /// How the stiffnesses walk. A road changes both axles' alike, a sensor that fails does not.
    walk: Walk,
    /// As likely as this the other road is the one.
    sure: f64,
    /// … and then as likely as this it goes on changing.
    again: f64,
    /// One window counts as evidence up to this, ln.
    clip: f64,
}

const TUNING: Tuning =
    Tuning { lasts_s: 15.0, walk: Walk { relative: 0.1, together: 0.95 }, sure: 0.95, again: 0.1, clip: 1.5 };

/// The other hypothesis.
#[derive(Clone, Debug)]
pub struct AnotherRoad {
    /// What it says of all that the filter knows.
    pub state: State,
    probability: f64,
}

impl AnotherRoad {
    /// How its stiffnesses walk.
    pub const WALK: Walk = TUNING.walk;

    /// Nothing has changed.
    pub fn unlikely(state: &State) -> Self {
        Self { state: *state, probability: 0.0 }
    }

    /// Some time passes.
    pub fn wait(&mut self, elapsed_s: f64) {
        self.probability += (0.5 - self.probability) * (1.0 - (-2.0 * elapsed_s / TUNING.lasts_s).exp());
    }

    /// Takes an axle's equation, by this state; what it says for it, ln.
    pub fn update(&mut self, equation: &Equation, variance: f64) -> f64 {
        let Equation { h, residual, .. } = equation;
        let expected = self.state.innovation(h, *residual, variance);
        self.state.update(h, *residual, variance * AxleMonitor::doubted(&expected));
        likelihood(&expected)
    }

    /// Weighs both by what a window's equations said for this one more than for the other; whether this is the one now.
    pub fn weigh(&mut self, more: f64) -> bool {
        let odds = more.clamp(-TUNING.clip, TUNING.clip).exp();
        self.probability = odds * self.probability / (1.0 + (odds - 1.0) * self.probability);
        let is_sure = self.probability > TUNING.sure;
        if is_sure {
            self.probability = TUNING.again;
        }
        is_sure
    }

    /// A component of the state by both hypotheses, with its standard deviation.
    pub fn beside(&self, same: &State, i: usize) -> (f64, f64) {
        let weighted = [(1.0 - self.probability, same), (self.probability, &self.state)];
        let mean = weighted.iter().map(|(weight, state)| weight * state.mean[i]).sum::<f64>();
        let spread = |state: &State| state.covariance[(i, i)] + (state.mean[i] - mean).powi(2);
        (mean, weighted.iter().map(|(weight, state)| weight * spread(state)).sum::<f64>().sqrt())
    }
}

/// How well an innovation was expected: ln of the likelihood, without constants.
pub fn likelihood(expected: &Innovation) -> f64 {
    -0.5 * (expected.nis() + expected.variance.ln())
}

#[cfg(test)]
mod tests {
    use super::super::state::{FRONT, STATES};
    use super::*;

    fn known(compliance: f64) -> State {
        State::new([compliance; STATES], [0.002; STATES])
    }

    #[test]
    fn where_nothing_tells_both_hypotheses_become_as_likely() {
        let same = known(0.05);
        let mut another = AnotherRoad::unlikely(&same);
        another.state = known(0.09);
        assert_eq!(another.beside(&same, FRONT), (0.05, 0.002));
        (0..60).for_each(|_| another.wait(1.0));
        let (mean, std) = another.beside(&same, FRONT);
        assert!((mean - 0.07).abs() < 1e-4 && (std - 0.02_f64.hypot(0.002)).abs() < 1e-4, "{mean}, {std}");
    }

    #[test]
    fn evidence_moves_the_mean_and_enough_of_it_decides() {
        let same = known(0.05);
        let mut another = AnotherRoad::unlikely(&same);
        another.state = known(0.09);
        another.wait(TUNING.lasts_s);
        let (before, _) = another.beside(&same, FRONT);
        assert!(!another.weigh(-1.0));
        assert!(another.beside(&same, FRONT).0 < before);
        // One window, whatever it says, does not decide.
        assert!(!another.weigh(100.0));
        let windows = 1 + (0..10).take_while(|_| !another.weigh(1.0)).count();
        assert!((2..8).contains(&windows), "{windows}");
    }
}
