//! A free run: from where the recording begins by speed and steering alone, without any look at what is measured.

use physics::Quantity;
use physics::model::effect::Recorded;

use super::inputs::{FreeDrive, STEP_S, compared_mean};
use crate::explain::predict::ExtendedCar;
use crate::explain::predict::car::{Before, Compute, Inputs, Instant, State};

/// What a free run says at the grid points.
#[derive(Clone, Debug, Default)]
pub struct Predicted {
    /// rad/s.
    pub yaw_rate: Vec<f64>,
    /// As a mean, m/s².
    pub lateral: Vec<f64>,
    /// rad, positive to the left.
    pub sideslip: Vec<f64>,
    /// Wheel speeds, rad/s, if they were asked for.
    pub wheels: [Vec<f64>; 4],
}

/// How the speed was measured.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SpeedSensing {
    /// How late, s.
    pub delay_s: f64,
    /// True speed / recorded speed.
    pub scale: f64,
}

/// So far the step's fastest rate may go; more needs smaller steps. Numerical: stable with the midpoint rule.
const LARGEST_STEP: f64 = 0.8;

/// Substeps are at most so many. Numerical.
const MOST_SUBSTEPS: f64 = 8.0;

/// Runs a car freely along a drive, its wheels' speeds included if `ask` says so.
pub fn run(drive: &FreeDrive, car: &ExtendedCar, speed: SpeedSensing, ask: Compute) -> Predicted {
    let points = drive.points();
    let mut predicted = Predicted {
        yaw_rate: Vec::with_capacity(points),
        lateral: Vec::with_capacity(points),
        sideslip: Vec::with_capacity(points),
        wheels: Default::default(),
    };
    along(drive, car, speed, ask, |point| {
        let now = point.now;
        predicted.yaw_rate.push(now.readings[Quantity::YawRate as usize]);
        predicted.lateral.push(now.readings[Quantity::LateralAcceleration as usize]);
        predicted.sideslip.push(point.state.body[1].atan2(point.state.body[0]));
        if ask == Compute::Readings {
            for (wheel, all) in predicted.wheels.iter_mut().enumerate() {
                all.push(now.readings[wheel] / speed.scale);
            }
        }
    });
    predicted.yaw_rate = later(predicted.yaw_rate, car.delay(Quantity::YawRate as usize));
    let lateral = later(predicted.lateral, car.delay(Quantity::LateralAcceleration as usize));
    predicted.lateral = compared_mean(&lateral);
    // They are what the speed was measured by.
    predicted.wheels = predicted.wheels.map(|wheel| later(wheel, speed.delay_s));
    predicted
}

/// A grid point of a free run.
pub struct Point<'r> {
    /// Time, s from the recording's start.
    pub t: f64,
    /// Where the car is.
    pub state: &'r State,
    /// What was steered, as it truly was.
    pub input: &'r Recorded,
    /// How fast that changes, rad/s.
    pub steering_rate: f64,
    /// What was a moment ago.
    pub before: &'r Before,
    /// Forces, accelerations and readings.
    pub now: &'r Instant,
}

/// The free run itself; `visit` sees each grid point.
pub fn along(
    drive: &FreeDrive,
    car: &ExtendedCar,
    speed: SpeedSensing,
    ask: Compute,
    mut visit: impl FnMut(&Point<'_>),
) {
    let steered = drive.steered(car.steering_delay());
    let recorded = |i: usize| Recorded { steering_wheel: steered[i], ..Recorded::default() };
    let start = drive.time(0);
    let yaw_rate = drive.yaw_rate.iter().copied().find(|yaw_rate| yaw_rate.is_finite()).unwrap_or(0.0);
    let (first_speed, _) = drive.driven(start, speed.delay_s, speed.scale);
    let mut state = car.rolling(start, first_speed, yaw_rate, &car.undo(start, recorded(0)));
    let mut before = Before::default();
    for i in 0..drive.points() {
        let t = drive.time(i);
        let at = [0, 1, 2].map(|part| {
            let t = t + 0.5 * STEP_S * part as f64;
            car.undo(t, recorded(2 * i + part))
        });
        let inputs = Inputs::new(at, STEP_S);
        let (vx, ax) = drive.driven(t, speed.delay_s, speed.scale);
        (state.body[0], state.live[0]) = (vx, ax);
        let now = car.instant(t, &state, &at[0], inputs.steering_rate, &before, ask);
        let steering_rate = inputs.steering_rate;
        visit(&Point { t, state: &state, input: &at[0], steering_rate, before: &before, now: &now });
        let substeps = (car.fastest_rate(vx) * STEP_S / LARGEST_STEP).ceil().clamp(1.0, MOST_SUBSTEPS);
        let h = STEP_S / substeps;
        for part in 0..substeps as usize {
            let share = |part: usize| part as f64 / substeps;
            let inputs = if substeps == 1.0 { inputs } else { inputs.part(share(part), share(part + 1)) };
            let t = t + part as f64 * h;
            let here = if part == 0 {
                now
            } else {
                car.instant(t, &state, &inputs.at[0], inputs.steering_rate, &now.before(), Compute::Rates)
            };
            state = car.step(&state, &here, t, h, &inputs);
        }
        before = now.before();
    }
}

/// What a sensor that is so late says, s.
pub fn later(values: Vec<f64>, delay_s: f64) -> Vec<f64> {
    let by = delay_s / STEP_S;
    if by == 0.0 || values.is_empty() {
        return values;
    }
    let last = values.len() - 1;
    let at = |i: usize| {
        let place = (i as f64 - by).clamp(0.0, last as f64);
        let before = place as usize;
        values[before] + (place - before as f64) * (values[(before + 1).min(last)] - values[before])
    };
    (0..values.len()).map(at).collect()
}
