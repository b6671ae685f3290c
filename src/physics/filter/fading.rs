//! What is left of the past.

/// The share e^(−T/τ) of something that is left after a time T, asked for from sample to sample: T is nearly always
/// the same, and the exponential is reckoned only where it is another one.
#[derive(Clone, Copy, Debug)]
pub struct Fading {
    time_constant_s: f64,
    elapsed_s: f64,
    left: f64,
}

impl Fading {
    /// With this time constant τ, s.
    pub const fn over(time_constant_s: f64) -> Self {
        Self { time_constant_s, elapsed_s: f64::NAN, left: f64::NAN }
    }

    /// What is left after so long, s.
    #[inline]
    pub fn left(&mut self, elapsed_s: f64) -> f64 {
        if elapsed_s != self.elapsed_s {
            (self.elapsed_s, self.left) = (elapsed_s, (-elapsed_s / self.time_constant_s).exp());
        }
        self.left
    }

    /// Moves a smoothed value towards what it is now, after so long, s.
    #[inline]
    pub fn smooth(&mut self, value: &mut f64, now: f64, elapsed_s: f64) {
        *value += (1.0 - self.left(elapsed_s)) * (now - *value);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_is_the_exponential_of_whatever_time_was_asked_last() {
        let mut fading = Fading::over(0.15);
        for elapsed_s in [0.01, 0.01, 0.0, 2.5, 0.01, f64::INFINITY, -1.0] {
            assert_eq!(fading.left(elapsed_s), (-elapsed_s / 0.15).exp());
        }
        assert!(fading.left(f64::NAN).is_nan());
    }
}
