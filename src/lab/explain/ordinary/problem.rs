//! The least squares of free runs: residuals, cost, slopes, normal equations and a step.

use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;

use super::grid::STEP_S;
use super::inputs::{BLOCK_POINTS, FreeDrive};
use super::numbers::{Free, placed, prior_cost};
use super::robust::{deviation, loss, memory, weight};
use super::run::{Predicted, run};
use crate::explain::model::Model;
use predict::car::Compute;

/// Of so many grid points one is fitted to: residuals next to each other say the same.
const EVERY: usize = 3;

/// What a residual is divided by: size of a channel, and the memory of its residuals in points.
#[derive(Clone, Copy, Debug)]
pub struct Scale {
    pub noise: [f64; 2],
    pub memory: [f64; 2],
}

impl Scale {
    /// 1 + 2 Σ ρ of a first-order noise is twice its time constant over the rows' distance.
    pub fn time_constant(memory: f64) -> f64 {
        0.5 * memory * EVERY as f64 * STEP_S
    }

    /// The other way round.
    pub fn memory_of(time_constant_s: f64) -> f64 {
        2.0 * time_constant_s / (EVERY as f64 * STEP_S)
    }
}

/// A problem.
#[derive(Clone, Copy)]
pub struct Problem<'p, 'a> {
    /// What is fitted …
    pub model: &'p Model<'a>,
    /// … by these numbers of it …
    pub free: &'p [Free],
    /// … to the fitted part of these.
    pub drives: &'p [FreeDrive],
}

/// By drive: for each number that it has, how the residuals of both channels change with it.
pub(super) type Slopes = Vec<Vec<(usize, Vec<[f64; 2]>)>>;

/// Normal equations at a point.
pub(super) struct Normal {
    pub information: DMatrix<f64>,
    pub gradient: DVector<f64>,
    /// Outer products of the gradients of the blocks …
    pub scatter: DMatrix<f64>,
    /// … and of the drives.
    pub scatter_of_drives: DMatrix<f64>,
}

impl Problem<'_, '_> {
    pub(super) fn predict(&self, at: &[f64]) -> Vec<Predicted> {
        (0..self.drives.len()).into_par_iter().map(|drive| self.predict_one(at, drive)).collect()
    }

    fn predict_one(&self, at: &[f64], drive: usize) -> Predicted {
        let (model, sensing) = placed(self.model, self.free, at, drive);
        run(&self.drives[drive], &model.car(), sensing, Compute::Motion)
    }

    /// Residuals of both channels at every so many grid points, not a number where there are none.
    pub fn residuals(&self, drive: &FreeDrive, predicted: &Predicted) -> Vec<[f64; 2]> {
        let at = |i: usize| {
            if !drive.counts[i] || drive.held[i] {
                return [f64::NAN; 2];
            }
            let lateral =
                drive.lateral.as_ref().map_or(f64::NAN, |lateral| lateral[i] - predicted.lateral[i]);
            [drive.yaw_rate[i] - predicted.yaw_rate[i], lateral]
        };
        (0..drive.points()).step_by(EVERY).map(at).collect()
    }

    /// A tenth of what the channels do: enough to begin with.
    pub(super) fn first_scale(&self) -> Scale {
        let spread = |of: &dyn Fn(&FreeDrive) -> Option<Vec<f64>>| {
            let all: Vec<f64> =
                self.drives.iter().filter_map(of).flatten().filter(|v| v.is_finite()).collect();
            let mean = all.iter().sum::<f64>() / all.len().max(1) as f64;
            let square = all.iter().map(|v| (v - mean) * (v - mean)).sum::<f64>() / all.len().max(1) as f64;
            0.1 * square.sqrt()
        };
        let yaw = spread(&|drive| Some(drive.yaw_rate.clone())).max(1e-3);
        let lateral = spread(&|drive| drive.lateral.clone()).max(0.05);
        Scale { noise: [yaw, lateral], memory: [8.0, 8.0] }
    }

    /// Size and memory of the residuals.
    pub(super) fn learned(&self, predicted: &[Predicted], before: Scale) -> Scale {
        let mut scale = before;
        let series: Vec<Vec<[f64; 2]>> = self
            .drives
            .iter()
            .zip(predicted)
            .map(|(drive, predicted)| self.residuals(drive, predicted))
            .collect();
        for channel in 0..2 {
            let errors = series.iter().flatten().map(|row| row[channel]);
            if errors.clone().filter(|error| error.is_finite()).count() < 50 {
                continue;
            }
            scale.noise[channel] = deviation(errors).unwrap_or(0.0).max(1e-6);
            scale.memory[channel] = memory(&series, channel);
        }
        scale
    }

