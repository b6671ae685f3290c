//! A drive with every lateral velocity of the thesis, and where on it the tires slide.

use std::ops::Range;

use super::ours::{self, Ours};
use crate::report::{Color, Span};
use crate::reproduce::SimulatedDrive;
use physics::estimate::thesis::{KinematicObserver, LateralVelocityEstimator, SlipAngles};
use physics::estimate::{Car, Kinematics};
use physics::estimates::LateralVelocities;
use physics::model::scenario::Piece;
use physics::model::{Scenario, Truth};

/// Below this speed nothing is estimated, m/s; the drives stay above it.
pub(super) const MINIMUM_SPEED: f64 = 4.0;
/// The steering that App. B leaves open, as methods.md §9 fixes it: Hz and rad.
pub(super) const AS_FIXED: (f64, f64) = (0.5, 0.1);
/// A steering that leaves the tires in their linear range.
pub(super) const GENTLE: (f64, f64) = (0.5, 0.01);
/// Filters have settled, stiffness is what it always was.
pub(super) const WHOLE: Range<f64> = 20.0..100.0;
/// Stiffness and friction are halved in Sim2.
pub(super) const HALVED: Range<f64> = 100.0..150.0;
/// Normalized cornering stiffness, 1/rad, of App. A.
pub(super) const STIFFNESS: f64 = 11.5;

/// A scenario of App. B with a steering sine of this frequency (Hz) and amplitude (rad).
pub(super) fn scenario(text: &str, (frequency_hz, amplitude): (f64, f64)) -> Result<Scenario, String> {
    let mut scenario = Scenario::parse(text).map_err(|error| error.to_string())?;
    let (phase_rad, offset, from_s, to_s) = (0.0, 0.0, 0.0, f64::INFINITY);
    scenario.steering_wheel_angle =
        vec![Piece::Sine { amplitude, frequency_hz, phase_rad, offset, from_s, to_s }];
    Ok(scenario)
}

/// One sample, its truth and what the methods make of it.
#[derive(Clone, Debug)]
pub(super) struct Point {
    /// Time, s.
    pub(super) t: f64,
    /// As measured.
    pub(super) now: Kinematics,
    /// As it is.
    pub(super) truth: Truth,
    /// Zero and methods 1–3; `joint` is ours.
    pub(super) velocities: LateralVelocities,
    /// Method 2 told the true a_x, −v_y r included, m/s.
    pub(super) kinematic_true_ax: f64,
    /// Method 2 with the longitudinal accelerometer, m/s; none without one.
    pub(super) kinematic_accelerometer: Option<f64>,
    /// Slip angles by each velocity.
    pub(super) slip_angles: SlipAngles,
    /// How long no tire has been sliding, s.
    pub(super) grip_s: f64,
    /// Our filter.
    pub(super) ours: Ours,
}

/// A drive and all of its points.
#[derive(Clone, Debug)]
pub(super) struct LateralDrive {
    /// The drive.
    pub(super) drive: SimulatedDrive,
    /// The car as the estimators see it.
    pub(super) car: Car,
    /// In order of time.
    pub(super) points: Vec<Point>,
}

/// A tire uses so much of its friction: it slides.
const SLIDES_FROM: f64 = 0.98;

fn slides(truth: &Truth) -> bool {
    (0..4).any(|i| truth.fx[i].hypot(truth.fy[i]) > SLIDES_FROM * truth.friction[i] * truth.fz[i])
}

