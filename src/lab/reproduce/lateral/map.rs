//! Every result over the frequency and the amplitude of steering (methods.md §9).

use std::sync::OnceLock;
use std::thread;

use super::course::{HALVED, LateralDrive, WHOLE, scenario};
use super::ekf::{self, Track, WALKS};
use super::regression::{self, Source};
use crate::report::{Color, Plot};
use crate::reproduce::SIM2;

/// Steering frequencies, Hz.
pub(super) const FREQUENCIES: [f64; 5] = [0.05, 0.1, 0.25, 0.5, 1.0];
/// Steering amplitudes, rad.
pub(super) const AMPLITUDES: [f64; 4] = [0.01, 0.02, 0.05, 0.1];
/// Colours of the amplitudes' lines.
const COLORS: [Color; 4] = [Color::First, Color::Second, Color::Third, Color::Notice];

/// Sim2 with one steering. Pairs are: before 100 s, while halved.
#[derive(Clone, Debug)]
pub(super) struct Cell {
    /// Steering frequency, Hz.
    pub(super) frequency: f64,
    /// Steering amplitude, rad.
    pub(super) amplitude: f64,
    /// Lowest and highest speed, m/s.
    pub(super) speeds: (f64, f64),
    /// Share of the time in which a tire slides.
    pub(super) sliding: [f64; 2],
    /// True lateral velocity, m/s rms.
    pub(super) vy: [f64; 2],
    /// Error of method 2, of method 2 with the true a_x, of method 3, of ours, m/s rms.
    pub(super) errors: [[f64; 4]; 2],
    /// Regression with the true v_y, and with method 3's.
    pub(super) slopes: [Track; 2],
    /// The EKF with each of [`WALKS`].
    pub(super) ekf: [Track; 3],
    /// Our stiffness.
    pub(super) ours: Track,
}

impl Cell {
    fn new(frequency: f64, amplitude: f64) -> Result<Self, String> {
        let scenario = scenario(SIM2, (frequency, amplitude))?;
        let course = LateralDrive::run(&scenario, scenario.seed)?;
        let phases = [WHOLE, HALVED];
        let errors = phases.clone().map(|phase| {
            [
                course.error(phase.clone(), |p| p.velocities.kinematic),
                course.error(phase.clone(), |p| Some(p.kinematic_true_ax)),
                course.error(phase.clone(), |p| p.velocities.bicycle),
                course.error(phase.clone(), |p| p.velocities.joint),
            ]
        });
        let slopes = [Source::Truth, Source::Bicycle].map(|source| {
            let slopes = regression::over(&course, source);
            Track::new(slopes.iter().copied())
        });
        let ekf = WALKS.map(|walk| {
            let points = ekf::over(&course, walk, |point| point.now);
            Track::new(points.iter().map(|point| (point.t, point.stiffness)))
        });
        let ours = course.points.iter().map(|p| (p.t, p.ours.mean_stiffness().unwrap_or(f64::NAN)));
        Ok(Self {
            frequency,
            amplitude,
            speeds: course.speeds(),
            sliding: phases.clone().map(|phase| course.sliding(phase)),
            vy: phases.map(|phase| course.lateral_velocity(phase)),
            errors,
            slopes,
            ekf,
            ours: Track::new(ours),
        })
    }

    /// No tire slides, neither before nor while halved.
    pub(super) fn grips(&self) -> bool {
        self.sliding == [0.0; 2]
    }
}

/// All cells, amplitude by amplitude. Driven once, whoever asks first.
pub(super) fn cells() -> Result<&'static [Cell], String> {
    static CELLS: OnceLock<Result<Vec<Cell>, String>> = OnceLock::new();
    CELLS.get_or_init(drive).as_deref().map_err(Clone::clone)
}

fn drive() -> Result<Vec<Cell>, String> {
    let steering: Vec<_> = AMPLITUDES
        .iter()
        .flat_map(|amplitude| FREQUENCIES.map(|frequency| (frequency, *amplitude)))
        .collect();
    let workers = thread::available_parallelism().map_or(1, usize::from);
    let share = steering.len().div_ceil(workers);
    thread::scope(|scope| {
        let parts: Vec<_> = steering
            .chunks(share)
            .map(|part| {
                scope.spawn(|| part.iter().map(|(f, a)| Cell::new(*f, *a)).collect::<Result<Vec<_>, _>>())
            })
            .collect();
        let mut cells = Vec::with_capacity(steering.len());
        for part in parts {
            cells.extend(part.join().map_err(|_| "a drive of the map failed")??);
        }
        Ok(cells)
    })
}

/// Cells for which `is` holds, e.g. `0.01 rad at 0.5, 1 Hz; 0.1 rad at 1 Hz`.
pub(super) fn names(cells: &[Cell], is: impl Fn(&Cell) -> bool) -> String {
    let row = |amplitude: &f64| {
        let row = cells.iter().filter(|cell| cell.amplitude == *amplitude && is(cell));
        let frequencies: Vec<_> = row.map(|cell| cell.frequency.to_string()).collect();
        (!frequencies.is_empty()).then(|| format!("{amplitude} rad at {} Hz", frequencies.join(", ")))
    };
    let rows: Vec<_> = AMPLITUDES.iter().filter_map(row).collect();
    if rows.is_empty() { "nowhere".into() } else { rows.join("; ") }
}

/// Least and greatest of a number over the cells.
pub(super) fn range<'a>(cells: impl Iterator<Item = &'a Cell>, value: impl Fn(&Cell) -> f64) -> (f64, f64) {
    cells.map(value).fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), x| (low.min(x), high.max(x)))
}

/// A number over frequency, a line for each amplitude.
pub(super) fn plot(
    title: &str,
    label: &str,
    cells: &[Cell],
    top: f64,
    value: impl Fn(&Cell) -> f64 + Copy,
) -> Plot {
    let plot = Plot::new(title, label, 0.0..1.05, 0.0..top).x_label("steering frequency, Hz");
    AMPLITUDES.iter().zip(COLORS).fold(plot, |plot, (amplitude, color)| {
        let row = cells.iter().filter(|cell| cell.amplitude == *amplitude);
        plot.line(&format!("{amplitude} rad"), color, row.map(|cell| (cell.frequency, value(cell))))
    })
}
