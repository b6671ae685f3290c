//! Choosing forward: the best effect, then what is best beside it, until nothing is left that the data
//! ask for and held-out data confirm.

use rayon::prelude::*;

use super::candidates::{Candidate, library};
use super::exogenous::follows_motion;
use super::fit::{Data, Fit};
use super::naming::{Refitted, Scored, refit, scan};
use super::smooth::courses;
use super::split::Part;
use crate::Quantity;
use crate::model::effect::Channel;

/// Evidence (twice the logarithm of the odds) that the first finding needs. The odds must beat those of
/// some fifty candidates, each with a small chance of its own; measured on recordings with nothing
/// missing (README).
pub const LEAST_EVIDENCE: f64 = 22.0;

/// Further findings need this, and this share of all that has been found.
const FURTHER_EVIDENCE: f64 = 30.0;
const FURTHER_SHARE: f64 = 0.03;

/// So many findings at most: what is beyond is noise, or another car.
const MOST_FINDINGS: usize = 5;

/// Candidates that are fitted together with everything else: so many at most, down to this share of the
/// best one's first-order gain.
const MOST_REFITTED: usize = 7;
const LEAST_SHARE: f64 = 0.08;

/// A course of which more than this follows from the driver's own inputs is none of wind and road.
const MOST_FOLLOWING: f64 = 0.4;

/// Rounds of a first fit, and of the one that is kept.
const FIRST_ROUNDS: usize = 4;
const LAST_ROUNDS: usize = 8;

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

/// What was chosen.
#[derive(Clone, Debug)]
pub struct Selection<'a> {
    /// The plain model.
    pub baseline: Fit<'a>,
    /// With all that was chosen.
    pub extended: Fit<'a>,
    /// What was chosen, in this order, each with the gain of held-out −2 ln likelihood.
    pub chosen: Vec<(Refitted<'a>, f64)>,
    /// All rounds.
    pub rounds: Vec<Round<'a>>,
}

