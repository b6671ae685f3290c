//! What recordings say beyond the ordinary car: effects that are searched by free runs.
//!
//! ```text
//! FreeFit ─► climb (for coloured noise) ─► scan (all trials, decoys) ─► refit (noise learned beside each) ─► told
//!             └────────────────────────── once more, with what was taken ◄──────────────┘
//! ```
//!
//! Every trial is scored to first order after all ordinary numbers have taken what they can; the best are fitted together
//! with these, with the noise's colour learned anew beside each. One is taken if the odds are for it, held-out blocks are
//! better predicted, and it beats the best that decoys do: the same effects at another time of the drive. What cannot be
//! told from physics that every car has is not called unusual.
//!
//! Beside references, drives of the same car that count as healthy, a trial is of the other recordings only, and a number
//! of the car may be another one there. Then all that counts is what the references have not.

mod climb;
mod colour;
mod power;
mod references;
mod refit;
mod rows;
mod scan;
mod told;
mod trial;

use std::collections::{BTreeMap, BTreeSet};

use rayon::prelude::*;

use super::fit::FreeFit;
use super::inputs::FreeDrive;
use super::numbers::Scope;
use super::run::Predicted;
use crate::explain::result::{Finding, Nature, Ranked};
use crate::explain::select::LEAST_EVIDENCE;
use physics::model::Vehicle;
use physics::model::effect::Kind;

use climb::State;
use refit::Refitted;
use scan::Scored;
use trial::Trial;

pub use power::{Power, Powers, powers};
pub use rows::rows;

/// What was found, and everything that was tried.
#[derive(Clone, Debug, Default)]
pub struct Beyond {
    /// What is unusual first, what every car has last.
    pub findings: Vec<Finding>,
    /// Is something of that more than an ordinary car and its sensors have?
    pub is_unusual: bool,
    /// Best first.
    pub ranking: Vec<Ranked>,
    /// What the car predicts with what the search found, if it found anything.
    pub predicted: Option<Vec<Predicted>>,
}

/// Most findings of the search.
const MOST: usize = 3;

/// Of a scan so many are fitted together with everything else …
const MOST_REFITTED: usize = 6;

/// … if to first order they have this share of the evidence that is needed.
const LEAST_OF_FIRST_ORDER: f64 = 0.3;

/// What to first order gains less than this share of what the best law does is no rival of it. Tuned by
/// `shared/trials/unknown`: there the best effect of the library has a tenth.
const LEAST_BESIDE_A_LAW: f64 = 0.2;

/// By so much held-out −2 ln likelihood must fall. Statistical: odds of e³ on driving that was not looked at.
const LEAST_HELD_GAIN: f64 = 6.0;

/// So many deviations a main number must be from nothing.
const LEAST_CLEAR: f64 = 4.0;

/// What a search works with.
struct Search<'s> {
    drives: &'s [FreeDrive],
    vehicle: &'s Vehicle,
    /// How often each name is tried: at so many times.
    tried: BTreeMap<String, usize>,
    /// Squared errors of yaw rate and lateral acceleration of the plain model, on held-out rows.
    plain: [f64; 2],
    /// So many recordings, the first ones, are references.
    references: usize,
}

/// What is asked of a search.
#[derive(Clone, Copy)]
pub struct Question<'q> {
    /// What could be there.
    pub kinds: &'q [&'static Kind],
    /// So many recordings, the first ones, are healthy, and the question is what the others have that they have not.
    pub references: usize,
    /// Squared errors of yaw rate and lateral acceleration of the plain model, on held-out rows.
    pub plain: [f64; 2],
    /// Does something repeat of what such runs leave? That has a reason, in the library or, as a law, in none.
    pub repeats: &'q (dyn Fn(&[Predicted]) -> bool + Sync),
    /// Of what is drawn at random.
    pub seed: u64,
}

