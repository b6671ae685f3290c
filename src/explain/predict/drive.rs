//! A recording as the filter takes it: inputs on a grid, readings at their own times.

use crate::model::Vehicle;
use crate::model::effect::Recorded;
use crate::{Quantity, Wheel};

/// What was recorded of each quantity: times (s from the recording's start) and values, SI.
#[derive(Clone, Debug, Default)]
pub struct Recording {
    /// What it is called.
    pub name: String,
    /// One track for each quantity.
    pub tracks: [Vec<(f64, f64)>; Quantity::COUNT],
}

impl Recording {
    /// Is there anything of a quantity?
    pub fn has(&self, quantity: Quantity) -> bool {
        self.tracks[quantity as usize].len() > 10
    }

    /// Time of the last reading, s.
    pub fn seconds(&self) -> f64 {
        self.tracks.iter().filter_map(|track| track.last()).map(|(t, _)| *t).fold(0.0, f64::max)
    }
}

/// Seconds between grid points.
pub const STEP_S: f64 = 0.01;

/// Below this speed slip angles mean nothing and wheel sensors are coarse, m/s.
const SLOWEST_MPS: f64 = 3.0;

/// An input, or all wheels, missing for so long ends a run, s.
const LONGEST_GAP_S: f64 = 0.3;

/// Shorter runs say nothing, s.
const SHORTEST_RUN_S: f64 = 3.0;

/// One reading.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Measured {
    /// It was taken in the step that begins at this grid point…
    pub step: u32,
    /// …at this share of it, above 0 and up to 1.
    pub share: f32,
    /// Its quantity.
    pub channel: u8,
    /// SI.
    pub value: f64,
}

/// A recording on a grid.
#[derive(Clone, Debug)]
pub struct Drive {
    /// The recording's name.
    pub name: String,
    /// Inputs as recorded, at each grid point.
    pub inputs: Vec<Recorded>,
    /// All readings in order of time.
    pub measured: Vec<Measured>,
    /// Where each step's readings begin in `measured`; one more than there are steps.
    pub first: Vec<u32>,
    /// Grid points from, to between which all inputs are there and the car is moving.
    pub runs: Vec<(usize, usize)>,
    /// Speed by the wheels at each grid point, m/s.
    pub speed: Vec<f64>,
    /// Is the drive torque known?
    pub knows_torque: bool,
}

/// Quantities that the filter compares.
pub const COMPARED: [Quantity; 7] = [
    Quantity::WheelSpeedFl,
    Quantity::WheelSpeedFr,
    Quantity::WheelSpeedRl,
    Quantity::WheelSpeedRr,
    Quantity::YawRate,
    Quantity::LateralAcceleration,
    Quantity::LongitudinalAcceleration,
];

impl Drive {
    /// Of a recording of this vehicle.
    pub fn new(recording: &Recording, vehicle: &Vehicle) -> Self {
        let steps = (recording.seconds() / STEP_S).floor() as usize;
        let at = |quantity: Quantity| on_grid(&recording.tracks[quantity as usize], steps + 1);
        let input = |quantity: Quantity| smooth_on_grid(&recording.tracks[quantity as usize], steps + 1);
        let steering = input(Quantity::SteeringWheelAngle);
        let knows_torque = recording.has(Quantity::DriveTorque);
        let (torque, pressure) = (input(Quantity::DriveTorque), input(Quantity::BrakePressure));
        let radius = vehicle.wheel_radius_m.value;
        let wheels = Wheel::ALL.map(|wheel| at(Quantity::wheel_speed(wheel)));
        let speed = |k: usize| {
            let there = wheels.iter().map(|wheel| wheel[k]).filter(|speed| speed.is_finite());
            let (sum, count) = there.fold((0.0, 0.0), |(sum, count), speed| (sum + speed, count + 1.0));
            radius * sum / count
        };
        let speed: Vec<f64> = (0..=steps).map(speed).collect();
        let or_zero = |value: f64| if value.is_finite() { value } else { 0.0 };
        let inputs = (0..=steps).map(|k| Recorded {
            steering_wheel: steering[k],
            drive_torque: or_zero(torque[k]),
            brake_pressure: or_zero(pressure[k]),
        });
        let inputs: Vec<Recorded> = inputs.collect();
        let mut measured = Vec::new();
        for channel in COMPARED {
            for (t, value) in &recording.tracks[channel as usize] {
                let place = t / STEP_S;
                let step = (place.ceil() - 1.0).max(0.0);
                if *t > 0.0 && (step as usize) < steps && value.is_finite() {
                    let share = (place - step) as f32;
                    measured.push(Measured {
                        step: step as u32,
                        share,
                        channel: channel as u8,
                        value: *value,
                    });
                }
            }
        }
        measured.sort_by(|a, b| {
            (a.step, a.share).partial_cmp(&(b.step, b.share)).unwrap_or(std::cmp::Ordering::Equal)
        });
        let mut first = Vec::with_capacity(steps + 1);
        let mut place = 0;
        for step in 0..=steps {
            while place < measured.len() && (measured[place].step as usize) < step {
                place += 1;
            }
            first.push(place as u32);
        }
        let usable = |k: usize| {
            speed[k] > SLOWEST_MPS && steering[k].is_finite() && (!knows_torque || torque[k].is_finite())
        };
        let mut runs = Vec::new();
        let mut begin = None;
        for k in 0..=steps + 1 {
            let goes = k <= steps && usable(k);
            match begin {
                None if goes => begin = Some(k),
                Some(from) if !goes => {
                    if (k - from) as f64 * STEP_S >= SHORTEST_RUN_S {
                        runs.push((from, k - 1));
                    }
                    begin = None;
                }
                _ => {}
            }
        }
        Self { name: recording.name.clone(), inputs, measured, first, runs, speed, knows_torque }
    }

