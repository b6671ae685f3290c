//! The configuration with what was found: effects, and the ordinary numbers as they are beside them.

mod beside;

use std::path::Path;

use crate::cli::Failure;
use crate::cli::desk::applied::Applied;
use lab::explain::found::{self, rounded};
use lab::explain::{Answer, Explanation, Verdict};
use lab::pages::explain::answer_lines;
use physics::model::Uncertain;
use physics::model::effect::{Course, EffectConfig, Series};

/// Points of a course in a file, per second.
const POINTS_PER_S: f64 = 5.0;

/// The whole configuration, ready for every other command. Numbers in doubt stay as they were, unless by force.
pub fn toml(from: &Path, to: &Path, answer: &Answer<'_>, force: bool) -> Result<String, Failure> {
    let explanation = &answer.explanation;
    if let Some(simulated) = &explanation.simulation {
        return beside::toml(from, to, explanation, simulated);
    }
    if explanation.verdict == Verdict::InsufficientExcitation && is_without_numbers(explanation) {
        return Err(nothing(
            from,
            to,
            "the recordings say too little to fit anything (insufficient_excitation)",
        ));
    }
    let mut applied = Applied::read(from, to)?;
    applied.say(&format!(
        "Written by gripd explain: {} with the numbers fitted to {:.0} s of recordings.",
        applied.name(),
        explanation.seconds
    ));
    answer_lines(explanation).iter().chain(&explanation.certain).for_each(|line| applied.say(line));
    let ordinary = explanation.parameters.ordinary.as_ref().filter(|_| explanation.is_by_ordinary);
    let of_ordinary = explanation.ordinary.as_ref().filter(|_| explanation.is_by_ordinary);
    if let Some(tire) = of_ordinary.map(|ordinary| ordinary.tire).or(explanation.tires_bend_as) {
        applied.bend_tires(tire);
    }
    for (name, estimate) in ordinary.unwrap_or(&explanation.parameters.extended) {
        if applied.has(name) && !explanation.in_doubt.contains_key(name) {
            applied.put(name, (estimate.value, estimate.std));
        }
    }
    for (name, doubt) in &explanation.in_doubt {
        if applied.has(name) {
            applied.put_doubtful(name, doubt, force);
        }
    }
    let effects = match explanation.verdict {
        _ if explanation.is_by_ordinary => found::effects(&explanation.findings).map_err(Failure::work)?,
        Verdict::MissingPhysics => effects(answer)?,
        _ => Vec::new(),
    };
    applied.text(&effects)
}

/// Was nothing of the car fitted at all?
fn is_without_numbers(explanation: &Explanation) -> bool {
    let numbers = &explanation.parameters;
    let ordinary = numbers.ordinary.as_ref().is_some_and(|ordinary| !ordinary.is_empty());
    !ordinary && numbers.extended.is_empty() && explanation.in_doubt.is_empty()
}

/// The failure of an `--apply` that would only have copied the configuration.
fn nothing(from: &Path, to: &Path, why: &str) -> Failure {
    Failure::work(format_args!(
        "--apply has nothing to write to {}: {why}; {} stays what it is",
        to.display(),
        from.display()
    ))
}

/// What was found, as the configuration's tables.
fn effects(answer: &Answer<'_>) -> Result<Vec<EffectConfig>, Failure> {
    let mut all = Vec::new();
    let own = answer.model.effects.len() - answer.explanation.findings.len();
    for (number, chosen) in answer.model.effects.iter().enumerate() {
        // The configuration's own effects come first.
        let finding = number.checked_sub(own).and_then(|number| answer.explanation.findings.get(number));
        let numbers = chosen.specs().zip(&chosen.numbers).map(|(spec, coordinate)| {
            let estimate = finding.and_then(|finding| finding.parameters.get(spec.name));
            let std = estimate.map_or(0.0, |estimate| estimate.std);
            let (low, high) = spec.range();
            Uncertain { value: rounded(spec.value(*coordinate).clamp(low, high)), std: rounded(std) }
        });
        let course = match &chosen.course {
            Course::Series(series) => {
                Course::Series(found::within_range(chosen.kind, chosen.channel, thinned(series)))
            }
            other => other.clone(),
        };
        let effect = EffectConfig::new(chosen.kind, chosen.channel, numbers.collect(), course);
        all.push(effect.map_err(Failure::work)?);
    }
    Ok(all)
}

/// As many points as a smooth course needs.
fn thinned(series: &Series) -> Series {
    let seconds = series.t.last().zip(series.t.first()).map_or(0.0, |(last, first)| last - first);
    let every = ((series.t.len() as f64 / (seconds * POINTS_PER_S).max(1.0)).round() as usize).max(1);
    let some = |values: &[f64]| values.iter().step_by(every).map(|value| rounded(*value)).collect();
    Series { t: some(&series.t), value: some(&series.value) }
}
