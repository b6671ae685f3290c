//! Residuals of real recordings: outliers count less, and neighbours say the same.

/// Residuals larger than this many deviations count like |e|, not like e². Huber's usual 1.345 would do as well; smooth
/// at zero.
const ROBUST: f64 = 1.5;

/// Quadratic near zero, linear far out.
pub fn loss(error: f64) -> f64 {
    let share = error / ROBUST;
    2.0 * ROBUST * ROBUST * ((1.0 + share * share).sqrt() - 1.0)
}

/// The loss's weight in normal equations.
pub fn weight(error: f64) -> f64 {
    let share = error / ROBUST;
    1.0 / (1.0 + share * share).sqrt()
}

/// Points that say as much as one: 1 + 2 Σ of the autocorrelation up to where it first falls below 0.1. What the model
/// misses remembers longer than noise does; a fit that takes all of it for noise believes its priors only.
pub fn memory(series: &[Vec<[f64; 2]>], channel: usize) -> f64 {
    let product = |lag: usize| {
        let (mut sum, mut count) = (0.0, 0.0);
        for rows in series {
            for pair in rows.windows(lag + 1) {
                let (first, last) = (pair[0][channel], pair[lag][channel]);
                if first.is_finite() && last.is_finite() {
                    sum += first * last;
                    count += 1.0;
                }
            }
        }
        if count > 0.0 { sum / count } else { 0.0 }
    };
    let variance = product(0).max(1e-300);
    let mut memory = 1.0;
    for lag in 1..LONGEST_MEMORY {
        let correlation = product(lag) / variance;
        if correlation < 0.1 {
            break;
        }
        memory += 2.0 * correlation;
    }
    memory.min(LONGEST_MEMORY as f64)
}

/// Rows, that is 0.3 s. Tuned by the real drives of `tests/campaign/free_runs`: with ten times as much the laps end at
/// their priors.
const LONGEST_MEMORY: usize = 10;

/// Deviation of errors by the median of their sizes; what is not finite is left out. None of nothing.
pub fn deviation(errors: impl Iterator<Item = f64>) -> Option<f64> {
    let mut sizes: Vec<f64> = errors.map(f64::abs).filter(|size| size.is_finite()).collect();
    if sizes.is_empty() {
        return None;
    }
    let middle = sizes.len() / 2;
    let (_, median, _) = sizes.select_nth_unstable_by(middle, f64::total_cmp);
    Some(1.4826 * *median)
}