    /// What is made as small as can be.
    pub(super) fn cost(&self, at: &[f64], predicted: &[Predicted], scale: &Scale) -> f64 {
        let mut cost = self.prior_cost(at);
        for (drive, predicted) in self.drives.iter().zip(predicted) {
            for row in self.residuals(drive, predicted) {
                for (channel, error) in row.into_iter().enumerate().filter(|(_, error)| error.is_finite()) {
                    cost += loss(error / scale.noise[channel]) / scale.memory[channel];
                }
            }
        }
        cost
    }

    /// What is thought of the numbers, −2 ln.
    pub fn prior_cost(&self, at: &[f64]) -> f64 {
        prior_cost(self.free, at)
    }

    /// How the residuals of each drive change with the numbers that it has, by differences.
    pub(super) fn slopes(&self, at: &[f64], predicted: &[Predicted]) -> Slopes {
        let count = self.free.len();
        let tasks: Vec<(usize, usize)> = (0..self.drives.len())
            .flat_map(|drive| (0..count).map(move |place| (drive, place)))
            .filter(|(drive, place)| self.free[*place].of.has(*drive))
            .collect();
        let moved = |(drive, place): (usize, usize)| {
            let free = &self.free[place];
            if let Some(channel) = free.number.offsets() {
                let mut slope = [0.0; 2];
                slope[channel] = free.of.share(drive);
                return (drive, place, vec![slope; self.drives[drive].points().div_ceil(EVERY)]);
            }
            let mut there = at.to_vec();
            // Inwards from an upper bound.
            let step = if at[place] + free.step > free.bounds.1 { -free.step } else { free.step };
            there[place] += step;
            let by = self.residuals(&self.drives[drive], &self.predict_one(&there, drive));
            let here = self.residuals(&self.drives[drive], &predicted[drive]);
            let slopes =
                here.iter().zip(by).map(|(here, by)| [(here[0] - by[0]) / step, (here[1] - by[1]) / step]);
            (drive, place, slopes.collect::<Vec<_>>())
        };
        let mut slopes: Slopes = vec![Vec::new(); self.drives.len()];
        for (drive, place, column) in tasks.into_par_iter().map(moved).collect::<Vec<_>>() {
            slopes[drive].push((place, column));
        }
        slopes
    }

    /// Gauss–Newton's normal equations.
    pub(super) fn normal(
        &self,
        at: &[f64],
        predicted: &[Predicted],
        slopes: &Slopes,
        scale: &Scale,
    ) -> Normal {
        let count = self.free.len();
        let mut normal = Normal {
            information: DMatrix::zeros(count, count),
            gradient: DVector::zeros(count),
            scatter: DMatrix::zeros(count, count),
            scatter_of_drives: DMatrix::zeros(count, count),
        };
        for ((drive, predicted), columns) in self.drives.iter().zip(predicted).zip(slopes) {
            self.add(&mut normal, drive, predicted, columns, scale);
        }
        for (i, free) in self.free.iter().enumerate() {
            let weight = 1.0 / (free.prior.1 * free.prior.1);
            normal.information[(i, i)] += weight;
            normal.gradient[i] += weight * (free.prior.0 - at[i]);
        }
        normal
    }

    /// What one drive says.
    fn add(
        &self,
        normal: &mut Normal,
        drive: &FreeDrive,
        predicted: &Predicted,
        columns: &[(usize, Vec<[f64; 2]>)],
        scale: &Scale,
    ) {
        let own = columns.len();
        let per_block = BLOCK_POINTS / EVERY;
        let mut information = DMatrix::<f64>::zeros(own, own);
        let mut of_block = DVector::<f64>::zeros(own);
        let mut of_drive = DVector::<f64>::zeros(own);
        let mut slopes = vec![0.0; own];
        let residuals = self.residuals(drive, predicted);
        for (row, errors) in residuals.iter().enumerate() {
            for channel in 0..2 {
                let error = errors[channel] / scale.noise[channel];
                if !error.is_finite() {
                    continue;
                }
                let weight = weight(error) / scale.memory[channel];
                for (slope, (_, column)) in slopes.iter_mut().zip(columns) {
                    *slope = column[row][channel] / scale.noise[channel];
                }
                for i in 0..own {
                    of_block[i] += weight * slopes[i] * error;
                    for j in 0..=i {
                        information[(i, j)] += weight * slopes[i] * slopes[j];
                    }
                }
            }
            if (row + 1) % per_block == 0 || row + 1 == residuals.len() {
                for (i, (at, _)) in columns.iter().enumerate() {
                    normal.gradient[*at] += of_block[i];
                    for (j, (to, _)) in columns.iter().enumerate() {
                        normal.scatter[(*at, *to)] += of_block[i] * of_block[j];
                    }
                }
                of_drive += &of_block;
                of_block.fill(0.0);
            }
        }
        for (i, (at, _)) in columns.iter().enumerate() {
            for (j, (to, _)) in columns.iter().enumerate() {
                normal.scatter_of_drives[(*at, *to)] += of_drive[i] * of_drive[j];
                normal.information[(*at, *to)] += information[(i.max(j), i.min(j))];
            }
        }
    }
}
