//! A course drawn at random: as smooth as the road, the wind or a temperature is.

use physics::model::effect::Series;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;
use rand_distr::{Distribution, StandardNormal};

/// Points of a course, per correlation length: between them it is a straight line.
const POINTS: f64 = 10.0;

/// A course over so many seconds with this root of the mean square and this correlation length (s), of a mean of zero:
/// white noise through two lags of first order. The same seed and number give the same course.
pub fn drawn(rms: f64, length_s: f64, seconds: f64, seed: u64, number: u64) -> Series {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    random.set_stream(number);
    let step = length_s / POINTS;
    let count = (seconds / step).ceil().max(1.0) as usize + 1;
    let (mut first, mut second) = (0.0, 0.0);
    let share = 1.0 - (-1.0 / POINTS).exp();
    // What it begins with is forgotten by then.
    let settling = 8 * POINTS as usize;
    let mut next = || {
        let noise: f64 = StandardNormal.sample(&mut random);
        first += share * (noise - first);
        second += share * (first - second);
        second
    };
    let all: Vec<f64> = (0..settling + count).map(|_| next()).skip(settling).collect();
    let mean = all.iter().sum::<f64>() / count as f64;
    let square = all.iter().map(|value| (value - mean).powi(2)).sum::<f64>() / count as f64;
    let scale = if square > 0.0 { rms / square.sqrt() } else { 0.0 };
    Series {
        t: (0..count).map(|i| i as f64 * step).collect(),
        value: all.into_iter().map(|value| scale * (value - mean)).collect(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_has_the_size_that_was_asked_for_and_changes_within_its_length() {
        let course = drawn(300.0, 1.5, 1500.0, 4, 0);
        assert!((course.rms() - 300.0).abs() < 1e-9);
        let after = |lag: usize| {
            let pairs = course.value.iter().zip(&course.value[lag..]);
            pairs.map(|(one, other)| one * other).sum::<f64>() / course.value.len() as f64 / 9e4
        };
        // Two lags in a row: (1 + x) e^(−x).
        assert!((after(10) - 0.74).abs() < 0.1 && after(60).abs() < 0.2, "{} {}", after(10), after(60));
        assert_eq!(course, drawn(300.0, 1.5, 1500.0, 4, 0));
        assert_ne!(course, drawn(300.0, 1.5, 1500.0, 5, 0));
        assert_ne!(course, drawn(300.0, 1.5, 1500.0, 4, 1));
    }
}
