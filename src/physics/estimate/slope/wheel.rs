//! One wheel's slip curve near its origin: slip = μ/k + δ₀.

use nalgebra::vector;

use crate::estimate::config::SlopeConfig;
use crate::estimate::learned::{Known, Trial};
use crate::estimate::traction::TractionPoint;
use crate::estimates::Estimate;
use crate::filter::{Gaussian, LearnedNoise};

/// Tuned with the tests `accuracy`, `sim3` (changes, force beyond the known), `learned` (between drives) and
/// `long_drives` (dwelling).
struct Tuning {
    /// Blocks that the learned noise remembers.
    noise_memory: f64,
    /// Normalized innovations count up to this, so that one bad block is no change of surface.
    clip: f64,
    /// Surfaces change the compliance by as much as this share of itself: down and up.
    changes: (f64, f64),
    /// Up to this relative uncertainty a slope is known well enough to notice its change.
    settled: f64,
    /// More force than this many times what the curve is known for may be off the line because the curve bends
    /// there: no evidence of another surface.
    beyond: f64,
    /// Between two drives the offset moves by this share of what tires may differ by at all: temperature, pressure,
    /// passengers.
    between_drives: f64,
    /// An offset is worth keeping when it is surer than this share of what it was before anything was measured.
    worth_keeping: f64,
    /// Blocks for which an earlier drive's numbers are on trial.
    trial: u32,
    /// Blocks that are looked at for whether a wheel dwells at its speed, …
    dwells: usize,
    /// … within so much, m/s.
    locked: f64,
    /// How fast a curve becomes known further up, and how slowly that is forgotten, s.
    known_s: (f64, f64),
}

const TUNING: Tuning = Tuning {
    noise_memory: 120.0,
    clip: 4.0,
    changes: (0.6, 1.5),
    settled: 0.08,
    beyond: 1.4,
    between_drives: 0.03,
    worth_keeping: 0.5,
    trial: 40,
    dwells: 4,
    locked: 0.2,
    known_s: (4.0, 120.0),
};

/// The filter of a driven wheel.
#[derive(Clone, Debug)]
pub(super) struct WheelSlope {
    /// Compliance 1/k and slip offset δ₀.
    pub(super) filter: Gaussian<2>,
    /// Noise of the slip.
    noise: LearnedNoise,
    /// Seconds since a block told something of the slope.
    age_s: f64,
    /// Did any block tell?
    informed: bool,
    /// Up to this normalized force the slip curve is known.
    known_up_to: f64,
    /// The slope when it was last known well. The surface may have changed since, unseen.
    pub(super) settled: Option<Known>,
    /// What was taken up from an earlier drive is on trial.
    trial: Option<Trial<2>>,
    /// Rolling speeds of the last blocks, m/s.
    speeds: [f64; TUNING.dwells],
}

impl WheelSlope {
    pub(super) fn new((slope, slope_std): (f64, f64), config: &SlopeConfig) -> Self {
        let compliance_std = (slope_std / (slope * slope)).max(SlopeConfig::SURFACE_STD / slope);
        Self {
            filter: Gaussian::new([1.0 / slope, 0.0], [compliance_std, config.initial_offset_std]),
            noise: LearnedNoise::new(TUNING.noise_memory),
            age_s: 0.0,
            informed: false,
            known_up_to: 0.0,
            settled: None,
            trial: None,
            speeds: [f64::NAN; TUNING.dwells],
        }
    }

    /// Takes up an earlier drive's numbers, where they are surer than the start. What it learned of the
    /// slope counts as `settled` still: a drive that tells nothing loses nothing.
    pub(super) fn restore(&mut self, slope: Option<Known>, offset: Option<Known>, config: &SlopeConfig) {
        let trial = Trial::new(self.filter, TUNING.trial);
        let [mut mean, mut std] = [self.filter.mean.into(), [self.filter.std(0), self.filter.std(1)]];
        if let Some(offset) = offset {
            let drift = TUNING.between_drives * config.initial_offset_std;
            let widened = offset.std.hypot(drift);
            if widened < std[1] {
                (mean[1], std[1]) = (offset.value, widened);
            }
        }
        if let Some(slope) = slope {
            let compliance = (1.0 + mean[1]) / slope.value;
            (mean[0], std[0]) = (compliance, compliance * config.earlier_std(slope));
            self.settled = Some(slope);
        }
        self.filter = Gaussian::new(mean, std);
        self.trial = Some(trial);
    }

    /// The offset, if enough is known of it to be worth keeping.
    pub(super) fn learned_offset(&self, config: &SlopeConfig) -> Option<Known> {
        let std = self.filter.alone_std(1, &[0, 1]);
        (std < TUNING.worth_keeping * config.initial_offset_std)
            .then(|| Known { value: self.filter.mean[1], std })
    }

    /// Fresh readings contradict an earlier drive's numbers: other tires, perhaps. As if there were none.
    fn start_afresh(&mut self, fresh: Gaussian<2>) {
        *self = Self {
            filter: fresh,
            noise: LearnedNoise::new(TUNING.noise_memory),
            age_s: self.age_s,
            informed: false,
            known_up_to: 0.0,
            settled: None,
            trial: None,
            speeds: self.speeds,
        };
    }

