//! Errors of free runs as a likelihood sees them: each channel has a colour of its own, and what follows from the
//! moments before tells nothing new.

use nalgebra::{DMatrix, DVector};

use super::super::robust::{deviation, weight};

/// Yaw rate, lateral acceleration, yaw rate by the front and by the rear wheels.
pub const CHANNELS: usize = 4;

/// One drive's errors, or what a number changes of them, by channel; not a number where nothing is known.
pub type Series = [Vec<f64>; CHANNELS];

/// The colour of noise: an autoregression of this order for each channel. At 30 ms it has the memory of filters, of a
/// mean over 0.2 s, and of a slow wander beside white noise.
const ORDER: usize = 8;

/// Errors beyond so many robust deviations do not shape the colour.
const OUTLIER: f64 = 5.0;

/// Fewer errors tell no colour.
const LEAST: usize = 100;

/// What of other channels at the same moment, and at so many before, tells a channel's error: a motion that the model misses
/// is in all of them. The wheels' are told first, then the gyroscope's beside them, then the accelerometer's beside all.
const OTHERS: [&[usize]; CHANNELS] = [&[2, 3], &[2, 3, 0], &[], &[2]];
const LAGS_OF_OTHERS: usize = 3;

/// Noise of each channel.
#[derive(Clone, Debug)]
pub struct Colour {
    /// How each channel follows from what is known before it.
    follows: [Follows; CHANNELS],
    /// Deviation of what they do not predict; not a number where the channel has too few errors.
    size: [f64; CHANNELS],
}

/// How a channel's error follows from what is known before it.
#[derive(Clone, Debug, Default)]
struct Follows {
    /// From its own before, the last one first.
    own: [f64; ORDER],
    /// From those of others, the one of the same moment first.
    others: Vec<(usize, [f64; LAGS_OF_OTHERS])>,
}

impl Colour {
    /// Of the errors of some drives that `counts` says count, row by row.
    pub fn of(drives: &[(Series, Vec<bool>)]) -> Self {
        let mut colour = Self { follows: Default::default(), size: [f64::NAN; CHANNELS] };
        let counted = |(series, counts): &(Series, Vec<bool>)| -> Series {
            series.each_ref().map(|errors| {
                let of = |(error, counts): (&f64, &bool)| if *counts { *error } else { f64::NAN };
                errors.iter().zip(counts).map(of).collect()
            })
        };
        let mut all: Vec<Series> = drives.iter().map(counted).collect();
        // Where a drive lacks a channel, nothing follows from that.
        let is_known = |all: &[Series], channel: usize| {
            all.iter().all(|series| series[channel].iter().filter(|error| error.is_finite()).count() >= LEAST)
        };
        let known: [bool; CHANNELS] = std::array::from_fn(|channel| is_known(&all, channel));
        for channel in 0..CHANNELS {
            let errors = all.iter().flat_map(|series| &series[channel]);
            let Some(most) = robust_deviation(errors).map(|deviation| OUTLIER * deviation) else { continue };
            for series in &mut all {
                series[channel].iter_mut().for_each(|error| *error = error.clamp(-most, most));
            }
        }
        for channel in 0..CHANNELS {
            let others = OTHERS[channel].iter().copied().filter(|other| known[*other] && known[channel]);
            let follows = Follows::of(&all, channel, others.collect());
            let left: Vec<f64> = all
                .iter()
                .flat_map(|series| follows.left(channel, series))
                .filter(|error| error.is_finite())
                .collect();
            if let Some(size) = likeliest_size(&left) {
                colour.follows[channel] = follows;
                colour.size[channel] = size;
            }
        }
        colour
    }

    /// What is not predicted of a channel, in deviations.
    pub fn whitened(&self, channel: usize, series: &Series) -> Vec<f64> {
        let size = self.size[channel];
        self.follows[channel].left(channel, series).into_iter().map(|error| error / size).collect()
    }

    /// What an error of this channel costs for the noise's size, −2 ln likelihood.
    pub fn cost_of_size(&self, channel: usize) -> f64 {
        2.0 * self.size[channel].ln()
    }
}

impl Follows {
    /// What it does not tell of a channel.
    fn left(&self, channel: usize, series: &Series) -> Vec<f64> {
        let errors = &series[channel];
        let mut left = vec![f64::NAN; errors.len()];
        let Some(now) = errors.get(ORDER..) else { return left };
        // Lag by lag, so that the sums are taken side by side.
        let add = |told: &mut [f64], weight: f64, before: &[f64]| {
            told.iter_mut().zip(before).for_each(|(told, before)| *told += weight * before);
        };
        let (mut own, mut by_others) = (vec![0.0; now.len()], vec![0.0; now.len()]);
        for (lag, weight) in self.own.iter().enumerate() {
            add(&mut own, *weight, &errors[ORDER - 1 - lag..]);
        }
        for (other, weights) in &self.others {
            for (lag, weight) in weights.iter().enumerate() {
                add(&mut by_others, *weight, &series[*other][ORDER - lag..]);
            }
        }
        for (i, left) in left[ORDER..].iter_mut().enumerate() {
            *left = now[i] - own[i] - by_others[i];
        }
        left
    }

