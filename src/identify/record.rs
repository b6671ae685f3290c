//! A recording as identification sees it: rows on a uniform grid, cut where nothing can be learnt.

use super::longitudinal_input::LongitudinalInput;
use physics::model::{DrivenAxle, Vehicle};
use physics::time::Clock;
use physics::{Micros, Quantity, Sample, Sensors, Wheel};

/// What was measured at one instant; not-a-number: not available.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Row {
    /// Seconds from the recording's start.
    pub t: f64,
    /// Steering wheel angle, rad.
    pub steering: f64,
    /// Angular speeds of the wheels, rad/s.
    pub wheel_speed: [f64; 4],
    /// Yaw rate, rad/s.
    pub yaw_rate: f64,
    /// Lateral acceleration, m/s².
    pub lateral_acceleration: f64,
    /// Longitudinal acceleration, m/s².
    pub longitudinal_acceleration: f64,
    /// Drive torque in the bus's unit.
    pub drive_torque: f64,
    /// Brake pressure, bar.
    pub brake_pressure: f64,
    /// Vehicle speed as another unit has it, m/s; as well as it is known, where it is an input.
    pub vehicle_speed: f64,
    /// Slip of each wheel, where it is an input (the thesis's 5.3.2).
    pub slip: [f64; 4],
    /// Is the brake known, or thought, to be applied?
    pub braking: bool,
}

/// A recording.
#[derive(Clone, Debug, PartialEq)]
pub struct Record {
    /// What it is called, for messages.
    pub name: String,
    /// From when on its seconds are counted.
    pub clock: Clock,
    /// Distance of the rows, s.
    pub period_s: f64,
    /// All rows in order of time.
    pub rows: Vec<Row>,
    /// What is on this bus, and how noisy it is said to be.
    pub sensors: Sensors,
}

impl Record {
    /// From the samples of a recording.
    pub fn new(name: &str, samples: &[Sample], sensors: &Sensors) -> Self {
        let mut steps: Vec<f64> = samples.iter().map(|s| s.elapsed_s).filter(|s| *s > 0.0).collect();
        steps.sort_by(f64::total_cmp);
        let period_s = steps.get(steps.len() / 2).copied().unwrap_or(0.01);
        let start = samples.first().map_or(Micros(0), |sample| sample.time);
        let rows = samples.iter().map(|sample| Row::new(sample, start)).collect();
        Self { name: name.into(), clock: Clock::of(start), period_s, rows, sensors: *sensors }
    }

    /// The same, its seconds counted from another moment: that of the recording's first frame.
    pub fn counted_from(mut self, start: Micros) -> Self {
        let later = (self.clock.begins() - start).seconds();
        self.rows.iter_mut().for_each(|row| row.t += later);
        self.clock = Clock::of(start);
        self
    }

    /// The same with rows no closer than the frames of its quickest message, so many seconds apart: what lies between them was
    /// interpolated and tells nothing.
    pub fn no_denser_than(mut self, frames_s: f64) -> Self {
        // Frames come a little early now and then.
        let every = (frames_s.min(WIDEST_S) / self.period_s + 0.1) as usize;
        if every > 1 {
            self.rows = self.rows.into_iter().step_by(every).collect();
            self.period_s *= every as f64;
        }
        self
    }

    /// Pieces of rows without gap, long enough, and fast enough to have slip angles: each gets a start
    /// of its own. With `braking`, braked stretches are in.
    pub(super) fn stretches(
        &self,
        vehicle: &Vehicle,
        least_s: f64,
        drive: LongitudinalInput,
        braking: bool,
    ) -> Vec<(usize, usize)> {
        let mut stretches = Vec::new();
        let mut begin = None;
        let mut last_t = f64::NEG_INFINITY;
        let radius = vehicle.wheel_radius_m.value;
        for (place, row) in self.rows.iter().enumerate() {
            let usable = row.is_usable(radius)
                && row.has_inputs(vehicle, drive)
                && match drive {
                    // What braking takes is in the speed.
                    LongitudinalInput::Speed => true,
                    _ if braking => row.brake_pressure.is_finite(),
                    _ => !row.braking,
                };
            let follows = row.t - last_t < 1.5 * self.period_s;
            last_t = row.t;
            if let Some(from) = begin
                && !(usable && follows)
            {
                stretches.push((from, place));
                begin = None;
            }
            if usable && begin.is_none() {
                begin = Some(place);
            }
        }
        if let Some(from) = begin {
            stretches.push((from, self.rows.len()));
        }
        let least = (least_s / self.period_s).ceil().max(2.0) as usize;
        stretches.retain(|(from, to)| to - from >= least);
        stretches
    }
}

/// Inputs are taken as straight lines from row to row, which a driver's hands are for so long, s. Physical.
const WIDEST_S: f64 = 0.05;

/// Below this speed slip angles mean nothing and wheel sensors are coarse, m/s.
pub(super) const SLOWEST_MPS: f64 = 3.0;

