//! The car, its tires, and the estimators that see them through its sensors.
//!
//! [`Sample`] goes in, [`Estimates`] come out. Nothing here knows of buses, files or the time of day.

pub mod estimate;
pub mod estimates;
pub mod faults;
pub mod filter;
pub mod model;
pub mod sample;
pub mod time;

pub use estimates::Estimates;
pub use faults::Faults;
pub use sample::{Quantity, Sample, Sensors, Wheel};
pub use time::Micros;
