//! Two-sided CUSUM change detection (thesis 2.25).

/// Which way the watched quantity went.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Alarm {
    /// It rose.
    Up,
    /// It fell.
    Down,
}

/// Accumulates what exceeds the drift, on both sides, until a threshold is passed.
///
/// Fed with normalized innovations (unit variance while nothing changes), drift and threshold are in
/// standard deviations: for white normal input there are about (exp(a) − 1 − a)/(4 drift²) inputs between
/// two false alarms, both sides together, with a = 2 drift (threshold + 1.166) (Siegmund).
#[derive(Clone, Copy, Debug)]
pub struct Cusum {
    drift: f64,
    threshold: f64,
    up: f64,
    down: f64,
}

impl Cusum {
    /// `drift` is what is forgiven at each input, `threshold` what the sum may reach.
    pub const fn new(drift: f64, threshold: f64) -> Self {
        Self { drift, threshold, up: 0.0, down: 0.0 }
    }

    /// Takes one value; on an alarm both sums start again from zero. What is not finite is ignored.
    #[inline]
    pub fn step(&mut self, value: f64) -> Option<Alarm> {
        if !value.is_finite() {
            return None;
        }
        self.up = (self.up + value - self.drift).max(0.0);
        self.down = (self.down - value - self.drift).max(0.0);
        let alarm = if self.up > self.threshold {
            Alarm::Up
        } else if self.down > self.threshold {
            Alarm::Down
        } else {
            return None;
        };
        self.reset();
        Some(alarm)
    }

    /// How near the sums are to an alarm, 0–1.
    pub fn suspicion(&self) -> f64 {
        self.up.max(self.down) / self.threshold
    }

    /// Forgets what was summed up.
    pub fn reset(&mut self) {
        self.up = 0.0;
        self.down = 0.0;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_step_is_noticed_with_its_sign_and_only_once() {
        let mut cusum = Cusum::new(0.5, 5.0);
        assert!((0..100).all(|_| cusum.step(0.4).is_none()));
        let alarms: Vec<_> = (0..5).filter_map(|_| cusum.step(-2.0)).collect();
        assert_eq!(alarms, [Alarm::Down]);
    }

    #[test]
    fn what_is_not_a_number_changes_nothing() {
        let mut cusum = Cusum::new(0.0, 1.0);
        assert_eq!(cusum.step(f64::NAN), None);
        assert_eq!(cusum.step(2.0), Some(Alarm::Up));
    }
}
