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
    /// Rates of the second signal beyond this count no more than this.
    usual_rate: f64,
    /// Both signals, smoothed once and twice.
    smooth: [[f64; 2]; 2],
    /// Mean squares of the rate of the second signal and of the difference, and their mean product, as far as they count.
    rate_square: f64,
    /// Mean square of what counts of the rate's square.
    rate_fourth: f64,
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
            usual_rate: f64::INFINITY,
            smooth: [[0.0; 2]; 2],
            rate_square: 0.0,
            rate_fourth: 0.0,
            square: 0.0,
            product: 0.0,
            expected_s: 0.0,
            seen_s: 0.0,
            doubt: Lasting::default(),
            is_crude: false,
        }
    }

    /// Where the second signal changes faster than this it says no more than where it changes so.
    pub fn of_rate(usual_rate: f64) -> Self {
        Self { usual_rate, ..Self::default() }
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
        let counts = 1.0 / (1.0 + (rate / self.usual_rate).powi(2));
        let learn = |mean: &mut f64, value: f64| *mean += memory * (value - *mean);
        learn(&mut self.rate_square, counts * rate * rate);
        learn(&mut self.rate_fourth, (counts * rate * rate).powi(2));
        learn(&mut self.square, counts * difference * difference);
        learn(&mut self.product, counts * difference * rate);
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

    /// How many seconds tell it: all of them if the second signal changes as much in each, few where it does in one moment
    /// only.
    pub fn told_by_s(&self) -> f64 {
        self.seen_s.min(self.memory_s) * self.rate_square * self.rate_square / self.rate_fourth
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

    /// GIVEN signals that change as they like THEN most of the memory tells; where one runs away for a second, that second does.
    #[test]
    fn a_moment_tells_for_a_moment() {
        let told_by_s = |away: f64| {
            let mut lateness = Lateness::default();
            for i in 0..3000 {
                let t = 0.01 * f64::from(i);
                let signal = 0.2 * (1.3 * t).sin() + away * (t - 29.0).max(0.0).powi(2);
                lateness.step([signal; 2], 0.0, 0.0, 0.01);
            }
            lateness.told_by_s()
        };
        let [usual, moment] = [0.0, 1.5].map(told_by_s);
        assert!(usual > 6.0 && moment < 1.5, "{usual} {moment}");
    }

    /// GIVEN equal signals of which, for a second, the second one runs away first THEN that counts less beyond the usual rate.
    #[test]
    fn what_changes_unusually_fast_counts_less() {
        let late_s = |usual_rate: f64| {
            let mut lateness = Lateness::of_rate(usual_rate);
            for i in 0..1000 {
                let t = 0.01 * f64::from(i);
                let usual = 0.2 * (1.3 * t).sin();
                let away = |t: f64| 1.5 * (t - 9.0).max(0.0).powi(2);
                lateness.step([usual + away(t - 0.3), usual + away(t)], 0.0, 0.0, 0.01);
            }
            lateness.late_s()
        };
        let [counted, uncounted] = [0.2, f64::INFINITY].map(late_s);
        assert!(counted < 0.5 * uncounted && uncounted > 0.1, "{counted} {uncounted}");
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
