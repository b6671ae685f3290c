//! Small numerics that several sections share.

use std::ops::Range;

/// Where a condition that holds at the range's start ceases to; it must cease once. By bisection, to
/// rounding.
pub fn crossing(range: Range<f64>, holds: impl Fn(f64) -> bool) -> f64 {
    let Range { start: mut low, end: mut high } = range;
    for _ in 0..200 {
        let middle = 0.5 * (low + high);
        if holds(middle) { low = middle } else { high = middle }
    }
    low
}

/// An error for the table: rounding, or how much it is.
pub fn within(error: f64) -> String {
    if error < 1e-12 { "exactly".into() } else { format!("within {error:.0e}") }
}