/// Searches beside a fitted ordinary car.
pub fn beyond(
    found: &FreeFit<'_>,
    vehicle: &Vehicle,
    drives: &[FreeDrive],
    question: Question<'_>,
) -> Beyond {
    let Question { kinds, references, plain, repeats, seed } = question;
    let mut answer = Beyond::default();
    let mut trials = trial::trials(found, drives, kinds, scope(references));
    if references == 0 && repeats(&found.predicted) {
        trials.extend(trial::laws(drives, scope(references)));
    }
    if trials.is_empty() {
        return answer;
    }
    let search = Search { drives, vehicle, tried: tried(&trials), plain, references };
    let mut state = search.start(found);
    // Of a car's numbers and sensors the references have the same.
    let usual = if references > 0 { Vec::new() } else { search.usual(&state) };
    let mut taken = BTreeSet::new();
    for round in 0..MOST {
        let (scored, null) = search.scan(&state, &trials, seed);
        let most = scored.iter().filter(|scored| scored.trial.is_law()).map(|scored| scored.gain);
        let least = LEAST_BESIDE_A_LAW * most.fold(0.0, f64::max);
        let open = |is_law: bool| {
            let open = scored.iter().filter(move |scored| scored.trial.is_law() == is_law);
            open.filter(|scored| !taken.contains(&scored.trial.name()))
                .filter(move |scored| scored.gain > least.max(LEAST_OF_FIRST_ORDER * LEAST_EVIDENCE))
                .take(MOST_REFITTED)
        };
        let some: Vec<&Scored> = open(false).chain(open(true)).collect();
        let refitted = some.into_par_iter().map(|scored| (scored.gain, search.refit(&state, scored)));
        let mut refitted: Vec<(f64, Refitted<'_>)> = refitted.collect();
        let names = refitted.iter().map(|(_, of)| of.trial.name()).collect();
        let healthy = search.healthy(&state, &trials, &names, seed);
        for (_, of) in &mut refitted {
            of.evidence = of.evidence_beyond(&healthy);
        }
        refitted.sort_by(|a, b| b.1.evidence.total_cmp(&a.1.evidence));
        for (gain, refitted) in &refitted {
            tracing::debug!(
                name = refitted.trial.name(),
                onset = ?refitted.trial.onset(),
                stretches = ?refitted.trial.stretches(),
                distance = ?refitted.distance(&healthy),
                gain,
                null,
                evidence = refitted.evidence,
                held_gain = refitted.held_gain,
                numbers = ?refitted.parameters(),
                "beyond the ordinary car"
            );
        }
        if round == 0 {
            answer.ranking = ranking(&refitted, &scored);
        }
        let usual_rivals = || refitted.iter().map(|(_, of)| of).filter(|of| of.trial.is_of_every_car());
        let of_library = || refitted.iter().map(|(_, of)| of).filter(|of| !of.trial.is_law());
        let is_sure = |(gain, of): &&(f64, Refitted<'_>)| {
            of.evidence > LEAST_EVIDENCE
                && (references > 0
                    || of.trial.is_of_every_car()
                    || usual_rivals().all(|usual| of.is_told_from(usual)))
                && (!of.trial.is_law() || of_library().all(|named| of.is_told_from(named)))
                && of.is_beyond(&healthy)
                && of.held_gain > least_held_gain(references, &of.trial)
                && (of.trial.has_time() || *gain > null)
                && of.clearest() > LEAST_CLEAR
                && !of.is_at_bound()
        };
        let Some((_, best)) = refitted.iter().find(is_sure) else { break };
        let all: Vec<(String, f64)> = refitted.iter().map(|(_, of)| (of.trial.name(), of.evidence)).collect();
        taken.insert(best.trial.name());
        let finding = search.finding(&state, best, &all);
        answer.is_unusual |= references > 0 || finding.kind != Nature::Ordinary;
        answer.findings.push(finding);
        state = search.with(best);
        let predicted = search.predicted(&state.model, &state.free, &state.at);
        if !repeats(&predicted) {
            trials.retain(|trial| !trial.is_law());
        }
        answer.predicted = Some(predicted);
    }
    answer.is_unusual |= usual.iter().any(|(_, is_unusual)| *is_unusual);
    answer.findings.extend(usual.into_iter().map(|(finding, _)| finding));
    // Stable: what has more evidence stays first.
    answer.findings.sort_by_key(|finding| finding.kind);
    answer
}

/// Of which recordings anything could be that is searched for.
fn scope(references: usize) -> Scope {
    if references > 0 { Scope::Since(references) } else { Scope::Car }
}

/// How often each name is tried; of a law, how many there are: any of them would have been told.
fn tried(trials: &[Trial]) -> BTreeMap<String, usize> {
    let laws = trials.iter().filter(|trial| trial.is_law()).count();
    let mut tried = BTreeMap::new();
    for trial in trials {
        *tried.entry(trial.name()).or_insert(0) += if trial.is_law() { laws } else { 1 };
    }
    tried
}

impl Search<'_> {
    /// The ordinary car to begin with, as the references let expect it.
    fn start<'a>(&self, found: &FreeFit<'a>) -> State<'a> {
        match self.references {
            0 => self.begin(found),
            references => self.begin(&references::expecting(found, references)),
        }
    }
}

