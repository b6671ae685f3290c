//! Tires of another kind than the table's: no table of a car knows how its tires bend before their limit.
//!
//! A curve that bends elsewhere is imitated by what softens tires, or pushes. So where something was named the search is repeated
//! with tires of another kind, if these explain the recordings better from the start, and as well with all that was found. Who
//! needs less for the same is right.

use physics::model::{TireKind, Vehicle};

use super::fit::Data;
use super::model::{Free, Model};
use super::ordinary::Bent;
use super::select::{LEAST_EVIDENCE, Selection};

/// Rounds of fitting other tires, from where the table's ended. Numerical: Gauss–Newton steps.
const ROUNDS: usize = 8;

/// The selection with the table's tires, or that with others. `search` searches again from a plain model.
pub fn or_other_tires<'a>(
    data: &Data<'_>,
    own: Selection<'a>,
    free: impl Fn(&Model<'a>) -> Vec<Free>,
    search: impl Fn(&Model<'a>, &[Free]) -> Selection<'a>,
) -> Selection<'a> {
    // Tires without a limit get one, with a bend, as a finding.
    if own.chosen.is_empty() || own.baseline.model.vehicle.tire == TireKind::Linear {
        return own;
    }
    let fitted = |vehicle: Vehicle| {
        let model = own.baseline.model.of(vehicle);
        data.fit(&model, &free(&model), &own.baseline.noise, ROUNDS)
    };
    let best = others(&own.baseline.model.vehicle)
        .map(fitted)
        .min_by(|a, b| a.cost().total_cmp(&b.cost()))
        .filter(|best| best.cost() < own.baseline.cost() - LEAST_EVIDENCE);
    let Some(best) = best else { return own };
    // Those that were imitated leave nothing out beside what imitated them.
    let with_all = own.extended.model.of(best.model.vehicle.clone().into_owned());
    let data_of_own = Data { split: own.split.clone(), ..data.clone() };
    let beside = data_of_own.fit(&with_all, &own.extended.free, &own.extended.noise, ROUNDS);
    tracing::debug!(own = own.extended.cost(), beside = beside.cost(), "with tires of another kind");
    if beside.cost() > own.extended.cost() + LEAST_EVIDENCE {
        return own;
    }
    let other = search(&best.model, &best.free);
    let cost = |of: &Selection<'_>| of.extended.cost() + LEAST_EVIDENCE * of.chosen.len() as f64;
    tracing::debug!(tire = ?best.model.vehicle.tire, own = cost(&own), other = cost(&other), "tires of another kind");
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
