//! A free run: from where the recording begins by speed and steering alone, without any look at what is measured.

use physics::Quantity;
use physics::model::effect::Recorded;

use super::grid::STEP_S;
use super::inputs::{FreeDrive, compared_mean};
use predict::ExtendedCar;
use predict::car::{Before, Compute, Inputs, Instant, Moved, Passed, State};

/// What a free run says at the grid points.
#[derive(Clone, Debug, Default)]
pub struct Predicted {
    /// rad/s.
    pub yaw_rate: Vec<f64>,
    /// As a mean, m/s².
    pub lateral: Vec<f64>,
    /// Lateral over longitudinal velocity, positive to the left: the tangent of the sideslip.
    pub tan_sideslip: Vec<f64>,
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

/// Runs a car freely along a drive, its wheels' speeds included if `ask` says so.
pub fn run(drive: &FreeDrive, car: &ExtendedCar, speed: SpeedSensing, ask: Compute) -> Predicted {
    let mut said = Predicted::with_room(drive.points());
    along(drive, car, speed, ask, |point| said.push(point, speed, ask));
    said.read(car, speed)
}

/// Where a car is, and what was a moment before.
#[derive(Clone, Copy)]
struct Moment {
    state: State,
    before: Before,
    /// The grid point before; none where the run begins.
    passed: Option<Passed>,
}

/// A free run of all readings that others can branch off from.
pub struct Track {
    /// Each grid point.
    path: Vec<Moment>,
    /// What it said there, not late yet.
    said: Predicted,
    /// So many states its effects have.
    own_states: usize,
}

impl Track {
    /// Of a car along a drive.
    pub fn of(drive: &FreeDrive, car: &ExtendedCar, speed: SpeedSensing) -> Self {
        let points = drive.points();
        let (path, said) = (Vec::with_capacity(points), Predicted::with_room(points));
        let mut track = Self { path, said, own_states: car.own_states() };
        along(drive, car, speed, Compute::Readings, |point| {
            track.path.push(*point.moment);
            track.said.push(point, speed, Compute::Readings);
        });
        track
    }

    /// What another car says that differs from this one between two moments only, s.
    pub fn branch(
        &self,
        drive: &FreeDrive,
        car: &ExtendedCar,
        speed: SpeedSensing,
        [from, to]: [f64; 2],
    ) -> Predicted {
        // States that this one has not are somewhere at that moment.
        if car.own_states() != self.own_states {
            return run(drive, car, speed, Compute::Readings);
        }
        let place = |t: f64| ((t - drive.from_s) / STEP_S).clamp(0.0, self.path.len() as f64);
        // A step looks half a step ahead.
        let (first, last) = (place(from).floor() as usize, place(to).ceil() as usize + 1);
        let first = first.saturating_sub(1);
        let mut said = self.said.until(first);
        if let Some(start) = self.path.get(first) {
            let branch = Along { drive, car, speed, ask: Compute::Readings };
            branch.run_from(first, *start, |point| {
                let i = said.yaw_rate.len();
                let is_back = i > last && point.state().is_near(&self.path[i].state);
                if !is_back {
                    said.push(point, speed, Compute::Readings);
                }
                !is_back
            });
        }
        said.extend_from(&self.said);
        said.read(car, speed)
    }
}

impl Predicted {
    fn with_room(points: usize) -> Self {
        let room = || Vec::with_capacity(points);
        Self { yaw_rate: room(), lateral: room(), tan_sideslip: room(), wheels: Default::default() }
    }

    /// What a car says now.
    fn push(&mut self, point: &Point<'_>, speed: SpeedSensing, ask: Compute) {
        let (state, now) = (point.state(), point.now);
        self.yaw_rate.push(now.readings[Quantity::YawRate as usize]);
        self.lateral.push(now.readings[Quantity::LateralAcceleration as usize]);
        self.tan_sideslip.push(state.body[1] / state.body[0]);
        if ask == Compute::Readings {
            for (reading, all) in now.readings.iter().zip(&mut self.wheels) {
                all.push(reading / speed.scale);
            }
        }
    }

    /// The first so many points.
    fn until(&self, points: usize) -> Self {
        let first = |values: &Vec<f64>| values[..points.min(values.len())].to_vec();
        Self {
            yaw_rate: first(&self.yaw_rate),
            lateral: first(&self.lateral),
            tan_sideslip: first(&self.tan_sideslip),
            wheels: self.wheels.each_ref().map(first),
        }
    }

