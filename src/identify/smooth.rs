//! Means and slopes around each row, not-a-numbers left out.

/// Mean of the values within `half` rows.
pub(super) fn centred_mean(values: &[f64], half: usize) -> Vec<f64> {
    let mut sums = Vec::with_capacity(values.len() + 1);
    let (mut sum, mut count) = (0.0, 0_u32);
    sums.push((sum, count));
    for value in values {
        if value.is_finite() {
            sum += value;
            count += 1;
        }
        sums.push((sum, count));
    }
    let mean = |place: usize| {
        let (from, to) = (place.saturating_sub(half), (place + half + 1).min(values.len()));
        let (sum, count) = (sums[to].0 - sums[from].0, sums[to].1 - sums[from].1);
        // None within: not-a-number, as is 0/0.
        sum / f64::from(count)
    };
    (0..values.len()).map(mean).collect()
}

/// Slope of the least-squares line through the values within `half` rows, per second.
pub(super) fn centred_slope(values: &[f64], half: usize, period_s: f64) -> Vec<f64> {
    let slope = |place: usize| {
        let (from, to) = (place.saturating_sub(half), (place + half + 1).min(values.len()));
        let points = values[from..to].iter().enumerate().filter(|(_, y)| y.is_finite());
        let points: Vec<(f64, f64)> = points.map(|(x, y)| (x as f64 * period_s, *y)).collect();
        let count = points.len() as f64;
        let mean_x = points.iter().map(|p| p.0).sum::<f64>() / count;
        let mean_y = points.iter().map(|p| p.1).sum::<f64>() / count;
        let spread: f64 = points.iter().map(|p| (p.0 - mean_x).powi(2)).sum();
        let common: f64 = points.iter().map(|p| (p.0 - mean_x) * (p.1 - mean_y)).sum();
        if spread > 0.0 { common / spread } else { f64::NAN }
    };
    (0..values.len()).map(slope).collect()
}

/// The middle one; reorders them.
pub(super) fn median(values: &mut [f64]) -> Option<f64> {
    let middle = values.len().checked_sub(1)? / 2;
    let (_, median, _) = values.select_nth_unstable_by(middle, f64::total_cmp);
    Some(*median)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_line_stays_a_line_and_gaps_do_not_spread() {
        let line: Vec<f64> =
            (0..50).map(|i| if i % 7 == 3 { f64::NAN } else { 2.0 + 0.03 * f64::from(i) }).collect();
        for slope in centred_slope(&line, 4, 0.01) {
            assert!((slope - 3.0).abs() < 1e-9);
        }
        let mean = centred_mean(&[1.0, f64::NAN, 3.0, f64::NAN, f64::NAN, f64::NAN], 1);
        assert_eq!(mean[..3], [1.0, 2.0, 3.0]);
        assert!(mean[5].is_nan());
        assert_eq!(median(&mut [3.0, 1.0, 2.0]), Some(2.0));
        assert_eq!(median(&mut []), None);
    }
}
