//! Forward selection of effects. It takes the best effect, then the best one beside it, until the evidence is too
//! small or held-out data do not confirm it.

use std::collections::BTreeSet;

use rayon::prelude::*;

use super::candidates::{Candidate, onsets, onsets_within};
use super::exogenous::{CourseOf, follows_motion};
use super::fit::{Data, Fit, Learn};
use super::held_out::first_confirmed;
use super::model::Model;
use super::naming::{Refitted, Scored, begun_at, refine, refit, scan};
use super::patches;
use super::precedence::put_in_order;
use super::shape::in_shape;
use super::smooth::courses;
use super::split::Split;
use super::throughout::shows_throughout;
use super::tuning::TUNING;
use super::whole_car::before_the_unusual;
use super::work;
use physics::Quantity;
use physics::model::effect::{Channel, Growth, Kind, Spec};
use predict::GriddedDrive;

/// Evidence (twice the logarithm of the odds) that the first finding needs. The odds must beat those of
/// some fifty candidates, each with a small chance of its own.
/// Statistical: odds of e¹², so that one of fifty candidates is named by chance in three of ten thousand drives, if noise
/// is as the model has it.
pub const LEAST_EVIDENCE: f64 = 24.0;

/// Rounds of fitting without learning any noise. Numerical: Gauss–Newton steps, here and below.
const STRICT_ROUNDS: usize = 4;

/// Rounds of a first fit, and of one that may win.
const FIRST_ROUNDS: usize = 2;
const NEXT_ROUNDS: usize = 3;

/// One round of choosing.
#[derive(Clone, Debug)]
pub struct Round<'a> {
    /// All candidates to first order, best first.
    pub scanned: Vec<Scored>,
    /// Those fitted together, best first; what was refused is left out.
    pub refitted: Vec<Refitted<'a>>,
    /// Candidates refused for following the driver's inputs, each with its evidence.
    pub following: Vec<(Candidate, f64)>,
}

impl<'a> Round<'a> {
    /// In which nothing else was asked.
    fn without_rivals(taken: &Refitted<'a>) -> Self {
        Self { scanned: Vec::new(), refitted: vec![taken.clone()], following: Vec::new() }
    }

    /// With what another look found.
    fn and(mut self, other: Self) -> Self {
        self.refitted.extend(other.refitted);
        self.refitted = best_of_each(self.refitted);
        self.following.extend(other.following);
        self
    }
}

/// What was chosen.
#[derive(Clone, Debug)]
pub struct Selection<'a> {
    /// The plain model.
    pub baseline: Fit<'a>,
    /// With all that was chosen.
    pub extended: Fit<'a>,
    /// What was chosen, in this order.
    pub chosen: Vec<Refitted<'a>>,
    /// All rounds.
    pub rounds: Vec<Round<'a>>,
    /// What was fitted to and what was not, at last.
    pub split: Split,
}

impl<'a> Selection<'a> {
    /// Is what was chosen first something that is added in the course of time?
    pub fn is_led_by_time(&self) -> bool {
        self.chosen.first().is_some_and(|refitted| refitted.candidate.is_added_in_time())
    }

    /// The evidence of each name, in the order in which they were chosen; everything of a name together: two wheels of an axle
    /// are smaller.
    pub fn of_names(&self) -> Vec<f64> {
        let mut of_names: Vec<(String, f64)> = Vec::new();
        for of in &self.chosen {
            let name = of.candidate.name();
            match of_names.iter_mut().find(|other| other.0 == name) {
                Some((_, evidence)) => *evidence += of.evidence,
                None => of_names.push((name, of.evidence)),
            }
        }
        of_names.into_iter().map(|(_, evidence)| evidence).collect()
    }

    /// Of a plain model beside which nothing was searched.
    pub fn nothing(baseline: Fit<'a>, split: Split) -> Self {
        Self { extended: baseline.clone(), baseline, chosen: Vec::new(), rounds: Vec::new(), split }
    }
}

