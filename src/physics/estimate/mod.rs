//! The estimators, one file each, and the pipeline that runs them on a [`Sample`](crate::Sample).
//!
//! No I/O, no clock, no allocation per sample. Each estimator takes [`Kinematics`] (a sample in the
//! car's own terms) and keeps what it knows; [`Pipeline`] decides the order and what is published.

mod abs_braking;
mod belief;
mod block;
mod brake_slip;
mod brush;
mod config;
mod cornering;
mod doubted;
mod expected;
mod friction;
mod kinematics;
mod lasting;
pub mod lateral_filter;
mod learned;
pub mod mapping;
mod motion;
mod overall_slope;
mod pipeline;
mod plain_readings;
mod roughness;
mod saturating;
mod saturation;
mod skid;
mod slope;
pub mod thesis;
mod torque_zero;
mod traction;

pub use config::{BrushConfig, EstimatorsConfig, FrictionConfig, SlopeConfig};
pub use cornering::{Axle, CorneringConfig, Doubt};
pub use expected::Contradiction;
pub use kinematics::{Car, Cornering, Heard, Kinematics};
pub use learned::{Known, Learned};
pub use pipeline::Pipeline;
pub use plain_readings::PlainReadings;
pub use saturation::{AtLimit, LimitFriction, SlipPoint, WheelSaturation};
