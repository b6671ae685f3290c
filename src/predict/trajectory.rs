//! A car's trajectory beside a recording: it predicts each reading, and is corrected.

use super::algebra::{Column, FILTERED, Gain, dot};
use super::car::{self, BODY_STATES, Before, ExtendedCar, Inputs, Instant, State};
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
    rows: Option<Rows>,
    /// The inputs at a grid point: the end of one step is the beginning of the next.
    reached: Option<(usize, Recorded)>,
}

/// What the equations say of a step.
pub(super) struct Predicted {
    /// Its beginning.
    pub(super) first: Instant,
    /// The state at its end.
    pub(super) next: State,
    /// Its end.
    pub(super) end: Instant,
    /// The inputs.
    pub(super) inputs: Inputs,
}

impl Trajectory {
    /// Where a run begins: as fast, and turning as fast, as was measured.
    pub(super) fn start(car: &ExtendedCar, drive: &GriddedDrive, k: usize) -> Self {
        let t = k as f64 * STEP_S;
        let input = car.input(drive, t);
        let state = car.rolling(t, drive.speed[k], drive.yaw_rate_after(k), &input);
        Self { state, before: Before::default(), rows: None, reached: None }
    }

    pub(super) fn predict(
        &mut self,
        car: &ExtendedCar,
        drive: &GriddedDrive,
        k: usize,
        live: &[Live],
    ) -> Predicted {
        let t = k as f64 * STEP_S;
        let first = self.reached.filter(|(reached, _)| *reached == k).map(|(_, input)| input);
        let first = first.unwrap_or_else(|| car.input(drive, t));
        let last = car.input(drive, t + STEP_S);
        self.reached = Some((k + 1, last));
        let inputs = Inputs::new([first, car.input(drive, t + 0.5 * STEP_S), last], STEP_S);
        let (at, rate) = (&inputs.at, inputs.steering_rate);
        let first = car.instant(t, &self.state, &at[0], rate, &self.before, car::Compute::Readings);
        let substeps = (car.fastest_rate(self.state.body[0]) * STEP_S / 0.8).ceil().clamp(1.0, 20.0);
        let mut next = self.state;
        if substeps == 1.0 {
            next = car.step(&next, &first, t, STEP_S, &inputs);
        } else {
            let h = STEP_S / substeps;
            for part in 0..substeps as usize {
                let share = |part: usize| part as f64 / substeps;
                let inputs = inputs.part(share(part), share(part + 1));
                let t = t + part as f64 * h;
                let here =
                    car.instant(t, &next, &inputs.at[0], rate, &first.before(), car::Compute::Readings);
                next = car.step(&next, &here, t, h, &inputs);
            }
        }
        for (value, live) in next.live.iter_mut().zip(live) {
            *value *= (-STEP_S / live.length_s).exp();
        }
        let end = car.instant(t + STEP_S, &next, &at[2], rate, &first.before(), car::Compute::Readings);
        match &mut self.rows {
            Some(rows) => rows.push(&first.readings),
            none => *none = Some(Rows::filled(&first.readings)),
        }
        Predicted { first, next, end, inputs }
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
        let at = |back: usize| match (back.checked_sub(1), &self.rows) {
            (Some(rows), Some(all)) => all.ago(channel, rows),
            (Some(_), None) => predicted.first.readings[channel],
            (None, _) => predicted.end.readings[channel],
        };
        let [a, b, c] = [whole, whole + 1, whole + 2].map(at);
        // The parabola through three.
        a + x * (b - a) + 0.5 * x * (x - 1.0) * (c - 2.0 * b + a)
    }

    pub(super) fn finish(&mut self, predicted: &Predicted, correction: &Column) {
        self.state = predicted.next;
        for (value, by) in self.state.body.iter_mut().zip(correction) {
            *value += by;
        }
        for (value, by) in self.state.live.iter_mut().zip(&correction[BODY_STATES..]) {
            *value += by;
        }
        self.state.body[0] = self.state.body[0].max(0.1);
        self.before = predicted.end.before();
    }
}

impl Trajectory {
    /// Forgets estimated courses but the first `keeps`.
    pub(super) fn forget_courses(&mut self, keeps: usize) {
        self.state.live[keeps..].fill(0.0);
    }

    /// Takes the speed from the wheels.
    pub(super) fn set_speed(&mut self, drive: &GriddedDrive, k: usize) {
        let around = |by: isize| k.checked_add_signed(by).and_then(|k| drive.speed.get(k)).copied();
        let near = points(0.1) as isize;
        let (Some(before), Some(after)) = (around(-near), around(near)) else { return };
        if before.is_finite() && after.is_finite() {
            self.state.body[0] = 0.5 * (before + after);
            self.state.live[0] = (after - before) / (2.0 * near as f64 * STEP_S);
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
        self.finish(&predicted, &[0.0; FILTERED]);
    }

    pub(super) fn follow(
        &mut self,
        car: &ExtendedCar,
        drive: &GriddedDrive,
        k: usize,
        noise: &Noise,
        gains: &[Gain],
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
        self.finish(&predicted, &correction);
    }
}
