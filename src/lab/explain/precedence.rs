//! Which of the candidates that come close goes first: what is simpler, and what every car has.

use rayon::prelude::*;

use super::candidates::Candidate;
use super::fit::{Data, Fit};
use super::model::{Model, Place};
use super::naming::Refitted;
use super::split::Part;
use super::tuning::TUNING;
use super::whole_car::is_ordinary;

/// Rounds of fitting for a decision. Numerical: Gauss–Newton steps.
pub const ROUNDS: usize = 8;

/// Puts the candidates of a round, best first, into the order in which they are taken. True if the first one is what every
/// car has, and stands for all others: beside it the data hardly want the best.
pub fn put_in_order<'a>(data: &Data<'_>, before: &Fit<'a>, refitted: &mut [Refitted<'a>]) -> bool {
    polish(data, before, refitted);
    prefer_the_simpler(refitted);
    prefer_the_ordinary(data, before, refitted)
}

/// Goes on with the fits of those that come close to the best: a few rounds do not decide between them.
fn polish<'a>(data: &Data<'_>, before: &Fit<'a>, refitted: &mut [Refitted<'a>]) {
    let Some(enough) = close(refitted) else { return };
    let is_close = |of: &Refitted<'_>| of.evidence > enough && of.candidate.live.is_none();
    if !refitted.iter().skip(1).any(is_close) {
        return;
    }
    refitted.par_iter_mut().filter(|of| is_close(of)).for_each(|of| {
        let fit = data.go_on(&of.fit, ROUNDS);
        if fit.cost() < of.fit.cost() {
            let polished = Refitted::new(before, of.candidate.clone(), fit);
            (of.fit, of.evidence) = (polished.fit, polished.evidence);
        }
    });
    refitted.sort_by(|a, b| b.evidence.total_cmp(&a.evidence));
}

/// The evidence that comes close to that of the best.
fn close(refitted: &[Refitted<'_>]) -> Option<f64> {
    Some(TUNING.selection.rival_share * refitted.first()?.evidence)
}

/// A number that is the same all the time is a simpler explanation than something that begins at a moment of its choice,
/// and that is simpler than a course that could be anything: where the simpler one explains about the same, it goes first.
pub fn prefer_the_simpler(refitted: &mut [Refitted<'_>]) {
    // A jump before the beginning is one all the same.
    let jumps = |candidate: &Candidate| candidate.channel.is_some() && candidate.kind.onset().is_some();
    let always = |other: &Refitted<'_>| {
        other.candidate.live.is_none() && other.onset().is_none() && !jumps(&other.candidate)
    };
    let Some(best) = refitted.first().filter(|best| !always(best)) else { return };
    let enough = 0.9 * best.evidence;
    let of_course = best.candidate.live.map(|_| best.candidate.channel);
    let is_simpler = |other: &Refitted<'_>| {
        let is_of_channel = of_course == Some(other.candidate.channel) && other.candidate.live.is_none();
        is_of_channel || always(other) && other.candidate.channel.is_none()
    };
    let simpler = refitted.iter().position(|other| other.evidence > enough && is_simpler(other));
    if let Some(place) = simpler {
        refitted[..=place].rotate_right(1);
    }
}

/// What every car has goes first where it comes close to the best, and the data want it beside that one, too, or hardly want
/// that one beside it. True in the latter case.
fn prefer_the_ordinary(data: &Data<'_>, before: &Fit<'_>, refitted: &mut [Refitted<'_>]) -> bool {
    let Some(best) = refitted.first().filter(|best| !is_ordinary(before, best)) else { return false };
    let Some(enough) = close(refitted) else { return false };
    let Some(place) = refitted.iter().position(|of| of.evidence > enough && is_ordinary(before, of)) else {
        return false;
    };
    let ordinary = &refitted[place];
    let Some(effect) = ordinary.fit.model.effects.last() else { return false };
    let model = best.fit.model.with(effect.clone());
    let both = data.fit(&model, &best.fit.free_with(&model), &best.fit.noise, ROUNDS);
    let left_of_best = ordinary.fit.cost() - both.cost();
    let left_of_ordinary = Refitted::new(&best.fit, ordinary.candidate.clone(), both).evidence;
    tracing::trace!(
        best = best.candidate.name(),
        ordinary = ordinary.candidate.name(),
        left_of_best,
        left_of_ordinary,
        "one beside the other"
    );
    let least = TUNING.selection.further_evidence;
    let stands_for_it = left_of_best < least;
    if left_of_ordinary > least || stands_for_it {
        refitted[..=place].rotate_right(1);
    }
    stands_for_it
}

/// The last fit of what is taken. What was taken before had to imitate it: the numbers beside its size begin anew, too. So do
/// the car's own, where what was held out is predicted better from there.
pub fn settled<'a>(data: &Data<'_>, of: &Fit<'a>) -> Fit<'a> {
    let from = |model: Model<'a>| data.fit(&model, &of.free, &of.noise, ROUNDS);
    let (on, (anew, from_table)) = rayon::join(
        || data.go_on(of, ROUNDS),
        || rayon::join(|| begun_anew(&of.model).map(from), || from(as_in_the_table(of))),
    );
    let better = |best: Fit<'a>, fit: Fit<'a>| if fit.cost() < best.cost() { fit } else { best };
    let best = [Some(on), anew].into_iter().flatten().fold(of.clone(), better);
    let held = data.of(Part::Holdout);
    let predicts = held.minus_two_ln(&from_table.sums) < held.minus_two_ln(&best.sums);
    if predicts { better(best, from_table) } else { best }
}

/// The model with the car's own numbers as the table has them.
fn as_in_the_table<'a>(of: &Fit<'a>) -> Model<'a> {
    let mut model = of.model.clone();
    for free in &of.free {
        if matches!(free.place, Place::Ordinary(_) | Place::Delay(_) | Place::BendAlong) {
            model.set(free.place, free.mean);
        }
    }
    model
}

/// The model with the numbers of all effects but the last at what is usual, but for their sizes.
fn begun_anew<'a>(model: &Model<'a>) -> Option<Model<'a>> {
    let mut anew = model.clone();
    let (_, earlier) = anew.effects.split_last_mut()?;
    for effect in earlier.iter_mut() {
        let specs: Vec<_> = effect.specs().collect();
        for place in effect.free.iter().filter(|place| !specs[**place].is_main) {
            effect.numbers[*place] = specs[*place].mean;
        }
    }
    (!earlier.is_empty()).then_some(anew)
}

#[cfg(test)]
mod tests {
    use super::super::bench::each_refitted;
    use super::*;
    use physics::model::effect::named;

    /// GIVEN a car whose wheels roll hard, which toe-in would do as well, and a little better by chance THEN what every car has goes
    /// first, and stands for the toe-in.
    #[test]
    #[ignore = "long: a car fitted, and more"]
    fn what_cannot_be_told_from_what_every_car_has_does_not_go_before_it() {
        let hard = "[[effect]]\nkind = \"rolling_resistance\"\ncoefficient = 0.004";
        let kinds = ["wheel_alignment", "rolling_resistance"].map(|name| named(name).unwrap());
        each_refitted(hard, &kinds, &[], |data, plain, mut order| {
            assert!(order[1].evidence > 30.0, "{}", order[1].evidence);
            order[0].evidence = order[1].evidence + 1.0;
            assert!(prefer_the_ordinary(data, plain, &mut order));
            assert_eq!(order[0].candidate.name(), "rolling_resistance");
            // Alone, it stands for nothing else.
            assert!(!prefer_the_ordinary(data, plain, &mut order[..1]));
        });
    }
}
