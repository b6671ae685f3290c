//! What is left of the error that repeats: the part that inputs and motion predict on driving that was held out.
//!
//! Missing physics is a function of what the car does, a disturbance is not. So the residuals of the training blocks are
//! regressed on features of inputs and simulated motion, and the regression predicts those of the held-out blocks. The
//! null is the same with decoys: the features of another time of the same drive.

use nalgebra::{DMatrix, DVector};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use super::grid::STEP_S;
use super::inputs::FreeDrive;
use super::robust::deviation;
use super::run::Predicted;
use crate::explain::play::lost_in_play;

/// Share of the held-out squared error that inputs and motion predict.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Remaining {
    /// As found, 0 to 1.
    pub share: f64,
    /// The 95 % quantile of the decoys.
    pub null: f64,
    /// The largest of the decoys.
    pub most_of_null: f64,
}

impl Remaining {
    /// Is it far more than any decoy predicts, by a quarter of what that leaves? Of a true drift or jump decoys predict as much.
    /// Tuned by play in the steering (0.82 beside 0.23) and drifts of it (0.71 beside 0.70) in the concealed recordings.
    pub fn repeats_clearly(&self) -> bool {
        self.share - self.most_of_null > LEAST_SHARE * (1.0 - self.most_of_null)
    }

    /// Does something repeat? Beyond every decoy (at most one in a hundred by chance), and enough to matter.
    pub fn repeats(&self) -> bool {
        self.share > self.most_of_null && self.share > LEAST_SHARE
    }
}

/// Less of what is left is not worth a verdict, whatever its significance. Tuned: a law that no library has leaves 0.9 in
/// `shared/trials/unknown`, calm drives of a real car up to 0.17.
const LEAST_SHARE: f64 = 0.25;

/// Rows are means over so many grid points: 0.1 s.
const POINTS: usize = 10;

/// Decoys. Statistical: the largest of a hundred is passed once in a hundred times.
const DECOYS: usize = 100;

/// Decoys are shifted by at least so many seconds: what is left of a manoeuvre's memory then is nothing. Of short drives
/// by a quarter.
const SHIFT_S: f64 = 10.0;

/// Fewer rows, 20 s of driving, tell nothing of what repeats.
const LEAST_ROWS: usize = 200;

/// Ridge, as a share of the features' own variance: so many features of one drive are never all independent.
const RIDGE: f64 = 0.03;

/// Residuals beyond so many robust deviations are outliers.
const OUTLIER: f64 = 5.0;

/// Time constants of the features' memories, s: tires, suspension and driver, heat.
const MEMORIES_S: [f64; 3] = [0.3, 1.0, 8.0];

/// What swings on a car after its lateral acceleration, hardly damped: frequencies, rad/s, of loads and liquids (a tank's first
/// sloshing mode, a trailer's). Physical.
const SWINGS_RAD_PER_S: [f64; 4] = [2.2, 3.2, 4.5, 6.5];

/// … and its damping ratio. Physical: wider than a tank's, so that a few frequencies are enough.
const SWING_DAMPING: f64 = 0.1;

/// Plays that are asked for, at the steering wheel, rad. Numerical: what lies between is like one of the two, a tight steering
/// has less.
const PLAYS_RAD: [f64; 2] = [0.03, 0.1];

/// Where what is cut off at a limit may bend, as shares of the largest value.
const LIMITS: [f64; 2] = [0.5, 0.75];

/// One drive's rows.
struct Rows {
    features: DMatrix<f64>,
    residual: Vec<f64>,
    held: Vec<bool>,
}

