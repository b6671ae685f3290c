//! Chances of the normal variable, and of what was counted.

/// Φ, by the error function's approximation of Abramowitz and Stegun (7.1.26), right to 1e-7.
pub fn normal_cdf(x: f64) -> f64 {
    let z = x.abs() / std::f64::consts::SQRT_2;
    let t = 1.0 / (1.0 + 0.327_591_1 * z);
    let series = [0.254_829_592, -0.284_496_736, 1.421_413_741, -1.453_152_027, 1.061_405_429];
    let sum = series.iter().rev().fold(0.0, |sum, factor| (sum + factor) * t);
    let erf = 1.0 - sum * (-z * z).exp();
    0.5 * (1.0 + erf.copysign(x))
}

/// Wilson's 95 % score interval of a share; all of it for none of none.
pub fn wilson(hits: usize, of: usize) -> [f64; 2] {
    if of == 0 {
        return [0.0, 1.0];
    }
    let (n, share, z) = (of as f64, hits as f64 / of as f64, 1.96_f64);
    let square = z * z / n;
    let middle = (share + 0.5 * square) / (1.0 + square);
    let half = z * (share * (1.0 - share) / n + 0.25 * square / n).sqrt() / (1.0 + square);
    [(middle - half).max(0.0), (middle + half).min(1.0)]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn chances_are_those_of_the_tables() {
        for (x, chance) in [(0.0, 0.5), (1.2816, 0.9), (-1.96, 0.025)] {
            assert!((normal_cdf(x) - chance).abs() < 1e-4, "{x}");
        }
        // Newcombe 1998, table I: 81 of 263.
        let [low, high] = wilson(81, 263);
        assert!((low - 0.2553).abs() < 1e-4 && (high - 0.3662).abs() < 1e-4, "{low} {high}");
        assert_eq!(wilson(0, 0), [0.0, 1.0]);
    }
}
