//! What a drive could have told: from the likelihood's curvature, how large an effect must be to be named, and which two
//! cannot be told apart.
//!
//! The numbers are those of the search itself: what an effect of its ordinary size changes, all ordinary numbers refitted,
//! in units of the noise that the drive has.

use nalgebra::DVector;
use rayon::prelude::*;

use super::super::fit::FreeFit;
use super::super::inputs::FreeDrive;
use super::super::numbers::{Free, placed};
use super::climb::State;
use super::course::courses;
use super::planned::with_planned;
use super::round::LEAST_HELD_GAIN;
use super::rows::Rows;
use super::scan::Ground;
use super::trial::{Trial, trials};
use super::{Question, Search, references};
use crate::chance::normal_cdf;
use crate::explain::select::LEAST_EVIDENCE;
use physics::model::Vehicle;

/// A bar that an effect must clear: what it has of it grows with its size, and scatters by one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bar {
    /// By the ordinary size.
    pub slope: f64,
    /// What is needed.
    pub needed: f64,
}

impl Bar {
    /// The share of the ordinary size that clears it with 90 % probability.
    fn share(self) -> f64 {
        (self.needed + NINE_OF_TEN) / self.slope
    }
}

/// What a drive could tell of an effect. Sizes are in the effect's unit, as a change from where it makes no difference.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Power {
    /// The effect with its channel, or the number of the car.
    pub name: String,
    /// The key of its main number …
    pub number: String,
    /// … and its unit.
    pub unit: String,
    /// The size that it usually has.
    pub ordinary: f64,
    /// The smallest size at which something is found with 90 % probability; infinite where it leaves no trace …
    pub noticed: f64,
    /// … and at which that is called by this name.
    pub named: f64,
    /// What it is most easily taken for, and the correlation of what both do.
    pub rival: Option<(String, f64)>,
    /// What a name needs: all bars of a way. Of what varies as it likes each course that was drawn is a way, as likely as the
    /// others; of all else there is one.
    pub ways: Vec<Vec<Bar>>,
    /// Where it makes no difference, in its unit …
    pub neutral: f64,
    /// … and when it begins, s; always there without.
    pub from_s: Option<f64>,
}

impl Power {
    /// How probably a size is called by its name.
    pub fn chance(&self, size: f64) -> f64 {
        chance(&self.ways, size.abs() / self.ordinary)
    }

    /// Something else tells it, too, in these ways; the better one counts.
    pub fn or_by(&mut self, ways: Vec<Vec<Bar>>) {
        let size = smallest(&ways, self.ordinary, 0.9);
        self.noticed = self.noticed.min(size);
        if size < self.named {
            (self.named, self.ways, self.rival) = (size, ways, None);
        }
    }

    /// The size that is called by its name with this probability, between none and ten times what is with 90 %; none where
    /// nothing is.
    pub fn size_of(&self, chance: f64) -> Option<f64> {
        let most = 10.0 * self.named;
        most.is_finite().then(|| reached(|size| self.chance(size) >= chance, most))
    }
}

/// How probably a share of the ordinary size clears all bars of a way, in the mean over the ways.
fn chance(ways: &[Vec<Bar>], share: f64) -> f64 {
    let of =
        |way: &Vec<Bar>| way.iter().map(|bar| normal_cdf(bar.slope * share - bar.needed)).fold(1.0, f64::min);
    ways.iter().map(of).sum::<f64>() / ways.len().max(1) as f64
}

/// The smallest size that clears them with this probability; infinite where none does.
pub(super) fn smallest(ways: &[Vec<Bar>], ordinary: f64, probability: f64) -> f64 {
    let clears = |size: f64| chance(ways, size / ordinary) >= probability;
    let most = MOST_TIMES_ORDINARY * ordinary;
    if clears(most) { reached(clears, most) } else { f64::INFINITY }
}

/// The first size for which something holds that holds for the largest one.
fn reached(holds: impl Fn(f64) -> bool, most: f64) -> f64 {
    let (mut low, mut high) = (0.0, most);
    for _ in 0..HALVINGS {
        let middle = 0.5 * (low + high);
        if holds(middle) { high = middle } else { low = middle }
    }
    high
}

