//! What a drive must not lead to, counted sample by sample.

use gripd::Estimates;
use gripd::estimates::{Estimate, MuSource};
use gripd::model::{Reading, Scenario, Truth};

use super::roads;
use testing::driven;

/// Cornering stiffness or friction that calls itself valid and is off by more, relative and absolute, is wrong.
const STIFFNESS_OFF: f64 = 0.25;
const FRICTION_OFF: f64 = 0.1;

/// A sensor's offset as it was learned, against the true one.
#[derive(Clone, Copy, Debug, Default)]
pub struct Offset {
    truth: f64,
    /// The first estimate looked at, and the last one.
    pub ends: Option<[f64; 2]>,
    /// The standard deviation of the first one.
    pub first_std: f64,
    /// The most that an estimate was off, in its standard deviations.
    pub most_stds_off: f64,
}

impl Offset {
    fn see(&mut self, estimate: Option<Estimate>) {
        let Some(estimate) = estimate else { return };
        if self.ends.is_none() {
            self.first_std = estimate.std;
        }
        let first = self.ends.map_or(estimate.value, |[first, _]| first);
        self.ends = Some([first, estimate.value]);
        let off = (estimate.value - self.truth).abs() / estimate.std;
        self.most_stds_off = self.most_stds_off.max(off);
    }

    /// From the first estimate to the last, in standard deviations of the first one.
    pub fn walked(&self) -> f64 {
        let [first, last] = self.ends.unwrap();
        (last - first).abs() / self.first_std
    }
}

/// Samples and extremes of a drive, from some time on.
#[derive(Clone, Debug, Default)]
pub struct Watch {
    pub samples: u64,
    pub not_finite: u64,
    pub slope_valid: u64,
    pub slope_valid_and_wrong: u64,
    pub cornering_valid: u64,
    pub cornering_valid_and_wrong: u64,
    pub motion_valid: u64,
    pub friction_valid: u64,
    pub friction_valid_and_wrong: u64,
    /// Samples whose friction is more than a bound from below.
    pub friction_measured: u64,
    /// By how much an interval of friction excluded the truth.
    pub most_excluded: f64,
    pub surface_changes: u32,
    /// m/s.
    pub highest_speed: f64,
    /// Samples with a sideslip; the largest; and how far it was off, degrees.
    pub with_sideslip: u64,
    pub largest_sideslip: f64,
    pub sideslip_most_off: f64,
    /// How far it was off while valid, where its standard deviation promises 0.6, degrees.
    pub valid_sideslip_most_off: f64,
    /// Of road wheel angle, lateral acceleration and yaw rate.
    pub offsets: [Offset; 3],
    /// Surface changes before.
    pub changes_before: Option<u32>,
}

/// As a car sends it: the wheel speeds of most, the demo's too, have no sign.
fn without_sign(reading: &Reading) -> Reading {
    let is_wheel = reading.quantity.wheel().is_some();
    Reading { value: if is_wheel { reading.value.abs() } else { reading.value }, ..*reading }
}

/// Drives, and watches between two times, s.
pub fn watch(scenario: &Scenario, from_s: f64, to_s: f64) -> Watch {
    let config = roads::config();
    let offset = |name: &str| scenario.sensors.by_name[name].offset;
    let road_angle = offset("steering_wheel_angle") / config.vehicle.steering_ratio.value;
    let truths = [road_angle, offset("lateral_acceleration"), offset("yaw_rate")];
    let offsets = truths.map(|truth| Offset { truth, ..Offset::default() });
    let mut watch = Watch { offsets, ..Watch::default() };
    driven::drive(scenario, scenario.seed, config, &[], without_sign, |_, truth, estimates| {
        if (from_s..to_s).contains(&truth.time.seconds()) {
            watch.see(truth, estimates);
        }
    });
    println!("{watch:#?}");
    watch
}

