//! What a simulated segment adds to the normal equations.

use nalgebra::{DMatrix, DVector, Vector3};

use super::segment::{LANES, Trace, products};

/// Residuals and derivatives of one segment, summed by channel. They are not weighted yet: weights may change without
/// another simulation.
#[derive(Clone, Debug)]
pub(super) struct SegmentSums {
    pub(super) channels: Vec<ChannelSums>,
    pub(super) end: Vector3<f64>,
    /// Derivatives of the end by parameters and start.
    pub(super) end_by: DMatrix<f64>,
}

/// Sums over the rows of one channel; derivatives by the parameters, then by the start.
#[derive(Clone, Debug)]
pub(super) struct ChannelSums {
    pub(super) channel: usize,
    pub(super) square: f64,
    pub(super) gradient: DVector<f64>,
    pub(super) information: DMatrix<f64>,
}

impl SegmentSums {
    /// From simulations that together carry all derivatives.
    pub(super) fn new(traces: &[Trace], channels: &[usize], count: usize) -> Self {
        let sums = channels.iter().enumerate().map(|(number, channel)| {
            let residuals = &traces[0].residuals[number];
            let mut gradient = DVector::zeros(count);
            let mut information = DMatrix::zeros(count, count);
            for (i, a) in traces.iter().enumerate() {
                for (residual, by) in residuals.iter().zip(&a.by[number]) {
                    for (lane, by) in by.iter().enumerate().take(count - i * LANES) {
                        gradient[i * LANES + lane] += residual * by;
                    }
                }
                for (j, b) in traces.iter().enumerate().skip(i) {
                    let block = products(&a.by[number], &b.by[number]);
                    for (row, line) in block.iter().enumerate().take(count - i * LANES) {
                        for (column, value) in line.iter().enumerate().take(count - j * LANES) {
                            information[(i * LANES + row, j * LANES + column)] = *value;
                            information[(j * LANES + column, i * LANES + row)] = *value;
                        }
                    }
                }
            }
            let square = residuals.iter().map(|residual| residual * residual).sum();
            ChannelSums { channel: *channel, square, gradient, information }
        });
        Self {
            channels: sums.collect(),
            end: Vector3::from_fn(|i, _| traces[0].end[i].value),
            end_by: DMatrix::from_fn(3, count, |i, j| traces[j / LANES].end[i].by[j % LANES]),
        }
    }
}
