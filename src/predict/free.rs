//! A free simulation: from the measured state at the start of each block, then by the inputs alone.

use super::car::ExtendedCar;
use super::drive::GriddedDrive;
use super::grid::points;
use super::noise::Noise;
use super::pass::pass_with;
use super::sums::Comparison;
use super::trajectory::Trajectory;

/// The block restarts so often, s. The contract's.
const RESTART_S: f64 = 20.0;

/// Simulates a drive. `held` holds the state to the recording up to each block's start; `free` goes on from
/// there. They may differ in how they come by a course: one estimates it, the other is told.
pub fn run(drive: &GriddedDrive, held: &ExtendedCar, free: &ExtendedCar, noise: &Noise) -> Vec<Comparison> {
    let mut compared = Vec::new();
    let per_block = points(RESTART_S);
    let mut watch = |trajectory: &Trajectory, k: usize, to: usize, begins: bool| {
        if !begins && !k.is_multiple_of(per_block) {
            return;
        }
        let mut trajectory = trajectory.clone();
        // What it is told it need not remember.
        let keeps = usize::from(!free.knows_torque());
        trajectory.forget_courses(keeps);
        let end = ((k / per_block + 1) * per_block).min(to);
        for step in k..end {
            if !free.knows_torque() {
                // Nobody knows what drives the car: its speed is the measured one.
                trajectory.set_speed(drive, step);
            }
            trajectory.run_free(free, drive, step, &mut compared);
        }
    };
    pass_with((0, drive), held, noise, &mut watch);
    compared
}