/// Of the residuals of one channel; none where there are too few.
pub fn remaining(
    drives: &[FreeDrive],
    predicted: &[Predicted],
    residual: impl Fn(&FreeDrive, &Predicted, usize) -> f64,
    seed: u64,
) -> Option<Remaining> {
    let mut all: Vec<Rows> =
        drives.iter().zip(predicted).map(|(drive, own)| rows(drive, own, &residual)).collect();
    all.retain(|rows| rows.residual.len() >= LEAST_ROWS);
    limit(&mut all);
    let none = vec![0; all.len()];
    let share = held_out_share(&all, &none)?;
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let mut decoys: Vec<f64> = (0..DECOYS)
        .filter_map(|_| {
            let shifts: Vec<usize> = all
                .iter()
                .map(|rows| {
                    let count = rows.residual.len();
                    let least = ((SHIFT_S / (POINTS as f64 * STEP_S)) as usize).min(count / 4);
                    random.random_range(least..count - least)
                })
                .collect();
            held_out_share(&all, &shifts)
        })
        .collect();
    decoys.sort_by(f64::total_cmp);
    let null = decoys.get(decoys.len() * 95 / 100).copied()?;
    let most = decoys.last().copied()?;
    Some(Remaining { share: share.max(0.0), null: null.max(0.0), most_of_null: most.max(0.0) })
}

/// Means of features and residuals.
fn rows(
    drive: &FreeDrive,
    predicted: &Predicted,
    residual: &impl Fn(&FreeDrive, &Predicted, usize) -> f64,
) -> Rows {
    let steered = drive.steered(0.0, 0..drive.points());
    let mean = |of: &dyn Fn(usize) -> f64, row: usize| {
        let points = row * POINTS..(row + 1) * POINTS;
        points.map(of).sum::<f64>() / POINTS as f64
    };
    let count = drive.points() / POINTS;
    let mut base = Vec::with_capacity(count);
    for row in 0..count {
        let driven = |i: usize| drive.driven(drive.time(i), 0.0, 1.0);
        base.push([
            mean(&|i| steered[2 * i], row),
            mean(&|i| predicted.yaw_rate[i], row),
            mean(&|i| predicted.lateral[i], row),
            mean(&|i| predicted.tan_sideslip[i].atan(), row),
            mean(&|i| driven(i).1, row),
            mean(&|i| driven(i).0, row),
        ]);
    }
    let features = features(&base);
    let (mut kept, mut residuals, mut held) = (Vec::new(), Vec::new(), Vec::new());
    for row in 0..count {
        let points = row * POINTS..(row + 1) * POINTS;
        let error = mean(&|i| residual(drive, predicted, i), row);
        if error.is_finite() && points.clone().all(|i| drive.counts[i]) {
            kept.push(row);
            residuals.push(error);
            held.push(drive.held[row * POINTS]);
        }
    }
    let features = DMatrix::from_fn(kept.len(), features.ncols(), |i, j| features[(kept[i], j)]);
    Rows { features, residual: residuals, held }
}

/// Inputs and motion, their products, signs, rates and memories; what play in the steering and limits of sensors would do.
fn features(base: &[[f64; 6]]) -> DMatrix<f64> {
    let step = POINTS as f64 * STEP_S;
    let rate = |row: usize, of: usize| {
        let before = base[row.saturating_sub(1)][of];
        (base[row][of] - before) / step
    };
    let mut memories = vec![[[0.0; 4]; MEMORIES_S.len()]; base.len()];
    for row in 1..base.len() {
        let [steering, _, ay, _, ax, _] = base[row];
        for (memory, seconds) in MEMORIES_S.iter().enumerate() {
            for (place, value) in [steering, ay, ay * ay, ax].into_iter().enumerate() {
                let before = memories[row - 1][memory][place];
                memories[row][memory][place] = before + step / (step + seconds) * (value - before);
            }
        }
    }
    let swings = SWINGS_RAD_PER_S.map(|frequency| swing(base.iter().map(|row| row[2]), frequency, step));
    let plays = PLAYS_RAD.map(|width| lost_in_play(base.iter().map(|row| row[0]), width));
    let most = |of: usize| base.iter().map(|row| row[of].abs()).fold(0.0, f64::max);
    let (most_yaw, most_ay) = (most(1), most(2));
    let of = |row: usize| -> Vec<f64> {
        let [steering, yaw, ay, slip, ax, v] = base[row];
        let mut all = vec![1.0, steering, yaw, ay, slip, ax, v, v * v];
        all.extend([steering * v, yaw * v, ay * v, slip * v, steering / v.max(2.0), ay * ay, ay.abs() * ay]);
        all.extend([ay.powi(3), slip * slip.abs(), steering * ax, yaw * ax, ay * ax, ax.min(0.0), ax * ax]);
        all.extend([steering * steering.abs(), rate(row, 0), rate(row, 1), rate(row, 2), rate(row, 4)]);
        all.extend(memories[row].iter().flatten());
        all.extend(swings.iter().flat_map(|swing| swing[row]));
        all.extend(plays.iter().flat_map(|lost| [lost[row], lost[row] * v]));
        all.extend(
            LIMITS.iter().flat_map(|limit| [beyond(yaw, limit * most_yaw), beyond(ay, limit * most_ay)]),
        );
        all
    };
    let rows: Vec<Vec<f64>> = (0..base.len()).map(of).collect();
    let columns = rows.first().map_or(0, Vec::len);
    DMatrix::from_fn(rows.len(), columns, |i, j| rows[i][j])
}