/// Chooses, beginning with what was taken before. `library` has the candidates for a model, of something that could
/// have begun at certain moments, s; `progress` is told the stage and how far it is.
pub fn select<'a>(
    data: &Data<'_>,
    (mut baseline, before): (Fit<'a>, Vec<Refitted<'a>>),
    library: &impl Fn(&Model<'_>, &[f64]) -> Vec<Candidate>,
    progress: &(dyn Fn(&str, f64) + Sync),
) -> Selection<'a> {
    let mut data = data.clone();
    let mut extended = baseline.clone();
    let mut chosen: Vec<Refitted<'a>> = Vec::new();
    let mut rounds = Vec::new();
    let longest = data.drives.iter().map(GriddedDrive::seconds).fold(0.0, f64::max);
    let onsets = if data.share < 1.0 { onsets_within(data.drives) } else { onsets(longest) };
    for taken in before {
        extended = taken.fit.clone();
        rounds.push(Round::without_rivals(&taken));
        chosen.push(taken);
    }
    let mut was_at_end = false;
    // What every car has leaves room for what is unusual.
    let is_unusual = |taken: &&Refitted<'a>| !taken.candidate.kind.search.every_car_has;
    while chosen.iter().filter(is_unusual).count() < TUNING.selection.most_findings {
        progress(if chosen.is_empty() { work::NAMING } else { work::MORE }, 0.0);
        let is_new = |candidate: &Candidate| {
            let same = |other: &Refitted<'_>| {
                let of_it = |place: &usize| candidate.free.contains(place);
                other.candidate.name() == candidate.name() && other.candidate.free.iter().all(of_it)
            };
            !chosen.iter().any(same)
        };
        let library: Vec<Candidate> = library(&extended.model, &onsets).into_iter().filter(is_new).collect();
        let found: f64 = chosen.iter().map(|refitted| refitted.evidence).sum();
        // An excerpt tells as much less: what passes here must pass again on everything.
        let is_further = !chosen.is_empty();
        let least = least_evidence(data.share, &chosen);
        let of_course = |of: &Refitted<'_>| {
            // What does not depend on the driving is hardly what the equations of the rest miss.
            let is_independent = of.follows.is_some_and(|share| share < TUNING.selection.independent);
            let share = if is_independent {
                TUNING.selection.further_share_of_independent
            } else {
                TUNING.selection.further_share_of_course
            };
            f64::max(data.share * TUNING.selection.further_evidence, share * found)
        };
        let is_enough = |of: &Refitted<'_>| {
            let is_further_course = is_further && of.candidate.live.is_some();
            of.evidence > if is_further_course { of_course(of) } else { least }
        };
        // Equations that hardly err as they are would only say the same again.
        let least_diffusion = data.strict(&extended.noise).diffusion;
        let errs =
            extended.noise.diffusion.iter().zip(least_diffusion).any(|(learnt, least)| *learnt > least);
        let strictly = || errs.then(|| data.fit_strictly(&extended, STRICT_ROUNDS));
        let learnt = (&extended, Learn::Noise);
        let mut round = if let Some(strict) = chosen.is_empty().then(strictly).flatten() {
            look(&data, &extended, &[learnt, (&strict, Learn::Nothing)], &library, least)
        } else {
            look(&data, &extended, &[learnt], &library, least)
        };
        let shows = |round: &Round<'_>| round.refitted.iter().any(is_enough);
        // Beside what was found, the rest mostly shows without.
        if is_further
            && !shows(&round)
            && let Some(strict) = strictly()
        {
            round = round.and(look(&data, &extended, &[(&strict, Learn::Nothing)], &library, least));
        }
        round.refitted.retain(|of| of.candidate.live.is_none() || is_enough(of));
        let stands_for_all = put_in_order(&data, &extended, &mut round.refitted);
        for refitted in &round.refitted {
            tracing::debug!(name = refitted.candidate.name(), evidence = refitted.evidence, "fitted");
        }
        let mut worth: Vec<&Refitted<'a>> = round.refitted.iter().filter(|of| is_enough(of)).collect();
        // What cannot be told from what every car has is not unusual, though that may not be sure enough to be named.
        if stands_for_all && !round.refitted.first().is_some_and(is_enough) {
            worth.clear();
        }
        let best = worth.first().copied();
        // At the end the rest of what every car has, once.
        let ordinary = if worth.is_empty() && was_at_end {
            Vec::new()
        } else {
            before_the_unusual(&data, &extended, &library, &round.refitted, best)
        };
        was_at_end |= worth.is_empty();
        if let Some(last) = ordinary.last() {
            extended = last.fit.clone();
            rounds.extend(ordinary.iter().map(Round::without_rivals));
            chosen.extend(ordinary);
            continue;
        }
        let taken = first_confirmed(&data, (&baseline, &extended), &worth, is_further);
        rounds.push(round);
        let Some(taken) = taken else { break };
        data.split = taken.split;
        (baseline, extended) = (taken.baseline, taken.refitted.fit.clone());
        chosen.push(taken.refitted);
    }
    Selection { baseline, extended, chosen, rounds, split: data.split }
}

