//! An axle's measurement update, and what its innovations show.

use super::config::CorneringConfig;
use super::doubt::{Axle, Doubt};
use super::equation::Equation;
use super::sliding::{Excess, Sliding};
use super::state::{FRONT, STATES, State};
use super::window::Means;
use crate::estimate::belief::Belief;
use crate::estimate::learned::Trial;
use crate::filter::{Cusum, LearnedNoise};
use crate::model::GRAVITY;

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
}

/// What an earlier drive learned is not true of this one.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct OtherCar;

impl AxleMonitor {
    /// Windows that the learned noise remembers.
    const NOISE_MEMORY: f64 = 100.0;
    /// Learned noise this many times (variance) the promised one is no longer a sensor's.
    const NOISE_LIMIT: f64 = 100.0;
    /// With so much more friction than is in use an axle is at its limit.
    const AT_LIMIT: f64 = 1.15;
    /// Below this probability of sliding nothing speaks for it.
    const HARDLY_SLIDING: f64 = 0.1;
    /// A residual of three standard deviations counts less than it would.
    const OUTLIER: f64 = 9.0;
    /// Up to this relative uncertainty a stiffness is known well enough to notice its change.
    const SETTLED: f64 = 0.15;
    /// A window surprises with a normalized innovation (squared) beyond this.
    const SURPRISING: f64 = 16.0;
    /// Normalized innovations count in the CUSUM up to this.
    const ALARM_CLIP: f64 = 4.0;
    /// Lateral acceleration from which a window tells something of the stiffness, m/s².
    pub const INFORMATIVE: f64 = 0.4;

    /// Nothing was measured yet.
    pub fn new(config: &CorneringConfig) -> Self {
        Self {
            noise: LearnedNoise::new(Self::NOISE_MEMORY),
            cusum: Cusum::new(config.cusum_drift, config.cusum_threshold),
            sliding: Sliding::default(),
        }
    }

    /// Variance of the axle's equation as it was learned, rad².
    pub fn variance(&self, equation: &Equation) -> f64 {
        self.noise.variance(equation.promised)
    }

    /// The axle surely slides.
    pub fn is_sliding(&self) -> bool {
        self.sliding.is_sure()
    }

    /// The stiffness is open again: a jump before says nothing of one to come.
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
            at_limit: belief.at_most(Self::AT_LIMIT * used),
        });
        if self.sliding.is_sure() {
            return Ok(Outcome::default());
        }
        let is_rolling = sliding < Self::HARDLY_SLIDING;
        if is_rolling {
            self.noise.learn(&expected, promised);
        }
        let settled = state.std(axle) < Self::SETTLED * state.mean[axle];
        let doubted = (expected.nis() / Self::OUTLIER).max(1.0) / (1.0 - sliding);
        state.update(&h, residual, variance * redundancy * doubted);
        // Steered fast to and fro, sensors a few milliseconds apart disagree in ways that look like softness.
        let steady = now.acceleration.abs() > now.acceleration_spread;
        let surprise = (expected.nis() > Self::SURPRISING).then(|| Doubt::Surprise {
            axle: if axle == FRONT { Axle::Front } else { Axle::Rear },
            deviations: expected.normalized() * force.signum(),
        });
        let tells_changes = is_rolling && steady && settled && force.abs() * GRAVITY >= Self::INFORMATIVE;
        let evidence = expected.normalized() * force.signum() / redundancy.sqrt();
        let surface_changed =
            tells_changes && self.cusum.step(evidence.clamp(-Self::ALARM_CLIP, Self::ALARM_CLIP)).is_some();
        Ok(Outcome { surprise, surface_changed })
    }

    /// Its innovations have not been about as large as believed, or the noise assumed for that is no sensor's.
    pub fn doubt(&self, axle: Axle, config: &CorneringConfig) -> Option<Doubt> {
        let (nis, scale) = (self.noise.nis(), self.noise.scale());
        let beyond = |number: f64, limit: f64| number >= limit || number.is_nan();
        if beyond(nis, config.inconsistent_nis) {
            Some(Doubt::TooSure { axle, nis })
        } else if beyond(scale, Self::NOISE_LIMIT) {
            Some(Doubt::Noise { axle, times: scale.sqrt() })
        } else {
            None
        }
    }
}
