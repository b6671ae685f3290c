//! A chosen effect as a finding of the answer: its probability, its numbers, its rivals.

use std::collections::{BTreeMap, BTreeSet};

use super::candidates::Candidate;
use super::chain::{AuditFinding, ChainReport, Confidence};
use super::conclusion::Conclusion;
use super::course::SmoothedCourse;
use super::fit::Fit;
use super::model::Place;
use super::naming::{Refitted, onset_std};
use super::result::{CourseEstimate, Estimate, Finding, Nature, Ranked, ToDrive, Where};
use super::select::{Round, Selection};
use physics::Quantity;
use physics::model::effect::{Spec, named};
use predict::{GriddedDrive, Recording};

/// A rival whose evidence is less than so far behind cannot be told from what was chosen.
/// Statistical: odds of 33 to 1.
pub const TOLD_APART: f64 = 7.0;

/// What is told of the effect chosen in this round. `place` is where its fit is better than the one before.
pub fn finding(
    conclusion: &Conclusion<'_, '_>,
    number: usize,
    extended: &Fit<'_>,
    mut place: Where,
) -> Finding {
    let taken = &conclusion.selection.chosen[number];
    let candidate = &taken.candidate;
    let of_its_kind = Finding::of(candidate.kind, candidate.channel);
    place.equation.clone_from(&of_its_kind.place.equation);
    // Those that the configuration switches on come first in the model.
    let effect = extended.model.effects.len() - conclusion.selection.chosen.len() + number;
    let mut parameters = own_numbers(conclusion, extended, effect);
    if let Some((at, place)) = taken.onset().zip(candidate.kind.onset()) {
        let std = onset_std(conclusion.data, extended, effect, place);
        parameters.insert(Spec::AT_S.name.into(), Estimate { value: at, std });
    }
    let mut series = None;
    if candidate.live.is_some() {
        if let Some(course) =
            SmoothedCourse::new(conclusion.drives, (extended, effect), candidate, &place.recording)
        {
            place.intervals = course.clear_stretches();
            place.recording.clone_from(&course.drive.name);
            course.summarize(candidate, (extended, effect), &mut parameters);
            series = Some(course.decimated(candidate));
        }
    } else if !candidate.stretches.is_empty() {
        place.intervals.clone_from(&candidate.stretches);
    } else if let Some(at) = taken.onset() {
        place.intervals = vec![[at, conclusion.drives.first().map_or(at, GriddedDrive::seconds)]];
    }
    for (name, estimate) in &mut parameters {
        let place = candidate.kind.place_of(name);
        let share = place.map_or(Spec::MODEL_ERROR, |place| candidate.kind.parameters[place].model_error);
        estimate.std = estimate.std.hypot(share * estimate.value);
    }
    let round = &conclusion.selection.rounds[number];
    Finding {
        kind: Nature::of_size(candidate.kind, candidate.channel, &parameters),
        probability: probability(taken, round),
        indistinguishable_from: rivals(taken, round),
        parameters,
        series,
        place,
        evidence: taken.evidence,
        ..of_its_kind
    }
}

/// Manoeuvres, in words, that would tell what findings could be something else as well.
pub fn told_apart(findings: &[Finding]) -> Vec<ToDrive> {
    let open = findings.iter().filter(|finding| !finding.indistinguishable_from.is_empty());
    open.map(|finding| finding.to_tell_apart.clone().into()).collect()
}

/// What the audit of the measurement is certain of, as findings, of what `counts`; what is there already is left out.
pub fn measured_wrong(
    recordings: &[Recording],
    chain: &[ChainReport],
    known: &[Finding],
    counts: impl Fn(&AuditFinding) -> bool,
) -> Vec<Finding> {
    let mut all: Vec<Finding> = Vec::new();
    for (recording, report) in recordings.iter().zip(chain) {
        let certain = report.findings.iter().filter(|audited| audited.confidence == Confidence::Certain);
        for audited in certain.filter(|audited| counts(audited)) {
            if !known.iter().chain(&all).any(|finding| says(finding, audited)) {
                all.push(wrong(recording, report, audited));
            }
        }
    }
    all
}