    /// From where it ends as another one.
    fn extend_from(&mut self, other: &Self) {
        let rest = |own: &mut Vec<f64>, other: &Vec<f64>| own.extend_from_slice(&other[own.len()..]);
        rest(&mut self.yaw_rate, &other.yaw_rate);
        rest(&mut self.lateral, &other.lateral);
        rest(&mut self.tan_sideslip, &other.tan_sideslip);
        self.wheels.iter_mut().zip(&other.wheels).for_each(|(own, other)| rest(own, other));
    }

    /// As late as the sensors are, and the lateral acceleration as it is compared.
    fn read(mut self, car: &ExtendedCar, speed: SpeedSensing) -> Self {
        self.yaw_rate = later(self.yaw_rate, car.delay(Quantity::YawRate as usize));
        let lateral = later(self.lateral, car.delay(Quantity::LateralAcceleration as usize));
        self.lateral = compared_mean(&lateral);
        // They are what the speed was measured by.
        self.wheels = self.wheels.map(|wheel| later(wheel, speed.delay_s));
        self
    }
}

/// A grid point of a free run.
pub struct Point<'r> {
    /// Time, s from the recording's start.
    pub t: f64,
    /// Where the car is.
    moment: &'r Moment,
    /// What was steered, as it truly was.
    pub input: &'r Recorded,
    /// How fast that changes, rad/s.
    pub steering_rate: f64,
    /// Forces, accelerations and readings.
    pub now: &'r Instant,
}

impl Point<'_> {
    /// Where the car is.
    pub fn state(&self) -> &State {
        &self.moment.state
    }

    /// What was a moment ago.
    pub fn before(&self) -> &Before {
        &self.moment.before
    }
}

/// The free run itself; `visit` sees each grid point.
pub fn along(
    drive: &FreeDrive,
    car: &ExtendedCar,
    speed: SpeedSensing,
    ask: Compute,
    mut visit: impl FnMut(&Point<'_>),
) {
    let along = Along { drive, car, speed, ask };
    along.run_from(0, Moment { state: along.start(), before: Before::default(), passed: None }, |point| {
        visit(point);
        true
    });
}

/// Who runs where.
struct Along<'r> {
    drive: &'r FreeDrive,
    car: &'r ExtendedCar,
    speed: SpeedSensing,
    ask: Compute,
}

impl Along<'_> {
    /// Where the car begins.
    fn start(&self) -> State {
        let Self { drive, car, speed, .. } = self;
        let start = drive.time(0);
        let yaw_rate = drive.yaw_rate.iter().copied().find(|yaw_rate| yaw_rate.is_finite()).unwrap_or(0.0);
        let (first_speed, _) = drive.driven(start, speed.delay_s, speed.scale);
        let steered = drive.steered(car.steering_delay(), 0..1);
        car.rolling(start, first_speed, yaw_rate, &car.undo(start, recorded(steered[0])))
    }

    /// From a grid point on, as long as `visit` says so.
    fn run_from(&self, first: usize, mut moment: Moment, mut visit: impl FnMut(&Point<'_>) -> bool) {
        let Self { drive, car, speed, ask } = self;
        let steered = drive.steered(car.steering_delay(), first..drive.points());
        for i in first..drive.points() {
            let t = drive.time(i);
            let input = |part: usize| {
                car.undo(t + 0.5 * STEP_S * part as f64, recorded(steered[2 * (i - first) + part]))
            };
            let (from, to) = (input(0), input(2));
            let steering_rate = (to.steering_wheel - from.steering_wheel) / STEP_S;
            let (vx, ax) = drive.driven(t, speed.delay_s, speed.scale);
            (moment.state.body[0], moment.state.live[0]) = (vx, ax);
            let now = car.instant(t, &moment.state, &from, steering_rate, &moment.before, *ask);
            if !visit(&Point { t, moment: &moment, input: &from, steering_rate, now: &now }) {
                return;
            }
            moment.before = now.before();
            match &mut moment.passed {
                Some(passed) if car.can_pass(vx, STEP_S) => {
                    car.pass(passed, &mut moment.state, &now.rate, &Moved::NOTHING, STEP_S);
                }
                passed => {
                    *passed = Some(Passed { state: moment.state, at: moment.state, rate: now.rate });
                    let inputs = Inputs::new([from, input(1), to], STEP_S);
                    moment.state = car.step_in_parts(&moment.state, &now, t, STEP_S, &inputs);
                }
            }
        }
    }
}

fn recorded(steering_wheel: f64) -> Recorded {
    Recorded { steering_wheel, ..Recorded::default() }
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
