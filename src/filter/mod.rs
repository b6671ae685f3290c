//! Kalman filtering, change detection and discretization (thesis ch. 2). Knows no vehicle.

pub mod cusum;
pub mod discretize;
pub mod gaussian;
pub mod noise;
pub mod observability;
pub mod whiteness;

pub use cusum::{Alarm, Cusum};
pub use gaussian::{Gaussian, Innovation};
pub use noise::LearnedNoise;
pub use observability::Gramian;
pub use whiteness::InnovationMonitor;