/// Displacement and velocity of what swings, both in units of the displacement at rest, driven by these values.
fn swing(driving: impl Iterator<Item = f64>, frequency: f64, step: f64) -> Vec<[f64; 2]> {
    // Each value holds for a step, in which the state turns about it and decays.
    let decay = (-SWING_DAMPING * frequency * step).exp();
    let (sin, cos) = (frequency * (1.0 - SWING_DAMPING * SWING_DAMPING).sqrt() * step).sin_cos();
    let mut state = [0.0; 2];
    let next = |value| {
        let [x, v] = [state[0] - value, state[1]];
        state = [value + decay * (cos * x + sin * v), decay * (cos * v - sin * x)];
        state
    };
    driving.map(next).collect()
}

/// What is beyond a limit, with its sign.
fn beyond(value: f64, limit: f64) -> f64 {
    value - value.clamp(-limit, limit)
}

/// Cuts outliers.
fn limit(all: &mut [Rows]) {
    let errors = all.iter().flat_map(|rows| &rows.residual).copied();
    let Some(most) = deviation(errors).map(|deviation| OUTLIER * deviation) else { return };
    for error in all.iter_mut().flat_map(|rows| &mut rows.residual) {
        *error = error.clamp(-most, most);
    }
}

/// 1 − Σ (e − ê)²/Σ e² of the held-out rows, the features of each drive shifted by so many rows.
fn held_out_share(all: &[Rows], shifts: &[usize]) -> Option<f64> {
    let count = all.first()?.features.ncols();
    let at = |rows: &Rows, shift: usize, row: usize| (row + shift) % rows.residual.len();
    let (mut sum, mut square, mut n) = (vec![0.0; count], vec![0.0; count], 0.0);
    for (rows, shift) in all.iter().zip(shifts) {
        for row in (0..rows.residual.len()).filter(|row| !rows.held[*row]) {
            for j in 0..count {
                let value = rows.features[(at(rows, *shift, row), j)];
                sum[j] += value;
                square[j] += value * value;
            }
            n += 1.0;
        }
    }
    let center: Vec<f64> = sum.iter().map(|sum| sum / f64::max(n, 1.0)).collect();
    let size = |j: usize| f64::sqrt((square[j] / f64::max(n, 1.0) - center[j] * center[j]).max(0.0));
    let sizes: Vec<f64> = (0..count).map(size).collect();
    let scaled = |rows: &Rows, shift: usize, row: usize| {
        DVector::from_fn(count, |j, _| {
            let value = rows.features[(at(rows, shift, row), j)];
            // The constant has no spread.
            if sizes[j] > 1e-9 { ((value - center[j]) / sizes[j]).clamp(-4.0, 4.0) } else { 1.0 }
        })
    };
    let mut information = DMatrix::<f64>::identity(count, count) * (RIDGE * n);
    let mut gradient = DVector::<f64>::zeros(count);
    for (rows, shift) in all.iter().zip(shifts) {
        for row in (0..rows.residual.len()).filter(|row| !rows.held[*row]) {
            let x = scaled(rows, *shift, row);
            gradient.axpy(rows.residual[row], &x, 1.0);
            information.ger(1.0, &x, &x, 1.0);
        }
    }
    let weights = information.cholesky()?.solve(&gradient);
    let (mut before, mut after) = (0.0, 0.0);
    for (rows, shift) in all.iter().zip(shifts) {
        for row in (0..rows.residual.len()).filter(|row| rows.held[*row]) {
            let error = rows.residual[row];
            before += error * error;
            after += (error - weights.dot(&scaled(rows, *shift, row))).powi(2);
        }
    }
    (before > 0.0).then(|| 1.0 - after / before)
}

