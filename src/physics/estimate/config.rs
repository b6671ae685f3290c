//! The `[estimators]` table: every tuning number, with its unit, meaning and default.

use serde::{Deserialize, Serialize};

use super::cornering::CorneringConfig;
use super::learned::Known;
use super::mapping::MappingConfig;
use super::thesis::config::{JointEkfConfig, LateralVelocitySource};
use crate::estimates::{Estimate, TOLD_RELATIVE_STD};

/// `[estimators]`. Everything has a default that suits a passenger car with ESP-grade sensors.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct EstimatorsConfig {
    /// Below this speed slip and lateral motion are not estimated, m/s.
    pub minimum_speed_mps: f64,
    /// Longitudinal slip slope (thesis 5.2.1).
    pub slope: SlopeConfig,
    /// Our joint lateral filter: motion, cornering stiffnesses and sensor offsets.
    pub cornering: CorneringConfig,
    /// The joint EKF of thesis (5.21), kept for comparison.
    pub joint_ekf: JointEkfConfig,
    /// Brush regression (thesis 8.1).
    pub brush: BrushConfig,
    /// What is published as friction.
    pub friction: FrictionConfig,
    /// From the slip slope to friction (thesis ch. 6), as `gripd calibrate` found it; without it
    /// nothing is mapped.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub mapping: Option<MappingConfig>,
    /// Which lateral velocity the lateral slope regression (5.20) stands on.
    pub lateral_slope_source: LateralVelocitySource,
}

impl Default for EstimatorsConfig {
    fn default() -> Self {
        Self {
            // Physical: below, wheel speeds are too coarse and may have lost their sign.
            minimum_speed_mps: 4.0,
            slope: SlopeConfig::default(),
            cornering: CorneringConfig::default(),
            joint_ekf: JointEkfConfig::default(),
            brush: BrushConfig::default(),
            friction: FrictionConfig::default(),
            mapping: None,
            lateral_slope_source: LateralVelocitySource::Joint,
        }
    }
}

impl EstimatorsConfig {
    /// The first value that no estimator can work with: its key and what would be accepted.
    pub fn problem(&self) -> Option<(&'static str, &'static str)> {
        let positive = |value: f64| value.is_finite() && value > 0.0;
        let checks = [
            ("minimum_speed_mps", positive(self.minimum_speed_mps), "must be positive"),
            ("slope.block_s", (0.05..=2.0).contains(&self.slope.block_s), "must be 0.05 to 2 s"),
            ("slope.compliance_walk", positive(self.slope.compliance_walk), "must be positive"),
            ("slope.cusum_threshold", positive(self.slope.cusum_threshold), "must be positive"),
            ("slope.change_boost", positive(self.slope.change_boost), "must be positive"),
            ("slope.initial_offset_std", positive(self.slope.initial_offset_std), "must be positive"),
            ("cornering.stiffness_walk", positive(self.cornering.stiffness_walk), "must be positive"),
            ("cornering.inconsistent_nis", self.cornering.inconsistent_nis > 1.0, "must be above 1"),
            ("brush.initial_mu", positive(self.brush.initial_mu), "must be positive"),
            ("brush.walk", positive(self.brush.walk), "must be positive"),
            ("brush.friction_walk", positive(self.brush.friction_walk), "must be positive"),
            ("friction.surface_lasts_s", positive(self.friction.surface_lasts_s), "must be positive"),
        ];
        let mapping = || self.mapping.as_ref().and_then(MappingConfig::problem);
        checks.into_iter().find(|(_, good, _)| !good).map(|(key, _, reason)| (key, reason)).or_else(mapping)
    }
}

/// `[estimators.slope]`. Compliance is 1/slope: slip per unit of normalized force.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct SlopeConfig {
    /// Samples are averaged over this time before each update, s.
    pub block_s: f64,
    /// Random walk of the compliance, 1/√s.
    pub compliance_walk: f64,
    /// After so long without information, s, the surface may have changed unseen …
    pub unseen_after_s: f64,
    /// … and the compliance walks by this share of itself, 1/√s.
    pub unseen_walk: f64,
    /// Random walk of the slip offset (tire radii drift with temperature), 1/√s.
    pub offset_walk: f64,
    /// Standard deviation of the slip offset before anything is measured: tires of one car differ in
    /// radius by this much.
    pub initial_offset_std: f64,
    /// Slip that is none, while the speed hardly changes: tooth wheels locked to the sampling. No evidence of another
    /// surface.
    pub feigned_slip: f64,
    /// CUSUM: standard deviations forgiven at each block.
    pub cusum_drift: f64,
    /// CUSUM: standard deviations that must add up for a surface change.
    pub cusum_threshold: f64,
    /// On a change the compliance's process noise is multiplied by this for one block (thesis 5.2.1).
    pub change_boost: f64,
    /// Blocks with less normalized force than this say nothing of the slope.
    pub informative_mu: f64,
    /// Blocks with more than this can tell a change of surface: less is needed than for the slope itself.
    pub noticeable_mu: f64,
    /// Lateral acceleration above which a block is not used, m/s².
    pub max_lateral_acceleration_mps2: f64,
    /// Where the bus tells neither of brakes nor of drive torque: deceleration by the tires, m/s²,
    /// above which the brakes may be on. Engine drag and gentle braking look alike.
    pub max_coasting_deceleration_mps2: f64,
    /// Share of the radius and load effects of cornering that is not modelled: slip per m/s².
    pub cornering_slip_std: f64,
    /// A slope counts as valid up to this relative standard deviation.
    pub valid_relative_std: f64,
    /// … and up to this age, s.
    pub valid_age_s: f64,
}

