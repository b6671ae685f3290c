//! A car's trajectory beside a recording: it predicts each reading, and is corrected.

use super::algebra::{Column, FILTERED, Gain, dot};
use super::car::{
    BODY_STATES, Before, Compute, ExtendedCar, Inputs, Instant, LEAST_MPS, Moved, Passed, State,
};
use super::drive::GriddedDrive;
use super::grid::{STEP_S, points};
use super::noise::{Live, Noise};
use super::sums::Comparison;
use physics::model::effect::{Readings, Recorded};

/// Readings may be so many grid points late. Physical: beyond the bound of `sensor_delay`.
const LATEST: usize = points(0.64);

/// The last rows of readings.
#[derive(Clone, Debug)]
struct Rows {
    rows: Vec<Readings>,
    newest: usize,
}

impl Rows {
    fn filled(row: &Readings) -> Self {
        Self { rows: vec![*row; LATEST], newest: 0 }
    }

    fn push(&mut self, row: &Readings) {
        self.newest = (self.newest + 1) % LATEST;
        self.rows[self.newest] = *row;
    }

    /// So many rows before the newest.
    fn ago(&self, channel: usize, rows: usize) -> f64 {
        self.rows[(self.newest + LATEST - rows) % LATEST][channel]
    }
}

/// A car on its way.
#[derive(Clone, Debug)]
pub(super) struct Trajectory {
    /// Where it is.
    pub(super) state: State,
    /// What was a moment ago.
    pub(super) before: Before,
    rows: Rows,
    /// The inputs there: the end of one step is the beginning of the next.
    input: Recorded,
    /// The step from here.
    step: Step,
    /// Has the end of the step before told it? Then no other instant has to be computed for it.
    is_told: bool,
}

/// A step, as its beginning tells it.
#[derive(Clone, Debug)]
pub(super) struct Step {
    /// Its beginning.
    pub(super) first: Instant,
    passed: Passed,
    /// The state at its end.
    pub(super) next: State,
}

impl Step {
    /// By the midpoint rule, from nothing but where a car is.
    fn begin(car: &ExtendedCar, t: f64, state: State, before: &Before, inputs: &Inputs) -> Self {
        let (input, rate) = (&inputs.at[0], inputs.steering_rate);
        let first = car.instant(t, &state, input, rate, before, Compute::Readings);
        let next = car.step_in_parts(&state, &first, t, STEP_S, inputs);
        Self { first, passed: Passed { state, at: state, rate: first.rate }, next }
    }
}

/// What the equations say of a step's end.
pub(super) struct Predicted {
    pub(super) end: Instant,
    /// The inputs at its beginning and its end.
    pub(super) inputs: [Recorded; 2],
    /// How fast the steering wheel turns over the step, rad/s.
    pub(super) steering_rate: f64,
}

/// Derivatives of rates and readings by the filtered states.
#[derive(Clone, Copy, Debug)]
pub(super) struct Derivatives {
    pub(super) rates: [Column; BODY_STATES],
    pub(super) readings: [Readings; FILTERED],
}

/// What the readings of a step change of its end: the filtered states, and to first order what follows from them.
pub(super) struct Correction<'a> {
    pub(super) by: &'a Column,
    pub(super) derivatives: &'a Derivatives,
    /// So many states are filtered.
    pub(super) states: usize,
}

impl Trajectory {
    /// Where a run begins: as fast, and turning as fast, as was measured.
    pub(super) fn start(car: &ExtendedCar, drive: &GriddedDrive, k: usize) -> Self {
        let t = k as f64 * STEP_S;
        let [input, middle, last] = [0.0, 0.5, 1.0].map(|share| car.input(drive, t + share * STEP_S));
        let state = car.rolling(t, drive.speed[k], drive.yaw_rate_after(k), &input);
        let before = Before::default();
        let step = Step::begin(car, t, state, &before, &Inputs::new([input, middle, last], STEP_S));
        Self { state, before, rows: Rows::filled(&step.first.readings), input, step, is_told: true }
    }

    /// The step from where it is, as [`Self::predict`] has found it.
    pub(super) fn step(&self) -> &Step {
        &self.step
    }

