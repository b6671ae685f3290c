//! What is unusual has to show on a whole car: one that has all of what every car has.

use super::candidates::Candidate;
use super::fit::{Data, Fit};
use super::model::{Free, Model, Place};
use super::naming::Refitted;
use super::precedence::{ROUNDS, is_ordinary};
use super::select::is_held_out_better;
use super::tuning::TUNING;

/// Less sure of itself, in standard deviations, nothing of what every car has is taken for it. Statistical.
const LEAST_SURE: f64 = 3.0;

/// What every car has beside what was taken, if `best` is unusual and the data hardly want it beside all of that together. One
/// by one none of it may come close: a body leans and pitches at once. Only of a car that has something of it already.
pub fn before_the_unusual<'a>(
    data: &Data<'_>,
    before: &Fit<'a>,
    library: &[Candidate],
    refitted: &[Refitted<'a>],
    best: &Refitted<'a>,
) -> Vec<Refitted<'a>> {
    let has_some = before.model.effects.iter().any(|effect| effect.kind.search.every_car_has);
    if is_ordinary(best) || !has_some {
        return Vec::new();
    }
    let ordinary: Vec<&Candidate> =
        library.iter().filter(|candidate| candidate.could_be_ordinary()).collect();
    let all = together(data, before, &ordinary, refitted);
    let left = left_of(data, &all, best);
    tracing::debug!(
        best = best.candidate.name(),
        evidence = best.evidence,
        of_ordinary = before.cost() - all.cost(),
        left,
        "beside all that is ordinary"
    );
    if left > TUNING.selection.rival_share * best.evidence {
        return Vec::new();
    }
    one_by_one(data, before, &ordinary, &all)
}

/// All of them fitted together, from where each was fitted alone or from little.
fn together<'a>(
    data: &Data<'_>,
    before: &Fit<'a>,
    ordinary: &[&Candidate],
    refitted: &[Refitted<'a>],
) -> Fit<'a> {
    let mut model = before.model.clone();
    for candidate in ordinary {
        let alone = refitted.iter().find(|of| of.candidate.name() == candidate.name() && is_ordinary(of));
        let effect = alone.and_then(|of| of.fit.model.effects.last()).cloned();
        model.effects.push(effect.unwrap_or_else(|| candidate.begun()));
    }
    data.fit(&model, &free_of(&model, before), &before.noise, ROUNDS)
}

/// The evidence of something beside a fit.
fn left_of<'a>(data: &Data<'_>, all: &Fit<'a>, best: &Refitted<'a>) -> f64 {
    let Some(effect) = best.fit.model.effects.last() else { return 0.0 };
    let model = all.model.with(effect.clone());
    let noise = match best.candidate.live.and(best.fit.noise.live.last()) {
        Some(live) => all.noise.with(*live),
        None => all.noise.clone(),
    };
    let with = data.fit(&model, &free_of(&model, all), &noise, ROUNDS);
    Refitted::new(all, best.candidate.clone(), with).evidence
}

/// Those that the fit of all is sure of, the surest first, as long as each is wanted beside those before, and on what was
/// held out.
fn one_by_one<'a>(
    data: &Data<'_>,
    before: &Fit<'a>,
    ordinary: &[&Candidate],
    all: &Fit<'a>,
) -> Vec<Refitted<'a>> {
    let first = before.model.effects.len();
    let mut wanted: Vec<(f64, usize)> = (0..ordinary.len())
        .map(|place| (sureness(all, first + place), place))
        .filter(|(sure, _)| *sure > LEAST_SURE)
        .collect();
    wanted.sort_by(|a, b| b.0.total_cmp(&a.0));
    let mut taken: Vec<Refitted<'a>> = Vec::new();
    for (_, place) in wanted {
        let earlier = taken.last().map_or(before, |of| &of.fit);
        let model = earlier.model.with(all.model.effects[first + place].clone());
        let fit = data.fit(&model, &free_of(&model, earlier), &all.noise, ROUNDS);
        let of = Refitted::new(earlier, ordinary[place].clone(), fit);
        tracing::debug!(name = of.candidate.name(), evidence = of.evidence, "ordinary");
        let is_enough = of.evidence > data.share * TUNING.selection.further_evidence;
        if is_enough && is_ordinary(&of) && is_held_out_better(data, earlier, &of, true) {
            taken.push(of);
        }
    }
    taken
}

/// How far its surest main number is from nothing, in standard deviations.
fn sureness(fit: &Fit<'_>, effect: usize) -> f64 {
    let specs: Vec<_> = fit.model.effects[effect].specs().collect();
    let of = |(place, free): (usize, &Free)| {
        let Place::Effect(of, number) = free.place else { return 0.0 };
        let variance = fit.covariance.get((place, place)).copied().unwrap_or(f64::INFINITY);
        if of != effect || !specs[number].is_main {
            return 0.0;
        }
        (fit.model.get(free.place) - specs[number].mean).abs() / variance.sqrt()
    };
    fit.free.iter().enumerate().map(of).fold(0.0, f64::max)
}

/// What was free, and the numbers of the effects that the model has more.
fn free_of(model: &Model<'_>, before: &Fit<'_>) -> Vec<Free> {
    let more = before.model.effects.len()..model.effects.len();
    before.free.iter().copied().chain(more.flat_map(|effect| model.free_of_effect(effect))).collect()
}
