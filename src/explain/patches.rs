//! Patches of another surface with clear edges. A filter that estimates how much of the road is different
//! finds out where that is; how different it is, and where exactly it begins and ends, a fit tells better.

use rayon::prelude::*;

use super::candidates::Candidate;
use super::fit::{Data, Fit, Learn};
use super::locate::merged;
use super::model::{Free, Model, Place};
use super::naming::Refitted;
use super::predict::drive::STEP_S;
use super::smooth::courses;
use crate::model::effect::Course;

/// Where a course is above this share of its peak there is a patch.
const EDGE: f64 = 0.35;

/// Shorter gaps are none: a surface shows only where tires slip, and they do not while one steers through
/// the middle.
const SHORTEST_GAP_S: f64 = 1.2;

/// Shorter patches are none.
const SHORTEST_S: f64 = 0.4;

/// More patches are no patches but a course.
const MOST: usize = 8;

/// What each edge's freedom is worth, twice the logarithm of how many places it could have.
const OF_AN_EDGE: f64 = 6.0;

/// Steps by which an edge is moved, s.
const STEPS: [f64; 5] = [2.0, 0.8, 0.4, 0.2, 0.1];

/// Does the effect lie in patches?
pub fn is_patchy(candidate: &Candidate) -> bool {
    candidate.kind.surroundings(candidate.channel).is_some_and(|course| course.sign != 0.0)
}

/// Where a fitted course has patches; none, if it has none, or the recordings are several.
pub fn intervals(data: &Data<'_>, fit: &Fit<'_>) -> Option<Vec<[f64; 2]>> {
    let [drive] = data.drives else { return None };
    let course = courses(drive, &fit.model, &fit.noise, Default::default()).pop()?;
    let peak = course.value.iter().fold(0.0, |peak: f64, value| peak.max(value.abs()));
    let first = course.t.first()?;
    let is_in: Vec<bool> = course.value.iter().map(|value| value.abs() > EDGE * peak).collect();
    let mut all = merged(&is_in, STEP_S, (SHORTEST_GAP_S / STEP_S) as usize);
    all.retain(|[from, to]| to - from > SHORTEST_S);
    for edge in all.as_flattened_mut() {
        *edge += first;
    }
    (1..=MOST).contains(&all.len()).then_some(all)
}

/// The effect of such a candidate within these stretches instead, fitted with everything else: which wheels
/// are on the patch is the candidate's, how different it is, is searched.
pub fn placed<'a>(
    data: &Data<'_>,
    before: &Fit<'a>,
    candidate: &Candidate,
    stretches: &[[f64; 2]],
    rounds: usize,
) -> Option<Refitted<'a>> {
    let candidate = Candidate {
        live: None,
        free: candidate.fixed.iter().filter(|(_, number)| *number != 0.0).map(|(place, _)| *place).collect(),
        stretches: stretches.to_vec(),
        ..candidate.clone()
    };
    let strict = data.strict(&before.noise);
    let cost = |model: &Model<'_>| -> f64 { data.minus_two_ln(&data.pass(model, &[], &strict)) };
    // How different: one of some, to begin with.
    let starts: Vec<(f64, Model<'a>)> = [0.15, 0.3, 0.5, 0.75, 1.0, 1.5]
        .into_par_iter()
        .map(|share| {
            let mut chosen = candidate.chosen(0);
            for place in &candidate.free {
                chosen.numbers[*place] *= share;
            }
            let model = before.model.with(chosen);
            (cost(&model), model)
        })
        .collect();
    let (_, start) = starts.into_iter().min_by(|a, b| a.0.total_cmp(&b.0))?;
    let effect = start.effects.len() - 1;
    let own = candidate.free.iter().filter_map(|place| {
        let spec = candidate.kind.spec(*place, candidate.channel)?;
        Some(Free { place: Place::Effect(effect, *place), mean: spec.mean, std: spec.std, step: spec.step })
    });
    let free: Vec<Free> = before.free.iter().copied().chain(own).collect();
    let strictly = data.search(&start, &free, &strict, rounds, Learn::Nothing);
    let edged = with_edges(&strictly.model, effect, cost);
    let again = data.search(&edged, &free, &strict, rounds, Learn::Nothing);
    let fit = data.fit(&with_edges(&again.model, effect, cost), &free, &strict, rounds);
    let Course::Stretches { intervals, .. } = &fit.model.effects[effect].course else { return None };
    tracing::trace!(name = candidate.name(), ?intervals, numbers = ?fit.model.effects[effect].numbers, "placed");
    let edges = 2.0 * intervals.len() as f64;
    let candidate = Candidate { stretches: intervals.clone(), ..candidate };
    let mut placed = Refitted::new(before, candidate, fit);
    placed.evidence -= edges * OF_AN_EDGE;
    Some(placed)
}

/// The model with each edge where it fits best, nearby, and without gaps that it fits better without.
fn with_edges<'a>(
    model: &Model<'a>,
    effect: usize,
    cost: impl Fn(&Model<'_>) -> f64 + Sync + Copy,
) -> Model<'a> {
    let mut best = (cost(model), model.clone());
    let mut gap = 1;
    while let Course::Stretches { intervals, .. } = &best.1.effects[effect].course
        && gap < intervals.len()
    {
        let mut model = best.1.clone();
        if let Course::Stretches { intervals, .. } = &mut model.effects[effect].course {
            intervals[gap - 1][1] = intervals[gap][1];
            intervals.remove(gap);
        }
        let without = cost(&model);
        if without < best.0 {
            best = (without, model);
        } else {
            gap += 1;
        }
    }
    for step in STEPS {
        let Course::Stretches { intervals, .. } = &best.1.effects[effect].course else { break };
        for edge in 0..2 * intervals.len() {
            let tried: Vec<(f64, Model<'a>)> = [-step, step]
                .into_par_iter()
                .filter_map(|by| {
                    let mut model = best.1.clone();
                    let Course::Stretches { intervals, .. } = &mut model.effects[effect].course else {
                        return None;
                    };
                    intervals.as_flattened_mut()[edge] += by;
                    let in_order = intervals.as_flattened().windows(2).all(|pair| pair[0] < pair[1]);
                    in_order.then(|| (cost(&model), model))
                })
                .collect();
            if let Some(better) = tried.into_iter().min_by(|a, b| a.0.total_cmp(&b.0))
                && better.0 < best.0
            {
                best = better;
            }
        }
    }
    best.1
}
