//! What of a recording goes with the answer: how it was split, how the car was driven, what was measured.

use serde::Serialize;

use super::super::ordinary::FreeTrace;
use physics::model::effect::Recorded;
use predict::GriddedDrive;
use predict::grid::STEP_S;

/// Speed and steering of so many grid points one is kept for plots: seventeen a second.
const SHOWN_EVERY: usize = 3;

/// A stretch of a recording.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Block {
    /// Its recording.
    pub recording: String,
    /// From, to, s.
    pub t: [f64; 2],
    /// The same in UTC, where its stamps are dates.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub t_utc: Option<[String; 2]>,
    /// Was it held out?
    pub is_holdout: bool,
}

/// How a recorded car was driven.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Driven {
    /// The recording.
    pub recording: String,
    /// Time, s; speed, m/s; steering wheel angle, rad. Not-a-number: not available.
    pub rows: Vec<[f64; 3]>,
}

impl Driven {
    /// How this one was.
    pub fn of(drive: &GriddedDrive) -> Self {
        let row = |(k, input): (usize, &Recorded)| [k as f64 * STEP_S, drive.speed[k], input.steering_wheel];
        let rows = drive.inputs.iter().enumerate().step_by(SHOWN_EVERY).map(row).collect();
        Self { recording: drive.name.clone(), rows }
    }
}

/// One channel of one recording, with both simulations.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Trace {
    /// The recording.
    pub recording: String,
    /// The quantity.
    pub channel: String,
    /// Its unit.
    pub unit: String,
    /// Times, s.
    pub t: Vec<f64>,
    /// As recorded.
    pub measured: Vec<f64>,
    /// By the plain model, free-running from the start of each block.
    pub baseline: Vec<f64>,
    /// By the extended one.
    pub extended: Vec<f64>,
}

impl Trace {
    /// Of a free run.
    pub(super) fn of(free: &FreeTrace) -> Self {
        let column = |place: usize| free.rows.iter().map(move |row| row[place]).collect();
        Self {
            recording: free.recording.clone(),
            channel: free.channel.name().into(),
            unit: free.channel.unit().into(),
            t: column(0),
            measured: column(1),
            baseline: column(3),
            extended: column(2),
        }
    }
}