    /// What the equations say of the step from a grid point. One instant is computed, at its end; where the beginning is not known
    /// from the step before, or something is too fast for that ([`ExtendedCar::pass`]), those of the midpoint rule besides.
    pub(super) fn predict(
        &mut self,
        car: &ExtendedCar,
        drive: &GriddedDrive,
        k: usize,
        live: &[Live],
    ) -> Predicted {
        let t = k as f64 * STEP_S;
        let inputs = [self.input, car.input(drive, t + STEP_S)];
        let [first, last] = inputs;
        self.input = last;
        let steering_rate = (last.steering_wheel - first.steering_wheel) / STEP_S;
        if !self.is_told {
            let inputs = Inputs::new([first, car.input(drive, t + 0.5 * STEP_S), last], STEP_S);
            self.step = Step::begin(car, t, self.state, &self.before, &inputs);
        }
        let Step { first, next, .. } = &mut self.step;
        for (value, live) in next.live.iter_mut().zip(live) {
            *value *= live.keeps();
        }
        let before = first.before();
        let end = car.instant(t + STEP_S, next, &last, steering_rate, &before, Compute::Readings);
        self.rows.push(&first.readings);
        Predicted { end, inputs, steering_rate }
    }

    /// What a sensor says in the step.
    pub(super) fn reading(
        &self,
        car: &ExtendedCar,
        predicted: &Predicted,
        channel: usize,
        share: f64,
    ) -> f64 {
        // Grid points before the step's end, the newest that there is.
        let back = (1.0 - share + car.delay(channel) / STEP_S).min((LATEST - 3) as f64);
        let whole = back.max(0.0) as usize;
        let x = back - whole as f64;
        let at = |back: usize| match back.checked_sub(1) {
            Some(rows) => self.rows.ago(channel, rows),
            None => predicted.end.readings[channel],
        };
        let [a, b, c] = [whole, whole + 1, whole + 2].map(at);
        // The parabola through three.
        a + x * (b - a) + 0.5 * x * (x - 1.0) * (c - 2.0 * b + a)
    }

    /// Goes to the end of a step.
    pub(super) fn finish(
        &mut self,
        car: &ExtendedCar,
        predicted: &Predicted,
        correction: Option<&Correction<'_>>,
    ) {
        self.before = predicted.end.before();
        let Step { first: here, passed, next } = &mut self.step;
        *here = predicted.end;
        let mut moved = Moved::NOTHING;
        if let Some(Correction { by, derivatives, states }) = correction {
            moved.body.copy_from_slice(&by[..BODY_STATES]);
            moved.rate = derivatives.rates.each_ref().map(|row| dot(row, by, *states));
            for (live, by) in next.live.iter_mut().zip(&by[BODY_STATES..]) {
                *live += by;
            }
            for (by, derivatives) in by.iter().zip(&derivatives.readings).take(*states) {
                for (reading, derivative) in here.readings.iter_mut().zip(derivatives) {
                    *reading += by * derivative;
                }
            }
        }
        self.is_told = car.can_pass(next.body[0], STEP_S) && !car.follows_steering();
        if self.is_told {
            car.pass(passed, next, &here.rate, &moved, STEP_S);
            self.state = passed.state;
        } else {
            self.state = *next;
            self.state.body.iter_mut().zip(moved.body).for_each(|(value, by)| *value += by);
        }
        self.state.body[0] = self.state.body[0].max(LEAST_MPS);
    }
}

impl Trajectory {
    /// Forgets estimated courses but the first `keeps`.
    pub(super) fn forget_courses(&mut self, keeps: usize) {
        self.state.live[keeps..].fill(0.0);
        self.is_told = false;
    }

    /// Takes the speed from the wheels.
    pub(super) fn set_speed(&mut self, drive: &GriddedDrive, k: usize) {
        let around = |by: isize| k.checked_add_signed(by).and_then(|k| drive.speed.get(k)).copied();
        let near = points(0.1) as isize;
        let (Some(before), Some(after)) = (around(-near), around(near)) else { return };
        if before.is_finite() && after.is_finite() {
            self.state.body[0] = 0.5 * (before + after);
            self.state.live[0] = (after - before) / (2.0 * near as f64 * STEP_S);
            self.is_told = false;
        }
    }

