//! Everything that is told of an identification.

use physics::Quantity;

use crate::identify::{Identification, IdentifyConfig, Record};

/// Everything that is told of an identification.
pub struct Story<'a> {
    /// The configured offset of each quantity, in its SI unit.
    pub offsets: [f64; Quantity::COUNT],
    /// What was asked for.
    pub used: &'a IdentifyConfig,
    /// The recordings.
    pub records: &'a [Record],
    /// What was found.
    pub found: &'a Identification,
}

/// Four significant digits, or as many as a number of this uncertainty has.
pub(super) fn digits(value: f64, std: f64) -> usize {
    let of = if std > 0.0 && std.is_finite() { 0.1 * std } else { 1e-3 * value.abs() };
    if of > 0.0 && of.is_finite() { (-of.log10().floor()).clamp(0.0, 9.0) as usize } else { 1 }
}

/// A number to so many decimals, without trailing zeros where there are many; a dash for none.
pub(super) fn number(value: f64, decimals: usize) -> String {
    if value.is_finite() { format!("{value:.decimals$}") } else { "–".into() }
}
