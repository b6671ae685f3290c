//! Sim2 over frequency and amplitude of the steering: how near the joint filter comes, and how near any
//! filter could.

use super::{SIM2, SimulatedDrive};
use physics::estimate::thesis::lateral_filter::bound::{Assumptions, stiffness_bound};
use physics::estimate::thesis::lateral_filter::model::Model;
use physics::estimate::thesis::lateral_filter::{LateralFilter, LateralFilterConfig, Noise};
use physics::estimate::{Car, Kinematics};
use physics::estimates::Estimate;
use physics::model::scenario::Piece;
use physics::model::tire::Tire;
use physics::model::{Scenario, Uncertain};

/// Amplitudes, rad at the front wheels: from none of the tires' limit to sliding in each bend.
pub const AMPLITUDES: [f64; 4] = [0.01, 0.02, 0.05, 0.1];
/// Frequencies, Hz.
pub const FREQUENCIES: [f64; 3] = [0.25, 0.5, 1.0];
/// Row just before the first change, five seconds after it, five seconds after the second.
pub const CHECKED: [usize; 3] = [9_999, 10_500, 15_500];
/// Rows from which stiffness and friction are others.
pub const CHANGES: [usize; 2] = [10_000, 15_000];

/// Seconds after the start and after each change that do not count for consistency: no filter foresees them.
const SETTLING_ROWS: usize = 100;
/// Rows of the windows whose mean NIS is judged.
const WINDOW: usize = 500;
/// 95 % of means of [`WINDOW`] squares of standard normal variables are within this of one.
const NIS_BOUND: f64 = 0.124;
/// What the user knows of the stiffness beforehand, 1/rad; the truth is 11.5.
const GUESS: Uncertain = Uncertain { value: 9.0, std: 3.0 };
/// Speed from which lateral motion is estimated, m/s.
const MINIMUM_SPEED: f64 = 4.0;

/// The joint filter on one drive.
#[derive(Clone, Debug, Default)]
pub struct Run {
    /// ln(estimate / truth) at [`CHECKED`], front and rear.
    pub errors: [[f64; 2]; 3],
    /// Mean NIS of yaw rate and lateral acceleration over the drive, what cannot be foreseen left out.
    pub nis: [f64; 2],
    /// Share of windows of 5 s whose mean NIS is within its 95 % bounds.
    pub within: f64,
    /// Seconds after each change from which both stiffnesses stay within 5 % until the next.
    pub settled_s: [f64; 2],
    /// Changes of surface noticed.
    pub changes: u32,
    /// Time and front stiffness with its standard deviation, ten a second.
    pub course: Vec<(f64, Estimate)>,
}

/// All drives of one amplitude and frequency.
#[derive(Clone, Debug)]
pub struct Cell {
    /// Amplitude, rad.
    pub amplitude: f64,
    /// Frequency, Hz.
    pub frequency: f64,
    /// One for each seed.
    pub runs: Vec<Run>,
    /// Cramér–Rao: the least relative standard deviation at [`CHECKED`], of the worse axle.
    pub bound: [f64; 3],
}

impl Cell {
    /// Drives seeds 1 to `seeds`.
    ///
    /// # Errors
    /// What is wrong with the scenario.
    pub fn drive(
        amplitude: f64,
        frequency: f64,
        seeds: u64,
        config: &LateralFilterConfig,
    ) -> Result<Self, String> {
        let mut runs = Vec::new();
        let mut bound = [0.0; 3];
        for seed in 1..=seeds {
            let drive = simulate(amplitude, frequency, seed)?;
            if seed == 1 {
                bound = self::bound(&drive, config);
            }
            runs.push(Run::of(&drive, config));
        }
        Ok(Self { amplitude, frequency, runs, bound })
    }

    /// Largest error of any drive and axle at a checked instant.
    pub fn worst(&self, check: usize) -> f64 {
        self.all(check).fold(0.0, |worst, error| error.abs().max(worst))
    }

    /// Root mean square error at a checked instant, of the worse axle.
    pub fn rms(&self, check: usize) -> f64 {
        let square = |axle: usize| self.runs.iter().map(|r| r.errors[check][axle].powi(2)).sum::<f64>();
        (square(0).max(square(1)) / self.runs.len() as f64).sqrt()
    }

