//! Tires of another kind than the table's: no table of a car knows how its tires bend before their limit.
//!
//! A curve that bends elsewhere is imitated by what softens tires, or pushes. So where something was named the search is made
//! with tires of another kind, if these explain the recordings better from the start, and as well with all that was found. Who
//! needs less for the same is right. What is found first tells mostly already which tires these are: the other search is spared.

use physics::Quantity;
use physics::model::{TireKind, Vehicle};

use super::candidates::Candidate;
use super::fit::{Data, Fit};
use super::model::Model;
use super::ordinary::Bent;
use super::search::Search;
use super::select::{LEAST_EVIDENCE, Selection};
use super::work;

/// Rounds of fitting other tires, from where the first ones' ended. Numerical: Gauss–Newton steps.
const ROUNDS: usize = 8;

/// The selection with the plain model's tires, or that with others.
pub fn with_best_tires<'a, H, L>(
    search: &Search<'_, '_, H, L>,
    plain: &Model<'a>,
    progress: &(dyn Fn(&str, f64) + Sync),
) -> Selection<'a>
where
    H: Fn(Quantity) -> bool + Copy,
    L: Fn(&Model<'_>, &[f64]) -> Vec<Candidate>,
{
    // Tires without a limit get one, with a bend, as a finding.
    if plain.vehicle.tire == TireKind::Linear {
        return search.select(plain, progress);
    }
    let begun = search.begin(plain, progress);
    let anew = |with: &Fit<'a>| {
        progress(work::AGAIN, 0.0);
        search.select(&begun.baseline.model.of(tires_of(with)), &|_, _| ())
    };
    if !begun.chosen.is_empty()
        && let Some(better) = search.in_part(|part| better(&begun.looked_at(part), &begun.extended))
    {
        let other = anew(&better);
        if !is_as_good(search.data, &other, tires_of(&begun.baseline)) {
            return other;
        }
        return simpler(search.go_on(begun, plain, progress), other);
    }
    let own = search.go_on(begun.clone(), plain, progress);
    if own.chosen.is_empty() {
        return own;
    }
    match better(&own.looked_at(search.data), &own.baseline) {
        // Those that were imitated leave nothing out beside what imitated them.
        Some(better) if is_as_good(search.data, &own, tires_of(&better)) => simpler(own, anew(&better)),
        _ => own,
    }
}

fn tires_of(fit: &Fit<'_>) -> Vehicle {
    fit.model.vehicle.clone().into_owned()
}

/// A fit with the kind of tires that explains the recordings best, where these are others.
fn better<'a>(data: &Data<'_>, own: &Fit<'a>) -> Option<Fit<'a>> {
    let fitted = |vehicle: Vehicle| data.fit(&own.model.of(vehicle), &own.free, &own.noise, ROUNDS);
    let best = others(&own.model.vehicle).map(fitted).min_by(|a, b| a.cost().total_cmp(&b.cost()))?;
    tracing::debug!(tire = ?best.model.vehicle.tire, own = own.cost(), best = best.cost(), "tires of another kind");
    (best.cost() < own.cost() - data.share * LEAST_EVIDENCE).then_some(best)
}

/// Does a car with these tires explain the recordings as well, with all that was found?
fn is_as_good(data: &Data<'_>, found: &Selection<'_>, tires: Vehicle) -> bool {
    let of = &found.extended;
    let beside = found.looked_at(data).fit(&of.model.of(tires), &of.free, &of.noise, ROUNDS);
    tracing::debug!(
        found = of.cost(),
        beside = beside.cost(),
        "all that was found with tires of another kind"
    );
    beside.cost() <= of.cost() + LEAST_EVIDENCE
}

/// That with other tires, where it needs less for the same.
fn simpler<'a>(own: Selection<'a>, other: Selection<'a>) -> Selection<'a> {
    let cost = |of: &Selection<'_>| of.extended.cost() + LEAST_EVIDENCE * of.chosen.len() as f64;
    tracing::debug!(own = cost(&own), other = cost(&other), "the simpler one of two kinds of tires");
    if cost(&other) < cost(&own) - LEAST_EVIDENCE { other } else { own }
}

/// The car with the other kinds of tires that bend. A table that has a magic formula was told how.
fn others(vehicle: &Vehicle) -> impl Iterator<Item = Vehicle> {
    let Bent { smooth, brush } = Bent::of(vehicle);
    let own = vehicle.tire;
    brush.into_iter().chain([smooth]).filter(move |other| other.tire != own)
}

#[cfg(test)]
mod tests {
    use super::super::bench::{case, recorded_as};
    use super::super::case::Case;
    use super::super::result::Verdict;
    use super::*;
    use physics::model::effect;

    /// What is missing, and the verdict, of brush tires with little noise under a table that knows of no bend, with these effects.
    fn named(effects: &str) -> (Vec<String>, Verdict) {
        let kinds = ["combined_slip", "surface_stiffness", "crosswind", "accelerometer_position"]
            .map(|name| effect::named(name).unwrap());
        let (mut vehicle, recording) = recorded_as(effects, |scenario| {
            scenario.vehicle.tire = TireKind::Brush;
            scenario.sensors.by_name.values_mut().for_each(|sensor| sensor.noise_std *= 0.3);
        });
        vehicle.tire = TireKind::Piecewise;
        let recordings = [recording];
        let asked = Case { library: &kinds, ..case(&vehicle, &recordings) };
        let explanation = asked.explain(&|_, _| ()).explanation;
        assert_eq!(explanation.tires_bend_as, Some(TireKind::Brush));
        (explanation.findings.into_iter().map(|it| it.effect).collect(), explanation.verdict)
    }

    /// GIVEN a brush's tires, and a table that knows of no bend WHEN what is missing is asked THEN it is how the tires bend, and
    /// neither wind nor a soft surface.
    #[test]
    #[ignore = "long: a car searched, and searched again"]
    fn tires_that_bend_are_no_wind() {
        assert_eq!(named(""), (vec![], Verdict::Adequate));
    }

    mod by_hand {
        use super::*;

        /// GIVEN a displaced accelerometer beside that THEN it is named, and nothing else.
        #[test]
        #[ignore = "by hand: a car searched, and searched again, a minute"]
        fn what_is_beside_tires_that_bend_is_named_alone() {
            let position = "[[effect]]\nkind = \"accelerometer_position\"\nforward_of_cg_m = 0.8";
            assert_eq!(named(position), (vec!["accelerometer_position".into()], Verdict::MissingPhysics));
        }
    }
}
