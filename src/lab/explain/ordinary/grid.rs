//! Values on a uniform grid: from readings, between its points, as means and slopes.

/// Seconds between grid points. Numerical.
pub const STEP_S: f64 = 0.01;

/// At a gap of more seconds nothing is known between two readings. Numerical: some messages of a slow bus.
const GAP_S: f64 = 0.5;

/// The value on the grid that begins at 0 s, interpolated.
pub fn at(grid: &[f64], t: f64) -> f64 {
    let place = (t / STEP_S).clamp(0.0, (grid.len() - 1) as f64);
    let before = (place as usize).min(grid.len().saturating_sub(2));
    grid[before] + (place - before as f64) * (grid[(before + 1).min(grid.len() - 1)] - grid[before])
}

/// A track on the grid from a time on; not a number in gaps.
pub fn resampled(track: &[(f64, f64)], from_s: f64, points: usize) -> Vec<f64> {
    resampled_every(STEP_S, track, from_s, points)
}

/// The same on a grid of other steps, s.
pub fn resampled_every(step_s: f64, track: &[(f64, f64)], from_s: f64, points: usize) -> Vec<f64> {
    let mut cursor = 1;
    let value = |i: usize| {
        let (value, gap) = interpolated(track, &mut cursor, from_s + i as f64 * step_s);
        if gap > GAP_S { f64::NAN } else { value }
    };
    (0..points).map(value).collect()
}

/// The value of a track at a time, and how far apart the readings are that it is between. Beyond the ends the last one
/// stays. The times that are asked for only grow.
pub fn interpolated(track: &[(f64, f64)], cursor: &mut usize, t: f64) -> (f64, f64) {
    if track.len() < 2 {
        return (f64::NAN, f64::INFINITY);
    }
    while *cursor + 1 < track.len() && track[*cursor].0 < t {
        *cursor += 1;
    }
    let ((t0, a), (t1, b)) = (track[*cursor - 1], track[*cursor]);
    let beyond = (t - t1).max(t0 - t).max(0.0);
    let share = if t1 > t0 { ((t - t0) / (t1 - t0)).clamp(0.0, 1.0) } else { 1.0 };
    (a + share * (b - a), (t1 - t0).max(beyond))
}

/// Gaps filled by a straight line.
pub fn filled(mut values: Vec<f64>) -> Vec<f64> {
    let known: Vec<(f64, f64)> =
        values.iter().enumerate().filter(|(_, v)| v.is_finite()).map(|(i, v)| (i as f64, *v)).collect();
    let mut cursor = 1;
    for (i, value) in values.iter_mut().enumerate() {
        if !value.is_finite() {
            *value = interpolated(&known, &mut cursor, i as f64).0;
        }
    }
    values
}

/// Mean over so many points around each; over fewer at the ends.
pub fn mean(values: &[f64], points: usize) -> Vec<f64> {
    let (back, ahead) = (points / 2, points.div_ceil(2));
    let around = |i: usize| &values[i.saturating_sub(back)..(i + ahead).min(values.len())];
    (0..values.len()).map(|i| around(i).iter().sum::<f64>() / around(i).len() as f64).collect()
}

/// Central differences, per second.
pub fn slope(values: &[f64]) -> Vec<f64> {
    let last = values.len() - 1;
    let of = |i: usize| {
        let (from, to) = (i.saturating_sub(1), (i + 1).min(last));
        (values[to] - values[from]) / ((to - from).max(1) as f64 * STEP_S)
    };
    (0..values.len()).map(of).collect()
}
