//! A recording as the filter takes it: inputs on a grid, readings at their own times.

use std::sync::Arc;

use super::grid::{COMPARED, Measured, SLOWEST_MPS, SPEED, STEP_S, points};
use super::slide::{Slide, slides};
use super::smoothing::{on_grid, smooth_on_grid};
use super::work::Work;
use physics::model::effect::Recorded;
use physics::model::{Scenario, ScenarioError, Simulation, Vehicle};
use physics::time::Clock;
use physics::{Micros, Quantity, Wheel};

/// What was recorded of each quantity: times (s from the recording's start) and values, SI.
#[derive(Clone, Debug, Default)]
pub struct Recording {
    /// What it is called.
    pub name: String,
    /// When it begins: its seconds count from there, s as its stamps count, since 1970 where these are dates.
    pub begins_s: Option<f64>,
    /// What is computed with it is counted here.
    pub work: Work,
    /// One track for each quantity.
    pub tracks: [Vec<(f64, f64)>; Quantity::COUNT],
}

impl Recording {
    /// What the sensors of a simulated drive say.
    ///
    /// # Errors
    /// What is wrong with the scenario.
    pub fn simulated(name: &str, scenario: &Scenario) -> Result<Self, ScenarioError> {
        let mut recording = Self { name: name.to_owned(), ..Self::default() };
        let mut simulation = Simulation::new(scenario, scenario.seed)?;
        while let Some(tick) = simulation.next_tick() {
            for reading in tick.readings {
                recording.tracks[reading.quantity as usize].push((reading.time.seconds(), reading.value));
            }
        }
        Ok(recording)
    }

    /// Its two clocks.
    pub fn clock(&self) -> Clock {
        Clock::of(self.begins_s.map(Micros::from_seconds).unwrap_or_default())
    }

    /// Is there anything of a quantity?
    pub fn has(&self, quantity: Quantity) -> bool {
        self.tracks[quantity as usize].len() > 10
    }

    /// Time of the last reading, s.
    pub fn seconds(&self) -> f64 {
        self.tracks.iter().filter_map(|track| track.last()).map(|(t, _)| *t).fold(0.0, f64::max)
    }
}

/// Shorter runs say nothing, s. Tuned, no test on record.
const SHORTEST_RUN_S: f64 = 3.0;

/// Why a grid point is not used.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Why {
    /// The car stands, or is too slow.
    Slow,
    /// An input is missing.
    Unknown,
    /// Wheels come back from sliding.
    Sliding,
    /// What is left between two such is too short.
    Short,
}

/// A recording on a grid. Copies share what was recorded, and may go over other stretches of it.
#[derive(Clone, Debug)]
pub struct GriddedDrive {
    /// The recording's name.
    pub name: String,
    /// Inputs as recorded, at each grid point.
    pub inputs: Arc<Vec<Recorded>>,
    /// All readings in order of time.
    pub measured: Arc<Vec<Measured>>,
    /// Where each step's readings begin in `measured`; one more than there are steps.
    pub first: Arc<Vec<u32>>,
    /// Grid points from, to between which all inputs are there and the car is moving.
    pub runs: Vec<(usize, usize)>,
    /// Speed by the wheels at each grid point, m/s; where none is on the bus, the vehicle's.
    pub speed: Arc<Vec<f64>>,
    /// Are drive and brake torques known?
    pub knows_torque: bool,
    /// Where wheels slide.
    pub slides: Arc<Vec<Slide>>,
    /// Why grid points are in no run, one by one.
    pub unused: Arc<Vec<Why>>,
}

