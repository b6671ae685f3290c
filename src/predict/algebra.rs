//! Vectors and matrices of the filtered states.

use super::car::{BODY_STATES, MOST_LIVE};

/// Most states that the filter corrects.
pub const FILTERED: usize = BODY_STATES + MOST_LIVE;

/// A square of the filtered states.
pub type Square = [[f64; FILTERED]; FILTERED];
/// A number for each filtered state.
pub type Column = [f64; FILTERED];

/// How one reading corrects the state.
#[derive(Clone, Copy, Debug)]
pub(super) struct Gain {
    /// The correction of the state per unit of the innovation.
    pub(super) k: Column,
    /// Derivatives of the reading by the state.
    pub(super) c: Column,
    /// Variance of the innovation.
    pub(super) s: f64,
}

/// Σ aᵢ bᵢ over the first `n`: a loop, for it is at the bottom of everything here.
#[inline(always)]
pub(super) fn dot(a: &Column, b: &Column, n: usize) -> f64 {
    a.iter().zip(b).take(n).fold(0.0, |sum, (a, b)| sum + a * b)
}