    /// After some seconds without information the surface may have become another one, unseen.
    pub(super) fn age(&mut self, elapsed_s: f64, config: &SlopeConfig) {
        self.age_s += elapsed_s;
        if self.age_s > config.unseen_after_s && elapsed_s.is_finite() {
            let walk = config.unseen_walk * self.filter.mean[0];
            let limit = (SlopeConfig::UNKNOWN_STD * self.filter.mean[0]).powi(2);
            if self.filter.covariance[(0, 0)] < limit {
                self.filter.inflate(0, (walk * walk * elapsed_s).min(limit));
            }
        }
    }

    /// Returns the evidence of a softer (positive) or stiffer surface, in standard deviations, if the
    /// block says anything of it.
    pub(super) fn step(
        &mut self,
        point: &TractionPoint,
        duration_s: f64,
        config: &SlopeConfig,
    ) -> Option<f64> {
        self.filter.inflate(0, config.compliance_walk * config.compliance_walk * duration_s);
        self.filter.inflate(1, config.offset_walk * config.offset_walk * duration_s);
        let regressor = vector![point.mu, 1.0];
        let residual = point.slip - regressor.dot(&self.filter.mean);
        // Noise of μ seen through the compliance counts as noise of the slip.
        let mu_part = self.filter.mean[0] * point.mu_std;
        let promised = point.slip_std * point.slip_std + mu_part * mu_part;
        let noise = self.noise.variance(promised);
        let expected = self.filter.innovation(&regressor, residual, noise);
        if let Some(trial) = &mut self.trial {
            match trial.step(&expected, noise) {
                Some(false) => {}
                Some(true) => {
                    let fresh = trial.fresh;
                    self.start_afresh(fresh);
                    return None;
                }
                None => self.trial = None,
            }
        }
        self.noise.learn(&expected, promised);
        // An outlier's residual is limited rather than dropped: at a change of surface all are.
        let normalized = expected.normalized();
        let limited = normalized.clamp(-TUNING.clip, TUNING.clip) * expected.variance.sqrt();
        self.filter.update(&regressor, limited, noise * self.noise.redundancy());
        if point.mu.abs() >= config.informative_mu {
            self.age_s = 0.0;
            self.informed = true;
            self.settle(config);
        }
        let beyond = point.mu.abs() > TUNING.beyond * self.known_up_to;
        self.explore(point.mu.abs(), duration_s);
        // A softer surface makes more slip in the direction of the force.
        let feigned = if self.dwells(point.rolling) { config.feigned_slip } else { 0.0 };
        let deviation = expected.variance.sqrt().hypot(feigned);
        let evidence = expected.residual / deviation * point.mu.signum();
        // What no change of surface could explain is no evidence of one.
        let explicable = self.filter.mean[0].abs() * point.mu.abs() / deviation;
        let (stiffer, softer) = TUNING.changes;
        (self.is_settled() && !beyond && point.mu.abs() > config.noticeable_mu).then(|| {
            evidence.clamp(-TUNING.clip, TUNING.clip).clamp(-stiffer * explicable, softer * explicable)
        })
    }

    /// Does the wheel dwell at one speed? Its teeth may be locked to the sampling then, and feign a slip that lasts.
    fn dwells(&mut self, speed: f64) -> bool {
        self.speeds.rotate_left(1);
        self.speeds[TUNING.dwells - 1] = speed;
        let changed = self.speeds.iter().map(|before| (speed - before).abs()).fold(0.0, f64::max);
        changed < TUNING.locked
    }

    fn explore(&mut self, mu: f64, duration_s: f64) {
        let (rise, fall) = TUNING.known_s;
        let time = if mu > self.known_up_to { rise } else { fall };
        self.known_up_to += (mu - self.known_up_to) * (duration_s / time).min(1.0);
    }

    /// Is the slope known well enough that a contradiction is news?
    fn is_settled(&self) -> bool {
        self.filter.std(0) < TUNING.settled * self.filter.mean[0]
    }

    /// Remembers a slope that is known well.
    fn settle(&mut self, config: &SlopeConfig) {
        let Some(slope) = self.slope() else { return };
        if config.is_known_well(&slope) {
            let relative = self.filter.alone_std(0, &[0, 1]) / self.filter.mean[0];
            self.settled = Some(Known { value: slope.value, std: relative * slope.value });
        }
    }

    pub(super) fn boost(&mut self, config: &SlopeConfig) {
        let walk = config.compliance_walk * config.compliance_walk * config.block_s;
        self.filter.inflate(0, walk * config.change_boost);
    }

    pub(super) fn slope(&self) -> Option<Estimate> {
        let compliance = self.filter.mean[0];
        let relative = self.filter.std(0) / compliance;
        // Slip is measured against a reference that the offset scales, too.
        let scale = 1.0 + self.filter.mean[1];
        (self.informed && compliance > 0.0 && relative < SlopeConfig::UNKNOWN_STD).then(|| Estimate {
            value: scale / compliance,
            std: scale * relative / compliance,
            age_s: self.age_s,
        })
    }

    pub(super) fn offset(&self) -> Option<Estimate> {
        self.informed.then(|| Estimate {
            value: self.filter.mean[1],
            std: self.filter.std(1),
            age_s: self.age_s,
        })
    }
}
