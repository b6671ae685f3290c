//! Lines through pairs whose both coordinates are uncertain.
//!
//! y = a x + b, or through the origin, or constant. χ² counts each residual by its effective variance
//! σ_y² + a² σ_x² + τ²: errors in x dilute an ordinary least-squares slope, and this takes the
//! dilution out. τ is what the pairs scatter beyond their own uncertainties (no two roads of one
//! stiffness have the same friction), such that χ² is what chance alone would make it.

/// One point with its standard deviations.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Point {
    /// Abscissa.
    pub x: f64,
    /// Its standard deviation.
    pub x_std: f64,
    /// Ordinate.
    pub y: f64,
    /// Its standard deviation.
    pub y_std: f64,
}

/// Which line.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Shape {
    /// y = b.
    Constant,
    /// y = a x.
    Proportional,
    /// y = a x + b.
    Line,
}

impl Shape {
    /// How many coefficients it has.
    pub const fn coefficients(self) -> usize {
        match self {
            Self::Constant | Self::Proportional => 1,
            Self::Line => 2,
        }
    }
}

/// A line fitted.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Regression {
    /// Which line.
    pub shape: Shape,
    /// Slope a; zero if constant.
    pub a: f64,
    /// Intercept b; zero if proportional.
    pub b: f64,
    /// Variances of a and b and their covariance.
    pub covariance: Covariance,
    /// Points it stands on.
    pub points: usize,
    /// χ² at this τ; n − p, or less where the points scatter less than they are uncertain.
    pub chi_square: f64,
    /// τ: scatter beyond the points' own uncertainties, in units of y.
    pub excess_std: f64,
    /// Root mean square of the σ_y.
    pub measurement_std: f64,
    /// 1 − (weighted residual squares) / (weighted squares around the weighted mean).
    pub r_square: f64,
    /// Akaike's criterion with the correction for few points: lower is better, by 2 noticeably.
    pub aicc: f64,
}

/// Of slope and intercept.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Covariance {
    /// Variance of a.
    pub aa: f64,
    /// Covariance of a and b.
    pub ab: f64,
    /// Variance of b.
    pub bb: f64,
}

/// What solving for a given τ² gives.
#[derive(Clone, Copy, Debug)]
struct Solution {
    a: f64,
    b: f64,
    covariance: Covariance,
    chi_square: f64,
}

impl Regression {
    /// No friction or slope is known better than this, relative to the spread of y.
    const LEAST_STD: f64 = 1e-6;

    /// Fits a line; `None` with fewer points than coefficients plus one, or with numbers that are
    /// not finite.
    pub fn fit(points: &[Point], shape: Shape) -> Option<Self> {
        let n = points.len() as f64;
        let freedom = n - shape.coefficients() as f64;
        let finite = |p: &Point| [p.x, p.x_std, p.y, p.y_std].iter().all(|value| value.is_finite());
        if freedom < 1.0 || !points.iter().all(finite) {
            return None;
        }
        let mean = points.iter().map(|p| p.y).sum::<f64>() / n;
        let spread = points.iter().map(|p| (p.y - mean).powi(2)).sum::<f64>() / n;
        let least = (Self::LEAST_STD * (spread.sqrt() + mean.abs()).max(1e-9)).powi(2);
        let excess = Self::excess(points, shape, freedom, least, 4.0 * spread + least)?;
        let solution = solve(points, shape, excess)?;
        let Solution { a, b, covariance, chi_square } = solution;
        let variance = |p: &Point| p.y_std * p.y_std + a * a * p.x_std * p.x_std + excess;
        let weights: f64 = points.iter().map(|p| 1.0 / variance(p)).sum();
        let mean = points.iter().map(|p| p.y / variance(p)).sum::<f64>() / weights;
        let around_mean: f64 = points.iter().map(|p| (p.y - mean).powi(2) / variance(p)).sum();
        let information: f64 = points.iter().map(|p| (std::f64::consts::TAU * variance(p)).ln()).sum();
        let k = shape.coefficients() as f64 + 1.0;
        let correction = if n > k + 1.0 { 2.0 * k * (k + 1.0) / (n - k - 1.0) } else { f64::INFINITY };
        Some(Self {
            shape,
            a,
            b,
            covariance,
            points: points.len(),
            chi_square,
            excess_std: excess.sqrt(),
            measurement_std: (points.iter().map(|p| p.y_std * p.y_std).sum::<f64>() / n).sqrt(),
            r_square: if around_mean > 0.0 { 1.0 - chi_square / around_mean } else { 0.0 },
            aicc: information + chi_square + 2.0 * k + correction,
        })
    }

