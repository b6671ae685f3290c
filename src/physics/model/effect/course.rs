//! How something that nobody measures varies while one drives.

use super::Now;

/// A course in time.
#[derive(Clone, Debug, PartialEq)]
pub enum Course {
    /// Nothing varies.
    None,
    /// The same all the time.
    Constant(f64),
    /// Linear between points, zero outside of them.
    Series(Series),
    /// A value within some stretches of time (s), zero outside.
    Stretches {
        /// From, to, s.
        intervals: Vec<[f64; 2]>,
        /// The value within.
        value: f64,
    },
    /// A filter estimates it while it runs: this is its place in [`Now::live`].
    Live(usize),
}

/// Values at times.
#[derive(Clone, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Series {
    /// Times, s, ascending.
    pub t: Vec<f64>,
    /// The value at each.
    pub value: Vec<f64>,
}

impl Course {
    /// Its value now.
    pub fn at(&self, now: &Now<'_>) -> f64 {
        match self {
            Self::Live(place) => now.live.get(*place).copied().unwrap_or(0.0),
            _ => self.at_time(now.t),
        }
    }

    /// Its value at a time, s; zero where only a running filter knows it.
    pub fn at_time(&self, t: f64) -> f64 {
        match self {
            Self::None | Self::Live(_) => 0.0,
            Self::Constant(value) => *value,
            Self::Series(series) => series.at(t),
            Self::Stretches { intervals, value } => {
                if intervals.iter().any(|[from, to]| (*from..*to).contains(&t)) { *value } else { 0.0 }
            }
        }
    }
}

impl Series {
    /// Linear between its points, zero outside.
    pub fn at(&self, t: f64) -> f64 {
        let after = self.t.partition_point(|point| *point <= t);
        let Some(before) = after.checked_sub(1) else { return 0.0 };
        if after >= self.t.len() {
            return if self.t[before] == t { self.value[before] } else { 0.0 };
        }
        let share = (t - self.t[before]) / (self.t[after] - self.t[before]);
        self.value[before] + share * (self.value[after] - self.value[before])
    }

    /// Root of the mean square over its points.
    pub fn rms(&self) -> f64 {
        let sum: f64 = self.value.iter().map(|value| value * value).sum();
        (sum / self.value.len().max(1) as f64).sqrt()
    }
}