/// Where references tell a number, other numbers may take its place at the price of being unlike theirs: then the evidence
/// is in that price, and held-out driving must not speak against it.
fn least_held_gain(references: usize, trial: &Trial) -> f64 {
    if references > 0 && trial.is_always_there() { -LEAST_HELD_GAIN } else { LEAST_HELD_GAIN }
}

fn ranking(refitted: &[(f64, Refitted<'_>)], scored: &[Scored]) -> Vec<Ranked> {
    let ranked = |trial: &Trial, score: f64, refitted: bool| Ranked {
        effect: trial.candidate().map_or_else(|| trial.name(), |candidate| candidate.kind.name.into()),
        channel: trial.candidate().and_then(|candidate| Some(candidate.channel?.to_string())),
        score,
        refitted,
    };
    let mut all: Vec<Ranked> = refitted.iter().map(|(_, of)| ranked(&of.trial, of.evidence, true)).collect();
    let least = all.last().map_or(f64::INFINITY, |last| last.score);
    let names: BTreeSet<String> = refitted.iter().map(|(_, of)| of.trial.name()).collect();
    let others = scored.iter().filter(|scored| !names.contains(&scored.trial.name()));
    all.extend(others.map(|scored| ranked(&scored.trial, scored.gain.min(least), false)));
    all
}

#[cfg(test)]
mod tests {
    use super::super::super::bench::recorded;
    use super::super::{Asked, Ordinary};
    use super::*;
    use physics::model::effect::KINDS;

    /// What is found in a drive with these effects.
    fn found(effects: &str) -> Beyond {
        let (vehicle, recording) = recorded(effects);
        let asked = Asked { library: KINDS, searches: &|_| true, references: 0, held_out: 0, seed: 1 };
        Ordinary::of(&vehicle, &[], &[recording], asked).unwrap().beyond
    }

    /// GIVEN a yaw rate whose zero jumps THEN that is named first, with its size and moment.
    #[test]
    fn a_jump_of_a_sensor_is_found_with_its_moment() {
        let jump = "[[effect]]\nkind = \"sensor_bias\"\nchannel = \"yaw_rate\"\nbias = 0.03\nat_s = 20.0\n";
        let beyond = found(jump);
        let first = &beyond.findings[0];
        assert_eq!((first.effect.as_str(), first.channel.as_deref()), ("sensor_bias", Some("yaw_rate")));
        assert!((first.parameters["bias"].value - 0.03).abs() < 0.004, "{:?}", first.parameters);
        assert!((first.parameters["at_s"].value - 20.0).abs() < 1.0, "{:?}", first.parameters);
        assert!(beyond.is_unusual && first.explained_share["yaw_rate"] > 0.05, "{:?}", first.explained_share);
    }

    /// GIVEN a car that pulls to the left when it brakes, as no effect of the library has it THEN that is told as a law, with
    /// its number.
    #[test]
    fn what_no_library_has_is_told_as_a_law() {
        let pull = "[[effect]]\nkind = \"law\"\nplace = \"front slip angle\"\n\
                    expression = \"coefficient * a_x\"\ncoefficient = 0.0008\n";
        let beyond = found(pull);
        let first = &beyond.findings[0];
        let law = first.law.as_ref().unwrap();
        assert_eq!((first.kind, law.place.as_str()), (Nature::Law, "front slip angle"), "{law:?}");
        assert_eq!(law.terms[0].feature, "a_x");
        assert_eq!(law.terms[0].unit, "rad/(m/s²)");
        assert!((law.terms[0].coefficient.value / 0.0008 - 1.0).abs() < 0.15, "{law:?}");
        assert!(beyond.is_unusual && first.explained_share["yaw_rate"] > 0.05, "{:?}", first.explained_share);
    }

    /// GIVEN an ordinary car, its steering late THEN these are told, and nothing unusual.
    #[test]
    fn an_ordinary_car_has_nothing_unusual() {
        let late = "[[effect]]\nkind = \"sensor_delay\"\nchannel = \"steering_wheel_angle\"\ndelay_s = 0.08\n\
                    [[effect]]\nkind = \"relaxation_length\"\nlength_m = 0.5\n";
        let beyond = found(late);
        assert!(!beyond.is_unusual, "{:?}", beyond.findings);
        let delay = beyond.findings.iter().find(|finding| finding.effect == "sensor_delay").unwrap();
        assert_eq!(delay.channel.as_deref(), Some("steering_wheel_angle"));
        assert!((delay.parameters["delay_s"].value - 0.08).abs() < 0.02, "{:?}", delay.parameters);
    }
}
