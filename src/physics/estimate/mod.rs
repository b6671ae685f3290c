//! The estimators, one file each, and the pipeline that runs them on a [`Sample`](crate::Sample).
//!
//! No I/O, no clock, no allocation per sample. Each estimator takes [`Kinematics`] (a sample in the
//! car's own terms) and keeps what it knows; [`Pipeline`] decides the order and what is published.

mod abs_braking;
mod belief;
mod bicycle_filter;
mod block;
mod brake_slip;
mod brush;
mod config;
mod cornering;
mod dahl_ekf;
mod friction;
mod joint_ekf;
mod kinematic_observer;
mod kinematics;
pub mod lateral_filter;
mod lateral_slope;
mod lateral_velocity;
mod learned;
pub mod mapping;
mod overall_slope;
mod pipeline;
mod roughness;
mod saturation;
mod slip_angles;
mod slope;
mod traction;
mod window;

pub use bicycle_filter::BicycleFilter;
pub use config::{
    BrushConfig, CorneringConfig, EstimatorsConfig, FrictionConfig, JointEkfConfig, LateralVelocitySource,
    SlopeConfig,
};
pub use cornering::{Axle, Doubt};
pub use dahl_ekf::{DahlEkf, DahlWheel};
pub use joint_ekf::JointEkf;
pub use kinematic_observer::{KinematicObserver, SpeedDerivative};
pub use kinematics::{Car, Cornering, Kinematics};
pub use lateral_slope::LateralSlopeEstimator;
pub use lateral_velocity::LateralVelocityEstimator;
pub use learned::{Known, Learned};
pub use pipeline::Pipeline;
pub use saturation::{LimitFriction, SlipPoint, WheelSaturation};
pub use slip_angles::SlipAngles;