    /// τ² for which χ² is as large as its degrees of freedom; the least if it is smaller anyway.
    fn excess(points: &[Point], shape: Shape, freedom: f64, least: f64, most: f64) -> Option<f64> {
        let chi_square = |excess: f64| solve(points, shape, excess).map(|s| s.chi_square);
        if chi_square(least)? <= freedom {
            return Some(least);
        }
        let (mut low, mut high) = (least, most);
        // χ² falls as τ² rises; the upper end may have to be farther for a proportional line.
        for _ in 0..60 {
            if chi_square(high)? <= freedom {
                break;
            }
            high *= 4.0;
        }
        for _ in 0..100 {
            let middle = (low * high).sqrt();
            if chi_square(middle)? > freedom { low = middle } else { high = middle }
        }
        Some((low * high).sqrt())
    }

    /// Degrees of freedom left.
    pub fn freedom(&self) -> f64 {
        self.points as f64 - self.shape.coefficients() as f64
    }

    /// F = (a/σ_a)² of the slope against none, with (1, [`Self::freedom`]) degrees of freedom.
    pub fn f_statistic(&self) -> f64 {
        if self.covariance.aa > 0.0 { self.a * self.a / self.covariance.aa } else { 0.0 }
    }

    /// The line at `x`.
    pub fn at(&self, x: f64) -> f64 {
        self.a * x + self.b
    }
}

/// Least χ² for a given τ² (York's equations: a is on both sides, iterated until it stays).
fn solve(points: &[Point], shape: Shape, excess: f64) -> Option<Solution> {
    /// A search that has not ended by then does not end.
    const ITERATIONS: usize = 200;
    let mut a = if shape == Shape::Constant { 0.0 } else { ordinary_slope(points, shape)? };
    for _ in 0..ITERATIONS {
        let (x_mean, y_mean) = centre(points, shape, a, excess);
        let (mut top, mut bottom) = (0.0, 0.0);
        for p in points {
            let weight = weight(p, a, excess);
            let (u, v) = (p.x - x_mean, p.y - y_mean);
            let beta = adjusted(p, u, v, a, excess);
            top += weight * beta * v;
            bottom += weight * beta * u;
        }
        let next = if shape == Shape::Constant { 0.0 } else { top / bottom };
        if !next.is_finite() {
            return None;
        }
        let settled = (next - a).abs() <= 1e-13 * a.abs();
        a = next;
        if settled {
            break;
        }
    }
    let (x_mean, y_mean) = centre(points, shape, a, excess);
    let b = if shape == Shape::Proportional { 0.0 } else { y_mean - a * x_mean };
    let weights: f64 = points.iter().map(|p| weight(p, a, excess)).sum();
    let chi_square = points.iter().map(|p| weight(p, a, excess) * (p.y - a * p.x - b).powi(2)).sum::<f64>();
    let covariance = if shape == Shape::Constant {
        Covariance { bb: 1.0 / weights, ..Covariance::default() }
    } else {
        // At the points' adjusted abscissas.
        let beta = |p: &Point| adjusted(p, p.x - x_mean, p.y - y_mean, a, excess);
        let shift = match shape {
            Shape::Line => points.iter().map(|p| weight(p, a, excess) * beta(p)).sum::<f64>() / weights,
            _ => 0.0,
        };
        let aa = 1.0 / points.iter().map(|p| weight(p, a, excess) * (beta(p) - shift).powi(2)).sum::<f64>();
        let pivot = x_mean + shift;
        match shape {
            Shape::Line => Covariance { aa, ab: -pivot * aa, bb: 1.0 / weights + pivot * pivot * aa },
            _ => Covariance { aa, ..Covariance::default() },
        }
    };
    let solution = Solution { a, b, covariance, chi_square };
    [a, b, covariance.aa, covariance.bb, chi_square].iter().all(|v| v.is_finite()).then_some(solution)
}

/// Weighted mean of the points, or the origin where the line has to go through it.
fn centre(points: &[Point], shape: Shape, a: f64, excess: f64) -> (f64, f64) {
    if shape == Shape::Proportional {
        return (0.0, 0.0);
    }
    let (mut sum, mut x, mut y) = (0.0, 0.0, 0.0);
    for p in points {
        let weight = weight(p, a, excess);
        sum += weight;
        x += weight * p.x;
        y += weight * p.y;
    }
    (x / sum, y / sum)
}

fn weight(p: &Point, a: f64, excess: f64) -> f64 {
    1.0 / (p.y_std * p.y_std + excess + a * a * p.x_std * p.x_std)
}

/// Best guess of a point's true abscissa, from its centre, given the line.
fn adjusted(p: &Point, u: f64, v: f64, a: f64, excess: f64) -> f64 {
    weight(p, a, excess) * (u * (p.y_std * p.y_std + excess) + a * v * p.x_std * p.x_std)
}

