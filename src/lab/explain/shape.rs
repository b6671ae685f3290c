//! Numbers beside the size of an effect: what a car can have.

use super::fit::{Data, Fit};
use super::model::{Free, Model, Place};
use super::naming::Refitted;
use super::tuning::TUNING;

/// Rounds of fitting. Numerical: Gauss–Newton steps.
const ROUNDS: usize = 8;

/// A fit whose numbers beside its size a car can have. One that ends at its bound is set to what is usual, and stays there
/// if it would only go back. If most of the evidence was for that number, this is another thing: a load that sloshes is no
/// roll at half of a car's frequency.
pub fn in_shape<'a>(data: &Data<'_>, before: &Fit<'a>, refitted: Refitted<'a>) -> Option<Refitted<'a>> {
    let out = at_bounds(&refitted);
    if out.is_empty() {
        return Some(refitted);
    }
    let effect = refitted.fit.model.effects.len() - 1;
    let usual = refitted.candidate.chosen(0);
    let mut model = refitted.fit.model.clone();
    let mut candidate = refitted.candidate.clone();
    for place in &out {
        model.effects[effect].numbers[*place] = usual.numbers[*place];
    }
    let keeps = |usual: &Refitted<'_>| {
        tracing::trace!(
            name = usual.candidate.name(),
            at_bounds = ?out,
            of = refitted.evidence,
            left = usual.evidence,
            "out of shape"
        );
        usual.evidence > TUNING.selection.left_in_shape * refitted.evidence
    };
    let fit = |model: &Model<'a>, free: &[Free]| data.fit(model, free, &refitted.fit.noise, ROUNDS);
    let again = Refitted::new(before, candidate.clone(), fit(&model, &refitted.fit.free));
    if at_bounds(&again).is_empty() && keeps(&again) {
        return Some(again);
    }
    model.effects[effect].free.retain(|place| !out.contains(place));
    candidate.free.retain(|place| !out.contains(place));
    let is_free = |free: &&Free| !out.iter().any(|place| free.place == Place::Effect(effect, *place));
    let free: Vec<Free> = refitted.fit.free.iter().filter(is_free).copied().collect();
    let usual = Refitted::new(before, candidate, fit(&model, &free));
    keeps(&usual).then_some(usual)
}

/// The numbers beside its size that end at their bounds, but for what is nothing there: tires need not lose radius with
/// load.
fn at_bounds(refitted: &Refitted<'_>) -> Vec<usize> {
    let model = &refitted.fit.model;
    let Some(effect) = model.effects.len().checked_sub(1) else { return Vec::new() };
    if refitted.candidate.kind.search.has_whole_shares {
        return Vec::new();
    }
    let is_out = |place: &usize| {
        let (spec, of) = (&refitted.candidate.kind.parameters[*place], Place::Effect(effect, *place));
        let is_nothing = spec.bounds.0 == 0.0 && model.get(of) < 0.5 * spec.bounds.1;
        !spec.is_main && !is_nothing && model.is_at_bound(of)
    };
    refitted.candidate.free.iter().copied().filter(is_out).collect()
}

#[cfg(test)]
mod tests {
    use super::super::bench::refitted;
    use super::super::select::LEAST_EVIDENCE;
    use super::*;
    use physics::model::effect::named;

    /// The roll of a body in a drive with one, a number of it at its lower bound: what is free of it then, and its evidence.
    fn rolling(numbers: &str, at_bound: &str) -> Option<(Vec<&'static str>, f64)> {
        let kind = named("body_roll").unwrap();
        let roll = format!("[[effect]]\nkind = \"body_roll\"\nroll_gain_rad_per_mps2 = 0.012\n{numbers}");
        refitted(&roll, kind, &[], |data, plain, mut roll| {
            let place = kind.place_of(at_bound).unwrap();
            roll.fit.model.put(Place::Effect(0, place), kind.parameters[place].bounds.0);
            let left = in_shape(data, plain, roll)?;
            let names = left.candidate.free.iter().map(|place| kind.parameters[*place].name);
            Some((names.collect(), left.evidence))
        })
    }

    /// GIVEN a body that rolls, hardly damped WHEN a search took the damping to its bound THEN it is found from what is usual.
    #[test]
    #[ignore = "long: a car fitted, and more"]
    fn a_search_that_went_astray_begins_anew() {
        let hardly = "roll_damping = 0.15\nroll_frequency_rad_per_s = 9.0";
        let (free, evidence) = rolling(hardly, "roll_damping").unwrap();
        assert!(free.contains(&"roll_damping"), "{free:?}");
        assert!(evidence > 10.0 * LEAST_EVIDENCE, "{evidence}");
    }

    /// GIVEN a body that rolls, damped less than any THEN the roll is still named, the damping held at what is usual.
    #[test]
    #[ignore = "long: a car fitted, and more"]
    fn a_number_at_its_bound_takes_no_name_away() {
        let hardly = "roll_damping = 0.05\nroll_frequency_rad_per_s = 9.0";
        let (free, evidence) = rolling(hardly, "roll_damping").unwrap();
        assert!(!free.contains(&"roll_damping") && free.contains(&"roll_gain_rad_per_mps2"), "{free:?}");
        assert!(evidence > 10.0 * LEAST_EVIDENCE, "{evidence}");
    }

    /// GIVEN what swings far below a car's roll frequency, undamped, as a load does that sloshes THEN it is not named a roll.
    #[test]
    #[ignore = "long: a car fitted, and more"]
    fn what_only_such_a_number_explains_is_another_thing() {
        let slow = "roll_damping = 0.05\nroll_frequency_rad_per_s = 5.0";
        let found = rolling(slow, "roll_frequency_rad_per_s");
        assert!(found.is_none(), "{found:?}");
    }

    /// GIVEN tires that lose no radius with load WHEN a search ends next to that THEN it is no bound.
    #[test]
    #[ignore = "long: a car fitted, and more"]
    fn next_to_nothing_is_no_bound() {
        let kind = named("load_transfer").unwrap();
        let loss = kind.place_of("radius_loss_m_per_n").unwrap();
        refitted("[[effect]]\nkind = \"load_transfer\"\ncg_height_m = 0.6", kind, &[], |_, _, mut of| {
            let mut is_out = |at: f64| {
                of.fit.model.put(Place::Effect(0, loss), at);
                at_bounds(&of).contains(&loss)
            };
            let most = kind.parameters[loss].bounds.1;
            assert!(!is_out(4e-5 * most));
            assert!(!is_out(0.5 * most));
            assert!(is_out(most));
        });
    }
}
