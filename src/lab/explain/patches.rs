//! Patches of another surface with clear edges.
//!
//! A filter estimates the share of the road that is different, and so finds the patches. A fit then tells better how
//! different they are, and where they begin and end.

use std::collections::BTreeSet;

use rayon::prelude::*;

use super::candidates::Candidate;
use super::fit::{Data, Fit, Learn};
use super::locate::merged;
use super::model::Model;
use super::naming::Refitted;
use super::smooth::courses;
use super::split::Part;
use super::tuning::TUNING;
use physics::model::effect::Course;

/// What each edge's freedom is worth, twice the logarithm of how many places it could have.
/// Statistical: e³, about twenty places.
const OF_AN_EDGE: f64 = 6.0;

/// Does the effect lie in patches?
pub fn is_patchy(candidate: &Candidate) -> bool {
    candidate.kind.disturbance(candidate.channel).is_some_and(|course| course.sign != 0.0)
}

/// Where wheels are seen to slide, the road may be slippery, whatever a filter makes of it: up to the limit of its
/// tires a car goes as its torques tell, on ice as on asphalt. None in several recordings, or in more stretches than
/// there are patches.
pub fn of_sliding(data: &Data<'_>) -> Option<Vec<[f64; 2]>> {
    let [drive] = data.drives else { return None };
    let all = merged(drive.slides.iter().map(|slide| [slide.from, slide.to]), TUNING.patches.same_road_s);
    (1..=TUNING.patches.most).contains(&all.len()).then_some(all)
}

/// The candidates that are slippery patches, of each kind and side one: how slippery, a fit searches.
pub fn slippery(library: &[Candidate]) -> impl Iterator<Item = &Candidate> {
    let mut seen = BTreeSet::new();
    library
        .iter()
        .filter(|candidate| candidate.kind.course.is_some_and(|course| course.is_slippery))
        .filter(move |candidate| seen.insert((candidate.kind.name, sides(candidate))))
}

/// The parameters of the wheels that are on the patch.
fn sides(candidate: &Candidate) -> Vec<usize> {
    candidate.fixed.iter().filter(|(_, number)| *number != 0.0).map(|(place, _)| *place).collect()
}

/// Could there be such a surface? Where a course is most of it, whatever it is a share of must be within its
/// bounds: a road that grips more than any is none.
pub fn is_possible(data: &Data<'_>, refitted: &Refitted<'_>) -> bool {
    if refitted.candidate.live.is_none() || !is_patchy(&refitted.candidate) {
        return true;
    }
    let Some(chosen) = refitted.fit.model.effects.last() else { return true };
    let peaks = data.drives.iter().filter_map(|drive| {
        let course = courses(drive, &refitted.fit.model, &refitted.fit.noise, Default::default()).pop()?;
        course.value.into_iter().max_by(|a, b| a.abs().total_cmp(&b.abs()))
    });
    let peak = peaks.max_by(|a, b| a.abs().total_cmp(&b.abs())).unwrap_or(0.0);
    chosen.specs().zip(&chosen.numbers).all(|(spec, number)| {
        let there = spec.mean + peak * (number - spec.mean);
        (spec.bounds.0..=spec.bounds.1).contains(&there)
    })
}