    /// The readings of a step.
    pub fn of_step(&self, step: usize) -> (usize, &[Measured]) {
        let (from, to) = (self.first[step] as usize, self.first[step + 1] as usize);
        (from, &self.measured[from..to])
    }

    /// Inputs as recorded some time after a grid point, s; between grid points linear.
    pub fn input_after(&self, k: usize, delay: f64) -> Recorded {
        if delay == 0.0 {
            return self.inputs[k];
        }
        let last = self.inputs.len() - 1;
        let place = (k as f64 + delay / STEP_S).clamp(0.0, last as f64);
        let before = (place as usize).min(last.saturating_sub(1));
        let share = place - before as f64;
        let (a, b) = (self.inputs[before].steering_wheel, self.inputs[before + 1].steering_wheel);
        Recorded { steering_wheel: a + share * (b - a), ..self.inputs[k] }
    }

    /// Seconds from the recording's start to its end.
    pub fn seconds(&self) -> f64 {
        (self.inputs.len() - 1) as f64 * STEP_S
    }
}

/// Inputs are smoothed over so long to each side, s: nobody turns a wheel or a pedal faster, and noise of an
/// input would act as a force.
const SMOOTH_S: f64 = 0.055;

/// A parabola through the readings around each grid point; not-a-number in gaps.
fn smooth_on_grid(track: &[(f64, f64)], points: usize) -> Vec<f64> {
    let plain = on_grid(track, points);
    let (mut from, mut to) = (0, 0);
    let at = |k: usize| {
        let t = k as f64 * STEP_S;
        while from < track.len() && track[from].0 < t - SMOOTH_S {
            from += 1;
        }
        while to < track.len() && track[to].0 <= t + SMOOTH_S {
            to += 1;
        }
        let around = &track[from..to.max(from)];
        // Moments of the times, scaled, and of the values.
        let mut m = [0.0; 5];
        let mut y = [0.0; 3];
        for (other, value) in around {
            let x = (other - t) / SMOOTH_S;
            let mut power = 1.0;
            for (i, moment) in m.iter_mut().enumerate() {
                *moment += power;
                if i < 3 {
                    y[i] += power * value;
                }
                power *= x;
            }
        }
        let normal = nalgebra::Matrix3::new(m[0], m[1], m[2], m[1], m[2], m[3], m[2], m[3], m[4]);
        let is_within =
            around.first().is_some_and(|(t0, _)| *t0 <= t) && around.last().is_some_and(|(t1, _)| *t1 >= t);
        let fit = (is_within && around.len() > 3 && plain[k].is_finite())
            .then(|| normal.lu().solve(&nalgebra::Vector3::from(y)))
            .flatten();
        fit.map_or(plain[k], |fit| fit[0])
    };
    (0..points).map(at).collect()
}

/// Linear between readings; not-a-number in gaps.
fn on_grid(track: &[(f64, f64)], points: usize) -> Vec<f64> {
    let mut after = 0;
    let at = |k: usize| {
        let t = k as f64 * STEP_S;
        while after < track.len() && track[after].0 < t {
            after += 1;
        }
        let before = after.checked_sub(1).map(|before| track[before]);
        match (before, track.get(after)) {
            (Some((t0, a)), Some((t1, b))) if t1 - t0 <= LONGEST_GAP_S => {
                if *t1 > t0 {
                    a + (b - a) * (t - t0) / (t1 - t0)
                } else {
                    a
                }
            }
            (None, Some((t1, b))) if t1 - t <= 0.05 => *b,
            (Some((t0, a)), None) if t - t0 <= 0.05 => a,
            _ => f64::NAN,
        }
    };
    (0..points).map(at).collect()
}
