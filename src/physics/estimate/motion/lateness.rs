//! Does one signal come later than another that should be equal?
//!
//! What comes τ later differs by −τ times its rate of change: the difference of both is regressed on that rate. It is
//! asked of signals that were smoothed twice, whose rate the second filter has for nothing.

use crate::estimate::lasting::Lasting;

/// Tuned with the tests `one_channel` and `motion`.
struct Tuning {
    /// Time constant of each smoothing, s.
    smooth_s: f64,
    /// Seconds that are remembered where nothing else is asked for, and the share of them before which nothing is said.
    memory_s: f64,
    shows: f64,
    /// So late are good sensors by their gateways, and models by tires and body, s, as far as it shows; more by so many
    /// deviations is a doubt, …
    least_s: f64,
    deviations: f64,
    /// … that ends at this share of what it begins at. Tires that were learned with this share of what is forgiven would be
    /// wrong already.
    ends: f64,
    crude: f64,
    /// One error lasts this long, s.
    error_lasts_s: f64,
}

const TUNING: Tuning = Tuning {
    smooth_s: 0.3,
    memory_s: 12.0,
    shows: 0.4,
    least_s: 0.03,
    deviations: 2.2,
    ends: 0.8,
    crude: 0.6,
    error_lasts_s: 0.6,
};

/// Compares two signals.
#[derive(Clone, Copy, Debug)]
pub struct Lateness {
    memory_s: f64,
    /// Both signals, smoothed once and twice.
    smooth: [[f64; 2]; 2],
    /// Mean squares of the rate of the second signal and of the difference, and their mean product.
    rate_square: f64,
    square: f64,
    product: f64,
    /// The mean of what is expected.
    expected_s: f64,
    seen_s: f64,
    doubt: Lasting,
    is_crude: bool,
}

impl Default for Lateness {
    fn default() -> Self {
        Self::of_seconds(TUNING.memory_s)
    }
}

impl Lateness {
    /// What disturbs the signals needs so many seconds to average out.
    pub fn of_seconds(memory_s: f64) -> Self {
        Self {
            memory_s,
            smooth: [[0.0; 2]; 2],
            rate_square: 0.0,
            square: 0.0,
            product: 0.0,
            expected_s: 0.0,
            seen_s: 0.0,
            doubt: Lasting::default(),
            is_crude: false,
        }
    }

    /// Takes both; how much later the first one is to come (s), give or take `tolerance_s`.
    pub fn step(&mut self, signals: [f64; 2], expected_s: f64, tolerance_s: f64, elapsed_s: f64) {
        let weight = (elapsed_s / TUNING.smooth_s).min(1.0);
        for ([once, twice], signal) in self.smooth.iter_mut().zip(signals) {
            *once += weight * (signal - *once);
            *twice += weight * (*once - *twice);
        }
        let [[_, one], [once, other]] = self.smooth;
        let (difference, rate) = (one - other, (once - other) / TUNING.smooth_s);
        self.seen_s += elapsed_s;
        let memory = (elapsed_s / self.seen_s.min(self.memory_s)).min(1.0);
        self.rate_square += memory * (rate * rate - self.rate_square);
        self.square += memory * (difference * difference - self.square);
        self.product += memory * (difference * rate - self.product);
        self.expected_s += memory * (expected_s - self.expected_s);
        let late = self.late_s().abs();
        let chance = TUNING.deviations * self.std_s();
        let ends = self.doubt.limit(TUNING.ends);
        let is_late = late > ends * (TUNING.least_s + tolerance_s + chance);
        let shows = self.seen_s > TUNING.shows * self.memory_s;
        self.is_crude = shows && late > TUNING.least_s + TUNING.crude * tolerance_s + chance;
        self.doubt.step(shows && is_late, elapsed_s);
    }

    /// How much later than expected the first signal comes at least, s: a filter that has got used to it hides a part.
    pub fn late_s(&self) -> f64 {
        -self.product / self.rate_square - self.expected_s
    }

    /// That it is too much.
    pub fn doubt(&self) -> Lasting {
        self.doubt
    }

    /// It is no doubt, but tires are not to be learned from these.
    pub fn is_crude(&self) -> bool {
        self.is_crude
    }

    fn std_s(&self) -> f64 {
        let left = (self.square - self.product * self.product / self.rate_square).max(0.0);
        let worth = self.seen_s.min(self.memory_s) / TUNING.error_lasts_s;
        (left / self.rate_square / worth).sqrt()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The first signal comes this much later than the second, and has an error of its own.
    fn late(by_s: f64, error: f64) -> Lateness {
        let mut lateness = Lateness::default();
        let signal = |t: f64| (1.3 * t).sin() + 0.6 * (2.9 * t).sin();
        for i in 0..3000 {
            let t = 0.01 * f64::from(i);
            lateness.step([signal(t - by_s) + error * (0.71 * t).cos(), signal(t)], 0.0, 0.0, 0.01);
        }
        lateness
    }

    #[test]
    fn what_comes_later_is_told_and_what_is_only_off_is_not() {
        for by_s in [0.0, 0.02, -0.02] {
            for error in [0.0, 0.3] {
                let lateness = late(by_s, error);
                assert!((lateness.late_s() - by_s).abs() < 0.05, "{lateness:?}");
                assert_eq!(lateness.doubt().lasts_s(), None, "{by_s} {error}");
            }
        }
        for by_s in [0.3, -0.3] {
            let lateness = late(by_s, 0.1);
            assert!((lateness.late_s() - by_s).abs() < 0.1, "{lateness:?}");
            assert!(lateness.doubt().lasts_s().is_some_and(|lasts| lasts > 10.0), "{by_s}");
            assert!(late(0.1 * by_s.signum(), 0.1).doubt().is_there(), "{by_s}");
        }
    }
}
