//! Measurement noise learned from the innovations.

use super::{Innovation, InnovationMonitor};

/// Tuned: the prior with the test `accuracy`, the rest with no test on record.
struct Tuning {
    /// One measurement may raise the learned variance as much as this many deviations would.
    clip: f64,
    /// The learned variance stays within these multiples of the promised one.
    limits: (f64, f64),
    /// What is promised weighs as much as this many measurements, and is doubted by a factor of two.
    prior: (f64, f64),
}

const TUNING: Tuning = Tuning { clip: 3.0, limits: (0.05, 1e4), prior: (10.0, 2.0) };

/// How much noisier a channel is than its data sheet promises, and how much its noise repeats itself.
///
/// A filter told too small a noise publishes too small an interval; one that takes coloured noise
/// for white does so, too. This learns both: the scale of the variance, and the redundancy by which
/// correlated measurements count less than independent ones.
#[derive(Clone, Copy, Debug)]
pub struct LearnedNoise {
    scale: f64,
    memory: f64,
    /// Measurements that the scale stands on, up to the memory.
    seen: f64,
    monitor: InnovationMonitor,
}

impl LearnedNoise {
    /// A memory of about `memory` measurements; starts with twice what is promised, and learns fast
    /// until the memory is filled.
    pub fn new(memory: f64) -> Self {
        let memory = memory.max(1.0);
        let (seen, scale) = TUNING.prior;
        Self { scale, memory, seen: seen.min(memory), monitor: InnovationMonitor::new(memory) }
    }

    /// Variance to expect of one measurement whose data sheet promises `promised`.
    pub fn variance(&self, promised: f64) -> f64 {
        promised * self.scale
    }

    /// Learns from an innovation that was computed with [`Self::variance`] of `promised`.
    pub fn learn(&mut self, innovation: &Innovation, promised: f64) {
        self.monitor.step(innovation);
        if promised <= 0.0 {
            return;
        }
        let from_state = innovation.variance - self.variance(promised);
        let seen = (innovation.residual * innovation.residual - from_state) / promised;
        if !seen.is_finite() {
            return;
        }
        let limit = TUNING.clip * TUNING.clip * self.scale;
        self.seen = (self.seen + 1.0).min(self.memory);
        self.scale += (seen.clamp(0.0, limit) - self.scale) / self.seen;
        self.scale = self.scale.clamp(TUNING.limits.0, TUNING.limits.1);
    }

    /// How many measurements are worth one independent one; at least one.
    pub fn redundancy(&self) -> f64 {
        self.monitor.redundancy()
    }

    /// Learned variance / promised variance.
    pub fn scale(&self) -> f64 {
        self.scale
    }

    /// Mean NIS; 1 when consistent.
    pub fn nis(&self) -> f64 {
        self.monitor.nis()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_channel_three_times_noisier_than_promised_is_found_out() {
        let mut noise = LearnedNoise::new(100.0);
        for i in 0..2000 {
            let residual = 3.0 * 1.225 * [1.0, -1.0, 0.0][i * 7 % 3];
            let variance = noise.variance(1.0);
            noise.learn(&Innovation { residual, variance }, 1.0);
        }
        assert!((noise.scale() - 9.0).abs() < 1.0, "{}", noise.scale());
        assert!((noise.nis() - 1.0).abs() < 0.15, "{}", noise.nis());
    }
}
