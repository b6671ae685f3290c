//! The lateral filter's state: its components, and what is known of them before anything is measured.

use nalgebra::SVector;

use super::config::CorneringConfig;
use crate::estimate::kinematics::Car;
use crate::filter::Gaussian;

/// Components.
pub const STATES: usize = 9;

/// Lateral velocity, m/s.
pub const VY: usize = 0;
/// Compliance of the front axle, rad per unit of normalized force.
pub const FRONT: usize = 1;
/// … of the rear axle.
pub const REAR: usize = 2;
/// Offset of the road wheel angle, rad.
pub const ANGLE_OFFSET: usize = 3;
/// Offset of the lateral acceleration, m/s².
pub const AY_OFFSET: usize = 4;
/// Offset of the yaw rate, rad/s.
pub const YAW_OFFSET: usize = 5;
/// Relative error of the speed.
pub const SPEED_SCALE: usize = 6;
/// Relative error of the steering angle.
pub const ANGLE_SCALE: usize = 7;
/// Gravity's part along the road's cross slope, m/s².
pub const BANK: usize = 8;

/// Mean and covariance.
pub type State = Gaussian<STATES>;
/// How something measured moves with the state.
pub type Row = SVector<f64, STATES>;

/// Lateral velocity of which nothing is known yet, m/s. Tuned, no test on record.
pub const UNKNOWN_VY: f64 = 0.5;
/// No data sheet knows a stiffness better than this, relative. Tuned, no test on record.
const LEAST_PRIOR_STD: f64 = 0.05;

/// What is known before anything is measured.
pub fn prior(car: &Car, config: &CorneringConfig) -> State {
    let mut mean = [0.0; STATES];
    let mut std = [0.0; STATES];
    for (i, (value, deviation)) in [FRONT, REAR].into_iter().zip(car.cornering_prior) {
        mean[i] = 1.0 / value;
        std[i] = (deviation / value).max(LEAST_PRIOR_STD) / value;
    }
    std[VY] = UNKNOWN_VY;
    std[ANGLE_OFFSET] = config.steering_offset_std;
    std[AY_OFFSET] = config.acceleration_offset_std;
    std[YAW_OFFSET] = config.yaw_rate_offset_std;
    std[SPEED_SCALE] = config.speed_scale_std.hypot(car.radius_relative_std);
    std[ANGLE_SCALE] = car.steering_ratio_relative_std;
    std[BANK] = config.bank_std;
    State::new(mean, std)
}