fn wrong(recording: &Recording, report: &ChainReport, audited: &AuditFinding) -> Finding {
    let mut finding = Finding {
        effect: audited.effect.into(),
        channel: Some(audited.channel.clone()),
        kind: Nature::Measurement,
        probability: CERTAIN,
        about: audited.evidence.clone(),
        evidence: audited.t * audited.t,
        ..Finding::default()
    };
    finding.place.channels.push(audited.channel.clone());
    let Some(kind) = named(audited.effect) else { return finding };
    finding.channel = finding.channel.filter(|_| kind.is_of_measurement());
    finding.place.equation = kind.place.into();
    finding.to_tell_apart = kind.to_tell_apart.into();
    finding.equation = kind.equation.into();
    // The effect has a number for each wheel.
    let wheel = audited.channel.parse::<Quantity>().ok().filter(|_| audited.effect == TIRE_RADIUS);
    let number = kind.parameters.get(wheel.map_or(0, |wheel| wheel as usize)).map(|spec| spec.name);
    let name = number.or_else(|| kind.course.map(|course| course.rms_name));
    let estimate = audited.value.zip(audited.std).map(|(value, std)| Estimate { value, std });
    finding.parameters.extend(name.map(str::to_owned).zip(estimate));
    if let Some(zero) = report.drift.as_ref().filter(|_| audited.effect == AuditFinding::DRIFT) {
        finding.place.recording.clone_from(&recording.name);
        finding.series = Some(CourseEstimate::of_zero(zero, recording.begins_s.unwrap_or_default()));
    }
    finding
}

/// Leaves a zero that moves to the audit where that has seen it: what the search finds of it, a drift or a jump, is what the
/// line from one stop to the next has left.
pub fn leave_drift_to_audit(findings: &mut Vec<Finding>, chain: &[ChainReport]) {
    if chain.iter().any(|report| report.drift.is_some()) {
        let moves =
            |finding: &Finding| [AuditFinding::DRIFT, "sensor_bias"].contains(&finding.effect.as_str());
        let is_of = |finding: &Finding| finding.channel.as_deref() == Some(Quantity::YawRate.name());
        findings.retain(|finding| !(moves(finding) && is_of(finding)));
    }
}

/// Where all curves are long, a road that is banked in them is as likely as an accelerometer that reads too little of them, or too
/// late.
pub fn leave_banks_open(findings: &mut [Finding], chain: &[ChainReport]) {
    const ROAD: &str = "road_bank";
    let may_be_banked = chain.iter().any(|report| report.may_be_banked);
    let lateral = Quantity::LateralAcceleration.name();
    let is_of_sensor = |finding: &&mut Finding| {
        ["sensor_scale", "sensor_delay"].contains(&finding.effect.as_str())
            && finding.channel.as_deref() == Some(lateral)
    };
    for finding in findings.iter_mut().filter(|_| may_be_banked).filter(is_of_sensor) {
        finding.probability = finding.probability.min(0.5);
        if !finding.indistinguishable_from.iter().any(|other| other == ROAD) {
            finding.indistinguishable_from.push(ROAD.to_owned());
        }
    }
}

/// Does a finding say what the audit says?
pub fn says(finding: &Finding, audited: &AuditFinding) -> bool {
    let channel = audited.channel.parse::<Quantity>().ok().filter(|_| audited.effect != TIRE_RADIUS);
    finding.effect == audited.effect
        && channel.is_none_or(|channel| finding.channel.as_deref() == Some(channel.name()))
}

/// One effect for all four wheels.
const TIRE_RADIUS: &str = "tire_radius";

/// How often the audit is right where it is certain.
const CERTAIN: f64 = 0.99;