impl LateralDrive {
    /// Drives `scenario` and runs the methods. The period is 10 ms.
    pub(super) fn run(scenario: &Scenario, seed: u64) -> Result<Self, String> {
        let drive = SimulatedDrive::simulate(scenario, seed)?;
        let car = Car::new(&drive.vehicle);
        let ours = ours::over(&drive);
        let mut methods = LateralVelocityEstimator::new(&car, &drive.sensors, MINIMUM_SPEED);
        let mut told = KinematicObserver::new(&drive.sensors);
        let mut measuring = KinematicObserver::new(&drive.sensors);
        let mut grip_s = 0.0;
        let mut points = Vec::with_capacity(drive.samples.len());
        for ((sample, truth), ours) in drive.samples.iter().zip(&drive.truth).zip(ours) {
            let now = Kinematics::new(sample, &car);
            let Some(cornering) = now.cornering(MINIMUM_SPEED) else { continue };
            let mut velocities = methods.step(&now);
            velocities.joint = ours.lateral_velocity;
            let observe = |observer: &mut KinematicObserver, ax: f64| {
                let acceleration = [ax, cornering.lateral_acceleration];
                observer.step(cornering.speed, cornering.yaw_rate, acceleration, now.elapsed_s)
            };
            grip_s = if slides(truth) { 0.0 } else { grip_s + now.elapsed_s };
            points.push(Point {
                t: truth.time.seconds(),
                truth: *truth,
                velocities,
                kinematic_true_ax: observe(&mut told, truth.longitudinal_acceleration),
                kinematic_accelerometer: now.longitudinal_acceleration.map(|ax| observe(&mut measuring, ax)),
                slip_angles: SlipAngles::new(&velocities, &now, &car),
                now,
                grip_s,
                ours,
            });
        }
        Ok(Self { drive, car, points })
    }

    /// Points within a time, s.
    pub(super) fn during(&self, time: Range<f64>) -> impl Iterator<Item = &Point> {
        self.points.iter().filter(move |point| time.contains(&point.t))
    }

    /// Root mean square of what `value` gives; not a number where it gives nothing.
    pub(super) fn rms(&self, time: Range<f64>, value: impl Fn(&Point) -> Option<f64>) -> f64 {
        rms(self.during(time).filter_map(value))
    }

    /// … of the error of a lateral velocity, m/s.
    pub(super) fn error(&self, time: Range<f64>, vy: impl Fn(&Point) -> Option<f64>) -> f64 {
        self.rms(time, |point| Some(vy(point)? - point.truth.lateral_velocity))
    }

    /// … of the true lateral velocity, m/s.
    pub(super) fn lateral_velocity(&self, time: Range<f64>) -> f64 {
        self.rms(time, |point| Some(point.truth.lateral_velocity))
    }

    /// Share of a time in which a tire slides.
    pub(super) fn sliding(&self, time: Range<f64>) -> f64 {
        let (mut count, mut sliding) = (0.0, 0.0);
        for point in self.during(time) {
            count += 1.0;
            sliding += f64::from(u8::from(point.grip_s == 0.0));
        }
        sliding / count
    }

    /// Lowest and highest speed, m/s.
    pub(super) fn speeds(&self) -> (f64, f64) {
        let speeds = self.points.iter().map(|point| point.truth.longitudinal_velocity);
        speeds.fold((f64::INFINITY, 0.0), |(low, high), speed| (speed.min(low), speed.max(high)))
    }

    /// A line for a plot.
    pub(super) fn line(&self, value: impl Fn(&Point) -> Option<f64>) -> impl Iterator<Item = (f64, f64)> {
        self.points.iter().map(move |point| (point.t, value(point).unwrap_or(f64::NAN)))
    }

    /// The true lateral velocity for a plot.
    pub(super) fn truth(&self) -> impl Iterator<Item = (f64, f64)> {
        self.line(|point| Some(point.truth.lateral_velocity))
    }
}

/// Root mean square; not a number of nothing.
pub(super) fn rms(values: impl Iterator<Item = f64>) -> f64 {
    let (count, sum) = values.fold((0.0, 0.0), |(count, sum), value| (count + 1.0, sum + value * value));
    (sum / count).sqrt()
}

/// Arithmetic mean; not a number of nothing.
pub(super) fn mean(values: impl Iterator<Item = f64>) -> f64 {
    let (count, sum) = values.fold((0.0, 0.0), |(count, sum), value| (count + 1.0, sum + value));
    sum / count
}

/// Sim2's halved phase in the background.
pub(super) fn halved() -> [Span; 1] {
    [Span { x: HALVED, label: "stiffness and friction halved".into(), color: Color::Surface(1) }]
}
