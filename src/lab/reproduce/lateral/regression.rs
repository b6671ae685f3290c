//! The lateral slope (5.20) over a drive, on each lateral velocity.

use super::course::{LateralDrive, MINIMUM_SPEED, Point};
use physics::estimate::thesis::LateralSlopeEstimator;

/// Where v_y comes from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Source {
    /// v_y = 0.
    Zero,
    /// Method 2.
    Kinematic,
    /// Method 3.
    Bicycle,
    /// The true one.
    Truth,
}

impl Source {
    fn velocity(self, point: &Point) -> Option<f64> {
        match self {
            Self::Zero => point.velocities.zero,
            Self::Kinematic => point.velocities.kinematic,
            Self::Bicycle => point.velocities.bicycle,
            Self::Truth => Some(point.truth.lateral_velocity),
        }
    }
}

/// C_yN over time: by the mean of both axles' compliances, 1/rad (the yaw acceleration, which (5.20)
/// leaves out, adds to one what it takes from the other); not a number where one is not known.
pub(super) fn over(course: &LateralDrive, source: Source) -> Vec<(f64, f64)> {
    let mut estimator = LateralSlopeEstimator::new(&course.car, MINIMUM_SPEED);
    let step = |point: &Point| {
        estimator.step(&point.now, source.velocity(point));
        let [front, rear] = estimator.slopes();
        (
            point.t,
            front.zip(rear).map_or(f64::NAN, |(front, rear)| 2.0 / (1.0 / front.value + 1.0 / rear.value)),
        )
    };
    course.points.iter().map(step).collect()
}
