//! A steering angle that has stopped: its last value goes on, though the car turns otherwise.

use super::grid::STEP_S;
use super::speed::COMPARED_MPS;

/// A hand holds the wheel still for a while, s …
const LEAST_S: f64 = 1.0;

/// … or for longer, if that is usual, as with a sensor of coarse steps: so many times what all but a hundredth of its values
/// last.
const LEAST_OF_USUAL: f64 = 10.0;

/// By so much of its most the curvature changes meanwhile. With a held wheel it changes as the car understeers over its speed,
/// and less. Tuned by two laps of a GTI whose steering stops 2 and 3.5 s before the end.
const LEAST_CHANGE: f64 = 0.5;

/// Yaw rates that change by less may be a gyro's noise, rad/s.
const LEAST_YAW_RATE: f64 = 0.05;

/// Means over so many grid points are compared, 0.3 s.
const WINDOW: usize = 30;

/// Stretches, s, in which it has: of readings, beside yaw rate, rad/s, and speed, m/s, on a grid that begins at 0 s.
pub fn frozen(steering: &[(f64, f64)], yaw_rate: &[f64], speed: &[f64]) -> Vec<[f64; 2]> {
    let holds = holds(steering);
    let place = |t: f64| ((t / STEP_S).max(0.0) as usize).min(speed.len().saturating_sub(1));
    let moves = |hold: &&[f64; 2]| speed.get(place(hold[0])).is_some_and(|speed| *speed > COMPARED_MPS);
    let mut lengths: Vec<f64> = holds.iter().filter(moves).map(|[from, to]| to - from).collect();
    lengths.sort_by(f64::total_cmp);
    let usual = lengths.get(lengths.len() * 99 / 100).copied().unwrap_or(0.0);
    let least = LEAST_S.max(LEAST_OF_USUAL * usual);
    let turns_otherwise = |[from, to]: &[f64; 2]| {
        let (from, to) = (place(*from), place(*to).min(yaw_rate.len()));
        let mean = |values: &[f64]| values.iter().sum::<f64>() / values.len() as f64;
        let windows = (from..to.saturating_sub(WINDOW)).step_by(WINDOW).map(|i| i..i + WINDOW);
        let means = windows.map(|window| (mean(&yaw_rate[window.clone()]), mean(&speed[window])));
        let means: Vec<(f64, f64)> =
            means.filter(|(yaw_rate, speed)| yaw_rate.is_finite() && *speed > COMPARED_MPS).collect();
        let spread = |of: fn(&(f64, f64)) -> f64| {
            let [low, high] = means
                .iter()
                .map(of)
                .fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], it| [low.min(it), high.max(it)]);
            (high - low, low.abs().max(high.abs()))
        };
        let (by, most) = spread(|(yaw_rate, speed)| yaw_rate / speed);
        means.len() > 1 && by > LEAST_CHANGE * most && spread(|(yaw_rate, _)| *yaw_rate).0 > LEAST_YAW_RATE
    };
    holds.into_iter().filter(|[from, to]| to - from >= least).filter(turns_otherwise).collect()
}

/// Stretches of one and the same value, s.
fn holds(steering: &[(f64, f64)]) -> Vec<[f64; 2]> {
    let same = steering.chunk_by(|(_, one), (_, next)| one == next);
    same.filter_map(|same| Some([same.first()?.0, same.last()?.0])).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A slalom at 10 m/s for 20 s, its steering in steps of so much; from a moment on the steering stands still.
    fn slalom(step: f64, stops_s: f64, turns_on: bool) -> (Vec<(f64, f64)>, Vec<f64>, Vec<f64>) {
        let yaw_rate = |t: f64| 0.3 * (1.5 * if turns_on { t } else { t.min(stops_s) }).sin();
        let steering = |i: usize| {
            let t = i as f64 * STEP_S;
            (t, (4.0 * yaw_rate(t.min(stops_s)) / step).round() * step)
        };
        let grid = (0..2000).map(|i| yaw_rate(i as f64 * STEP_S)).collect();
        ((0..2000).map(steering).collect(), grid, vec![10.0; 2000])
    }

    #[test]
    fn what_stops_while_the_car_turns_is_found_and_a_held_wheel_is_none() {
        for step in [5e-4, 0.026] {
            let (steering, yaw_rate, speed) = slalom(step, 16.0, true);
            let found = frozen(&steering, &yaw_rate, &speed);
            assert!(matches!(found[..], [[from, to]] if (from - 16.0).abs() < 0.1 && to > 19.9), "{found:?}");
            let (steering, yaw_rate, speed) = slalom(step, 16.0, false);
            assert_eq!(frozen(&steering, &yaw_rate, &speed), Vec::<[f64; 2]>::new());
            let (steering, yaw_rate, speed) = slalom(step, 20.0, true);
            assert_eq!(frozen(&steering, &yaw_rate, &speed), Vec::<[f64; 2]>::new());
        }
    }

    #[test]
    fn what_cannot_be_judged_is_not_frozen() {
        assert!(frozen(&[], &[], &[]).is_empty());
        let (steering, yaw_rate, _) = slalom(5e-4, 16.0, true);
        assert!(frozen(&steering, &yaw_rate, &vec![1.0; 2000]).is_empty(), "a car that creeps");
        assert!(frozen(&steering, &vec![f64::NAN; 2000], &vec![10.0; 2000]).is_empty(), "no yaw rate");
    }
}
