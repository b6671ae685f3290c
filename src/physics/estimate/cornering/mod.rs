//! The joint lateral filter that is published: motion, both axles' cornering stiffness, and the
//! errors of the sensors it stands on.
//!
//! The joint EKF of thesis (5.21) multiplies two unknowns, stiffness and slip angle, and is soon surer
//! of both than it can be. Here the *measured* forces are the regressors: lateral acceleration and
//! yaw acceleration give each axle's normalized force μ, and with the compliance κ = 1/k every
//! equation is linear in what is unknown:
//!
//! ```text
//! v̇_y = a_y − v_x r                                 kinematics: no tire in it
//! δ − (v_y + a r)/v_x = κ_F μ_F                       μ_F = (a_y + J ṙ/(m b))/g
//!   − (v_y − b r)/v_x = κ_R μ_R                       μ_R = (a_y − J ṙ/(m a))/g     (thesis 5.20)
//! ```
//!
//! The equations hold for means over a window as well, if v_y's change from one window's mean to the next is
//! integrated from every sample ([`window`]). Windows are long because noise in a regressor pulls the compliance to
//! zero; only changes of the force from window to window work against that. For the same reason the yaw acceleration,
//! mostly noise in gentle driving, is shrunk to its expectation ([`window::YawAcceleration`]).
//!
//! Tires bend: near their limit they slip further than κ μ, by a factor that depends on the share of the friction in
//! use ([`bend`]); the belief over the friction gives the factor's mean and variance. Tires slide: an axle whose slip
//! angle its force does not explain at all is left out, and v_y follows its kinematics alone ([`sliding`]).
//! What the bend says of the friction see [`saturating`](super::saturating).
//!
//! Further states are the offsets of steering, accelerometer and gyro, the scales of speed and
//! steering angle, and the road's bank, which turns v_y but is no tire force. Noise is learned from the
//! innovations; a CUSUM detector per axle notices a change of surface, and one that is not noticed is a hypothesis
//! beside ([`another_road`]).

mod another_road;
mod apart;
mod axle;
mod bend;
mod config;
mod doubt;
mod equation;
mod estimator;
mod lasting;
mod model;
mod single_brake;
mod sliding;
mod standstill;
mod state;
#[cfg(test)]
mod tests;
mod window;

pub use apart::Apart;
pub use config::CorneringConfig;
pub use doubt::{Axle, Doubt};
pub use estimator::CorneringEstimator;
pub use lasting::expected_errors;
