//! The extended Kalman filter that holds a car to a recording.

use super::algebra::{Column, FILTERED, Gain, Square, dot};
use super::car::{BODY_STATES, Compute, ExtendedCar, Instant, State};
use super::drive::GriddedDrive;
use super::grid::STEP_S;
use super::noise::{Live, Noise};
use super::sums::{BlockOutput, Filtered, Innovation, PassOptions};
use super::trajectory::{Correction, Derivatives, Trajectory};
use physics::Quantity;

/// Differences by which the filter linearizes, in the state's units.
/// Numerical: far above rounding, far below what bends the equations.
const DIFFERENCE: [f64; BODY_STATES] = [1e-3, 1e-3, 1e-4];

/// What is known of a start: measured speed and yaw rate, and that no car drifts much. Physical.
const START_STD: [f64; BODY_STATES] = [0.3, 0.5, 0.03];

/// A run in progress: state and covariance of the filter, and the cars beside it.
#[derive(Clone)]
pub(super) struct Filter {
    pub(super) trajectory: Trajectory,
    p: Square,
    n: usize,
    /// Derivatives of rates and readings by the state, where they were taken last, and how many steps ago.
    derivatives: Option<(Derivatives, usize)>,
}

impl Filter {
    /// Where a run begins, at a grid point.
    pub(super) fn new((car, drive, noise): (&ExtendedCar, &GriddedDrive, &Noise), k: usize) -> Self {
        let trajectory = Trajectory::start(car, drive, k);
        Self { trajectory, p: start_covariance(noise), n: BODY_STATES + noise.live.len(), derivatives: None }
    }

    /// One step: predicts, compares, corrects.
    pub(super) fn step(
        &mut self,
        (car, drive, noise): (&ExtendedCar, &GriddedDrive, &Noise),
        (k, begins): (usize, bool),
        out: &mut BlockOutput,
        options: &mut PassOptions<'_>,
    ) {
        let BlockOutput { gains, errors, derivatives: by_state, sums } = out;
        let n = self.n;
        let from = self.trajectory.state;
        let before = self.trajectory.before;
        let predicted = self.trajectory.predict(car, drive, k, &noise.live);
        let t = k as f64 * STEP_S;
        let (derivatives, age) = self.derivatives.take().unwrap_or_else(|| {
            let (input, rate) = (&predicted.inputs[0], predicted.steering_rate);
            let at = |state: &State| {
                let state = car.settled(t, state, input, &before);
                car.instant(t, &state, input, rate, &before, Compute::Readings)
            };
            (Derivatives::of(&from, &noise.live, None, at), 0)
        });
        let a = transition(&derivatives.rates, n, noise);
        let mut p = sandwich(&a, &self.p, n);
        for (i, diffusion) in noise.diffusion.iter().enumerate() {
            p[i][i] += diffusion * diffusion * STEP_S;
        }
        for (i, live) in noise.live.iter().enumerate() {
            let keeps = live.keeps();
            p[BODY_STATES + i][BODY_STATES + i] += live.size * live.size * (1.0 - keeps * keeps);
        }
        let next = &self.trajectory.step().next;
        let (p_before, x_before) = (p, column_of(next));
        // They change slowly, and serve this step's readings and the next ones' transitions.
        let derivatives = if age + 1 < SERVES {
            self.derivatives.insert((derivatives, age + 1))
        } else {
            let (input, rate) = (&predicted.inputs[1], predicted.steering_rate);
            let first = self.trajectory.step().first.before();
            let at = |state: &State| {
                let state = car.settled(t + STEP_S, state, input, &first);
                car.instant(t + STEP_S, &state, input, rate, &first, Compute::Readings)
            };
            // Where no effect has states of its own, that is what was predicted.
            let settled = car.settled(t + STEP_S, next, input, &first);
            let here = (settled == *next).then_some(predicted.end);
            self.derivatives.insert((Derivatives::of(next, &noise.live, here, at), 0))
        };
        let derivatives = &derivatives.0;
        by_state.push(*derivatives);
        let by = &derivatives.readings;
        let mut correction = [0.0; FILTERED];
        let (_, measured) = drive.of_step(k);
        for reading in measured {
            let channel = usize::from(reading.channel);
            let own_noise = noise.sensor[channel];
            let at = t + f64::from(reading.share) * STEP_S;
            if !own_noise.is_finite() || !options.readings.include(at) {
                continue;
            }
            let (mut c, mut pc): (Column, Column) = ([0.0; FILTERED], [0.0; FILTERED]);
            for (c, by) in c.iter_mut().zip(by) {
                *c = by[channel];
            }
            for (pc, row) in pc.iter_mut().zip(&p) {
                *pc = dot(row, &c, n);
            }
            let own = dot(&c, &pc, n);
            let slipping = predicted.end.slipping.get(channel).map_or(0.0, |by| noise.slip * by);
            let model = own + slipping * slipping;
            let s = model + own_noise * own_noise;
            let shift = dot(&c, &correction, n);
            let says = self.trajectory.reading(car, &predicted, channel, f64::from(reading.share));
            let error = reading.value - says - shift;
            let mut k_: Column = [0.0; FILTERED];
            for i in 0..n {
                k_[i] = pc[i] / s;
                for (j, pc) in pc.iter().enumerate().take(n) {
                    p[i][j] -= k_[i] * pc;
                }
                correction[i] += k_[i] * error;
            }
            gains.push(Gain { k: k_, c, s });
            errors.push(error);
            sums.log_s += s.ln();
            sums.square[channel] += error * error / s;
            sums.excess[channel] += error * error - model;
            sums.of[channel] += 1;
            if let Some(innovations) = &mut options.innovations {
                innovations.push(Innovation {
                    t: at,
                    channel: reading.channel,
                    value: reading.value,
                    error,
                    std: s.sqrt(),
                });
            }
        }
        make_symmetric(&mut p, n);
        self.p = p;
        let corrected = Correction { by: &correction, derivatives, states: n };
        self.trajectory.finish(car, &predicted, Some(&corrected));
        if let Some(steps) = &mut options.steps {
            let filtered = (column_of(&self.trajectory.state), p);
            steps.push(Filtered { k: k + 1, begins, a, predicted: (x_before, p_before), filtered });
        }
    }
}