/// Numerical: to a millionth.
const HALVINGS: usize = 40;

/// Beyond so many times the ordinary size the first-order answer means nothing, and no car has it. Numerical.
pub const MOST_TIMES_ORDINARY: f64 = 1000.0;

/// All effects of a search, and how probably the one of a row, at its ordinary size, is told from the one of a column.
#[derive(Clone, Debug, Default)]
pub struct Powers {
    /// By name.
    pub all: Vec<Power>,
    /// Of what varies as it likes; where nothing is planned.
    pub courses: Vec<Power>,
    /// Probabilities.
    pub separable: Vec<Vec<f64>>,
}

/// Of a standard normal variable: with 90 % probability it is not less than so far below its mean. Statistical.
pub const NINE_OF_TEN: f64 = 1.2816;

/// Smaller parts of what an effect does are rounding.
const LEAST_LEFT: f64 = 1e-9;

/// What is left of an effect's trace when the ordinary numbers have taken what they can.
struct Trace<'t> {
    trial: &'t Trial,
    /// Its main number, and where that is for the ordinary size.
    free: Free,
    /// Change of the coordinate at the ordinary size.
    by: f64,
    /// How much of it could be on these drives.
    could_be: f64,
    /// Whitened, for that change; of fitted rows times the root of their weight.
    left: DVector<f64>,
    /// Sum of squares of held-out rows.
    held: f64,
}

/// What these drives could tell of a fitted car, and what they would with each of these drives more, which nobody has
/// driven yet. Of those only how they are driven counts; none for one that the car would not get through.
pub fn powers_with(
    found: &FreeFit<'_>,
    vehicle: &Vehicle,
    drives: &[FreeDrive],
    question: Question<'_>,
    planned: Vec<Option<FreeDrive>>,
) -> (Powers, Vec<Option<Powers>>) {
    let Question { kinds, references, plain, .. } = question;
    let all = trials(found, drives, kinds, question.scope());
    let search =
        Search { drives, vehicle, tried: super::tried(&all, &[]), plain, references, is_simulated: false };
    let state = search.start(found);
    let then = planned.into_par_iter().map(|planned| {
        let (found, drives) = with_planned(found, (&state, vehicle), drives, planned?)?;
        Some(powers(&found, vehicle, &drives, question))
    });
    let then: Vec<Option<Powers>> = then.collect();
    let middle = 0.5 * drives.iter().map(|drive| drive.time(drive.points())).fold(0.0, f64::max);
    let mut now = search.powers(&state, &typical(&all, middle));
    if then.is_empty() {
        now.courses = search.course_powers(&state, &courses(found, drives, kinds, question.scope()));
    }
    (now, then)
}

fn powers(found: &FreeFit<'_>, vehicle: &Vehicle, drives: &[FreeDrive], question: Question<'_>) -> Powers {
    powers_with(found, vehicle, drives, question, Vec::new()).0
}

/// One trial of each name: always there, or from the middle of the drive on.
fn typical(all: &[Trial], middle: f64) -> Vec<&Trial> {
    let off = |trial: &Trial| match (trial.onset(), trial.stretches()) {
        (Some((at, _)), _) => (at - middle).abs(),
        (None, [[from, to], ..]) if from.is_finite() && to.is_infinite() => (from - middle).abs(),
        (None, [[from, _], ..]) if from.is_finite() => f64::INFINITY,
        _ => 0.0,
    };
    let mut chosen: Vec<&Trial> = Vec::new();
    for trial in all {
        match chosen.iter_mut().find(|other| other.name() == trial.name() && other.is_of_same_number(trial)) {
            Some(other) if off(trial) < off(other) => *other = trial,
            Some(_) => {}
            None => chosen.push(trial),
        }
    }
    chosen
}

