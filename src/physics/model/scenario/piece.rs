//! A quantity over time, put together from pieces that are summed.

use serde::{Deserialize, Serialize};

use super::{Problem, finite, positive};

/// One piece of an input; the pieces of an input are summed. Times are seconds from the start.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(tag = "kind", rename_all = "snake_case", deny_unknown_fields)]
pub enum Piece {
    /// The same value always.
    Constant {
        /// The value.
        value: f64,
    },
    /// Straight lines through points; before the first and after the last the value stays.
    Points {
        /// Time (s) and value, times rising.
        points: Vec<[f64; 2]>,
    },
    /// Zero, and from `at_s` on `value`.
    Step {
        /// When.
        at_s: f64,
        /// The value afterwards.
        value: f64,
    },
    /// Zero, then in a straight line to `value`, which stays.
    Ramp {
        /// When the line begins.
        from_s: f64,
        /// When it ends.
        to_s: f64,
        /// The value afterwards.
        value: f64,
    },
    /// offset + amplitude sin(2 π f t + phase), t from `from_s`.
    Sine {
        /// Amplitude.
        amplitude: f64,
        /// Frequency f.
        frequency_hz: f64,
        /// Phase at the beginning.
        #[serde(default)]
        phase_rad: f64,
        /// Added constant.
        #[serde(default)]
        offset: f64,
        /// Zero before.
        #[serde(default)]
        from_s: f64,
        /// Zero afterwards.
        #[serde(default = "never", skip_serializing_if = "is_never")]
        to_s: f64,
    },
    /// A sine of constant amplitude whose frequency rises in a straight line.
    Chirp {
        /// Amplitude.
        amplitude: f64,
        /// Frequency at `from_s`.
        from_hz: f64,
        /// Frequency at `to_s`.
        to_hz: f64,
        /// Zero before.
        from_s: f64,
        /// Zero afterwards.
        to_s: f64,
    },
    /// Smooth random of zero mean: a Gaussian process of correlation
    /// (1 + |τ|/τ_c) exp(−|τ|/τ_c), whose rate of change has the rms `rms / correlation_time_s`.
    /// Different in every seed and at every place it is written.
    Random {
        /// Root mean square.
        rms: f64,
        /// τ_c.
        correlation_time_s: f64,
        /// Zero before, fading in over one correlation time.
        #[serde(default)]
        from_s: f64,
        /// Zero afterwards, fading out over one correlation time before.
        #[serde(default = "never", skip_serializing_if = "is_never")]
        to_s: f64,
    },
}

fn never() -> f64 {
    f64::INFINITY
}

// By reference, because serde asks so.
fn is_never(time: &f64) -> bool {
    *time == f64::INFINITY
}

impl Piece {
    /// Checks the numbers; `key` says where the piece stands.
    pub(super) fn validate(&self, key: &str, problems: &mut Vec<Problem>) {
        let mut window = |from: f64, to: f64| {
            finite(problems, &format!("{key}.from_s"), from);
            if to.is_nan() || to <= from {
                problems.push(Problem::new(format!("{key}.to_s"), to, "must be later than from_s"));
            }
        };
        match self {
            Self::Constant { value } => finite(problems, &format!("{key}.value"), *value),
            Self::Points { points } => {
                if points.is_empty() {
                    problems.push(Problem::new(format!("{key}.points"), 0, "needs one point or more"));
                }
                for (i, point) in points.iter().enumerate() {
                    for number in point {
                        finite(problems, &format!("{key}.points[{i}]"), *number);
                    }
                    if i > 0 && point[0] < points[i - 1][0] {
                        let reason = "times must not fall";
                        problems.push(Problem::new(format!("{key}.points[{i}]"), point[0], reason));
                    }
                }
            }
            Self::Step { at_s, value } => {
                finite(problems, &format!("{key}.at_s"), *at_s);
                finite(problems, &format!("{key}.value"), *value);
            }
            Self::Ramp { from_s, to_s, value } => {
                window(*from_s, *to_s);
                finite(problems, &format!("{key}.to_s"), *to_s);
                finite(problems, &format!("{key}.value"), *value);
            }
            Self::Sine { amplitude, frequency_hz, phase_rad, offset, from_s, to_s } => {
                window(*from_s, *to_s);
                finite(problems, &format!("{key}.amplitude"), *amplitude);
                finite(problems, &format!("{key}.frequency_hz"), *frequency_hz);
                finite(problems, &format!("{key}.phase_rad"), *phase_rad);
                finite(problems, &format!("{key}.offset"), *offset);
            }
            Self::Chirp { amplitude, from_hz, to_hz, from_s, to_s } => {
                window(*from_s, *to_s);
                finite(problems, &format!("{key}.to_s"), *to_s);
                finite(problems, &format!("{key}.amplitude"), *amplitude);
                finite(problems, &format!("{key}.from_hz"), *from_hz);
                finite(problems, &format!("{key}.to_hz"), *to_hz);
            }
            Self::Random { rms, correlation_time_s, from_s, to_s } => {
                window(*from_s, *to_s);
                finite(problems, &format!("{key}.rms"), *rms);
                positive(problems, &format!("{key}.correlation_time_s"), *correlation_time_s);
                if *correlation_time_s > 0.0 && *correlation_time_s < 0.05 {
                    let key = format!("{key}.correlation_time_s");
                    problems.push(Problem::new(key, correlation_time_s, "must be 0.05 or more"));
                }
            }
        }
    }
}
