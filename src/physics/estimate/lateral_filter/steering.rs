//! How lively the driver's hands are.

/// Tuned with the test `sim2_joint`.
struct Tuning {
    /// How fast the density follows: ln per unit of excess NIS and sample.
    gain: f64,
    /// NIS counts up to this.
    clip: f64,
    /// Limits of the density, rad²/s³.
    limits: (f64, f64),
    /// The density to begin with, rad²/s³.
    start: f64,
}

const TUNING: Tuning = Tuning { gain: 0.02, clip: 9.0, limits: (1e-6, 1e3), start: 0.1 };

/// Learns the spectral density of the steering's angular acceleration from the steering readings alone, so
/// that a filter of them neither lags behind the hands nor follows the sensor's noise.
///
/// A two-state Kalman filter (angle, rate) whose process noise is turned up while its innovations are larger
/// than it believes, and down while they are smaller.
#[derive(Clone, Copy, Debug)]
pub struct SteeringActivity {
    angle: f64,
    rate: f64,
    /// Covariance: of the angle, of both, of the rate.
    covariance: [f64; 3],
    density: f64,
    variance: f64,
}

impl SteeringActivity {
    /// `variance`: of a reading, rad².
    pub fn new(variance: f64) -> Self {
        Self { angle: 0.0, rate: 0.0, covariance: [1.0, 0.0, 1.0], density: TUNING.start, variance }
    }

    /// Takes a reading, rad; returns the density, rad²/s³.
    pub fn step(&mut self, reading: f64, elapsed_s: f64) -> f64 {
        let h = elapsed_s;
        let [aa, ar, rr] = self.covariance;
        let q = self.density * h;
        let aa = aa + h * (2.0 * ar + h * rr) + q * h * h * 0.25;
        let ar = ar + h * rr + q * h * 0.5;
        let rr = rr + q;
        self.angle += h * self.rate;
        let residual = reading - self.angle;
        let total = aa + self.variance;
        let gains = [aa / total, ar / total];
        self.angle += gains[0] * residual;
        self.rate += gains[1] * residual;
        self.covariance = [aa - gains[0] * aa, ar - gains[0] * ar, rr - gains[1] * ar];
        let surprise = (residual * residual / total).min(TUNING.clip) - 1.0;
        if surprise.is_finite() {
            self.density *= 1.0 + TUNING.gain * surprise;
        }
        self.density = self.density.clamp(TUNING.limits.0, TUNING.limits.1);
        self.density
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand_chacha::ChaCha8Rng;
    use rand_chacha::rand_core::SeedableRng;
    use rand_distr::{Distribution, StandardNormal};

    fn learned(amplitude: f64, frequency_hz: f64) -> f64 {
        let mut activity = SteeringActivity::new(1e-6);
        let mut rng = ChaCha8Rng::seed_from_u64(1);
        let mut density = 0.0;
        for i in 0..5000 {
            let t = f64::from(i) * 0.01;
            let noise: f64 = StandardNormal.sample(&mut rng);
            density = activity
                .step(amplitude * (std::f64::consts::TAU * frequency_hz * t).sin() + 1e-3 * noise, 0.01);
        }
        density
    }

    #[test]
    fn livelier_hands_are_learned_as_such() {
        let (still, calm, lively) = (learned(0.0, 0.5), learned(0.02, 0.5), learned(0.1, 1.0));
        assert!(still < 0.2 * calm && calm < 0.1 * lively, "{still} {calm} {lively}");
    }
}
