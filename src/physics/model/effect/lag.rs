//! First-order lags, however short.

/// Below this a lag is not integrated as it is, s: it would need shorter steps than its influence is
/// worth. Numerical: with the steps of 10 ms that drives are run with.
const SHORTEST_S: f64 = 0.0125;

/// What comes out of a lag of `time_constant`, s: the state or, where the lag is shorter than
/// [`SHORTEST_S`], as much of the input beside it as makes the delay that of the short lag. Smooth in the
/// time constant, and the input itself at zero.
pub(super) fn output(input: f64, state: f64, time_constant: f64) -> f64 {
    let share = (time_constant / SHORTEST_S).clamp(0.0, 1.0);
    input + share * (state - input)
}

/// How the state changes, per second.
pub(super) fn rate(input: f64, state: f64, time_constant: f64) -> f64 {
    (input - state) * fastest_rate(time_constant)
}

/// The rate itself, 1/s.
pub(super) fn fastest_rate(time_constant: f64) -> f64 {
    1.0 / time_constant.max(SHORTEST_S)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// How late a ramp comes out, s.
    fn delay_of(time_constant: f64) -> f64 {
        let h = 1e-4;
        let mut state = 0.0;
        for i in 0..100_000 {
            state += h * rate(f64::from(i) * h, state, time_constant);
        }
        10.0 - output(10.0, state, time_constant)
    }

    #[test]
    fn a_ramp_is_late_by_the_time_constant_even_a_short_one() {
        for time_constant in [0.0, 0.001, 0.0124, 0.0125, 0.06] {
            let delay = delay_of(time_constant);
            assert!((delay - time_constant).abs() < 1e-6, "{time_constant}: {delay}");
        }
    }
}