impl Watch {
    fn see(&mut self, truth: &Truth, estimates: &Estimates) {
        self.samples += 1;
        self.not_finite += u64::from(!is_finite(estimates));
        let before = *self.changes_before.get_or_insert(estimates.surface_changes);
        self.surface_changes = estimates.surface_changes - before;

        self.slope_valid += u64::from(estimates.slope_valid);
        let slopes = estimates.slope.iter().zip(truth.slope);
        let is_off = slopes.flat_map(|(slope, truth)| slope.map(|slope| (slope.value / truth - 1.0).abs()));
        let is_wrong = is_off.fold(0.0, f64::max) > STIFFNESS_OFF;
        self.slope_valid_and_wrong += u64::from(estimates.slope_valid && is_wrong);

        self.cornering_valid += u64::from(estimates.cornering_valid);
        let axles = estimates.cornering.iter().zip([truth.cornering_front, truth.cornering_rear]);
        let is_off = axles.flat_map(|(axle, truth)| axle.map(|axle| (axle.value / truth - 1.0).abs()));
        let is_wrong = is_off.fold(0.0, f64::max) > STIFFNESS_OFF;
        self.cornering_valid_and_wrong += u64::from(estimates.cornering_valid && is_wrong);

        let friction = &estimates.friction;
        self.friction_valid += u64::from(friction.valid);
        let is_wrong = friction.max.is_none_or(|max| (max - truth.mu_max).abs() > FRICTION_OFF);
        self.friction_valid_and_wrong += u64::from(friction.valid && is_wrong);
        let is_bound = matches!(friction.source, MuSource::None | MuSource::LowerBound);
        self.friction_measured += u64::from(!is_bound);
        let below = friction.low.map_or(0.0, |low| low - truth.mu_max);
        let above = friction.high.map_or(0.0, |high| truth.mu_max - high);
        self.most_excluded = self.most_excluded.max(below).max(above);

        let motion = &estimates.motion;
        self.motion_valid += u64::from(motion.valid);
        self.highest_speed = self.highest_speed.max(motion.speed.unwrap_or(0.0));
        if let Some(sideslip) = motion.sideslip {
            self.with_sideslip += 1;
            self.largest_sideslip = self.largest_sideslip.max(sideslip.abs().to_degrees());
            let off = (sideslip - truth.sideslip).abs().to_degrees();
            self.sideslip_most_off = self.sideslip_most_off.max(off);
            if motion.valid {
                self.valid_sideslip_most_off = self.valid_sideslip_most_off.max(off);
            }
        }
        let offsets = &estimates.offsets;
        let learned = [offsets.road_angle, offsets.lateral_acceleration, offsets.yaw_rate];
        for (offset, estimate) in self.offsets.iter_mut().zip(learned) {
            offset.see(estimate);
        }
    }

    /// Holds for every drive there is.
    pub fn is_sane(&self, samples: u64) {
        assert!(self.samples > samples, "{self:#?}");
        assert_eq!(self.not_finite, 0, "{self:#?}");
    }
}

/// Every number that is given out is one.
fn is_finite(estimates: &Estimates) -> bool {
    let numbers = |estimate: &Option<Estimate>| estimate.map(|e| [e.value, e.std, e.age_s]);
    let of = [
        estimates.slope.as_slice(),
        &estimates.slip_offset,
        &estimates.cornering,
        &estimates.thesis.cornering_regression,
        &[estimates.thesis.cornering_ekf],
        &[estimates.offsets.road_angle, estimates.offsets.lateral_acceleration, estimates.offsets.yaw_rate],
    ];
    let (motion, ways, friction) =
        (&estimates.motion, &estimates.thesis.lateral_velocities, &estimates.friction);
    let plain = [
        motion.speed,
        motion.lateral_velocity,
        motion.sideslip,
        motion.slip_angle_front,
        motion.slip_angle_rear,
        ways.zero,
        ways.integration,
        ways.kinematic,
        ways.bicycle,
        ways.joint,
        friction.max,
        friction.low,
        friction.high,
        friction.used,
        friction.age_s,
        friction.brush,
        friction.brush_std,
        estimates.thesis.friction_dahl,
        friction.abs,
        friction.map,
        Some(estimates.excitation_long),
        Some(estimates.excitation_lat),
    ];
    of.into_iter().flatten().filter_map(numbers).flatten().all(f64::is_finite)
        && plain.into_iter().flatten().all(f64::is_finite)
}