#[cfg(test)]
mod tests {
    use super::super::super::bench::recorded;
    use super::super::inputs::Held;
    use super::*;

    /// A drive, and a run that says what was measured but for this.
    fn found(error: impl Fn(&FreeDrive, &Predicted, usize) -> f64) -> Remaining {
        let (vehicle, recording) = recorded("");
        let drive = FreeDrive::new(&recording, &vehicle, Held::EveryThird, 600.0).unwrap();
        let predicted = Predicted {
            yaw_rate: drive.yaw_rate.clone(),
            lateral: drive.lateral.clone().unwrap(),
            tan_sideslip: vec![0.0; drive.points()],
            wheels: Default::default(),
        };
        remaining(&[drive], &[predicted], error, 1).unwrap()
    }

    /// Coloured noise, of no input.
    fn road(points: usize) -> Vec<f64> {
        let mut random = ChaCha8Rng::seed_from_u64(7);
        let mut value = 0.0;
        let next = |_| {
            value += 0.03 * (0.5 - random.random::<f64>() - 0.2 * value);
            value
        };
        (0..points).map(next).collect()
    }

    #[test]
    fn what_follows_from_the_motion_repeats_and_noise_of_any_colour_does_not() {
        let road = road(100_000);
        let noise = found(|_, _, i| road[i]);
        assert!(!noise.repeats(), "{noise:?}");
        let physics = found(|_, own, i| 0.005 * own.lateral[i] * own.lateral[i].abs() + 0.2 * road[i]);
        assert!(physics.repeats() && physics.share > 0.4, "{physics:?}");
    }

    /// GIVEN a load that swings after the lateral acceleration, at a frequency between those asked for THEN what it leaves repeats.
    #[test]
    fn what_swings_repeats() {
        let road = road(100_000);
        let swings = std::cell::OnceCell::new();
        let found = found(|_, own, i| {
            let all = swings.get_or_init(|| swing(own.lateral.iter().copied(), 3.8, STEP_S));
            0.05 * all[i][0] + 0.05 * road[i]
        });
        assert!(found.repeats_clearly(), "{found:?}");
    }

    /// GIVEN a steady value THEN what swings after it has come to rest there, and at first turns at its frequency.
    #[test]
    fn what_swings_is_an_oscillator() {
        let all = swing(std::iter::repeat_n(2.0, 20_000), 3.0, STEP_S);
        let [end, moving] = all[all.len() - 1];
        assert!((end - 2.0).abs() < 1e-6 && moving.abs() < 1e-6, "{end} {moving}");
        let passes = |range: std::ops::Range<usize>| {
            all[range].windows(2).filter(|w| w[0][0] < 2.0 && w[1][0] >= 2.0).count()
        };
        // 3 rad/s are 4.8 turns in 10 s.
        assert_eq!(passes(0..(10.0 / STEP_S) as usize), 5);
    }

    /// GIVEN 4° of play at the steering wheel, and an accelerometer that ends at 2 m/s² THEN what they leave repeats.
    #[test]
    fn what_play_and_limits_do_repeats() {
        let road = road(100_000);
        let steered = std::cell::OnceCell::new();
        let play = found(|drive, _, i| {
            let lost = steered.get_or_init(|| {
                lost_in_play(drive.steered(0.0, 0..drive.points()).into_iter().step_by(2), 0.07)
            });
            lost[i] + 0.05 * road[i]
        });
        assert!(play.repeats_clearly(), "{play:?}");
        let limit = found(|_, own, i| 0.3 * beyond(own.lateral[i], 2.0) + 0.05 * road[i]);
        assert!(limit.repeats_clearly(), "{limit:?}");
    }
}