/// Among all that was fitted in its round, and nothing at all. What it was preferred to for being simpler is no
/// more probable, whatever its evidence.
fn probability(taken: &Refitted<'_>, round: &Round<'_>) -> f64 {
    let others = round.refitted.iter().filter(|other| other.candidate.name() != taken.candidate.name());
    probability_among(taken.evidence, others.map(|other| other.evidence))
}

/// Of what has this evidence among others and nothing at all, by their odds.
pub fn probability_among(evidence: f64, others: impl Iterator<Item = f64>) -> f64 {
    let weight = |other: f64| (0.5 * (other - evidence).min(0.0)).exp();
    1.0 / (1.0 + others.map(weight).sum::<f64>() + weight(0.0))
}

/// What this recording cannot tell it from.
fn rivals(taken: &Refitted<'_>, round: &Round<'_>) -> Vec<String> {
    let close = round.refitted.iter().filter(|other| other.evidence > taken.evidence - TOLD_APART);
    let names: BTreeSet<String> = close.map(|other| other.candidate.name()).collect();
    names.into_iter().filter(|name| *name != taken.candidate.name()).collect()
}

/// Everything that was tried in the first round, best first: fitted ones by their evidence, the others to
/// first order, never above a fitted one.
pub fn ranking(selection: &Selection<'_>) -> Vec<Ranked> {
    let mut ranking: Vec<Ranked> = Vec::new();
    let mut seen = BTreeSet::new();
    let Some(round) = selection.rounds.first() else { return ranking };
    let mut rank = |candidate: &Candidate, score: f64, refitted: bool| {
        if seen.insert(candidate.name()) {
            let least = ranking.last().map_or(f64::INFINITY, |last| last.score);
            ranking.push(Ranked {
                effect: candidate.kind.name.into(),
                channel: candidate.channel.map(|channel| channel.to_string()),
                score: score.min(least),
                refitted,
            });
        }
    };
    for other in &round.refitted {
        rank(&other.candidate, other.evidence, true);
    }
    let refused: Vec<String> = round.following.iter().map(|(candidate, _)| candidate.name()).collect();
    for other in round.scanned.iter().filter(|other| !refused.contains(&other.candidate.name())) {
        rank(&other.candidate, other.gain, false);
    }
    ranking
}

/// Numbers of one of the effects, by name.
fn own_numbers(conclusion: &Conclusion<'_, '_>, fit: &Fit<'_>, number: usize) -> BTreeMap<String, Estimate> {
    let Some(chosen) = fit.model.effects.get(number) else { return BTreeMap::new() };
    let variances = conclusion.data.variances(fit);
    let of = |(place, spec): (usize, Spec)| {
        let coordinate = chosen.numbers[place];
        // What is not searched has nothing to say.
        let free = fit.free.iter().position(|free| free.place == Place::Effect(number, place))?;
        let std = variances[free].sqrt() * spec.scale.slope(coordinate).abs();
        Some((spec.name.to_owned(), Estimate { value: spec.value(coordinate), std }))
    };
    chosen.specs().enumerate().filter_map(of).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_scale_may_be_a_bank_where_all_curves_are_long() {
        let scale = |channel: &str| Finding {
            effect: "sensor_scale".into(),
            channel: Some(channel.into()),
            probability: 0.99,
            ..Finding::default()
        };
        let mut findings = [scale("lateral_acceleration"), scale("yaw_rate")];
        leave_banks_open(&mut findings, &[ChainReport::default()]);
        assert!(findings.iter().all(|finding| finding.probability == 0.99));
        let banked = ChainReport { may_be_banked: true, ..ChainReport::default() };
        leave_banks_open(&mut findings, &[ChainReport::default(), banked]);
        assert_eq!(findings[0].indistinguishable_from, ["road_bank"]);
        assert_eq!((findings[0].probability, findings[1].probability), (0.5, 0.99));
        assert!(findings[1].indistinguishable_from.is_empty());
    }
}
