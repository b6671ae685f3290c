//! Straight lines through points of which some are wrong.

use nalgebra::{DMatrix, DVector};

/// What a line through the points says.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Line {
    /// Factor of each regressor, in their order; the last is the constant.
    pub(super) factors: Vec<f64>,
    /// Correlation of the response with the first regressor, the others taken out of both; −1 to 1.
    pub(super) correlation: f64,
    /// The first factor over its standard deviation; the points are taken for two thirds dependent.
    pub(super) significance: f64,
    /// Points that were used.
    pub(super) points: usize,
}

/// The share of points that may be left out as wrong.
const WRONG: f64 = 0.1;
/// Fewer points say nothing.
const FEWEST: usize = 25;

/// Fits `response = Σ factor · regressor + constant`, where all are numbers. Points further off than four
/// standard deviations (by the median) are left out once, but never more than a tenth of them.
pub(super) fn line(response: &[f64], regressors: &[&[f64]]) -> Option<Line> {
    let rows: Vec<usize> = (0..response.len())
        .filter(|row| {
            let finite = |series: &[f64]| series.get(*row).is_some_and(|value| value.is_finite());
            finite(response) && regressors.iter().all(|series| finite(series))
        })
        .collect();
    let first = fit(response, regressors, &rows)?;
    let mut amounts: Vec<f64> =
        rows.iter().map(|row| residual(response, regressors, &first, *row).abs()).collect();
    amounts.sort_by(f64::total_cmp);
    let median = amounts.get(amounts.len() / 2).copied().unwrap_or(0.0);
    let tenth =
        amounts.get(((1.0 - WRONG) * amounts.len() as f64) as usize).copied().unwrap_or(f64::INFINITY);
    let most = (4.0 * 1.4826 * median).max(tenth);
    let kept: Vec<usize> =
        rows.into_iter().filter(|row| residual(response, regressors, &first, *row).abs() <= most).collect();
    let factors = fit(response, regressors, &kept)?;
    // Without the first regressor the response is explained that much worse.
    let squares = |factors: &[f64], regressors: &[&[f64]]| -> f64 {
        kept.iter().map(|row| residual(response, regressors, factors, *row).powi(2)).sum()
    };
    let with = squares(&factors, regressors);
    let others = regressors.get(1..)?;
    let without = squares(&fit(response, others, &kept)?, others);
    let explained = if without > 0.0 { (1.0 - with / without).clamp(0.0, 1.0) } else { 0.0 };
    let slope = *factors.first()?;
    let independent = kept.len() as f64 / 3.0 - factors.len() as f64;
    let significance =
        slope.signum() * (explained / (1.0 - explained).max(1e-9) * independent.max(1.0)).sqrt();
    Some(Line { correlation: slope.signum() * explained.sqrt(), significance, points: kept.len(), factors })
}

fn residual(response: &[f64], regressors: &[&[f64]], factors: &[f64], row: usize) -> f64 {
    let told: f64 = regressors.iter().zip(factors).map(|(series, factor)| factor * series[row]).sum();
    response[row] - told - factors.last().copied().unwrap_or(0.0)
}

/// Least squares; `None` if there are too few points, or if the regressors cannot be told apart.
fn fit(response: &[f64], regressors: &[&[f64]], rows: &[usize]) -> Option<Vec<f64>> {
    let width = regressors.len() + 1;
    if rows.len() < FEWEST {
        return None;
    }
    // Every regressor in its own size, so that those of thousands and of thousandths meet as equals.
    let scales: Vec<f64> = regressors
        .iter()
        .map(|series| (rows.iter().map(|row| series[*row].powi(2)).sum::<f64>() / rows.len() as f64).sqrt())
        .collect();
    if scales.iter().any(|scale| *scale <= 0.0 || !scale.is_finite()) {
        return None;
    }
    let mut normal = DMatrix::<f64>::zeros(width, width);
    let mut right = DVector::<f64>::zeros(width);
    let mut point = vec![1.0; width];
    for row in rows {
        for ((value, series), scale) in point.iter_mut().zip(regressors).zip(&scales) {
            *value = series[*row] / scale;
        }
        for i in 0..width {
            right[i] += point[i] * response[*row];
            for j in 0..width {
                normal[(i, j)] += point[i] * point[j];
            }
        }
    }
    for i in 0..width {
        normal[(i, i)] *= 1.0 + 1e-12;
    }
    let solved = normal.cholesky()?.solve(&right);
    let mut factors: Vec<f64> =
        scales.iter().zip(solved.iter()).map(|(scale, value)| value / scale).collect();
    factors.push(solved[width - 1]);
    factors.iter().all(|factor| factor.is_finite()).then_some(factors)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_line_is_found_among_wrong_points_and_gaps() {
        let x: Vec<f64> = (0..300).map(|i| f64::from(i).sin()).collect();
        let z: Vec<f64> = (0..300).map(|i| (0.37 * f64::from(i)).cos()).collect();
        let mut y: Vec<f64> = x.iter().zip(&z).map(|(x, z)| -2.0 * x + 0.5 * z + 7.0).collect();
        y[10] = 500.0;
        y[20] = f64::NAN;
        let found = line(&y, &[&x, &z]).unwrap();
        assert!((found.factors[0] + 2.0).abs() < 1e-9 && (found.factors[2] - 7.0).abs() < 1e-9);
        assert!(found.correlation < -0.999 && found.points >= 270);
    }

    #[test]
    fn what_has_nothing_to_do_with_it_is_not_correlated() {
        let x: Vec<f64> = (0..300).map(|i| f64::from(i).sin()).collect();
        let y: Vec<f64> = (0..300).map(|i| f64::from(i * 7919 % 101)).collect();
        assert!(line(&y, &[&x]).unwrap().correlation.abs() < 0.2);
        assert_eq!(line(&y[..10], &[&x[..10]]), None);
    }
}
