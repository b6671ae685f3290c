//! What is unusual has to show on a whole car: one that has all of what every car has.

use super::candidates::Candidate;
use super::fit::{Data, Fit};
use super::held_out::is_confirmed;
use super::naming::Refitted;
use super::precedence::ROUNDS;
use super::tuning::TUNING;
use physics::model::effect::Usual;

/// Less sure of itself, in standard deviations, nothing of what every car has is taken for it. Statistical.
const LEAST_SURE: f64 = 3.0;

/// Has the car shown something of what every car has?
fn is_whole(fit: &Fit<'_>) -> bool {
    fit.model.effects.iter().any(|effect| effect.kind.search.every_car_has)
}

/// Has every car it? On a whole one so little of it may be ordinary, too.
pub fn is_ordinary(before: &Fit<'_>, of: &Refitted<'_>) -> bool {
    let Candidate { kind, channel, .. } = &of.candidate;
    let is_usual = |usual: Usual| usual.holds(main_numbers(&of.fit, of.fit.model.effects.len() - 1));
    kind.search.every_car_has || is_whole(before) && kind.usual(*channel).is_some_and(is_usual)
}

/// What every car has beside what was taken, if nothing else is wanted any more, or if `best` is unusual and the data hardly
/// want it beside all of that together. One by one none of it may come close: a body leans and pitches at once. Only of a car
/// that has something of it already.
pub fn before_the_unusual<'a>(
    data: &Data<'_>,
    before: &Fit<'a>,
    library: &[Candidate],
    refitted: &[Refitted<'a>],
    best: Option<&Refitted<'a>>,
) -> Vec<Refitted<'a>> {
    if best.is_some_and(|best| is_ordinary(before, best)) || !is_whole(before) {
        return Vec::new();
    }
    // Small sizes of it that are usual shall not stand for it.
    let is_best = |of: &Candidate| best.is_some_and(|best| best.candidate.name() == of.name());
    let ordinary: Vec<&Candidate> =
        library.iter().filter(|of| of.could_be_ordinary() && !is_best(of)).collect();
    let all = together(data, before, &ordinary, refitted);
    if let Some(best) = best {
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
        let alone =
            refitted.iter().find(|of| of.candidate.name() == candidate.name() && is_ordinary(before, of));
        let effect = alone.and_then(|of| of.fit.model.effects.last()).cloned();
        model.effects.push(effect.unwrap_or_else(|| candidate.begun()));
    }
    data.fit(&model, &before.free_with(&model), &before.noise, ROUNDS)
}

/// The evidence of something beside a fit.
fn left_of<'a>(data: &Data<'_>, all: &Fit<'a>, best: &Refitted<'a>) -> f64 {
    let Some(effect) = best.fit.model.effects.last() else { return 0.0 };
    let model = all.model.with(effect.clone());
    let noise = match best.candidate.live.and(best.fit.noise.live.last()) {
        Some(live) => all.noise.with(*live),
        None => all.noise.clone(),
    };
    let with = data.fit(&model, &all.free_with(&model), &noise, ROUNDS);
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
    if wanted.is_empty() {
        return Vec::new();
    }
    wanted.sort_by(|a, b| b.0.total_cmp(&a.0));
    // What their noise alone gains is no evidence of them.
    let plain = data.fit(&before.model, &before.free, &all.noise, ROUNDS);
    let plain = if plain.cost() < before.cost() { &plain } else { before };
    let mut taken: Vec<Refitted<'a>> = Vec::new();
    for (_, place) in wanted {
        let earlier = taken.last().map_or(plain, |of| &of.fit);
        let model = earlier.model.with(all.model.effects[first + place].clone());
        let fit = data.fit(&model, &earlier.free_with(&model), &all.noise, ROUNDS);
        let of = Refitted::new(earlier, ordinary[place].clone(), fit);
        tracing::debug!(name = of.candidate.name(), evidence = of.evidence, "ordinary");
        let is_enough = of.evidence > data.share * TUNING.selection.further_evidence;
        if is_enough && is_ordinary(before, &of) && is_confirmed(data, earlier, &of, true) {
            taken.push(of);
        }
    }
    taken
}

/// How far its surest main number is from nothing, in standard deviations.
fn sureness(fit: &Fit<'_>, effect: usize) -> f64 {
    let of = |(number, std): (f64, f64)| if std > 0.0 { number.abs() / std } else { 0.0 };
    main_numbers(fit, effect).map(of).fold(0.0, f64::max)
}

/// How far the main numbers of an effect are from nothing, each with its standard deviation; zero where it was not fitted.
fn main_numbers(fit: &Fit<'_>, effect: usize) -> impl Iterator<Item = (f64, f64)> {
    let variance = |place: usize| fit.covariance.get((place, place)).copied().unwrap_or(f64::INFINITY);
    fit.main_numbers(effect)
        .map(move |(value, place)| (value, place.map_or(0.0, |place| variance(place).sqrt())))
}

#[cfg(test)]
mod tests {
    use super::super::bench::{fitted, recorded, training};
    use super::super::candidates;
    use super::super::model::Chosen;
    use super::*;
    use physics::model::effect::{Course, named};
    use predict::GriddedDrive;

    /// GIVEN accelerometers that read too much WHEN nothing is known of what every car has THEN that is a wrong scale; on a car that
    /// moves load the one along pitches, if it is little.
    #[test]
    #[ignore = "long: a car fitted"]
    fn a_whole_car_pitches() {
        let (vehicle, recording) = recorded("");
        let drives = [GriddedDrive::new(&recording, &vehicle)];
        let plain = fitted(&training(&drives), &vehicle);
        let with = |effect: Chosen| Fit { model: plain.model.with(effect), ..plain.clone() };
        let whole = with(Chosen::usual(named("load_transfer").unwrap(), None, Course::None));
        let kind = named("sensor_scale").unwrap();
        let scale = |channel: &str, by: f64| {
            let library = candidates::library(&[kind], &plain.model, |_| true, &[]);
            let name = format!("sensor_scale:{channel}");
            let candidate = library.into_iter().find(|candidate| candidate.name() == name).unwrap();
            let mut effect = candidate.chosen(0);
            effect.numbers[0] = by;
            Refitted::new(&plain, candidate, with(effect))
        };
        let pitches = scale("longitudinal_acceleration", 0.05);
        assert!(is_ordinary(&whole, &pitches) && !is_ordinary(&plain, &pitches));
        assert!(!is_ordinary(&whole, &scale("longitudinal_acceleration", 0.2)));
        assert!(!is_ordinary(&whole, &scale("lateral_acceleration", 0.05)));
    }
}