/// Least squares without any uncertainty (thesis 6.6, 6.10): where the iteration starts.
fn ordinary_slope(points: &[Point], shape: Shape) -> Option<f64> {
    let n = points.len() as f64;
    let (x_mean, y_mean) = match shape {
        Shape::Proportional => (0.0, 0.0),
        _ => (points.iter().map(|p| p.x).sum::<f64>() / n, points.iter().map(|p| p.y).sum::<f64>() / n),
    };
    let square: f64 = points.iter().map(|p| (p.x - x_mean).powi(2)).sum();
    let product: f64 = points.iter().map(|p| (p.x - x_mean) * (p.y - y_mean)).sum();
    (square > 0.0).then(|| product / square)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn points(rows: &[[f64; 4]]) -> Vec<Point> {
        rows.iter().map(|&[x, x_std, y, y_std]| Point { x, x_std, y, y_std }).collect()
    }

    #[test]
    fn without_errors_in_x_it_is_weighted_least_squares() {
        // By hand: w = 1, 1, 4 (the excess stays nil, χ² being below 1): x̄ = 8/6·… see below.
        let rows = points(&[[0.0, 0.0, 1.0, 1.0], [1.0, 0.0, 2.0, 1.0], [2.0, 0.0, 2.0, 0.5]]);
        let fit = Regression::fit(&rows, Shape::Line).unwrap();
        // Σw = 6, Σwx = 9, Σwy = 11, Σwxx = 17, Σwxy = 18: a = (6·18 − 9·11)/(6·17 − 81) = 9/21.
        assert!((fit.a - 9.0 / 21.0).abs() < 1e-6, "{fit:?}");
        assert!((fit.b - (11.0 - 9.0 * 9.0 / 21.0) / 6.0).abs() < 1e-6);
        assert!((fit.covariance.aa - 6.0 / 21.0).abs() < 1e-6);
        assert!((fit.covariance.bb - 17.0 / 21.0).abs() < 1e-6);
        assert!((fit.covariance.ab + 9.0 / 21.0).abs() < 1e-6);
        let residuals = [1.0 - fit.at(0.0), 2.0 - fit.at(1.0), 2.0 - fit.at(2.0)];
        let chi = residuals[0].powi(2) + residuals[1].powi(2) + 4.0 * residuals[2].powi(2);
        assert!((fit.chi_square - chi).abs() < 1e-6 && fit.excess_std < 1e-5);
    }

    #[test]
    fn pairs_that_scatter_more_than_they_may_get_an_excess() {
        // Residuals ±0.3 around 2 with uncertainties of 0.01: τ² = Σr²/(n − 1) − 0.01².
        let rows = points(&[
            [0.0, 0.0, 1.7, 0.01],
            [1.0, 0.0, 2.3, 0.01],
            [2.0, 0.0, 1.7, 0.01],
            [3.0, 0.0, 2.3, 0.01],
        ]);
        let fit = Regression::fit(&rows, Shape::Constant).unwrap();
        assert!((fit.b - 2.0).abs() < 1e-9);
        assert!((fit.excess_std.powi(2) - (0.36 / 3.0 - 1e-4)).abs() < 1e-6, "{fit:?}");
        assert!((fit.chi_square - 3.0).abs() < 1e-6);
        assert!((fit.covariance.bb - 0.12 / 4.0).abs() < 1e-6);
    }

    #[test]
    fn equal_errors_in_both_give_the_orthogonal_line() {
        // Deming with ratio 1: a = (Syy − Sxx + √((Syy − Sxx)² + 4 Sxy²)) / (2 Sxy).
        let rows =
            points(&[[0.0, 1.0, 0.1, 1.0], [1.0, 1.0, 1.3, 1.0], [2.0, 1.0, 1.6, 1.0], [3.0, 1.0, 3.4, 1.0]]);
        let fit = Regression::fit(&rows, Shape::Line).unwrap();
        let (mx, my) = (1.5, 1.6);
        let sum = |f: &dyn Fn(&Point) -> f64| rows.iter().map(f).sum::<f64>();
        let (xx, yy) = (sum(&|p| (p.x - mx).powi(2)), sum(&|p| (p.y - my).powi(2)));
        let xy = sum(&|p| (p.x - mx) * (p.y - my));
        let deming = (yy - xx + ((yy - xx).powi(2) + 4.0 * xy * xy).sqrt()) / (2.0 * xy);
        assert!((fit.a - deming).abs() < 1e-6, "{} {deming}", fit.a);
    }

    #[test]
    fn too_few_or_broken_points_give_nothing() {
        let rows = points(&[[0.0, 0.0, 1.0, 0.1], [1.0, 0.0, 2.0, 0.1]]);
        assert_eq!(Regression::fit(&rows, Shape::Line), None);
        assert!(Regression::fit(&rows, Shape::Proportional).is_some());
        let rows = points(&[[1.0, 0.0, f64::NAN, 0.1]; 5]);
        assert_eq!(Regression::fit(&rows, Shape::Constant), None);
        // All at one abscissa: no line.
        let rows = points(&[[1.0, 0.0, 1.0, 0.1]; 5]);
        assert_eq!(Regression::fit(&rows, Shape::Line), None);
    }
}
