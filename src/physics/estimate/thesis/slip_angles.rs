//! Slip angles (thesis 5.9, 5.10) with each of the lateral velocities.

use crate::estimate::kinematics::{Car, Kinematics};
use crate::estimates::LateralVelocities;

/// Front and rear slip angle, rad, by each of the ways to the lateral velocity; positive when they
/// give a positive lateral force.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SlipAngles {
    /// With v_y = 0.
    pub zero: Option<[f64; 2]>,
    /// With method 1.
    pub integration: Option<[f64; 2]>,
    /// With method 2.
    pub kinematic: Option<[f64; 2]>,
    /// With method 3.
    pub bicycle: Option<[f64; 2]>,
    /// With the joint filter.
    pub joint: Option<[f64; 2]>,
}

impl SlipAngles {
    /// From the velocities at a sample; none where speed, yaw rate or steering angle are missing, or
    /// where the velocity is.
    pub fn new(velocities: &LateralVelocities, now: &Kinematics, car: &Car) -> Self {
        let angles = |vy: Option<f64>| {
            let (vy, speed) = (vy?, now.speed.filter(|speed| *speed > 0.0)?);
            Some(car.slip_angles(speed, vy, now.yaw_rate?, [now.road_angle?, now.rear_angle]))
        };
        Self {
            zero: angles(velocities.zero),
            integration: angles(velocities.integration),
            kinematic: angles(velocities.kinematic),
            bicycle: angles(velocities.bicycle),
            joint: angles(velocities.joint),
        }
    }
}
