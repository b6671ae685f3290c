//! The courses of a drive by fixed-interval smoothing (Rauch, Tung and Striebel) over a pass of the filter.

use nalgebra::{DMatrix, DVector};

use super::locate::merged;
use super::model::Model;
use predict::FILTERED;
use predict::GriddedDrive;
use predict::car::BODY_STATES;
use predict::grid::STEP_S;
use predict::noise::Noise;
use predict::pass::pass_backwards;
use predict::sums::{Filtered, UsedReadings};

/// A course with its uncertainty, at grid points.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Smoothed {
    /// Times, s.
    pub t: Vec<f64>,
    /// Values.
    pub value: Vec<f64>,
    /// Standard deviations.
    pub std: Vec<f64>,
}

impl Smoothed {
    /// Stretches, s, in which value and standard deviation fulfil something: longer than `shortest_s`, gaps up
    /// to `bridged_s` bridged.
    pub fn stretches(
        &self,
        is_in: impl Fn(f64, f64) -> bool,
        bridged_s: f64,
        shortest_s: f64,
    ) -> Vec<[f64; 2]> {
        let points = self.t.iter().zip(self.value.iter().zip(&self.std));
        let inside = points.filter(|(_, (value, std))| is_in(**value, **std));
        let mut all = merged(inside.map(|(t, _)| [*t, t + STEP_S]), bridged_s);
        all.retain(|[from, to]| to - from > shortest_s);
        all
    }

    /// Largest absolute value.
    pub fn peak(&self) -> f64 {
        self.value.iter().fold(0.0, |peak, value| peak.max(value.abs()))
    }
}

/// All courses that the model's filter estimates over a drive, by their places.
pub fn courses(
    drive: &GriddedDrive,
    model: &Model<'_>,
    noise: &Noise,
    readings: UsedReadings,
) -> Vec<Smoothed> {
    let n = BODY_STATES + noise.live.len();
    let mut all = vec![Smoothed::default(); noise.live.len()];
    if all.is_empty() {
        return all;
    }
    // Stretch by stretch, each from its end.
    let mut later = None;
    pass_backwards(drive, &model.car(), noise, readings, &mut |steps| {
        for (k, state, variance) in backwards(steps, n, &mut later) {
            for (live, course) in all.iter_mut().enumerate() {
                course.t.push(k as f64 * STEP_S);
                course.value.push(state[BODY_STATES + live]);
                course.std.push(variance[BODY_STATES + live].max(0.0).sqrt());
            }
        }
    });
    for course in &mut all {
        course.t.reverse();
        course.value.reverse();
        course.std.reverse();
    }
    all
}

/// A step with its smoothed state and covariance.
type Later = (Filtered, DVector<f64>, DMatrix<f64>);

/// Smoothed states and variances of a stretch, last step first; what comes `later` in its run, if anything does,
/// is known, and the stretch's first step is put there for the one before.
fn backwards(
    steps: &[Filtered],
    n: usize,
    later: &mut Option<Later>,
) -> Vec<(usize, DVector<f64>, DVector<f64>)> {
    let vector = |x: &[f64; FILTERED]| DVector::from_fn(n, |i, _| x[i]);
    let matrix = |p: &[[f64; FILTERED]; FILTERED]| DMatrix::from_fn(n, n, |i, j| p[i][j]);
    let mut out = Vec::with_capacity(steps.len());
    for now in steps.iter().rev() {
        let filtered = (vector(&now.filtered.0), matrix(&now.filtered.1));
        let smoothed = match later.take() {
            None => filtered,
            Some((next, mut x, mut p)) => {
                let predicted = matrix(&next.predicted.1);
                let Some(inverse) = predicted.clone().cholesky().map(|c| c.inverse()) else {
                    *later = Some((*now, x, p));
                    continue;
                };
                let gain = &filtered.1 * matrix(&next.a).transpose() * inverse;
                x = &filtered.0 + &gain * (x - vector(&next.predicted.0));
                p = &filtered.1 + &gain * (p - predicted) * gain.transpose();
                (x, p)
            }
        };
        out.push((now.k, smoothed.0.clone(), smoothed.1.diagonal()));
        // Nothing leads from one run into another.
        *later = (!now.begins).then_some((*now, smoothed.0, smoothed.1));
    }
    out
}