impl Default for SlopeConfig {
    /// Tuned with the tests `accuracy` and `sim3`, `feigned_slip` and what is unseen with `long_drives`. Statistical
    /// are drift and threshold of the CUSUM: with innovations that are white and normal one false alarm in 10⁸
    /// blocks, a year of driving (Siegmund's formula, see [`Cusum`](crate::filter::Cusum)).
    fn default() -> Self {
        Self {
            block_s: 0.25,
            compliance_walk: 2e-5,
            unseen_after_s: 5.0,
            unseen_walk: 0.04,
            offset_walk: 2e-6,
            initial_offset_std: 0.02,
            feigned_slip: 4e-4,
            cusum_drift: 0.75,
            cusum_threshold: 12.0,
            change_boost: 1e6,
            informative_mu: 0.03,
            noticeable_mu: 0.012,
            max_lateral_acceleration_mps2: 3.0,
            max_coasting_deceleration_mps2: 0.0,
            cornering_slip_std: 1e-4,
            valid_relative_std: TOLD_RELATIVE_STD,
            valid_age_s: 30.0,
        }
    }
}

/// What holds for a slope by whatever means it was found.
impl SlopeConfig {
    /// A compliance is at first uncertain by this share of itself at least, however sure the data sheet or an
    /// earlier drive: the surface is the road's. Tuned with the test `learned`.
    pub(super) const SURFACE_STD: f64 = 0.3;
    /// A slope this uncertain (relative) is not given out at all. Tuned, no test on record.
    pub(super) const UNKNOWN_STD: f64 = 0.5;

    /// How uncertain, relative, what an earlier drive knew is now: half of what makes it valid has to be news.
    pub(super) fn earlier_std(&self, slope: Known) -> f64 {
        let news = std::f64::consts::SQRT_2 * self.valid_relative_std;
        Self::SURFACE_STD.max(news).max(slope.std / slope.value)
    }

    /// Sure enough to be worth keeping, and, as long as it is fresh, to be acted upon.
    pub(super) fn is_known_well(&self, slope: &Estimate) -> bool {
        slope.std <= self.valid_relative_std * slope.value
    }

    /// Known well, and lately.
    pub(super) fn is_valid(&self, slope: &Estimate) -> bool {
        self.is_known_well(slope) && slope.age_s <= self.valid_age_s
    }
}

/// `[estimators.brush]`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct BrushConfig {
    /// Friction assumed before anything is measured, and its standard deviation.
    pub initial_mu: f64,
    /// Relative random walk of the regression's parameters, 1/√s.
    pub walk: f64,
    /// With compensation: relative random walk of the friction, 1/√s. A surface may change without its
    /// slope telling, so that what low slip says nothing of is known for some tens of seconds.
    pub friction_walk: f64,
    /// Friction stays where it is while only low slip is seen, though the slope changes (thesis 8.1.1).
    /// Without it a softer surface counts as a more slippery one.
    pub compensate: bool,
    /// Adjust to ABS brakings (8.4) and to forces above the estimated friction (8.5).
    pub calibrate: bool,
}

impl Default for BrushConfig {
    /// Tuned: `friction_walk` with the test `campaign`, the rest with no test on record.
    fn default() -> Self {
        Self { initial_mu: 0.9, walk: 0.01, friction_walk: 0.03, compensate: true, calibrate: true }
    }
}

/// `[estimators.friction]`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct FrictionConfig {
    /// How long a surface lasts on average, s: the less, the faster what was measured or used ages.
    pub surface_lasts_s: f64,
    /// Use of friction (used / estimated) from which the brush curvature is published.
    pub brush_from_use: f64,
    /// Use of friction from which the published value counts as valid.
    pub valid_from_use: f64,
    /// Half-width of the interval up to which the published value counts as valid.
    pub valid_half_width: f64,
    /// How long a measurement (ABS braking, spinning wheels) stays valid at most, s, …
    pub abs_valid_s: f64,
    /// … and how long it is still published at most, with an interval that opens, s.
    pub abs_memory_s: f64,
}

impl Default for FrictionConfig {
    /// Tuned with the test `campaign`: what is valid may be wrong in so few drives.
    fn default() -> Self {
        Self {
            surface_lasts_s: 10.0,
            brush_from_use: 0.7,
            valid_from_use: 0.85,
            valid_half_width: 0.1,
            abs_valid_s: 5.0,
            abs_memory_s: 20.0,
        }
    }
}