impl Row {
    fn new(sample: &Sample, start: Micros) -> Self {
        let get = |quantity| sample.get(quantity).unwrap_or(f64::NAN);
        let is_on = |quantity| sample.get(quantity).is_some_and(|value| value > 0.5);
        let pressed = |quantity, more_than| sample.get(quantity).is_some_and(|value| value > more_than);
        Self {
            t: (sample.time - start).seconds(),
            steering: get(Quantity::SteeringWheelAngle),
            wheel_speed: Wheel::ALL.map(|wheel| get(Quantity::wheel_speed(wheel))),
            yaw_rate: get(Quantity::YawRate),
            lateral_acceleration: get(Quantity::LateralAcceleration),
            longitudinal_acceleration: get(Quantity::LongitudinalAcceleration),
            drive_torque: get(Quantity::DriveTorque),
            brake_pressure: get(Quantity::BrakePressure),
            vehicle_speed: get(Quantity::VehicleSpeed),
            slip: [f64::NAN; 4],
            braking: is_on(Quantity::BrakeActive)
                || is_on(Quantity::AbsActive)
                || pressed(Quantity::BrakePressure, 1.0)
                || pressed(Quantity::BrakeTorque, 20.0),
        }
    }

    /// The mean speed of the wheels that are there, m/s.
    pub(super) fn rolling_speed(&self, radius: f64) -> f64 {
        let wheels = self.wheel_speed.iter().filter(|speed| speed.is_finite());
        let (sum, count) = wheels.fold((0.0, 0.0), |(sum, count), speed| (sum + speed, count + 1.0));
        if count > 0.0 { radius * sum / count } else { self.vehicle_speed }
    }

    /// The mean speed of the wheels that roll freely (of all, where all are driven), m/s.
    pub(super) fn undriven_speed(&self, vehicle: &Vehicle) -> f64 {
        let all = vehicle.driven_axle == DrivenAxle::All;
        let counts = |wheel: &Wheel| all || !vehicle.driven_axle.drives(*wheel);
        let speeds = Wheel::ALL.into_iter().filter(counts).map(|wheel| self.wheel_speed[wheel as usize]);
        let there = speeds.filter(|speed| speed.is_finite());
        let (sum, count) = there.fold((0.0, 0.0), |(sum, count), speed| (sum + speed, count + 1.0));
        vehicle.wheel_radius_m.value * sum / count
    }

    /// The car's speed as well as it is known, m/s: by the wheels that roll freely, else as another unit has it, else
    /// by the wheels there are.
    pub fn speed(&self, vehicle: &Vehicle) -> f64 {
        let known = [self.undriven_speed(vehicle), self.vehicle_speed];
        let known = known.into_iter().find(|speed| speed.is_finite());
        known.unwrap_or_else(|| self.rolling_speed(vehicle.wheel_radius_m.value))
    }

    /// Is all there that the equations are driven by?
    fn has_inputs(&self, vehicle: &Vehicle, drive: LongitudinalInput) -> bool {
        let driven = Wheel::ALL.into_iter().filter(|wheel| vehicle.driven_axle.drives(*wheel));
        match drive {
            LongitudinalInput::Torque => self.drive_torque.is_finite(),
            LongitudinalInput::WheelSpeeds => {
                driven.map(|w| self.wheel_speed[w as usize]).all(f64::is_finite)
            }
            LongitudinalInput::Slips => self.slip.iter().all(|slip| slip.is_finite()),
            LongitudinalInput::Speed => self.vehicle_speed.is_finite(),
        }
    }

    fn is_usable(&self, radius: f64) -> bool {
        self.steering.is_finite()
            && (self.yaw_rate.is_finite() || self.lateral_acceleration.is_finite())
            && self.rolling_speed(radius) > SLOWEST_MPS
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// GIVEN samples every 10 ms WHEN frames come every 40 ms, every 12 ms, and once a second THEN every fourth row stays, every
    /// one, and every fifth.
    #[test]
    fn rows_lie_as_far_apart_as_frames() {
        let sample = |k: i64| Sample::empty(Micros::from_millis(10 * k), if k > 0 { 0.01 } else { 0.0 });
        let samples: Vec<Sample> = (0..100).map(sample).collect();
        let record = Record::new("test", &samples, &Sensors::default());
        for (frames_s, every) in [(0.0398, 4), (0.012, 1), (1.0, 5)] {
            let thinned = record.clone().no_denser_than(frames_s);
            let times: Vec<f64> = thinned.rows.iter().map(|row| row.t).collect();
            let expected: Vec<f64> = record.rows.iter().step_by(every).map(|row| row.t).collect();
            assert_eq!(times, expected, "{frames_s} s");
            assert!((thinned.period_s - 0.01 * every as f64).abs() < 1e-12, "{frames_s} s");
        }
    }
}
