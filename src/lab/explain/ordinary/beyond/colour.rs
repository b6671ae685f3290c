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

/// Noise of each channel.
#[derive(Clone, Debug)]
pub struct Colour {
    /// Weights of the errors before, the last one first.
    weights: [[f64; ORDER]; CHANNELS],
    /// Deviation of what they do not predict; not a number where the channel has too few errors.
    size: [f64; CHANNELS],
}

impl Colour {
    /// Of the errors of some drives that `counts` says count, row by row.
    pub fn of(drives: &[(Series, Vec<bool>)]) -> Self {
        let mut colour = Self { weights: [[0.0; ORDER]; CHANNELS], size: [f64::NAN; CHANNELS] };
        for channel in 0..CHANNELS {
            let errors = |drive: &(Series, Vec<bool>)| -> Vec<f64> {
                let of = |(error, counts): (&f64, &bool)| if *counts { *error } else { f64::NAN };
                drive.0[channel].iter().zip(&drive.1).map(of).collect()
            };
            let all: Vec<Vec<f64>> = drives.iter().map(errors).collect();
            let Some(most) = robust_deviation(all.iter().flatten()).map(|deviation| OUTLIER * deviation)
            else {
                continue;
            };
            let limited: Vec<Vec<f64>> =
                all.into_iter().map(|drive| drive.iter().map(|e| e.clamp(-most, most)).collect()).collect();
            colour.weights[channel] = autoregression(&limited);
            let left = limited.iter().flat_map(|drive| filtered(drive, &colour.weights[channel]));
            let left: Vec<f64> = left.filter(|error| error.is_finite()).collect();
            colour.size[channel] = likeliest_size(&left).unwrap_or(f64::NAN);
        }
        colour
    }

    /// What the moments before do not predict of a channel, in deviations.
    pub fn whitened(&self, channel: usize, series: &[f64]) -> Vec<f64> {
        let size = self.size[channel];
        filtered(series, &self.weights[channel]).map(|error| error / size).collect()
    }

    /// What an error of this channel costs for the noise's size, −2 ln likelihood.
    pub fn cost_of_size(&self, channel: usize) -> f64 {
        2.0 * self.size[channel].ln()
    }
}

fn filtered<'s>(series: &'s [f64], weights: &'s [f64; ORDER]) -> impl Iterator<Item = f64> + 's {
    (0..series.len()).map(move |i| {
        if i < ORDER {
            return f64::NAN;
        }
        let before: f64 = weights.iter().enumerate().map(|(lag, weight)| weight * series[i - 1 - lag]).sum();
        series[i] - before
    })
}

/// Least squares of each error on those before.
fn autoregression(drives: &[Vec<f64>]) -> [f64; ORDER] {
    let mut information = DMatrix::<f64>::zeros(ORDER, ORDER);
    let mut gradient = DVector::<f64>::zeros(ORDER);
    for drive in drives {
        for window in drive.windows(ORDER + 1).filter(|window| window.iter().all(|e| e.is_finite())) {
            let before = DVector::from_fn(ORDER, |lag, _| window[ORDER - 1 - lag]);
            gradient.axpy(window[ORDER], &before, 1.0);
            information.ger(1.0, &before, &before, 1.0);
        }
    }
    // A hundredth of a per mille more keeps a constant channel solvable.
    for i in 0..ORDER {
        information[(i, i)] *= 1.0 + 1e-5;
    }
    let found = information.cholesky().map(|factor| factor.solve(&gradient));
    std::array::from_fn(|lag| found.as_ref().map_or(0.0, |found| found[lag]))
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
        let drive = ([noise.clone(), empty.clone(), empty.clone(), empty], vec![true; noise.len()]);
        let colour = Colour::of(&[drive]);
        let white: Vec<f64> =
            colour.whitened(0, &noise).into_iter().filter(|error| error.is_finite()).collect();
        let correlation: f64 = white.windows(2).map(|pair| pair[0] * pair[1]).sum::<f64>()
            / white.iter().map(|error| error * error).sum::<f64>();
        assert!(correlation.abs() < 0.02, "{correlation}");
        // A robust one: of the uniform noise's 0.289 its tails' part is missing.
        assert!((0.2..0.289).contains(&colour.size[0]), "{}", colour.size[0]);
        assert!(colour.whitened(1, &noise)[100].is_nan());
    }
}