    /// Of what is missed alike. Errors of opposite sign are not of the motion: a gyroscope that reads too much pulls the model
    /// away from the wheels, and noise that follows from them so would swallow it.
    fn of(drives: &[Series], channel: usize, mut others: Vec<usize>) -> Self {
        loop {
            let follows = Self::least_squares(drives, channel, others.clone());
            let all = |weights: &[f64; LAGS_OF_OTHERS]| weights.iter().sum::<f64>();
            let least = follows.others.iter().min_by(|a, b| all(&a.1).total_cmp(&all(&b.1)));
            match least.filter(|(_, weights)| all(weights) < 0.0) {
                Some((opposite, _)) => others.retain(|other| other != opposite),
                None => return follows,
            }
        }
    }

    /// Least squares of each error on what is known before it.
    fn least_squares(drives: &[Series], channel: usize, others: Vec<usize>) -> Self {
        let count = ORDER + LAGS_OF_OTHERS * others.len();
        let mut information = DMatrix::<f64>::zeros(count, count);
        let mut gradient = DVector::<f64>::zeros(count);
        let mut known = DVector::<f64>::zeros(count);
        for series in drives {
            for i in ORDER..series[channel].len() {
                let own = (1..=ORDER).map(|lag| series[channel][i - lag]);
                let of_others = others
                    .iter()
                    .flat_map(|other| (0..LAGS_OF_OTHERS).map(move |lag| series[*other][i - lag]));
                known.iter_mut().zip(own.chain(of_others)).for_each(|(known, error)| *known = error);
                let now = series[channel][i];
                if now.is_finite() && known.iter().all(|error| error.is_finite()) {
                    gradient.axpy(now, &known, 1.0);
                    information.ger(1.0, &known, &known, 1.0);
                }
            }
        }
        // A hundredth of a per mille more keeps a constant channel solvable.
        for i in 0..count {
            information[(i, i)] *= 1.0 + 1e-5;
        }
        let Some(found) = information.cholesky().map(|factor| factor.solve(&gradient)) else {
            return Self::default();
        };
        let of_other = |(place, other): (usize, usize)| {
            (other, std::array::from_fn(|lag| found[ORDER + LAGS_OF_OTHERS * place + lag]))
        };
        Self {
            own: std::array::from_fn(|lag| found[lag]),
            others: others.into_iter().enumerate().map(of_other).collect(),
        }
    }
}

/// The size at which the robust likelihood of the errors is largest: Σ w e² = N s².
fn likeliest_size(errors: &[f64]) -> Option<f64> {
    let mut size = robust_deviation(errors.iter())?.max(1e-9);
    for _ in 0..SIZE_ROUNDS {
        let square: f64 = errors.iter().map(|error| weight(error / size) * error * error).sum();
        size = (square / errors.len() as f64).sqrt().max(1e-9);
    }
    Some(size)
}

/// Rounds of that. Numerical.
const SIZE_ROUNDS: usize = 12;

/// The robust deviation of errors that are enough to tell it.
fn robust_deviation<'e>(errors: impl Iterator<Item = &'e f64> + Clone) -> Option<f64> {
    let known = errors.clone().filter(|error| error.is_finite()).count();
    deviation(errors.copied()).filter(|_| known >= LEAST)
}

#[cfg(test)]
mod tests {
    use rand::{RngExt, SeedableRng};
    use rand_chacha::ChaCha8Rng;

    use super::*;

    /// GIVEN noise that remembers half of the moment before WHEN its colour is learned THEN what is left is white and as
    /// large as what drove it.
    #[test]
    fn what_is_left_of_coloured_noise_is_white() {
        let mut random = ChaCha8Rng::seed_from_u64(3);
        let mut value = 0.0;
        let noise: Vec<f64> = (0..20_000)
            .map(|_| {
                value = 0.5 * value + (random.random::<f64>() - 0.5);
                value
            })
            .collect();
        let empty = vec![f64::NAN; noise.len()];
        let count = noise.len();
        let series = [noise, empty.clone(), empty.clone(), empty];
        let colour = Colour::of(&[(series.clone(), vec![true; count])]);
        let white: Vec<f64> =
            colour.whitened(0, &series).into_iter().filter(|error| error.is_finite()).collect();
        let correlation: f64 = white.windows(2).map(|pair| pair[0] * pair[1]).sum::<f64>()
            / white.iter().map(|error| error * error).sum::<f64>();
        assert!(correlation.abs() < 0.02, "{correlation}");
        // A robust one: of the uniform noise's 0.289 its tails' part is missing.
        assert!((0.2..0.289).contains(&colour.size[0]), "{}", colour.size[0]);
        assert!(colour.whitened(1, &series)[100].is_nan());
    }

    /// GIVEN a motion that gyroscope and wheels miss alike, and a little noise of each WHEN their colour is learned THEN what
    /// the gyroscope misses beside the wheels is its own noise, and alone it is all of it.
    #[test]
    fn what_all_miss_is_told_once() {
        let mut random = ChaCha8Rng::seed_from_u64(4);
        let (mut motion, mut series) = (0.0, Series::default());
        for _ in 0..5_000 {
            motion = 0.98 * motion + (random.random::<f64>() - 0.5);
            for channel in [0, 2, 3] {
                series[channel].push(motion + 0.1 * (random.random::<f64>() - 0.5));
            }
            series[1].push(f64::NAN);
        }
        let size = |series: &Series| Colour::of(&[(series.clone(), vec![true; 5_000])]).size[0];
        let beside = size(&series);
        series[2].fill(f64::NAN);
        series[3].fill(f64::NAN);
        let alone = size(&series);
        assert!(beside < 0.04 && alone > 0.2, "{beside} {alone}");
    }
}
