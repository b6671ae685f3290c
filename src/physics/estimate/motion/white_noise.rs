//! The white part of a sensor's noise, from its readings alone.
//!
//! Of three readings y₁ − 2 y₂ + y₃ has six times the variance of one reading's white noise; motion within three samples
//! hardly bends, and what is slower than that is left to the innovations. A reading that comes again is no news: the
//! variance is that of one sample if all samples were independent.
//!
//! Noise that was differentiated or filtered somewhere cancels out in means. So the same is asked of the means of some
//! samples; there motion bends more. The smaller of both variances is the noise.

/// Tuned with the test `white_noise`.
struct Tuning {
    /// Readings that are remembered.
    memory: f64,
    /// The promised noise counts as so many readings.
    prior: f64,
    /// One reading may raise the variance as much as this many deviations would.
    clip: f64,
    /// Of the promised variance at least this share is left.
    least: f64,
    /// More samples than this without a new reading: the signal stands.
    standing: f64,
    /// So many samples make a mean, and so many means are remembered.
    block: f64,
    block_memory: f64,
}

const TUNING: Tuning = Tuning {
    memory: 200.0,
    prior: 5.0,
    clip: 4.0,
    least: 0.1,
    standing: 12.0,
    block: 8.0,
    block_memory: 50.0,
};

/// Learns one channel's.
#[derive(Clone, Copy, Debug)]
pub struct WhiteNoise {
    promised: f64,
    variance: f64,
    seen: f64,
    /// The last two readings that differed.
    readings: [f64; 2],
    known: u8,
    /// Samples since the last new reading, and how many there are to one on average.
    samples: f64,
    repeats: f64,
    blocks: Blocks,
}

/// The same for means.
#[derive(Clone, Copy, Debug, Default)]
struct Blocks {
    sum: f64,
    count: f64,
    means: [f64; 2],
    known: u8,
    /// Of a sample, as far as it is known.
    variance: f64,
    seen: f64,
}

impl WhiteNoise {
    /// `promised`: variance by the data sheet.
    pub fn new(promised: f64) -> Self {
        Self {
            promised,
            variance: promised,
            seen: TUNING.prior,
            readings: [0.0; 2],
            known: 0,
            samples: 0.0,
            repeats: 1.0,
            blocks: Blocks::default(),
        }
    }

    /// Takes a sample.
    pub fn step(&mut self, value: f64) {
        self.blocks.step(value);
        self.samples += 1.0;
        let [before, last] = self.readings;
        if self.known > 0 && value == last {
            return;
        }
        let samples = std::mem::take(&mut self.samples);
        self.readings = [last, value];
        if self.known < 2 {
            self.known += 1;
            return;
        }
        if samples > TUNING.standing {
            return;
        }
        self.seen = (self.seen + 1.0).min(TUNING.memory);
        self.repeats += (samples - self.repeats) / self.seen;
        let bend = before - 2.0 * last + value;
        let limit = TUNING.clip * TUNING.clip * self.variance;
        self.variance += ((bend * bend / 6.0).min(limit) - self.variance) / self.seen;
        self.variance = self.variance.max(TUNING.least * self.promised);
    }

    /// The series has a gap.
    pub fn interrupt(&mut self) {
        (self.known, self.samples) = (0, 0.0);
        self.blocks = Blocks { variance: self.blocks.variance, seen: self.blocks.seen, ..Blocks::default() };
    }

    /// Variance of a sample.
    pub fn variance(&self) -> f64 {
        let single = self.variance * self.repeats.max(1.0);
        if self.blocks.seen < 0.5 * TUNING.block_memory {
            return single;
        }
        single.min(self.blocks.variance).max(TUNING.least * self.promised)
    }
}

impl Blocks {
    fn step(&mut self, value: f64) {
        self.sum += value;
        self.count += 1.0;
        if self.count < TUNING.block {
            return;
        }
        let mean = std::mem::take(&mut self.sum) / std::mem::take(&mut self.count);
        let [before, last] = self.means;
        self.means = [last, mean];
        if self.known < 2 {
            self.known += 1;
            return;
        }
        let bend = before - 2.0 * last + mean;
        self.seen = (self.seen + 1.0).min(TUNING.block_memory);
        self.variance += (bend * bend / 6.0 * TUNING.block - self.variance) / self.seen;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn noise_is_learned_whatever_was_promised_and_repeated_readings_count_once() {
        for (repeats, promised) in [(1, 0.01), (2, 0.01), (1, 100.0)] {
            let mut noise = WhiteNoise::new(promised);
            let mut random = 1_u64;
            let mut reading = 0.0;
            for i in 0..2000 {
                if i % repeats == 0 {
                    random = random.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
                    let uniform = (random >> 11) as f64 / (1_u64 << 53) as f64 - 0.5;
                    reading = 12.0_f64.sqrt() * uniform + (0.01 * f64::from(i)).sin();
                }
                noise.step(reading);
            }
            let expected = f64::from(repeats).max(0.1 * promised);
            assert!((noise.variance() / expected - 1.0).abs() < 0.4, "{} of {expected}", noise.variance());
        }
    }
}
