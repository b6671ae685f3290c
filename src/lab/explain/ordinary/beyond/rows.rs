//! Errors of free runs as rows of a least-squares problem.

use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;

use super::super::inputs::{FreeDrive, turning};
use super::super::numbers::{Free, placed};
use super::super::robust::{loss, weight};
use super::super::run::{Predicted, Track, run};
use super::Search;
use super::colour::{CHANNELS, Colour, Series};
use crate::explain::model::Model;
use predict::car::Compute;

/// Of so many grid points one is a row.
pub const EVERY: usize = 3;

/// Blocks of 6 s, rows.
const BLOCK: usize = 200;

/// A run that says more, rad/s or m/s², or nothing finite, is of no car. Numerical.
const OUT_OF_BOUNDS: f64 = 1e3;

/// Whitened rows of everything that counts.
pub struct Rows {
    /// Drive, channel, row.
    pub places: Vec<(usize, usize, usize)>,
    /// Is it held out?
    pub held: Vec<bool>,
}

/// −2 ln likelihood of rows.
#[derive(Clone, Copy, Debug, Default)]
pub struct Cost {
    /// Of the training part.
    pub train: f64,
    /// Of the held-out part.
    pub held: f64,
    /// Of the training part, by channel.
    pub by_channel: [f64; CHANNELS],
}

impl Search<'_> {
    /// The colour of what does not last: of a state's errors less their means over blocks. In the colour of all of them
    /// an effect that lasts would look like slow noise.
    pub(super) fn short_colour(&self, errors: &[Series]) -> Colour {
        let level = |series: &Vec<f64>| -> Vec<f64> {
            let blocks = series.chunks(BLOCK).flat_map(|block| {
                let known: Vec<f64> = block.iter().copied().filter(|error| error.is_finite()).collect();
                let mean = known.iter().sum::<f64>() / known.len().max(1) as f64;
                block.iter().map(move |error| error - mean)
            });
            blocks.collect()
        };
        let levelled: Vec<Series> = errors.iter().map(|series| series.each_ref().map(level)).collect();
        self.colour(&levelled)
    }

    pub(super) fn colour(&self, errors: &[Series]) -> Colour {
        let train = |(drive, errors): (&FreeDrive, &Series)| {
            let counts = rows(drive).map(|i| drive.counts[i] && !drive.held[i]).collect();
            (errors.clone(), counts)
        };
        Colour::of(&self.drives.iter().zip(errors).map(train).collect::<Vec<_>>())
    }

    /// What a model predicts of each drive.
    pub(super) fn predicted(&self, model: &Model<'_>, free: &[Free], at: &[f64]) -> Vec<Predicted> {
        let of = |(number, drive): (usize, &FreeDrive)| {
            let (model, sensing) = placed(model, free, at, number);
            run(drive, &model.car(), sensing, Compute::Motion)
        };
        self.drives.par_iter().enumerate().map(of).collect()
    }

    /// What a model does not predict.
    pub(super) fn errors(&self, model: &Model<'_>, free: &[Free], at: &[f64]) -> Vec<Series> {
        let of = |drive: usize| self.errors_of(model, free, at, drive);
        (0..self.drives.len()).into_par_iter().map(of).collect()
    }

    pub(super) fn errors_of(&self, model: &Model<'_>, free: &[Free], at: &[f64], number: usize) -> Series {
        let (model, sensing) = placed(model, free, at, number);
        self.unpredicted(number, &run(&self.drives[number], &model.car(), sensing, Compute::Readings))
    }

    /// What one drive has that was not predicted.
    fn unpredicted(&self, number: usize, predicted: &Predicted) -> Series {
        let drive = &self.drives[number];
        let difference = |measured: Option<&[f64]>, predicted: &[f64]| -> Vec<f64> {
            let error = |measured: f64, predicted: f64| {
                if predicted.abs() < OUT_OF_BOUNDS { measured - predicted } else { OUT_OF_BOUNDS }
            };
            rows(drive)
                .map(|i| measured.map_or(f64::NAN, |measured| error(measured[i], predicted[i])))
                .collect()
        };
        let axle = |axle: usize| {
            let by_wheels =
                turning(self.vehicle, axle, &predicted.wheels[2 * axle], &predicted.wheels[2 * axle + 1]);
            difference(drive.axles[axle].as_deref(), &by_wheels)
        };
        [
            difference(Some(&drive.yaw_rate), &predicted.yaw_rate),
            difference(drive.lateral.as_deref(), &predicted.lateral),
            axle(0),
            axle(1),
        ]
    }

    /// A model's run along each drive, from which others can branch off.
    pub(super) fn tracks(&self, model: &Model<'_>, free: &[Free], at: &[f64]) -> Vec<Track> {
        let of = |(number, drive): (usize, &FreeDrive)| {
            let (model, sensing) = placed(model, free, at, number);
            Track::of(drive, &model.car(), sensing)
        };
        self.drives.par_iter().enumerate().map(of).collect()
    }

    /// What a model does not predict of one drive that differs between two moments, s, from one whose runs are known.
    pub(super) fn branched(
        &self,
        tracks: &[Track],
        between: [f64; 2],
        (model, free, at): (&Model<'_>, &[Free], &[f64]),
        number: usize,
    ) -> Series {
        let (model, sensing) = placed(model, free, at, number);
        let drive = &self.drives[number];
        self.unpredicted(number, &tracks[number].branch(drive, &model.car(), sensing, between))
    }

    pub(super) fn slopes(
        &self,
        model: &Model<'_>,
        free: &[Free],
        at: &[f64],
        errors: &[Series],
    ) -> Vec<Vec<Series>> {
        let of = |place: usize| self.slope(model, free, (at, errors), (place, free[place].step), None);
        (0..free.len()).into_par_iter().map(of).collect()
    }

    /// How the predictions change with one number; `branch` are the runs without it, and between which moments, s, it acts.
    pub(super) fn slope(
        &self,
        model: &Model<'_>,
        free: &[Free],
        (at, errors): (&[f64], &[Series]),
        (place, step): (usize, f64),
        branch: Option<(&[Track], [f64; 2])>,
    ) -> Vec<Series> {
        let mut there = at.to_vec();
        let step = if at[place] + step > free[place].bounds.1 { -step } else { step };
        there[place] += step;
        let of = |(drive, errors): (usize, &Series)| -> Series {
            if !free[place].of.has(drive) {
                return std::array::from_fn(|channel| vec![0.0; errors[channel].len()]);
            }
            let moved = match branch {
                Some((tracks, between)) => self.branched(tracks, between, (model, free, &there), drive),
                None => self.errors_of(model, free, &there, drive),
            };
            std::array::from_fn(|channel| {
                errors[channel]
                    .iter()
                    .zip(&moved[channel])
                    .map(|(here, there)| (here - there) / step)
                    .collect()
            })
        };
        errors.iter().enumerate().map(of).collect()
    }

    /// The rows that count in a colour.
    pub(super) fn rows(&self, colour: &Colour, errors: &[Series]) -> Rows {
        let mut all = Rows { places: Vec::new(), held: Vec::new() };
        for (number, (drive, errors)) in self.drives.iter().zip(errors).enumerate() {
            for channel in 0..CHANNELS {
                for (row, error) in colour.whitened(channel, errors).into_iter().enumerate() {
                    if error.is_finite() && drive.counts[row * EVERY] {
                        all.places.push((number, channel, row));
                        all.held.push(drive.held[row * EVERY]);
                    }
                }
            }
        }
        all
    }

    /// Rows of something in a colour.
    pub(super) fn white(&self, colour: &Colour, rows: &Rows, series: &[Series]) -> DVector<f64> {
        rows.of(&whitened(colour, series), 0)
    }

    /// Of whitened errors.
    pub(super) fn cost(&self, colour: &Colour, rows: &Rows, errors: &DVector<f64>) -> Cost {
        let mut all = Cost::default();
        for ((error, (_, channel, _)), is_held) in errors.iter().zip(&rows.places).zip(&rows.held) {
            let cost = loss(*error) + colour.cost_of_size(*channel);
            if *is_held {
                all.held += cost;
            } else {
                all.train += cost;
                all.by_channel[*channel] += cost;
            }
        }
        all
    }

    /// Sum of held-out squares of a channel.
    pub(super) fn held_square(&self, errors: &[Series], channel: usize) -> f64 {
        let of = |(drive, errors): (&FreeDrive, &Series)| -> f64 {
            let counts = rows(drive).map(|i| drive.counts[i] && drive.held[i]);
            let held =
                errors[channel].iter().zip(counts).filter(|(error, counts)| *counts && error.is_finite());
            held.map(|(error, _)| error * error).sum()
        };
        self.drives.iter().zip(errors).map(of).sum()
    }
}