    fn all(&self, check: usize) -> impl Iterator<Item = f64> {
        self.runs.iter().flat_map(move |run| run.errors[check])
    }
}

/// Sim2 with this steering.
///
/// # Errors
/// What is wrong with the scenario.
pub fn simulate(amplitude: f64, frequency: f64, seed: u64) -> Result<SimulatedDrive, String> {
    let mut scenario = Scenario::parse(SIM2).map_err(|e| e.to_string())?;
    scenario.steering_wheel_angle = vec![Piece::Sine {
        amplitude,
        frequency_hz: frequency,
        phase_rad: 0.0,
        offset: 0.0,
        from_s: 0.0,
        to_s: f64::INFINITY,
    }];
    let mut drive = SimulatedDrive::simulate(&scenario, seed)?;
    drive.vehicle.lateral_stiffness_front = GUESS;
    drive.vehicle.lateral_stiffness_rear = GUESS;
    Ok(drive)
}

fn bound(drive: &SimulatedDrive, config: &LateralFilterConfig) -> [f64; 3] {
    let car = Car::new(&drive.vehicle);
    let model = Model::new(&car, Tire::new(&drive.vehicle));
    let noise = Noise::promised(&car, &drive.sensors, config);
    let known = Assumptions::default();
    let step_s = drive.samples.first().map_or(0.01, |sample| sample.elapsed_s);
    let bounds =
        stiffness_bound(&drive.truth, step_s, &model, &noise, config, &known, |row| CHANGES.contains(&row));
    CHECKED.map(|row| bounds.get(row).map_or(f64::NAN, |b| b.stiffness[0].max(b.stiffness[1])))
}

impl Run {
    fn of(drive: &SimulatedDrive, config: &LateralFilterConfig) -> Self {
        let car = Car::new(&drive.vehicle);
        let tire = Tire::new(&drive.vehicle);
        let mut filter = LateralFilter::new(&car, tire, &drive.sensors, config, MINIMUM_SPEED);
        let mut run = Self::default();
        let mut nis = Consistency::default();
        for (row, (sample, truth)) in drive.samples.iter().zip(&drive.truth).enumerate() {
            filter.step(&Kinematics::new(sample, &car));
            let truths = [truth.cornering_front, truth.cornering_rear];
            // Not known is as wrong as can be.
            let errors = [0, 1].map(|axle| {
                filter.stiffness()[axle].map_or(f64::INFINITY, |c| (c.value / truths[axle]).ln())
            });
            if let Some(check) = CHECKED.iter().position(|checked| *checked == row) {
                run.errors[check] = errors;
            }
            if errors.iter().any(|error| error.abs() > 0.05) {
                let after = CHANGES.iter().rposition(|change| *change <= row);
                if let Some(after) = after {
                    run.settled_s[after] = (row + 1 - CHANGES[after]) as f64 * sample.elapsed_s;
                }
            }
            let foreseen =
                [0, CHANGES[0], CHANGES[1]].iter().all(|from| row < *from || row >= from + SETTLING_ROWS);
            if let Some([_, yaw, acceleration]) = filter.innovations().filter(|_| foreseen) {
                nis.add([yaw.nis(), acceleration.nis()]);
            }
            if row % 10 == 0
                && let Some(front) = filter.stiffness()[0]
            {
                run.course.push((truth.time.seconds(), front));
            }
        }
        (run.nis, run.within) = nis.result();
        run.changes = filter.changes();
        run
    }
}

/// Sums for the consistency.
#[derive(Default)]
struct Consistency {
    total: [f64; 2],
    count: usize,
    window: [f64; 2],
    windows: usize,
    within: usize,
}

impl Consistency {
    fn add(&mut self, nis: [f64; 2]) {
        for (i, value) in nis.into_iter().enumerate() {
            self.total[i] += value;
            self.window[i] += value;
        }
        self.count += 1;
        if self.count.is_multiple_of(WINDOW) {
            for sum in std::mem::take(&mut self.window) {
                self.windows += 1;
                self.within += usize::from((sum / WINDOW as f64 - 1.0).abs() <= NIS_BOUND);
            }
        }
    }

    fn result(&self) -> ([f64; 2], f64) {
        (self.total.map(|sum| sum / self.count as f64), self.within as f64 / self.windows as f64)
    }
}
