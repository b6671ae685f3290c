//! How well a simulation without feedback fits: the number that people compare.
//!
//! Driven by the recorded steering wheel, torques or wheel speeds, restarted from the measured state each
//! 20 s (contract: `fit`), 100 (1 − |y − ŷ| / |y − mean y|) per cent.

use super::car::PlainCar;
use super::longitudinal_input::LongitudinalInput;
use super::motion::Output;
use super::parameter::Values;
use super::prepare;
use super::record::Record;
use physics::model::Vehicle;

/// Length of a block, s; what does not divide by it is spread over the blocks.
pub const BLOCK_S: f64 = 20.0;
/// Shorter stretches do not count, s.
const LEAST_S: f64 = 2.0;

/// Measured and simulated, row by row, and the fit of each channel.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Fits {
    /// Per cent, for the channels there are.
    pub percent: Vec<(&'static str, f64)>,
    /// The rows.
    pub rows: Vec<FitRow>,
}

/// One row of a free run.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FitRow {
    /// The recording.
    pub record: usize,
    /// Seconds from its start.
    pub t: f64,
    /// What was measured, by [`Output`].
    pub measured: [f64; Output::COUNT],
    /// What was simulated.
    pub simulated: [f64; Output::COUNT],
}

/// Runs freely through all records with the vehicle as its table says, no offsets.
pub fn free_run(records: &[Record], vehicle: &Vehicle, drive: LongitudinalInput) -> Fits {
    fits(records, vehicle, &Values::of(vehicle), drive)
}

/// Runs freely through all records.
pub(super) fn fits(records: &[Record], vehicle: &Vehicle, values: &Values, drive: LongitudinalInput) -> Fits {
    let car = PlainCar::plain(vehicle, drive, values);
    let mut rows = Vec::new();
    for segment in prepare::segments(records, vehicle, values, drive, BLOCK_S, LEAST_S) {
        let outputs = segment.outputs(&car, drive, segment.start);
        for (place, (simulated, measured)) in outputs.iter().zip(&segment.measured).enumerate() {
            let t = segment.t + place as f64 * segment.period_s;
            rows.push(FitRow { record: segment.record, t, measured: *measured, simulated: *simulated });
        }
    }
    let percent = Output::ALL.into_iter().filter_map(|channel| {
        let there = || rows.iter().filter(|row| !row.measured[channel as usize].is_nan());
        let count = there().count() as f64;
        let mean = there().map(|row| row.measured[channel as usize]).sum::<f64>() / count;
        let square = |value: f64| value * value;
        let spread: f64 = there().map(|row| square(row.measured[channel as usize] - mean)).sum();
        let miss = |row: &FitRow| square(row.measured[channel as usize] - row.simulated[channel as usize]);
        let missed: f64 = there().map(miss).sum();
        (spread > 0.0).then(|| (channel.name(), 100.0 * (1.0 - (missed / spread).sqrt())))
    });
    Fits { percent: percent.collect(), rows }
}
