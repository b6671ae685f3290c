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

/// The place of the largest weight, the first of them if there are several; 0 where there is none.
pub fn likeliest(weights: &[f64]) -> usize {
    (1..weights.len()).fold(0, |best, i| if weights[i] > weights[best] { i } else { best })
}
