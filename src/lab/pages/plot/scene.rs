//! What all parts of the page are made of.

use super::Drive;
use super::drive::Interval;
use crate::report::Color;
use crate::report::interactive::{Grid, Numbers, Series, Source};
use physics::Quantity;
use physics::model::Vehicle;

/// A drive, its car, and the rows that the page has of it.
pub struct Scene<'a> {
    pub drive: &'a Drive,
    pub vehicle: &'a Vehicle,
    pub grid: Grid,
}

impl<'a> Scene<'a> {
    /// Lines that a page may have beside the quantities': speed and what is expected of yaw rate and lateral acceleration,
    /// sideslip and slip angles, cornering stiffness and slip slope with their intervals, friction, and the time itself.
    const OTHER_LINES: usize = 30;

    pub fn new(drive: &'a Drive, vehicle: &'a Vehicle) -> Self {
        let lines = drive.quantities.len() + Self::OTHER_LINES;
        Self { grid: Grid::of_page(&drive.times, lines, 0), drive, vehicle }
    }

    /// A line of a column in another unit (`factor` of it are one SI unit).
    pub fn line(&self, name: &str, source: Source, color: Color, column: &[f32], factor: f64) -> Series {
        Series { name: name.into(), source, color, values: self.scaled(column, factor), interval: None }
    }

    /// A line with its interval.
    pub fn interval(&self, name: &str, color: Color, column: &Interval) -> Series {
        let edges = (self.grid.lower(&column.low), self.grid.upper(&column.high));
        let interval = (!edges.0.is_empty() && !edges.1.is_empty()).then_some(edges);
        Series { interval, ..self.line(name, Source::Estimated, color, &column.value, 1.0) }
    }

    fn scaled(&self, column: &[f32], factor: f64) -> Numbers {
        if factor == 1.0 {
            return self.grid.line(column);
        }
        let column: Vec<f32> = column.iter().map(|value| (f64::from(*value) * factor) as f32).collect();
        self.grid.line(&column)
    }

    /// Lateral acceleration by the sensor, or where the car has none by speed and yaw rate; and whether it is the sensor's.
    pub fn lateral_acceleration(&self) -> (Vec<f32>, bool) {
        match self.drive.signal(Quantity::LateralAcceleration) {
            Some(column) => (column.to_vec(), true),
            None => (self.speed_by_yaw_rate(), false),
        }
    }

    /// Speed times yaw rate: the lateral acceleration of a car whose sideslip does not change, m/s².
    pub fn speed_by_yaw_rate(&self) -> Vec<f32> {
        let yaw_rate = self.drive.signal(Quantity::YawRate).unwrap_or_default();
        self.drive.speed.iter().zip(yaw_rate).map(|(speed, yaw_rate)| speed * yaw_rate).collect()
    }

    /// Longitudinal acceleration by the sensor, or where the car has none by the change of the speed; and whether it is the
    /// sensor's.
    pub fn longitudinal_acceleration(&self) -> (Vec<f32>, bool) {
        /// A speed is differentiated over so many samples to either side: 0.3 s in all.
        const REACH: usize = 15;
        /// No tire on a road gives more, m/s²: the speed's signal has jumped.
        const MOST: f32 = 15.0;
        if let Some(column) = self.drive.signal(Quantity::LongitudinalAcceleration) {
            return (column.to_vec(), true);
        }
        let (speed, times) = (&self.drive.speed, &self.drive.times);
        let change = |place: usize| {
            let ends = (place.checked_sub(REACH)?, place + REACH);
            let time = times.get(ends.1)? - times.get(ends.0)?;
            (time < 2.0 * Grid::LONGEST_STEP_S).then_some(())?;
            let change = (speed.get(ends.1)? - speed.get(ends.0)?) / time as f32;
            Some(change).filter(|change| change.abs() <= MOST)
        };
        ((0..speed.len()).map(|place| change(place).unwrap_or(f32::NAN)).collect(), false)
    }
}

/// The largest finite value.
pub fn most(values: impl Iterator<Item = f32>) -> Option<f32> {
    values.filter(|value| value.is_finite()).reduce(f32::max)
}
