//! Our own joint lateral filter, beside the thesis's. The one place to put another in its stead.

use crate::reproduce::SimulatedDrive;
use physics::estimate::{EstimatorsConfig, Pipeline};
use physics::estimates::Estimate;

/// What it knows at a sample.
#[derive(Clone, Copy, Debug)]
pub(super) struct Ours {
    /// Lateral velocity, m/s.
    pub(super) lateral_velocity: Option<f64>,
    /// Cornering stiffness front and rear, normalized, 1/rad.
    pub(super) stiffness: [Option<Estimate>; 2],
}

impl Ours {
    /// Of the whole car, 1/rad: the thesis's C_yN.
    pub(super) fn mean_stiffness(&self) -> Option<f64> {
        let [front, rear] = self.stiffness;
        Some(0.5 * (front?.value + rear?.value))
    }
}

/// The published filter on every sample of a drive.
pub(super) fn over(drive: &SimulatedDrive) -> Vec<Ours> {
    let mut pipeline = Pipeline::new(&drive.vehicle, &drive.sensors, &EstimatorsConfig::default());
    let mut step = |sample| {
        let estimates = pipeline.step(sample);
        Ours { lateral_velocity: estimates.motion.lateral_velocity, stiffness: estimates.cornering }
    };
    drive.samples.iter().map(&mut step).collect()
}