impl GriddedDrive {
    /// Of a recording of this vehicle.
    pub fn new(recording: &Recording, vehicle: &Vehicle) -> Self {
        let steps = (recording.seconds() / STEP_S).floor() as usize;
        let at = |quantity: Quantity| on_grid(&recording.tracks[quantity as usize], steps + 1);
        let input = |quantity: Quantity| smooth_on_grid(&recording.tracks[quantity as usize], steps + 1);
        let steering = input(Quantity::SteeringWheelAngle);
        // Who does not see the brakes does not know what slows the car down.
        let knows_torque = recording.has(Quantity::DriveTorque) && recording.has(Quantity::BrakePressure);
        let (torque, pressure) = (input(Quantity::DriveTorque), input(Quantity::BrakePressure));
        let radius = vehicle.wheel_radius_m.value;
        let wheels = Wheel::ALL.map(|wheel| at(Quantity::wheel_speed(wheel)));
        let has_wheels = Wheel::ALL.into_iter().any(|wheel| recording.has(Quantity::wheel_speed(wheel)));
        let vehicle_speed = at(SPEED);
        let speed = |k: usize| {
            if !has_wheels {
                return vehicle_speed[k];
            }
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
        for channel in COMPARED.into_iter().chain((!has_wheels).then_some(SPEED)) {
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
        let slides = slides(&measured, vehicle);
        measured.retain(|reading| !slides.iter().any(|slide| slide.spoils(reading)));
        let mut first = Vec::with_capacity(steps + 1);
        let mut place = 0;
        for step in 0..=steps {
            while place < measured.len() && (measured[place].step as usize) < step {
                place += 1;
            }
            first.push(place as u32);
        }
        let why_not = |k: usize| {
            let comes_back = || slides.iter().any(|slide| slide.comes_back(k as f64 * STEP_S));
            let is_known = steering[k].is_finite() && (!knows_torque || torque[k].is_finite());
            match () {
                () if !is_known || !speed[k].is_finite() => Some(Why::Unknown),
                () if speed[k] <= SLOWEST_MPS => Some(Why::Slow),
                () if comes_back() => Some(Why::Sliding),
                () => None,
            }
        };
        let mut runs = Vec::new();
        let mut unused = Vec::new();
        let mut begin = None;
        for k in 0..=steps + 1 {
            let why = if k <= steps { why_not(k) } else { None };
            let goes = k <= steps && why.is_none();
            unused.extend(why);
            match begin {
                None if goes => begin = Some(k),
                Some(from) if !goes => {
                    if (k - from) as f64 * STEP_S >= SHORTEST_RUN_S {
                        runs.push((from, k - 1));
                    } else {
                        unused.extend(std::iter::repeat_n(Why::Short, k - from));
                    }
                    begin = None;
                }
                _ => {}
            }
        }
        Self {
            name: recording.name.clone(),
            inputs: Arc::new(inputs),
            measured: Arc::new(measured),
            first: Arc::new(first),
            runs,
            speed: Arc::new(speed),
            knows_torque,
            slides: Arc::new(slides),
            unused: Arc::new(unused),
        }
    }

    /// The same recording, gone over only within these stretches (grid points from, to; in order, apart).
    pub fn within(&self, stretches: &[(usize, usize)]) -> Self {
        let shortest = points(SHORTEST_RUN_S);
        let of = |&(from, to): &(usize, usize)| {
            let cut = stretches.iter().map(move |&(begin, end)| (from.max(begin), to.min(end)));
            cut.filter(move |(from, to)| *to >= from + shortest)
        };
        let runs = self.runs.iter().flat_map(of).collect();
        Self { runs, ..self.clone() }
    }

    /// Seconds that are gone over.
    pub fn used_seconds(&self) -> f64 {
        self.runs.iter().map(|(from, to)| (to - from) as f64 * STEP_S).sum()
    }

    /// The readings of a step.
    pub fn of_step(&self, step: usize) -> (usize, &[Measured]) {
        let (from, to) = (self.first[step] as usize, self.first[step + 1] as usize);
        (from, &self.measured[from..to])
    }

    /// Speed by the wheels around a time, m/s; 0 where nobody knows.
    pub fn speed_at(&self, t: f64) -> f64 {
        let speed = self.speed.get((t / STEP_S).round() as usize).copied();
        speed.filter(|speed| speed.is_finite()).unwrap_or(0.0)
    }

    /// Mean of the measured yaw rate in the tenth of a second after a grid point, rad/s; 0 where nobody measured.
    pub fn yaw_rate_after(&self, k: usize) -> f64 {
        let to = (k + points(0.1)).min(self.first.len() - 1);
        let (from, to) = (self.first[k] as usize, self.first[to] as usize);
        let rates = self.measured[from..to].iter().filter(|m| m.channel == Quantity::YawRate as u8);
        let (sum, count) = rates.fold((0.0, 0.0), |(sum, count), m| (sum + m.value, count + 1.0));
        if count > 0.0 { sum / count } else { 0.0 }
    }

    /// The inputs that act at a time, s, where the steering's record is so late and torques act so late after
    /// theirs.
    pub fn acting(&self, t: f64, steering_delay: f64, torque_delay: f64) -> Recorded {
        let steering = self.around(t + steering_delay);
        let steering_wheel = steering.of(|input| input.steering_wheel);
        if !self.knows_torque {
            return Recorded { steering_wheel, drive_torque: 0.0, brake_pressure: 0.0 };
        }
        let torques = self.around(t - torque_delay);
        Recorded {
            steering_wheel,
            drive_torque: torques.of(|input| input.drive_torque),
            brake_pressure: torques.of(|input| input.brake_pressure),
        }
    }

    /// The inputs recorded around a time.
    #[inline]
    fn around(&self, t: f64) -> Around<'_> {
        let last = self.inputs.len() - 1;
        let place = (t / STEP_S).clamp(0.0, last as f64);
        let before = (place as usize).min(last.saturating_sub(1));
        let x = place - before as f64;
        let at = |k: usize| &self.inputs[k.min(last)];
        let inputs = [at(before.saturating_sub(1)), at(before), at(before + 1), at(before + 2)];
        // Catmull and Rom's cubic: through the grid points, slopes by their neighbours.
        let weights = [
            0.5 * x * (x * (2.0 - x) - 1.0),
            0.5 * (x * x * (3.0 * x - 5.0) + 2.0),
            0.5 * x * (x * (4.0 - 3.0 * x) + 1.0),
            0.5 * x * x * (x - 1.0),
        ];
        Around { inputs, weights }
    }

    /// Seconds from the recording's start to its end.
    pub fn seconds(&self) -> f64 {
        (self.inputs.len() - 1) as f64 * STEP_S
    }
}

/// Inputs at four grid points around a time, and what each of them weighs.
struct Around<'a> {
    inputs: [&'a Recorded; 4],
    weights: [f64; 4],
}

impl Around<'_> {
    #[inline]
    fn of(&self, value: impl Fn(&Recorded) -> f64) -> f64 {
        let [before, from, to, after] = self.inputs;
        let (before, from, to, after) = (value(before), value(from), value(to), value(after));
        let [a, b, c, d] = self.weights;
        let sum = before * a + from * b + to * c + after * d;
        if sum.is_finite() {
            return sum;
        }
        // Beside a gap the nearest neighbour must do.
        let or = |value: f64, other: f64| if value.is_finite() { value } else { other };
        let (from, to) = (or(from, to), or(to, from));
        let all = [or(before, from), from, to, or(after, to)];
        all.iter().zip(self.weights).map(|(value, weight)| value * weight).sum()
    }
}