fn start_covariance(noise: &Noise) -> Square {
    let mut p = [[0.0; FILTERED]; FILTERED];
    for (i, std) in START_STD.iter().enumerate() {
        p[i][i] = std * std;
    }
    for (i, live) in noise.live.iter().enumerate() {
        p[BODY_STATES + i][BODY_STATES + i] = live.size * live.size;
    }
    p
}

/// Steps that derivatives serve. Numerical: they change slowly.
const SERVES: usize = 2;

impl Derivatives {
    /// By differences from what is `here`, if that is known.
    fn of(state: &State, live: &[Live], here: Option<Instant>, at: impl Fn(&State) -> Instant) -> Self {
        let here = here.unwrap_or_else(|| at(state));
        let mut rates = [[0.0; FILTERED]; BODY_STATES];
        let mut readings = [[0.0; Quantity::COUNT]; FILTERED];
        for column in 0..BODY_STATES + live.len() {
            let mut moved = *state;
            let difference = match column.checked_sub(BODY_STATES) {
                None => {
                    moved.body[column] += DIFFERENCE[column];
                    DIFFERENCE[column]
                }
                Some(place) => {
                    moved.live[place] += live[place].difference;
                    live[place].difference
                }
            };
            let there = at(&moved);
            let by = 1.0 / difference;
            for (row, rates) in rates.iter_mut().enumerate() {
                rates[column] = (there.rate.body[row] - here.rate.body[row]) * by;
            }
            for (channel, reading) in readings[column].iter_mut().enumerate() {
                *reading = (there.readings[channel] - here.readings[channel]) * by;
            }
        }
        Self { rates, readings }
    }
}

/// Rounding must not grow into a covariance that is none.
fn make_symmetric(p: &mut Square, n: usize) {
    for (i, j) in (0..n).flat_map(|i| (0..i).map(move |j| (i, j))) {
        let mean = 0.5 * (p[i][j] + p[j][i]);
        p[i][j] = mean;
        p[j][i] = mean;
    }
}

fn column_of(state: &State) -> Column {
    std::array::from_fn(|i| match i.checked_sub(BODY_STATES) {
        None => state.body[i],
        Some(live) => state.live[live],
    })
}

/// exp(J h) to second order; courses decay on their own.
fn transition(j: &[Column; BODY_STATES], n: usize, noise: &Noise) -> Square {
    let mut a = [[0.0; FILTERED]; FILTERED];
    for (i, own) in j.iter().enumerate() {
        for k in 0..n {
            let mut square = 0.0;
            for (by, row) in own.iter().zip(j) {
                square += by * row[k];
            }
            a[i][k] = STEP_S * own[k] + 0.5 * STEP_S * STEP_S * square;
        }
        a[i][i] += 1.0;
    }
    for (i, live) in noise.live.iter().enumerate() {
        a[BODY_STATES + i][BODY_STATES + i] = live.keeps();
    }
    a
}

/// A P Aᵀ.
fn sandwich(a: &Square, p: &Square, n: usize) -> Square {
    let mut ap = [[0.0; FILTERED]; FILTERED];
    for (ap, a) in ap.iter_mut().zip(a).take(n) {
        // Row by row: neighbours in memory are neighbours in the loop.
        for (a, p) in a.iter().zip(p).take(n) {
            for (ap, p) in ap.iter_mut().zip(p) {
                *ap += a * p;
            }
        }
    }
    let mut out = [[0.0; FILTERED]; FILTERED];
    for (out, ap) in out.iter_mut().zip(&ap).take(n) {
        for (out, a) in out.iter_mut().zip(a).take(n) {
            *out = dot(ap, a, n);
        }
    }
    out
}