impl Search<'_> {
    fn powers(&self, state: &State<'_>, chosen: &[&Trial]) -> Powers {
        let traces = self.traces(state, chosen);
        let count = traces.len();
        let between = |i: usize, j: usize| {
            let (a, b) = (&traces[i].left, &traces[j].left);
            (a.dot(b) / (a.norm() * b.norm()).max(LEAST_LEFT)).clamp(-1.0, 1.0)
        };
        let row =
            |i: usize| (0..count).map(|j| if i == j { 1.0 } else { between(i, j) }).collect::<Vec<f64>>();
        let correlations: Vec<Vec<f64>> = (0..count).map(row).collect();
        let separable = (0..count)
            .map(|i| {
                let told =
                    |rho: &f64| normal_cdf(0.5 * traces[i].left.norm() * (1.0 - rho * rho).max(0.0).sqrt());
                correlations[i].iter().map(told).collect()
            })
            .collect();
        let all = (0..count).map(|i| self.power(&traces, i, &correlations[i], state)).collect();
        Powers { all, separable, courses: Vec::new() }
    }

    fn traces<'t>(&self, state: &State<'_>, chosen: &[&'t Trial]) -> Vec<Trace<'t>> {
        let Some(ground) = Ground::new(self, state, state.colour.clone()) else { return Vec::new() };
        let Ground { colour, rows, weights, .. } = &ground;
        let of = |trial: &&'t Trial| -> Option<Trace<'t>> {
            let (model, free, at) = state.beside(trial);
            let place = (state.free.len()..free.len()).find(|place| trial.is_main(&free[*place]))?;
            let main = free[place];
            let by = [main.prior.1, -main.prior.1]
                .into_iter()
                .find(|by| (main.bounds.0..=main.bounds.1).contains(&(at[place] + by)))?;
            let slope = self.slope(&model, &free, (&at, &state.errors), (place, by), None);
            let could_be = self.could_be(&slope, by);
            let left = ground.left(&(self.white(colour, rows, &slope) * by));
            let held = held_square(&left, rows);
            let left = left.component_mul(&weights.map(f64::sqrt));
            Some(Trace { trial, free: main, by, could_be, left, held })
        };
        chosen.par_iter().filter_map(of).collect()
    }

    fn power(&self, traces: &[Trace<'_>], number: usize, correlations: &[f64], state: &State<'_>) -> Power {
        let trace = &traces[number];
        let name = trace.trial.name();
        let clear = trace.left.norm();
        // What the evidence of the ordinary size must reach: the freedom of the number counts against it.
        let freedom = (clear * clear).max(1.0).ln();
        let needed = (LEAST_EVIDENCE + freedom + self.price_of_trying(&name)).sqrt();
        let mut bars = vec![Bar { slope: clear, needed }];
        if self.references == 0 || !trace.trial.is_always_there() {
            bars.push(Bar { slope: trace.held.sqrt(), needed: LEAST_HELD_GAIN.sqrt() });
        }
        if self.references > 0 && trace.trial.is_always_there() {
            bars.push(references::bar(clear, trace.could_be, self.references));
        }
        let noticed = bars.iter().map(|bar| bar.share()).fold(0.0, f64::max);
        let rivals = correlations.iter().enumerate().filter(|(other, _)| traces[*other].trial.name() != name);
        let rival = rivals.max_by(|a, b| a.1.abs().total_cmp(&b.1.abs()));
        // Its own evidence must be the larger one: the difference has twice its root as deviation.
        let apart = rival.map_or(1.0, |(_, rho)| (1.0 - rho * rho).max(LEAST_LEFT).sqrt());
        bars.push(Bar { slope: 0.5 * clear * apart, needed: 0.0 });
        let named = bars.iter().map(|bar| bar.share()).fold(0.0, f64::max);
        let (model, _) = placed(&state.model, &state.free, &state.at, 0);
        let (number, unit, value) = trace.trial.size(&model, &trace.free, trace.by);
        Power {
            number,
            unit,
            ordinary: value,
            noticed: noticed * value,
            named: named * value,
            rival: rival.map(|(other, rho)| (traces[other].trial.name(), *rho)),
            ways: vec![bars],
            neutral: trace.trial.neutral_value(&trace.free),
            from_s: trace.trial.begins(),
            name,
        }
    }
}

fn held_square(left: &DVector<f64>, rows: &Rows) -> f64 {
    left.iter().zip(&rows.held).filter(|(_, held)| **held).map(|(left, _)| left * left).sum()
}
