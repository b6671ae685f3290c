//! Means over a few tenths of a second of lateral motion, and the exact integrals between them.

/// Integrals along the way: what v_y changes by.
#[derive(Clone, Copy, Debug, Default)]
pub struct Path {
    /// Time, s.
    pub time: f64,
    /// Distance, m.
    pub distance: f64,
    /// ∫ a_y dt, m/s.
    pub pushed: f64,
    /// ∫ v_x r dt, m/s.
    pub turned: f64,
}

impl Path {
    /// This one's entries combined with another's.
    pub fn with(&self, other: &Path, combine: impl Fn(f64, f64) -> f64) -> Path {
        Path {
            time: combine(self.time, other.time),
            distance: combine(self.distance, other.distance),
            pushed: combine(self.pushed, other.pushed),
            turned: combine(self.turned, other.turned),
        }
    }
}

/// Means of a window.
#[derive(Clone, Copy, Debug, Default)]
pub struct Means {
    pub speed: f64,
    pub yaw_rate: f64,
    pub yaw_acceleration: f64,
    /// What is not known of the yaw acceleration.
    pub yaw_acceleration_std: f64,
    pub acceleration: f64,
    /// How much the lateral acceleration moved within the window (standard deviation).
    pub acceleration_spread: f64,
    pub angle: f64,
    /// Of the rear wheels.
    pub rear_angle: f64,
    /// Normalized force along the car.
    pub along: f64,
    pub samples: f64,
    /// Mean of the integrals, counted from the mean of the window before.
    pub path: Path,
}

/// Sums of the samples of a window.
#[derive(Clone, Debug, Default)]
pub struct Window {
    length_s: f64,
    sums: Means,
    /// Integrals up to now, counted from the last window's mean.
    pub path: Path,
    time: f64,
    time_sum: f64,
    time_square: f64,
    time_yaw: f64,
    yaw_square: f64,
    acceleration_square: f64,
}

impl Window {
    /// Fewer samples have no scatter about their line. Statistical.
    const FEWEST: f64 = 4.0;

    /// A window of `length_s` seconds.
    pub fn new(length_s: f64) -> Self {
        Self { length_s, ..Self::default() }
    }

    pub fn step(&mut self, sample: &Means, elapsed_s: f64) -> Option<Means> {
        let passed = Path {
            time: elapsed_s,
            distance: elapsed_s * sample.speed,
            pushed: elapsed_s * sample.acceleration,
            turned: elapsed_s * sample.speed * sample.yaw_rate,
        };
        self.path = self.path.with(&passed, |sum, step| sum + step);
        let sums = &mut self.sums;
        sums.samples += 1.0;
        sums.speed += sample.speed;
        sums.yaw_rate += sample.yaw_rate;
        sums.acceleration += sample.acceleration;
        sums.angle += sample.angle;
        sums.rear_angle += sample.rear_angle;
        sums.along += sample.along;
        sums.path = sums.path.with(&self.path, |sum, path| sum + path);
        self.time_sum += self.time;
        self.time_square += self.time * self.time;
        self.time_yaw += self.time * sample.yaw_rate;
        self.yaw_square += sample.yaw_rate * sample.yaw_rate;
        self.acceleration_square += sample.acceleration * sample.acceleration;
        self.time += elapsed_s;
        // Half a sample of tolerance: the sum of many periods is not exactly the window's length.
        if self.time + 0.5 * elapsed_s < self.length_s {
            return None;
        }
        let means = self.means();
        let path = self.path.with(&means.path, |now, mean| now - mean);
        *self = Self { path, ..Self::new(self.length_s) };
        (means.samples >= Self::FEWEST).then_some(means)
    }

    fn means(&self) -> Means {
        let sums = &self.sums;
        let n = sums.samples;
        let spread = self.time_square - self.time_sum * self.time_sum / n;
        let rate = (self.time_yaw - self.time_sum * sums.yaw_rate / n) / spread;
        let around_line = self.yaw_square - sums.yaw_rate * sums.yaw_rate / n - rate * rate * spread;
        Means {
            speed: sums.speed / n,
            yaw_rate: sums.yaw_rate / n,
            yaw_acceleration: rate,
            yaw_acceleration_std: (around_line.max(0.0) / (n - 2.0).max(1.0) / spread).sqrt(),
            acceleration: sums.acceleration / n,
            acceleration_spread: (self.acceleration_square / n - (sums.acceleration / n).powi(2))
                .max(0.0)
                .sqrt(),
            angle: sums.angle / n,
            rear_angle: sums.rear_angle / n,
            along: sums.along / n,
            samples: n,
            path: sums.path.with(&Path::default(), |sum, _| sum / n),
        }
    }
}

/// Running variances of the yaw acceleration and of its noise.
#[derive(Clone, Copy, Debug, Default)]
pub struct YawAcceleration {
    total: f64,
    noise: f64,
}

impl YawAcceleration {
    /// Windows that are remembered. Tuned, no test on record.
    const MEMORY: f64 = 100.0;

    /// Replaces the measured yaw acceleration by its expectation, given the share of noise in it. The remaining error
    /// is then independent of the value and does not bias a slope.
    pub fn shrink(&mut self, means: &mut Means) {
        self.total += (means.yaw_acceleration.powi(2) - self.total) / Self::MEMORY;
        self.noise += (means.yaw_acceleration_std.powi(2) - self.noise) / Self::MEMORY;
        let signal = (self.total - self.noise).max(0.0);
        let share =
            if self.total > 0.0 { signal / (signal + self.noise).max(f64::MIN_POSITIVE) } else { 0.0 };
        means.yaw_acceleration *= share;
        means.yaw_acceleration_std = (share * self.noise).sqrt();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_path_between_windows_is_exact_at_any_frequency() {
        let mut window = Window::new(0.4);
        let mut velocity = 0.0;
        let mut sum = (0.0, 0.0);
        let mut before: Option<f64> = None;
        for i in 0..400 {
            let acceleration = (i as f64 * 0.7).sin();
            velocity += 0.01 * acceleration;
            sum = (sum.0 + velocity, sum.1 + 1.0);
            let sample = Means { speed: 20.0, acceleration, samples: 1.0, ..Means::default() };
            if let Some(means) = window.step(&sample, 0.01) {
                let mean = sum.0 / sum.1;
                if let Some(before) = before {
                    assert!((means.path.pushed - (mean - before)).abs() < 1e-12);
                    assert!((means.path.time - 0.4).abs() < 1e-12);
                }
                before = Some(mean);
                sum = (0.0, 0.0);
            }
        }
        assert!(before.is_some());
    }

    #[test]
    fn a_yaw_acceleration_that_is_mostly_noise_is_mostly_shrunk() {
        let mut shrinking = YawAcceleration::default();
        let mut last = Means::default();
        for i in 0..1000 {
            let value = if i % 2 == 0 { 0.01 } else { -0.01 };
            last = Means { yaw_acceleration: value, yaw_acceleration_std: 0.01, ..Means::default() };
            shrinking.shrink(&mut last);
        }
        assert!(last.yaw_acceleration.abs() < 0.002, "{last:?}");
    }
}
