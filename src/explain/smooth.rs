//! How a course went, seen from the end of the drive: Rauch, Tung and Striebel's smoother over a pass.

use nalgebra::{DMatrix, DVector};

use super::locate::merged;
use super::model::Model;
use super::predict::Drive;
use super::predict::FILTERED;
use super::predict::car::BODY_STATES;
use super::predict::drive::STEP_S;
use super::predict::noise::Noise;
use super::predict::pass::{Ask, Filtered, Readers, pass};

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
pub fn courses(drive: &Drive, model: &Model<'_>, noise: &Noise, readers: Readers) -> Vec<Smoothed> {
    let mut steps = Vec::new();
    let ask = Ask { steps: Some(&mut steps), readers, ..Ask::default() };
    pass((0, drive), &model.car(), &[], noise, ask);
    let n = BODY_STATES + noise.live.len();
    let mut all = vec![Smoothed::default(); noise.live.len()];
    // Run by run, each from its end.
    let mut end = steps.len();
    while end > 0 {
        let begin = steps[..end].iter().rposition(|step| step.begins).unwrap_or(0);
        for (k, state, variance) in backwards(&steps[begin..end], n) {
            for (live, course) in all.iter_mut().enumerate() {
                course.t.push(k as f64 * STEP_S);
                course.value.push(state[BODY_STATES + live]);
                course.std.push(variance[BODY_STATES + live].max(0.0).sqrt());
            }
        }
        end = begin;
    }
    for course in &mut all {
        course.t.reverse();
        course.value.reverse();
        course.std.reverse();
    }
    all
}

/// Smoothed states and variances of a run, last step first.
fn backwards(steps: &[Filtered], n: usize) -> Vec<(usize, DVector<f64>, DVector<f64>)> {
    let vector = |x: &[f64; FILTERED]| DVector::from_fn(n, |i, _| x[i]);
    let matrix = |p: &[[f64; FILTERED]; FILTERED]| DMatrix::from_fn(n, n, |i, j| p[i][j]);
    let mut out = Vec::with_capacity(steps.len());
    let Some(last) = steps.last() else { return out };
    let mut x = vector(&last.filtered.0);
    let mut p = matrix(&last.filtered.1);
    out.push((last.k, x.clone(), p.diagonal()));
    for pair in steps.windows(2).rev() {
        let (now, next) = (&pair[0], &pair[1]);
        let filtered = matrix(&now.filtered.1);
        let predicted = matrix(&next.predicted.1);
        let a = matrix(&next.a);
        let Some(inverse) = predicted.clone().cholesky().map(|c| c.inverse()) else { continue };
        let gain = &filtered * a.transpose() * inverse;
        x = vector(&now.filtered.0) + &gain * (x - vector(&next.predicted.0));
        p = &filtered + &gain * (p - predicted) * gain.transpose();
        out.push((now.k, x.clone(), p.diagonal()));
    }
    out
}
