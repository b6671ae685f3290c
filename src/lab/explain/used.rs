//! Which part of a recording an answer is of, and why not of the rest.

use serde::Serialize;

use predict::grid::{SLOWEST_MPS, STEP_S};
use predict::{GriddedDrive, Why};

/// Of one recording.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Used {
    /// The recording.
    pub recording: String,
    /// Its length.
    pub seconds: f64,
    /// Of which so many are used.
    pub used_s: f64,
    /// What is left out, the longest first.
    pub left_out: Vec<Unused>,
}

/// A part that is left out.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Unused {
    /// So long, s.
    pub seconds: f64,
    /// Why, to go on with a sentence.
    pub why: String,
}

const ALL: [Why; 4] = [Why::Slow, Why::Unknown, Why::Sliding, Why::Short];

fn words(why: Why) -> String {
    match why {
        Why::Slow => format!("standing, or slower than {SLOWEST_MPS} m/s"),
        Why::Unknown => "without steering wheel angle, speed or a torque that is configured".into(),
        Why::Sliding => "just after wheels had slid".into(),
        Why::Short => "in pieces of less than 3 s between such".into(),
    }
}

impl Used {
    /// Of a drive.
    pub fn of(drive: &GriddedDrive) -> Self {
        let of = |why: Why| {
            let count = drive.unused.iter().filter(|unused| **unused == why).count();
            Unused { seconds: count as f64 * STEP_S, why: words(why) }
        };
        // A grid point more or less is nobody's loss.
        let mut left_out: Vec<Unused> = ALL.map(of).into_iter().filter(|it| it.seconds >= 0.5).collect();
        left_out.sort_by(|a, b| b.seconds.total_cmp(&a.seconds));
        // Without any run the sum is −0.
        let used_s = drive.used_seconds() + 0.0;
        Self { recording: drive.name.clone(), seconds: drive.seconds(), used_s, left_out }
    }
}