/// Chooses, beginning with what was taken before. `progress` is told the stage and how far it is.
pub fn select<'a>(
    data: &Data<'_>,
    (baseline, before): (Fit<'a>, Vec<Refitted<'a>>),
    has: &(impl Fn(Quantity) -> bool + Sync),
    seconds: f64,
    progress: &(dyn Fn(&str, f64) + Sync),
) -> Selection<'a> {
    let mut extended = baseline.clone();
    let mut chosen: Vec<(Refitted<'a>, f64)> = Vec::new();
    let mut rounds = Vec::new();
    for taken in before {
        let held = data.of(Part::Holdout);
        let gain = held.minus_two_ln(&extended.sums) - held.minus_two_ln(&taken.fit.sums);
        extended = taken.fit.clone();
        let refitted = vec![taken.clone()];
        rounds.push(Round { scanned: Vec::new(), refitted, following: Vec::new() });
        chosen.push((taken, gain));
    }
    while chosen.len() < MOST_FINDINGS {
        progress(if chosen.is_empty() { "naming" } else { "looking for more" }, chosen.len() as f64 / 5.0);
        let library = library(&extended.model, has, seconds);
        let is_new = |candidate: &Candidate| {
            let same = |other: &(Refitted<'_>, f64)| {
                other.0.candidate.name() == candidate.name() && other.0.candidate.free == candidate.free
            };
            !chosen.iter().any(same)
        };
        let library: Vec<Candidate> = library.into_iter().filter(is_new).collect();
        let scanned = scan(data, &extended, &library);
        let best = scanned.first().map_or(0.0, |scored| scored.gain);
        let is_worth = |(rank, scored): &(usize, &Scored)| {
            // What grows with the square shows little to first order.
            let hides = scored.candidate.kind.name == "load_transfer";
            let is_large = scored.gain > (LEAST_SHARE * best).max(0.3 * LEAST_EVIDENCE);
            hides || *rank < MOST_REFITTED && is_large
        };
        let worth: Vec<&Scored> =
            scanned.iter().enumerate().filter(is_worth).map(|(_, scored)| scored).collect();
        let mut refitted: Vec<Refitted<'a>> =
            worth.par_iter().map(|scored| refit(data, &extended, scored, FIRST_ROUNDS)).collect();
        refitted.sort_by(|a, b| b.evidence.total_cmp(&a.evidence));
        let mut following = Vec::new();
        refitted.retain(|refitted| {
            let share = following_share(data, refitted);
            if share > MOST_FOLLOWING {
                following.push((refitted.candidate.clone(), refitted.evidence));
            }
            share <= MOST_FOLLOWING
        });
        prefer_the_simpler(&mut refitted);
        let found: f64 = chosen.iter().map(|(refitted, _)| refitted.evidence).sum();
        let least =
            if chosen.is_empty() { LEAST_EVIDENCE } else { FURTHER_EVIDENCE.max(FURTHER_SHARE * found) };
        let Some(first) = refitted.first().filter(|first| first.evidence > least) else {
            rounds.push(Round { scanned, refitted, following });
            break;
        };
        let (after, noise) = (&first.fit, &first.fit.noise);
        let polished = data.fit(&after.model, &after.free, noise, LAST_ROUNDS);
        let fit = if polished.minus_two_ln + polished.prior < after.minus_two_ln + after.prior {
            polished
        } else {
            after.clone()
        };
        let held = data.of(Part::Holdout);
        let gain = held.minus_two_ln(&extended.sums) - held.minus_two_ln(&fit.sums);
        // It must not make the prediction of what it has not seen worse.
        let confirmed = gain > -0.02 * first.evidence - 5.0 && (chosen.is_empty() || gain > 0.0);
        tracing::debug!(name = first.candidate.name(), evidence = first.evidence, held_out = gain, confirmed);
        if !confirmed {
            rounds.push(Round { scanned, refitted, following });
            break;
        }
        let taken = Refitted { fit: fit.clone(), ..first.clone() };
        rounds.push(Round { scanned, refitted, following });
        chosen.push((taken, gain));
        extended = fit;
    }
    Selection { baseline, extended, chosen, rounds }
}

/// How much of a candidate's course follows from the driver's inputs.
fn following_share(data: &Data<'_>, refitted: &Refitted<'_>) -> f64 {
    if refitted.candidate.live.is_none() {
        return 0.0;
    }
    let Some(length) = refitted.fit.noise.live.last().map(|live| live.length_s) else { return 0.0 };
    let model = &refitted.fit.model;
    // Brakes and slippery patches show where the driver makes them show.
    if refitted
        .candidate
        .kind
        .surroundings(refitted.candidate.channel)
        .is_some_and(|course| course.sign != 0.0)
    {
        return 0.0;
    }
    let shares = data.drives.iter().map(|drive| {
        let courses = courses(drive, model, &refitted.fit.noise, Default::default());
        courses.last().map_or(0.0, |course| (follows_motion(drive, course, length), drive.seconds()).0)
    });
    let shares: Vec<f64> = shares.collect();
    shares.iter().sum::<f64>() / shares.len().max(1) as f64
}

/// A number that is the same all the time is the simpler explanation than a course that could be anything:
/// where both explain about the same, it goes first.
fn prefer_the_simpler(refitted: &mut [Refitted<'_>]) {
    let Some(best) = refitted.first() else { return };
    if best.candidate.live.is_none() {
        return;
    }
    let enough = 0.9 * best.evidence;
    let simpler = refitted.iter().position(|other| {
        other.candidate.live.is_none() && other.evidence > enough && !is_of_a_sensor(other.candidate.channel)
    });
    if let Some(place) = simpler {
        refitted[..=place].rotate_right(1);
    }
}

fn is_of_a_sensor(channel: Option<Channel>) -> bool {
    channel.is_some()
}