impl Rows {
    /// The rows of something whitened, so many rows later; those at the end are the first ones.
    pub fn of(&self, white: &[Series], shift: usize) -> DVector<f64> {
        let of = |(drive, channel, row): &(usize, usize, usize)| {
            let all = &white[*drive][*channel];
            let later = row + shift;
            let value = all[if later < all.len() { later } else { later % all.len() }];
            if value.is_finite() { value } else { 0.0 }
        };
        DVector::from_iterator(self.places.len(), self.places.iter().map(of))
    }
}

/// Something of each drive in a colour.
pub fn whitened(colour: &Colour, series: &[Series]) -> Vec<Series> {
    let of = |series: &Series| std::array::from_fn(|channel| colour.whitened(channel, series));
    series.iter().map(of).collect()
}

/// Grid points of the rows.
pub fn rows(drive: &FreeDrive) -> impl Iterator<Item = usize> + use<> {
    (0..drive.points()).step_by(EVERY)
}

/// Robust weights of training rows; held-out rows have none.
pub fn weights(white: &DVector<f64>, rows: &Rows) -> DVector<f64> {
    let of = |(error, held): (&f64, &bool)| if *held { 0.0 } else { weight(*error) };
    DVector::from_iterator(white.len(), white.iter().zip(&rows.held).map(of))
}

/// Normal equations with the priors.
pub fn normal(
    columns: &[&DVector<f64>],
    white: &DVector<f64>,
    rows: &Rows,
    free: &[Free],
    at: &[f64],
) -> (DMatrix<f64>, DVector<f64>) {
    let weights = weights(white, rows);
    let count = columns.len();
    let weighed: Vec<DVector<f64>> =
        columns.par_iter().map(|column| column.component_mul(&weights)).collect();
    let mut information = DMatrix::zeros(count, count);
    let entries: Vec<(usize, usize, f64)> = (0..count)
        .into_par_iter()
        .flat_map_iter(|i| (0..=i).map(move |j| (i, j)))
        .map(|(i, j)| (i, j, weighed[i].dot(columns[j])))
        .collect();
    for (i, j, value) in entries {
        information[(i, j)] = value;
        information[(j, i)] = value;
    }
    let mut gradient = DVector::from_iterator(count, weighed.iter().map(|column| column.dot(white)));
    for i in 0..count {
        let precision = free[i].prior.1.powi(-2);
        information[(i, i)] += precision;
        gradient[i] += precision * (free[i].prior.0 - at[i]);
    }
    (information, gradient)
}