/// Evidence that is needed in a share of the recordings, after so much has been chosen or nothing.
pub fn least_evidence(share: f64, chosen: &[Refitted<'_>]) -> f64 {
    if chosen.is_empty() {
        return share * LEAST_EVIDENCE;
    }
    let of_found = |taken: &Refitted<'_>| {
        let by = if taken.candidate.kind.search.every_car_has {
            TUNING.selection.further_share_of_ordinary
        } else {
            TUNING.selection.further_share
        };
        by * taken.evidence
    };
    f64::max(share * TUNING.selection.further_evidence, chosen.iter().map(of_found).sum())
}

/// Scans the library from some fits, fits what is worth it, and refuses what only follows the driver.
fn look<'a>(
    data: &Data<'_>,
    before: &Fit<'a>,
    grounds: &[(&Fit<'a>, Learn)],
    library: &[Candidate],
    least: f64,
) -> Round<'a> {
    let scans: Vec<Vec<Scored>> = grounds.iter().map(|(at, _)| scan(data, at, library)).collect();
    tracing::trace!(candidates = library.len(), grounds = grounds.len(), "scanned");
    let mut all = fitted(data, before, grounds.iter().zip(&scans), library, least);
    for of in &mut all {
        of.follows = following_share(data, of);
    }
    let is_own = |of: &Refitted<'_>| of.follows.is_none_or(|share| share <= TUNING.selection.most_following);
    let (refitted, refused): (Vec<_>, Vec<_>) = all.into_iter().partition(is_own);
    let following = refused.into_iter().map(|refused| (refused.candidate, refused.evidence)).collect();
    Round { scanned: scans.into_iter().next().unwrap_or_default(), refitted, following }
}

/// The candidates that are worth it by any of the scans, fitted with everything else, best first.
fn fitted<'f, 'a: 'f>(
    data: &Data<'_>,
    before: &Fit<'a>,
    scans: impl Iterator<Item = (&'f (&'f Fit<'a>, Learn), &'f Vec<Scored>)>,
    library: &[Candidate],
    least: f64,
) -> Vec<Refitted<'a>> {
    let worth: Vec<(&(&Fit<'a>, Learn), &Scored)> = scans
        .flat_map(|(ground, scanned)| worth(scanned, least).map(move |scored| (ground, scored)))
        .collect();
    let first: Vec<Refitted<'a>> = worth
        .par_iter()
        .map(|(ground, scored)| refit(data, before, **ground, scored, FIRST_ROUNDS))
        .collect();
    for ((ground, scored), first) in worth.iter().zip(&first) {
        tracing::trace!(
            name = scored.candidate.name(),
            from = ?ground.1,
            gain = scored.gain,
            evidence = first.evidence,
            "first fit"
        );
    }
    let mut all = best_of_each(first);
    let enough = TUNING.selection.rival_share * all.first().map_or(0.0, |first| first.evidence);
    all.par_iter_mut().enumerate().for_each(|(rank, refitted)| {
        if rank < TUNING.selection.most_rivals || refitted.evidence > enough {
            *refitted = refine(data, before, refitted, NEXT_ROUNDS);
        }
    });
    let patches = patches(data, before, &all, library);
    let mut all: Vec<Refitted<'a>> =
        all.into_par_iter().filter_map(|refitted| in_shape(data, before, refitted)).collect();
    all.retain(|refitted| {
        patches::is_possible(data, refitted)
            && is_noteworthy(refitted)
            && does_begin(data, refitted)
            && shows_throughout(data, refitted)
    });
    best_of_each(all.into_iter().chain(patches).collect())
}

/// Is it large enough to be anybody's mistake, and no load that is less than none? See
/// [`SearchHints`](physics::model::effect::SearchHints).
fn is_noteworthy(refitted: &Refitted<'_>) -> bool {
    let candidate = &refitted.candidate;
    let of_a_torque = matches!(
        candidate.channel.and_then(Channel::quantity),
        Some(Quantity::DriveTorque | Quantity::BrakePressure)
    );
    let size = refitted.size();
    let least = candidate.kind.search.least_of_torque.filter(|_| of_a_torque);
    least.zip(size).is_none_or(|(least, size)| size.abs() > least)
        && !(candidate.is_from_start() && size.is_some_and(|size| size < 0.0))
}

/// Of what begins at a moment: do the data say that it was not there from the start? Else the car's own numbers would have it.
/// What may be there from the start has not to begin, if it is no load that is less than none.
fn does_begin(data: &Data<'_>, refitted: &Refitted<'_>) -> bool {
    let Refitted { candidate, fit, .. } = refitted;
    let Some(place) = candidate.kind.onset().filter(|_| refitted.onset().is_some()) else { return true };
    if candidate.kind.search.from_start && refitted.size().is_some_and(|size| size >= 0.0) {
        return true;
    }
    let (always, _) =
        begun_at(data, &fit.model, &fit.noise, fit.model.effects.len() - 1, place, Spec::AT_S.mean);
    always - fit.minus_two_ln > data.share * LEAST_EVIDENCE
}

/// What lies in patches, within clear edges: each kind of them wherever the course of any kind has some; and each
/// kind of slippery ones where wheels slide.
fn patches<'a>(
    data: &Data<'_>,
    before: &Fit<'a>,
    all: &[Refitted<'a>],
    library: &[Candidate],
) -> Vec<Refitted<'a>> {
    let patchy: Vec<&Refitted<'a>> = all
        .iter()
        .filter(|refitted| refitted.candidate.live.is_some() && patches::is_patchy(&refitted.candidate))
        .collect();
    let mut places: Vec<Vec<[f64; 2]>> =
        patchy.par_iter().filter_map(|refitted| patches::intervals(data, &refitted.fit)).collect();
    places.dedup();
    let mut pairs: Vec<(&Candidate, &Vec<[f64; 2]>)> = patchy
        .iter()
        .flat_map(|refitted| places.iter().map(move |place| (&refitted.candidate, place)))
        .collect();
    let sliding = patches::of_sliding(data);
    if let Some(place) = &sliding {
        let is_there = |kind: &Kind| before.model.effects.iter().any(|effect| *effect.kind == *kind);
        let slippery = patches::slippery(library).filter(|candidate| !is_there(candidate.kind));
        pairs.extend(slippery.map(|candidate| (candidate, place)));
    }
    let placed = pairs
        .par_iter()
        .filter_map(|(candidate, place)| patches::placed(data, before, candidate, place, NEXT_ROUNDS));
    placed.collect()
}

