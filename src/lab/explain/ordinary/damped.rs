//! A damped step of a search within bounds.

use nalgebra::{DMatrix, DVector};

use super::numbers::Free;
use identify::bounded_step;

/// Where Levenberg's and Marquardt's step leads, from where the numbers are; see [`bounded_step`].
pub fn damped_step(
    information: &DMatrix<f64>,
    gradient: &DVector<f64>,
    damping: f64,
    free: &[Free],
    at: &[f64],
) -> Option<Vec<f64>> {
    let mut information = information.clone();
    for i in 0..free.len() {
        information[(i, i)] *= 1.0 + damping;
    }
    let limits = free.iter().zip(at).map(|(free, at)| (free.bounds.0 - at, free.bounds.1 - at));
    let step = bounded_step(&information, gradient, &limits.collect::<Vec<_>>())?;
    let next = free.iter().zip(at).zip(&step);
    // A sum is rounded.
    Some(next.map(|((free, at), by)| (at + by).clamp(free.bounds.0, free.bounds.1)).collect())
}
