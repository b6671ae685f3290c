//! An FMU's parameters tuned to a recording, within their ranges.
//!
//! What is compared are the outputs that the recording has, each by the deviation of what was recorded of it, without its
//! mean: zeros of sensors are not the model's. The search is that of Levenberg and Marquardt; derivatives are differences
//! of runs, all of them in one process.

use nalgebra::{DMatrix, DVector};

use super::ForeignError;
use super::job::{Job, Run, Value};
use super::parent::{Program, Rows};
use super::wiring::{Recorded, Wiring, at};

/// What came of tuning.
#[derive(Clone, Debug)]
pub struct Tuned {
    /// Parameters: name, value before and after, and whether it stands at an end of its range.
    pub values: Vec<(String, f64, f64, bool)>,
    /// Share of what was recorded that is left over, rms by rms, before and after.
    pub left: [f64; 2],
    /// The last run.
    pub rows: Rows,
}

/// Rounds of the search.
const MOST_ROUNDS: usize = 20;
/// A round that gains less than this share of the squares is the last.
const GAIN: f64 = 1e-4;
/// A difference is over this share of the range.
const DIFFERENCE: f64 = 1e-3;

/// Runs an FMU, tuned where there is something to tune.
///
/// # Errors
/// How a run failed.
pub fn tune(
    wiring: &Wiring,
    recorded: &Recorded,
    program: &Program,
    archive: &std::path::Path,
) -> Result<Tuned, ForeignError> {
    let search = Search { wiring, recorded, program, archive };
    let knobs = &wiring.tuned;
    let mut at: Vec<f64> =
        knobs.iter().map(|knob| (knob.start - knob.range[0]) / (knob.range[1] - knob.range[0])).collect();
    let mut rows = search.runs(std::slice::from_ref(&at))?.remove(0);
    let mut residual = search.residual(&rows);
    let before = rms(&residual);
    let mut damping = 1e-3;
    for _ in 0..if knobs.is_empty() { 0 } else { MOST_ROUNDS } {
        // Into the range, from its upper end.
        let differences: Vec<f64> =
            at.iter().map(|at| if at + DIFFERENCE <= 1.0 { DIFFERENCE } else { -DIFFERENCE }).collect();
        let moved: Vec<Vec<f64>> = (0..at.len())
            .map(|place| {
                let mut moved = at.clone();
                moved[place] += differences[place];
                moved
            })
            .collect();
        let columns: Vec<DVector<f64>> = search
            .runs(&moved)?
            .iter()
            .zip(&differences)
            .map(|(rows, difference)| (search.residual(rows) - &residual) / *difference)
            .collect();
        let jacobian = DMatrix::from_columns(&columns);
        let (normal, gradient) = (jacobian.tr_mul(&jacobian), jacobian.tr_mul(&residual));
        let cost = residual.norm_squared();
        let mut gained = false;
        while damping < 1e6 {
            let step = step(&normal, &gradient, damping, &at);
            let next: Vec<f64> =
                at.iter().zip(step.iter()).map(|(at, step)| (at - step).clamp(0.0, 1.0)).collect();
            let next_rows = search.runs(std::slice::from_ref(&next))?.remove(0);
            let next_residual = search.residual(&next_rows);
            let gain = cost - next_residual.norm_squared();
            if gain > 0.0 {
                (at, rows, residual) = (next, next_rows, next_residual);
                damping = (damping * 0.1).max(1e-9);
                gained = gain > GAIN * cost;
                break;
            }
            damping *= 10.0;
        }
        if !gained {
            break;
        }
    }
    let values = knobs.iter().zip(&at).map(|(knob, at)| {
        let value = knob.range[0] + at * (knob.range[1] - knob.range[0]);
        (knob.name.clone(), knob.start, value, *at < DIFFERENCE || *at > 1.0 - DIFFERENCE)
    });
    Ok(Tuned { values: values.collect(), left: [before, rms(&residual)], rows })
}

/// The damped step; what stands at an end of its range and would go beyond stays out of it.
fn step(normal: &DMatrix<f64>, gradient: &DVector<f64>, damping: f64, at: &[f64]) -> DVector<f64> {
    let mut damped = normal.clone();
    let mut gradient = gradient.clone();
    for place in 0..at.len() {
        let is_held =
            (at[place] <= 0.0 && gradient[place] > 0.0) || (at[place] >= 1.0 && gradient[place] < 0.0);
        if is_held {
            damped.row_mut(place).fill(0.0);
            damped.column_mut(place).fill(0.0);
            gradient[place] = 0.0;
        }
        // A parameter without any influence stays where it is.
        damped[(place, place)] += damping * damped[(place, place)] + f64::EPSILON;
        if is_held {
            damped[(place, place)] = 1.0;
        }
    }
    let none = DVector::zeros(at.len());
    damped.cholesky().map_or(none, |factors| factors.solve(&gradient))
}

fn rms(residual: &DVector<f64>) -> f64 {
    residual.norm() / (residual.len().max(1) as f64).sqrt()
}

struct Search<'a> {
    wiring: &'a Wiring,
    recorded: &'a Recorded,
    program: &'a Program,
    archive: &'a std::path::Path,
}

impl Search<'_> {
    /// Runs at places within the ranges.
    fn runs(&self, places: &[Vec<f64>]) -> Result<Vec<Rows>, ForeignError> {
        let common = self.wiring.job.runs.first().cloned().unwrap_or_default();
        let run = |at: &Vec<f64>| {
            let value = |(knob, at): (&super::wiring::Knob, &f64)| Value {
                kind: knob.kind,
                reference: knob.reference,
                value: knob.range[0] + at * (knob.range[1] - knob.range[0]),
            };
            let tuned = self.wiring.tuned.iter().zip(at).map(value);
            Run { set: common.set.iter().copied().chain(tuned).collect() }
        };
        let job = Job { runs: places.iter().map(run).collect(), ..self.wiring.job.clone() };
        let done = self.program.work(&job);
        done.map_err(|reason| ForeignError::Run(self.archive.to_owned(), reason))
    }

    /// What a run leaves of the recording.
    fn residual(&self, rows: &Rows) -> DVector<f64> {
        let tracks = self.wiring.tracks(rows);
        let mut all = Vec::new();
        for (quantity, _) in &self.wiring.outputs {
            let recorded = &self.recorded[*quantity as usize];
            let (Some((first, _)), Some((last, _))) = (recorded.first(), recorded.last()) else { continue };
            let within = tracks[*quantity as usize].iter().filter(|(t, _)| first <= t && t <= last);
            let (expected, left): (Vec<f64>, Vec<f64>) = within
                .map(|(t, value)| {
                    let expected = at(recorded, *t);
                    (expected, value - expected)
                })
                .unzip();
            let deviation = deviation(&expected);
            // A channel that stands still says nothing.
            if deviation > 0.0 {
                let mean = left.iter().sum::<f64>() / left.len() as f64;
                all.extend(left.iter().map(|left| (left - mean) / deviation));
            }
        }
        DVector::from_vec(all)
    }
}

fn deviation(values: &[f64]) -> f64 {
    let count = values.len().max(1) as f64;
    let mean = values.iter().sum::<f64>() / count;
    (values.iter().map(|value| (value - mean).powi(2)).sum::<f64>() / count).sqrt()
}
