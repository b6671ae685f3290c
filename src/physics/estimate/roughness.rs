//! How rough the road is (thesis 3.3.1): by how much more the wheels' speeds scatter than their sensors do.
//!
//! A soft slope may be gravel or snow; gravel shakes the wheels, snow and ice do not. Roughness is the scatter of the
//! difference between front and rear wheel of a side about its trend over a block: the car's own acceleration cancels
//! out. It depends on the suspension as well as on the road, so it does not compare across cars; its unit is the
//! speed of the rim. A calibrated mapping from slope to friction knows how rough its roads were and gives nothing on
//! others ([`Mapping::holds_on`](super::mapping::Mapping::holds_on)).

use super::block::Block;
use crate::estimates::Estimate;

/// Averages the scatter of the wheels' speeds.
#[derive(Clone, Debug)]
pub struct Roughness {
    /// Of one wheel's speed by its data sheet, m/s.
    wheel_noise: f64,
    /// Variance of one wheel's speed, (m/s)², and over how many seconds it is averaged.
    variance: f64,
    averaged_s: f64,
    /// Since the last block, s.
    age_s: f64,
}

impl Roughness {
    /// The last so many seconds count. Tuned with the test `long_drives`.
    const MEMORY_S: f64 = 2.0;
    /// Less than this tells nothing, s. Tuned with the test `long_drives`.
    const LEAST_S: f64 = 0.5;
    /// An axle hops at 10 to 15 Hz: so many independent readings a second has each side. Physical.
    const INDEPENDENT_HZ: f64 = 20.0;

    /// `wheel_noise` is that of one wheel's speed by its data sheet, m/s.
    pub fn new(wheel_noise: f64) -> Self {
        Self { wheel_noise, variance: 0.0, averaged_s: 0.0, age_s: 0.0 }
    }

    /// Time passes.
    pub fn age(&mut self, elapsed_s: f64) {
        self.age_s += elapsed_s;
        if self.age_s > Self::MEMORY_S {
            self.averaged_s = 0.0;
        }
    }

    /// Takes a block of rolling: brakes and wheels that spin scatter by themselves.
    pub fn step(&mut self, block: &Block) {
        let [left, right] = block.difference_std;
        // The difference of two wheels has the variance of both.
        let variance = 0.25 * (left * left + right * right);
        if !variance.is_finite() {
            return;
        }
        self.age_s = 0.0;
        self.averaged_s = (self.averaged_s + block.duration_s).min(Self::MEMORY_S);
        self.variance += block.duration_s / self.averaged_s * (variance - self.variance);
    }

    /// Standard deviation of the rims' speed about their rolling, beyond the sensors' own, m/s.
    pub fn estimate(&self) -> Option<Estimate> {
        if self.averaged_s < Self::LEAST_S {
            return None;
        }
        let beyond = (self.variance - self.wheel_noise * self.wheel_noise).max(0.0);
        let readings = 2.0 * Self::INDEPENDENT_HZ * self.averaged_s;
        let variance_std = self.variance * (2.0 / readings).sqrt();
        let value = beyond.sqrt();
        // A root is never known better than where it begins to rise.
        Some(Estimate {
            value,
            std: variance_std / (2.0 * value.max(variance_std.sqrt())),
            age_s: self.age_s,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn block(scatter: f64) -> Block {
        Block {
            duration_s: 0.25,
            difference_std: [std::f64::consts::SQRT_2 * scatter; 2],
            ..Block::default()
        }
    }

    #[test]
    fn what_the_sensors_scatter_is_taken_off_and_what_is_long_ago_forgotten() {
        let mut roughness = Roughness::new(0.03);
        assert_eq!(roughness.estimate(), None);
        for scatter in [0.03, 0.05] {
            for _ in 0..40 {
                roughness.age(0.25);
                roughness.step(&block(scatter));
            }
            let found = roughness.estimate().unwrap();
            let truth = f64::sqrt(scatter * scatter - 0.03 * 0.03);
            assert!((found.value - truth).abs() < 0.001, "{found:?}");
            assert!(found.std > 0.0 && found.std < 0.02 && found.age_s == 0.0, "{found:?}");
        }
        roughness.age(1.0);
        assert_eq!(roughness.estimate().unwrap().age_s, 1.0);
        roughness.age(2.0);
        assert_eq!(roughness.estimate(), None);
    }
}
