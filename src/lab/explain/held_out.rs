//! Which candidate is taken: the first that driving which it was not fitted to confirms.

use super::fit::{Data, Fit};
use super::naming::{Refitted, refine};
use super::precedence::settled;
use super::split::{BLOCK_S, Part, Split};
use super::tuning::TUNING;

/// Rounds of fitting where the split has changed. Numerical: Gauss–Newton steps.
const ROUNDS: usize = 3;

/// A candidate that held-out data confirm.
pub struct Taken<'a> {
    /// It, all its numbers settled.
    pub refitted: Refitted<'a>,
    /// What begins at a moment changes what is held out, …
    pub split: Split,
    /// … and with it the plain model.
    pub baseline: Fit<'a>,
}

/// The first that is confirmed, of those that come close to the first one.
pub fn first_confirmed<'a>(
    data: &Data<'_>,
    before: (&Fit<'a>, &Fit<'a>),
    ordered: &[&Refitted<'a>],
    is_further: bool,
) -> Option<Taken<'a>> {
    let close = TUNING.selection.rival_share * ordered.first()?.evidence;
    let mut tried = ordered.iter().filter(|of| of.evidence >= close).take(TUNING.selection.most_rivals);
    tried.find_map(|of| confirmed(data, before, of, is_further))
}

/// A candidate, all its numbers settled, if held-out data confirm it beside the plain model and what was chosen before.
fn confirmed<'a>(
    data: &Data<'_>,
    (baseline, extended): (&Fit<'a>, &Fit<'a>),
    of: &Refitted<'a>,
    is_further: bool,
) -> Option<Taken<'a>> {
    let mut data = data.clone();
    let (mut refitted, mut baseline, mut extended) = (of.clone(), baseline.clone(), extended.clone());
    if let Some(split) = of.onset().and_then(|at| data.split.released(at, TUNING.selection.onset_s)) {
        data.split = split;
        let again = |fit: &Fit<'a>| data.fit(&fit.model, &fit.free, &fit.noise, ROUNDS);
        baseline = again(&baseline);
        extended = if is_further { again(&extended) } else { baseline.clone() };
        // What was fitted to other blocks cannot be compared; and within one that was held out, it could
        // have begun anywhere.
        let mut fit = of.fit.clone();
        fit.model = of.begun_within(&data, BLOCK_S);
        refitted = Refitted::new(&extended, refitted.candidate, again(&fit));
        refitted = refine(&data, &extended, &refitted, ROUNDS);
    }
    refitted.fit = settled(&data, &refitted.fit);
    let is_confirmed = is_confirmed(&data, &extended, &refitted, is_further);
    tracing::debug!(
        name = refitted.candidate.name(),
        evidence = refitted.evidence,
        confirmed = is_confirmed,
        numbers = ?refitted.fit.model.effects.last().map(|effect| effect.values()),
        live = ?refitted.fit.noise.live,
    );
    is_confirmed.then_some(Taken { refitted, baseline, split: data.split })
}

/// Does what it is fitted to confirm the held-out part? It must not make the prediction of what it has not seen
/// worse.
pub fn is_confirmed(data: &Data<'_>, before: &Fit<'_>, of: &Refitted<'_>, is_further: bool) -> bool {
    let held = data.of(Part::Holdout);
    let gain = held.minus_two_ln(&before.sums) - held.minus_two_ln(&of.fit.sums);
    tracing::debug!(name = of.candidate.name(), held_out = gain);
    let worse = TUNING.selection.worse_share * of.evidence + TUNING.selection.worse;
    gain > -worse && (!is_further || gain > 0.0)
}

#[cfg(test)]
mod tests {
    use super::super::bench::each_refitted;
    use super::*;
    use physics::model::effect::named;

    /// GIVEN candidates the best of which only seems so: held-out driving does not confirm it THEN the next one is taken.
    #[test]
    #[ignore = "long: a car fitted, and more"]
    fn where_the_best_is_not_confirmed_the_next_is_asked() {
        let lag = "[[effect]]\nkind = \"steering_lag\"\ntime_constant_s = 0.08";
        let kinds = ["steering_lag", "rear_steer", "air_drag", "steering_ratio", "wheel_alignment"];
        each_refitted(lag, &kinds.map(|name| named(name).unwrap()), &[], |data, plain, all| {
            let is_confirmed = |of: &Refitted<'_>| confirmed(data, (plain, plain), of, true).is_some();
            let (lag, others) = all.split_first().unwrap();
            let other = others.iter().find(|of| !is_confirmed(of)).unwrap();
            let mut other = other.clone();
            other.evidence = 1.5 * lag.evidence;
            let taken = |order: &[&Refitted<'_>]| {
                first_confirmed(data, (plain, plain), order, true).map(|of| of.refitted.candidate.name())
            };
            assert_eq!(taken(&[&other, lag]).as_deref(), Some("steering_lag"));
            // Not one that comes nowhere near.
            other.evidence = 3.0 * lag.evidence;
            assert_eq!(taken(&[&other, lag]), None);
        });
    }
}
