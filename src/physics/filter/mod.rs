//! Kalman filtering, change detection and discretization (thesis ch. 2). Knows no vehicle.

pub mod consistency;
pub mod cusum;
pub mod discretize;
pub mod fading;
pub mod gaussian;
pub mod noise;
pub mod observability;
mod small;
pub mod student;
pub mod whiteness;

pub use consistency::Consistency;
pub use cusum::{Alarm, Cusum};
pub use fading::Fading;
pub use gaussian::{Gaussian, Innovation};
pub use noise::LearnedNoise;
pub use observability::{Observability, Spectrum};
pub use whiteness::InnovationMonitor;
