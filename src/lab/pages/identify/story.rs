//! Everything that is told of an identification.

use std::collections::BTreeMap;

use physics::Quantity;
use physics::model::Vehicle;

use identify::{Fits, Identification, IdentifyConfig, LongitudinalInput, Record};

/// Everything that is told of an identification.
pub struct Story<'a> {
    /// The configured offset of each quantity, in its SI unit.
    pub offsets: [f64; Quantity::COUNT],
    /// The car as its table has it.
    pub vehicle: &'a Vehicle,
    /// What was asked for.
    pub used: &'a IdentifyConfig,
    /// The recordings.
    pub records: &'a [Record],
    /// Those that nothing was fitted to.
    pub held_out: &'a [Record],
    /// How a free run predicts these: with the table's numbers, and with those found.
    pub predicted: [Fits; 2],
    /// What was found.
    pub found: &'a Identification,
}

impl Story<'_> {
    /// When recordings begin, in UTC, by their names; of those whose stamps are dates.
    pub(super) fn begins_utc(&self) -> BTreeMap<String, String> {
        let of = |record: &Record| Some((record.name.clone(), record.clock.utc(0.0)?));
        self.records.iter().chain(self.held_out).filter_map(of).collect()
    }

    /// What the recordings cannot tell, for what they lack.
    pub(super) fn untold(&self) -> Vec<&'static str> {
        let has = |quantity| self.records.iter().any(|record| record.sensors.has(quantity));
        let mut untold = Vec::new();
        if self.found.drive == LongitudinalInput::Speed {
            untold.push(
                "the measured speed is an input (no forces along the car without drive_torque or the speeds of all \
                 driven wheels): nothing can be told of longitudinal stiffness, drag, rolling resistance, wheel radius \
                 and inertia",
            );
        }
        if !has(Quantity::LateralAcceleration) {
            untold.push(
                "without lateral_acceleration the yaw rate has to tell alone: which axle is softer shows in every \
                 curve, how stiff both are only in quick steering",
            );
        }
        untold
    }
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