/// Where a fitted course has patches; none, if it has none, or the recordings are several.
pub fn intervals(data: &Data<'_>, fit: &Fit<'_>) -> Option<Vec<[f64; 2]>> {
    let [drive] = data.drives else { return None };
    let course = courses(drive, &fit.model, &fit.noise, Default::default()).pop()?;
    let peak = course.peak();
    let all = course.stretches(
        |value, _| value.abs() > TUNING.patches.edge * peak,
        TUNING.patches.shortest_gap_s,
        TUNING.patches.shortest_s,
    );
    (1..=TUNING.patches.most).contains(&all.len()).then_some(all)
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
    let candidate =
        Candidate { live: None, free: sides(candidate), stretches: stretches.to_vec(), ..candidate.clone() };
    let strict = data.strict(&before.noise);
    // Where on the road they are, all of the recording tells; what they are, its training part.
    let held = data.of(Part::Holdout);
    let cost = |model: &Model<'_>| -> f64 {
        let sums = data.pass(model, &[], &strict);
        data.minus_two_ln(&sums) + held.minus_two_ln(&sums)
    };
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
    let free = before.free_with(&start);
    let strictly = data.search(&start, &free, &strict, rounds, Learn::Nothing);
    let edges = Edges { cost, effect };
    let again = data.search(&edges.placed(&strictly.model), &free, &strict, rounds, Learn::Nothing);
    let fit = data.fit(&edges.placed(&again.model), &free, &strict, rounds);
    let intervals = edges.of(&fit.model);
    tracing::trace!(name = candidate.name(), ?intervals, numbers = ?fit.model.effects[effect].numbers, "placed");
    let count = 2.0 * intervals.len() as f64;
    let candidate = Candidate { stretches: intervals.to_vec(), ..candidate };
    let mut placed = Refitted::new(before, candidate, fit);
    // Which side it is on was a choice, too.
    let choices = choices_of(&placed.candidate);
    placed.evidence -= count * OF_AN_EDGE + 2.0 * choices.ln();
    Some(placed)
}

/// How many of its kind there were to choose from: left or right.
fn choices_of(candidate: &Candidate) -> f64 {
    candidate.kind.parameters.len() as f64 / candidate.free.len().max(1) as f64
}

/// Searches where patches begin and end.
struct Edges<C> {
    cost: C,
    effect: usize,
}

impl<C: Fn(&Model<'_>) -> f64 + Sync> Edges<C> {
    /// The model with each edge where it fits best, nearby, without gaps that it fits better without, and
    /// without patches that are not worth their edges.
    fn placed<'a>(&self, model: &Model<'a>) -> Model<'a> {
        let mut best = ((self.cost)(model), model.clone());
        let mut gap = 1;
        while gap < self.of(&best.1).len() {
            let without = self.changed(&best.1, |all| {
                all[gap - 1][1] = all[gap][1];
                all.remove(gap);
            });
            if without.0 < best.0 {
                best = without;
            } else {
                gap += 1;
            }
        }
        for step in TUNING.patches.edge_steps_s {
            for edge in 0..2 * self.of(&best.1).len() {
                let tried: Vec<(f64, Model<'a>)> = [-step, step]
                    .into_par_iter()
                    .map(|by| self.changed(&best.1, |all| all.as_flattened_mut()[edge] += by))
                    .filter(|(_, model)| self.of(model).as_flattened().is_sorted_by(|a, b| a < b))
                    .collect();
                let better = tried.into_iter().min_by(|a, b| a.0.total_cmp(&b.0));
                if let Some(better) = better.filter(|better| better.0 < best.0) {
                    best = better;
                }
            }
        }
        let mut patch = 0;
        while patch < self.of(&best.1).len() && self.of(&best.1).len() > 1 {
            let without = self.changed(&best.1, |all| {
                all.remove(patch);
            });
            if without.0 < best.0 + 2.0 * OF_AN_EDGE {
                best = without;
            } else {
                patch += 1;
            }
        }
        best.1
    }

    fn of<'m>(&self, model: &'m Model<'_>) -> &'m [[f64; 2]] {
        match &model.effects[self.effect].course {
            Course::Stretches { intervals, .. } => intervals,
            _ => &[],
        }
    }

    fn changed<'a>(&self, model: &Model<'a>, change: impl FnOnce(&mut Vec<[f64; 2]>)) -> (f64, Model<'a>) {
        let mut model = model.clone();
        if let Course::Stretches { intervals, .. } = &mut model.effects[self.effect].course {
            change(intervals);
        }
        ((self.cost)(&model), model)
    }
}