    /// One step without any correction.
    pub(super) fn run_free(
        &mut self,
        car: &ExtendedCar,
        drive: &GriddedDrive,
        k: usize,
        compared: &mut Vec<Comparison>,
    ) {
        let predicted = self.predict(car, drive, k, &[]);
        for reading in drive.of_step(k).1 {
            let channel = usize::from(reading.channel);
            let simulated = self.reading(car, &predicted, channel, f64::from(reading.share));
            let t = (k as f64 + f64::from(reading.share)) * STEP_S;
            compared.push(Comparison { t, channel: reading.channel, measured: reading.value, simulated });
        }
        self.finish(car, &predicted, None);
    }

    pub(super) fn follow(
        &mut self,
        car: &ExtendedCar,
        drive: &GriddedDrive,
        k: usize,
        noise: &Noise,
        (gains, derivatives): (&[Gain], &Derivatives),
        errors: &mut Vec<f64>,
    ) {
        let predicted = self.predict(car, drive, k, &noise.live);
        let mut correction = [0.0; FILTERED];
        let (_, measured) = drive.of_step(k);
        let n = BODY_STATES + noise.live.len();
        for reading in measured {
            let channel = usize::from(reading.channel);
            if !noise.sensor[channel].is_finite() {
                continue;
            }
            let gain = &gains[errors.len()];
            let says = self.reading(car, &predicted, channel, f64::from(reading.share));
            let error = reading.value - says - dot(&gain.c, &correction, n);
            for (i, correction) in correction.iter_mut().enumerate().take(n) {
                *correction += gain.k[i] * error;
            }
            errors.push(error);
        }
        self.finish(car, &predicted, Some(&Correction { by: &correction, derivatives, states: n }));
    }
}

#[cfg(test)]
mod tests {
    use super::super::car::{Settings, Torque};
    use super::super::delay::Delays;
    use super::super::drive::Recording;
    use super::*;
    use identify::Values;
    use physics::model::Scenario;

    /// GIVEN a drive that steers, brakes and accelerates WHEN a car goes along with one instant for each step, and with those of the
    /// midpoint rule, a measurement moving both THEN they are at the same places.
    #[test]
    fn one_instant_for_a_step_is_enough() {
        let scenario = Scenario::parse(include_str!("../../tests/data/steered.toml")).unwrap();
        let drive = GriddedDrive::new(&Recording::simulated("", &scenario).unwrap(), &scenario.vehicle);
        let car = ExtendedCar::new(Settings {
            vehicle: &scenario.vehicle,
            values: &Values::of(&scenario.vehicle),
            torque: Torque::Recorded,
            bend_along: 1.0,
            delays: Delays::default(),
            effects: Vec::new(),
        });
        let (from, to) = drive.runs[0];
        let mut quick = Trajectory::start(&car, &drive, from);
        let mut thorough = quick.clone();
        // What moves the rates of a car that goes straight, about: the yaw rate dies out in a fifth of a second.
        let mut rates = [[0.0; FILTERED]; BODY_STATES];
        rates[2][2] = -5.0;
        let derivatives = Derivatives { rates, readings: [[0.0; physics::Quantity::COUNT]; FILTERED] };
        let mut by = [0.0; FILTERED];
        let (mut most, mut apart) = ([0.0_f64; BODY_STATES], [0.0_f64; BODY_STATES]);
        for k in from..to {
            by[2] = 2e-4 * (k as f64).sin();
            let correction = Correction { by: &by, derivatives: &derivatives, states: BODY_STATES };
            for trajectory in [&mut quick, &mut thorough] {
                let predicted = trajectory.predict(&car, &drive, k, &[]);
                trajectory.finish(&car, &predicted, Some(&correction));
            }
            thorough.is_told = false;
            for i in 0..BODY_STATES {
                most[i] = most[i].max(thorough.state.body[i].abs());
                apart[i] = apart[i].max((quick.state.body[i] - thorough.state.body[i]).abs());
            }
        }
        assert!(most[2] > 0.1, "it turns: {most:?}");
        assert!(apart.iter().zip(most).all(|(apart, most)| *apart < 0.005 * most), "{apart:?} of {most:?}");
    }
}
