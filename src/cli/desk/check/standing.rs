//! When the car of a recording stands.

use std::collections::BTreeMap;

use super::recording::STUCK_S;
use physics::Quantity;

/// When the car stands: all of the speeds that there are near zero.
#[derive(Default)]
pub struct Standing {
    /// The newest speeds: rim or road, m/s at a radius of a third of a metre.
    speeds: BTreeMap<Quantity, f64>,
    /// Since when.
    since: Option<f64>,
    intervals: Vec<[f64; 2]>,
}

/// Slower than this it stands, m/s. Physical: wheel sensors know nothing below.
const STANDING_MPS: f64 = 0.3;

impl Standing {
    /// Takes a value, s from the first frame.
    pub fn take(&mut self, quantity: Quantity, at: f64, value: f64) {
        let rim = match quantity {
            Quantity::VehicleSpeed => value.abs(),
            wheel if wheel.wheel().is_some() => value.abs() / 3.0,
            _ => return,
        };
        self.speeds.insert(quantity, rim);
        match (self.speeds.values().all(|speed| *speed < STANDING_MPS), self.since) {
            (true, None) => self.since = Some(at),
            (false, Some(_)) => self.end(at),
            _ => (),
        }
    }

    fn end(&mut self, at: f64) {
        if let Some(since) = self.since.take()
            && at - since > STUCK_S
        {
            self.intervals.push([since, at]);
        }
    }

    /// A file has ended, s from the first frame.
    pub fn end_of_file(&mut self, at: f64) {
        self.end(at);
        self.speeds.clear();
    }

    /// From, to, s.
    pub fn intervals(self) -> Vec<[f64; 2]> {
        self.intervals
    }
}
