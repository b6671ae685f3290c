//! An axle's measurement update, and what its innovations show.

use super::another_road::likelihood;
use super::config::CorneringConfig;
use super::doubt::{Axle, Doubt};
use super::equation::Equation;
use super::sliding::{Excess, Sliding};
use super::state::{FRONT, STATES, State};
use super::window::Means;
use crate::estimate::belief::Belief;
use crate::estimate::learned::Trial;
use crate::filter::{Cusum, Innovation, LearnedNoise};
use crate::model::GRAVITY;

/// Tuned: sliding with the tests `campaign` and `long_drives`, changes with `real_cars`, noise with no test on
/// record.
struct Tuning {
    /// Windows that the learned noise remembers.
    noise_memory: f64,
    /// Learned noise this many times (variance) the promised one is no longer a sensor's.
    noise_limit: f64,
    /// With so much more friction than is in use an axle is at its limit.
    at_limit: f64,
    /// Below this probability of sliding nothing speaks for it.
    hardly_sliding: f64,
    /// Up to this relative uncertainty a stiffness is known well enough to notice its change.
    settled: f64,
    /// Normalized innovations count in the CUSUM up to this.
    alarm_clip: f64,
}

const TUNING: Tuning = Tuning {
    noise_memory: 100.0,
    noise_limit: 100.0,
    at_limit: 1.15,
    hardly_sliding: 0.1,
    settled: 0.15,
    alarm_clip: 4.0,
};

/// What is learned from an axle's innovations besides the state.
#[derive(Clone, Debug)]
pub struct AxleMonitor {
    noise: LearnedNoise,
    cusum: Cusum,
    sliding: Sliding,
}

/// What a measurement update showed.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Outcome {
    /// An innovation that the filter did not expect.
    pub surprise: Option<Doubt>,
    /// The stiffness jumped.
    pub surface_changed: bool,
    /// The equation's variance as it counted, and what it says for the state, ln; nothing while the axle slides.
    pub weight: Option<(f64, f64)>,
}

/// What an earlier drive learned is not true of this one.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct OtherCar;

impl AxleMonitor {
    /// An innovation with an NIS beyond this counts less than it would. Statistical: three deviations, one
    /// healthy window in 370.
    const OUTLIER_NIS: f64 = 9.0;
    /// Gate: a window surprises with an NIS beyond this. Statistical: four deviations, one
    /// healthy window in 16,000.
    const GATE_NIS: f64 = 16.0;
    /// Lateral acceleration from which a window tells something of the stiffness, m/s². Tuned, no test on record.
    pub const INFORMATIVE: f64 = 0.4;

    /// Nothing was measured yet.
    pub fn new(config: &CorneringConfig) -> Self {
        Self {
            noise: LearnedNoise::new(TUNING.noise_memory),
            cusum: Cusum::new(config.cusum_drift, config.cusum_threshold),
            sliding: Sliding::default(),
        }
    }

    /// The axle surely slides.
    pub fn is_sliding(&self) -> bool {
        self.sliding.is_sure()
    }

    /// The stiffness is open again: the CUSUM starts from zero.
    pub fn forget_evidence(&mut self) {
        self.cusum.reset();
    }

    /// Corrects the state by the axle's equation, unless the axle slides.
    ///
    /// # Errors
    /// While what an earlier drive learned is on trial: that the equation contradicts it. The state is as before.
    pub fn update(
        &mut self,
        equation: &Equation,
        now: &Means,
        state: &mut State,
        trial: &mut Option<Trial<STATES>>,
        belief: &Belief,
    ) -> Result<Outcome, OtherCar> {
        let Equation { axle, h, force, used, straight, residual, promised, .. } = *equation;
        let redundancy = self.noise.redundancy();
        let variance = self.noise.variance(promised) + equation.bend_variance;
        let expected = state.innovation(&h, residual, variance);
        match trial.as_mut().map(|trial| trial.step(&expected, variance)) {
            Some(Some(true)) => return Err(OtherCar),
            Some(None) => *trial = None,
            _ => {}
        }
        let sliding = self.sliding.weigh(&Excess {
            angle: -residual * force.signum(),
            variance: expected.variance,
            straight: straight.abs(),
            at_limit: belief.at_most(TUNING.at_limit * used),
        });
        if self.sliding.is_sure() {
            return Ok(Outcome::default());
        }
        let is_rolling = sliding < TUNING.hardly_sliding;
        if is_rolling {
            self.noise.learn(&expected, promised);
        }
        let settled = state.std(axle) < TUNING.settled * state.mean[axle];
        let counted = variance * redundancy / (1.0 - sliding);
        let weight = is_rolling.then(|| (counted, likelihood(&state.innovation(&h, residual, counted))));
        state.update(&h, residual, counted * Self::doubted(&expected));
        // Steered fast to and fro, sensors a few milliseconds apart disagree in ways that look like softness.
        let steady = now.acceleration.abs() > now.acceleration_spread;
        let surprise = (expected.nis() > Self::GATE_NIS).then(|| Doubt::Surprise {
            axle: if axle == FRONT { Axle::Front } else { Axle::Rear },
            deviations: expected.normalized() * force.signum(),
        });
        let tells_changes = is_rolling && steady && settled && force.abs() * GRAVITY >= Self::INFORMATIVE;
        let evidence = expected.normalized() * force.signum() / redundancy.sqrt();
        let surface_changed =
            tells_changes && self.cusum.step(evidence.clamp(-TUNING.alarm_clip, TUNING.alarm_clip)).is_some();
        Ok(Outcome { surprise, surface_changed, weight })
    }

    /// By how much the variance of an equation grows that was expected like this.
    pub fn doubted(expected: &Innovation) -> f64 {
        (expected.nis() / Self::OUTLIER_NIS).max(1.0)
    }

    /// Its innovations are larger than expected, or the noise that explains them is no sensor's.
    pub fn doubt(&self, axle: Axle, config: &CorneringConfig) -> Option<Doubt> {
        let (nis, scale) = (self.noise.nis(), self.noise.scale());
        let beyond = |number: f64, limit: f64| number >= limit || number.is_nan();
        if beyond(nis, config.inconsistent_nis) {
            Some(Doubt::TooSure { axle, nis })
        } else if beyond(scale, TUNING.noise_limit) {
            Some(Doubt::Noise { axle, times: scale.sqrt() })
        } else {
            None
        }
    }
}
