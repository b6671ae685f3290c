//! A filter's view of its own consistency: are the innovations as large, and as independent, as the
//! filter believes?

use super::Innovation;

/// Running second moments of normalized innovations.
///
/// A consistent filter has NIS 1 and no correlation from one innovation to the next. Both are
/// tracked with exponential forgetting; single outliers are limited to [`Self::CLIP`] standard
/// deviations, so that one bad frame is no inconsistency.
#[derive(Clone, Copy, Debug)]
pub struct InnovationMonitor {
    memory: f64,
    /// Innovations that count, up to the memory.
    seen: f64,
    square: f64,
    product: f64,
    previous: f64,
}

impl InnovationMonitor {
    /// Normalized innovations count up to this many standard deviations. Tuned, no test on record.
    pub const CLIP: f64 = 5.0;

    /// Consistency is believed at the start as after this many innovations. Tuned with the test `accuracy`.
    const PRIOR: f64 = 20.0;

    /// A memory of about `memory` innovations; starts consistent.
    pub fn new(memory: f64) -> Self {
        let memory = memory.max(1.0);
        Self { memory, seen: Self::PRIOR.min(memory), square: 1.0, product: 0.0, previous: 0.0 }
    }

    /// Takes one innovation.
    pub fn step(&mut self, innovation: &Innovation) {
        let value = innovation.normalized().clamp(-Self::CLIP, Self::CLIP);
        if !value.is_finite() {
            return;
        }
        self.seen = (self.seen + 1.0).min(self.memory);
        self.square += (value * value - self.square) / self.seen;
        self.product += (value * self.previous - self.product) / self.seen;
        self.previous = value;
    }

    /// Mean NIS; 1 when consistent.
    pub fn nis(&self) -> f64 {
        self.square
    }

    /// Correlation between one innovation and the next; 0 when consistent.
    pub fn correlation(&self) -> f64 {
        if self.square > 0.0 { (self.product / self.square).clamp(-0.95, 0.95) } else { 0.0 }
    }

    /// How many times fewer independent measurements there were than innovations, for an
    /// autoregressive noise of this correlation; at least one.
    pub fn redundancy(&self) -> f64 {
        let rho = self.correlation().max(0.0);
        (1.0 + rho) / (1.0 - rho)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn feed(monitor: &mut InnovationMonitor, values: impl Iterator<Item = f64>) {
        for residual in values {
            monitor.step(&Innovation { residual, variance: 1.0 });
        }
    }

    #[test]
    fn alternating_signs_are_consistent_and_runs_are_not() {
        let mut monitor = InnovationMonitor::new(50.0);
        feed(&mut monitor, (0..500).map(|i| if i % 2 == 0 { 1.0 } else { -1.0 }));
        assert!((monitor.nis() - 1.0).abs() < 0.01 && monitor.redundancy() < 1.01);
        feed(&mut monitor, (0..500).map(|i| if i % 20 < 10 { 2.0 } else { -2.0 }));
        assert!(monitor.nis() > 3.5 && monitor.redundancy() > 4.0);
    }
}
