//! The estimators, one file each, and the pipeline that runs them on a [`Sample`](crate::Sample).
//!
//! No I/O, no clock, no allocation per sample. Each estimator takes [`Kinematics`] (a sample in the
//! car's own terms) and keeps what it knows; [`Pipeline`] decides the order and what is published.

mod abs_braking;
mod block;
mod brush;
mod config;
mod cornering;
mod friction;
mod joint_ekf;
mod kinematics;
pub mod lateral_filter;
mod lateral_slope;
mod lateral_velocity;
mod pipeline;
mod slope;
mod traction;
mod window;

pub use config::{
    BrushConfig, CorneringConfig, EstimatorsConfig, FrictionConfig, JointEkfConfig, LateralVelocitySource,
    SlopeConfig,
};
pub use kinematics::{Car, Cornering, Kinematics};
pub use pipeline::Pipeline;
