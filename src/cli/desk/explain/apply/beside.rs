//! What somebody's simulation leaves out, put into the configuration: effects as `[[effect]]` tables, numbers of the car as
//! those of `[vehicle]`. Everything else stays: the numbers of the car that drives like the simulation are not the car's.

use std::path::Path;

use crate::cli::Failure;
use crate::cli::desk::applied::Applied;
use lab::explain::found;
use lab::explain::{Estimate, Explanation, Finding, Simulated};
use lab::pages::explain::{answer_lines, name_of};
use physics::model::TireKind;
use physics::model::effect::named;

/// Numbers of a tire with a bend of its own.
const OF_TIRES: [&str; 4] =
    ["lateral_stiffness_front", "lateral_stiffness_rear", "friction", "magic_formula_shape"];

/// The whole configuration.
///
/// # Errors
/// If nothing was found, or nothing of what was found can stand in a configuration.
pub fn toml(
    from: &Path,
    to: &Path,
    explanation: &Explanation,
    simulated: &Simulated,
) -> Result<String, Failure> {
    let nothing = |why: &str| super::nothing(from, to, why);
    if explanation.findings.is_empty() {
        return Err(nothing("nothing was found that the simulation leaves out"));
    }
    let mut applied = Applied::read(from, to)?;
    applied.say(&format!(
        "Written by gripd explain: {} with what the simulation {} leaves out of {:.0} s of a recording.",
        applied.name(),
        simulated.name,
        explanation.seconds
    ));
    answer_lines(explanation).iter().chain(&explanation.certain).for_each(|line| applied.say(line));
    let mut written = 0;
    let mut effects = Vec::new();
    for finding in &explanation.findings {
        let table =
            if is_whole(finding) { found::effects([finding]).map_err(Failure::work)? } else { Vec::new() };
        let put = match number_of_the_car(finding).filter(|(key, _)| applied.has(key)) {
            Some((key, number)) => {
                // Stiffness and friction are of the tire that was fitted.
                if simulated.is_bent && OF_TIRES.contains(&key) {
                    applied.bend_tires(TireKind::MagicFormula);
                }
                applied.put(key, (number.value, number.std));
                true
            }
            None => !table.is_empty(),
        };
        if put {
            written += 1;
            effects.extend(table);
        } else {
            let name = name_of(finding);
            tracing::warn!("{name}: a configuration has no place for it, so it is not written");
            applied.say(&format!("Not in this file, for a configuration has no place for it: {name}."));
        }
    }
    if written == 0 {
        let all: Vec<String> = explanation.findings.iter().map(name_of).collect();
        return Err(nothing(&format!(
            "a configuration has no place for what was found ({})",
            all.join(", ")
        )));
    }
    applied.text(&effects)
}

/// Of a finding that is another number of the car: its key in `[vehicle]`, and what it is in the recording.
fn number_of_the_car(finding: &Finding) -> Option<(&str, Estimate)> {
    finding.reference_value?;
    let (name, number) = finding.parameters.first_key_value()?;
    (finding.effect == *name).then_some((name.as_str(), *number))
}

/// Does it say all that its effect needs to act? One of its further numbers alone, a load sensitivity without a height, does not.
fn is_whole(finding: &Finding) -> bool {
    let Some(kind) = named(&finding.effect) else { return true };
    let main: Vec<&str> = kind.parameters.iter().filter(|spec| spec.is_main).map(|spec| spec.name).collect();
    main.is_empty() || main.iter().any(|name| finding.parameters.contains_key(*name))
}