/// The candidates of a scan that are worth a fit.
fn worth(scanned: &[Scored], least: f64) -> impl Iterator<Item = &Scored> {
    let best = scanned.first().map_or(0.0, |scored| scored.gain);
    let enough = move |(rank, scored): &(usize, &Scored)| {
        let hides = scored.candidate.kind.search.growth == Growth::Quadratic;
        let is_among_best =
            *rank < TUNING.selection.most_refitted && scored.gain > TUNING.selection.least_share * best;
        scored.gain > TUNING.selection.least_of_first_order * least && (hides || is_among_best)
    };
    scanned.iter().enumerate().filter(enough).map(|(_, scored)| scored)
}

/// Of each candidate the fit with most evidence, best first.
fn best_of_each(mut refitted: Vec<Refitted<'_>>) -> Vec<Refitted<'_>> {
    refitted.sort_by(|a, b| b.evidence.total_cmp(&a.evidence));
    let mut seen = BTreeSet::new();
    refitted.retain(|refitted| seen.insert(refitted.candidate.name()));
    refitted
}

/// How much of a candidate's course follows from the driver's inputs; none of what is no course.
pub fn following_share(data: &Data<'_>, refitted: &Refitted<'_>) -> Option<f64> {
    refitted.candidate.live?;
    let place = refitted.fit.noise.live.len().checked_sub(1)?;
    // Slippery patches show where the driver makes them show.
    if patches::is_patchy(&refitted.candidate) {
        return None;
    }
    let of = if refitted.candidate.channel.is_none() { CourseOf::Road } else { CourseOf::Other };
    let share = mean_following(data, &refitted.fit, place, of);
    tracing::trace!(name = refitted.candidate.name(), share, "follows the driver");
    Some(share)
}

/// How much of a fit's course at a place follows from what the driver does: the mean over the drives.
pub fn mean_following(data: &Data<'_>, fit: &Fit<'_>, place: usize, of: CourseOf) -> f64 {
    let length = fit.noise.live[place].length_s;
    let share = |drive| {
        let courses = courses(drive, &fit.model, &fit.noise, Default::default());
        courses.get(place).map_or(0.0, |course| follows_motion(drive, course, length, of))
    };
    data.drives.iter().map(share).sum::<f64>() / data.drives.len().max(1) as f64
}

#[cfg(test)]
mod tests {
    use super::super::bench::refitted;
    use super::*;
    use physics::model::effect::named;

    /// Does the centre of gravity move at a moment in a drive in which it did at another, s?
    fn begins(truly: f64, at: f64) -> bool {
        let hidden = format!("[[effect]]\nkind = \"cg_shift\"\nshift_m = -0.15\nat_s = {truly}\n");
        refitted(&hidden, named("cg_shift").unwrap(), &[at], |data, _, shift| {
            assert_eq!(shift.onset(), Some(at));
            does_begin(data, &shift)
        })
    }

    #[test]
    #[ignore = "long: two cars fitted"]
    fn what_was_off_from_the_start_is_no_change() {
        assert!(begins(22.0, 22.0));
        assert!(!begins(-1.0, 5.0));
    }
}
