//! What an explanation came to, of what, and beside what, in a sentence or two each.

use super::words::{channel, effect, in_order, is_of_sensors, list, number, parameters, three};
use crate::explain::{Confirmed, Explanation, Finding, Nature, Simulated, Verdict};

/// What it came to, in two or three words.
pub fn verdict(verdict: Verdict) -> &'static str {
    match verdict {
        Verdict::MissingPhysics => "Missing physics",
        Verdict::Adequate => "Adequate",
        Verdict::Unchanged => "Unchanged",
        Verdict::UnknownPhysics => "Unknown physics",
        Verdict::InsufficientExcitation => "Too little excitation",
    }
}

/// The answer's first two lines, the same wherever it stands: verdict and subject; what it came to.
pub fn answer(explanation: &Explanation) -> [String; 2] {
    [format!("{} ({})", verdict(explanation.verdict), subject(explanation)), headline(explanation)]
}

/// What it came to, in a sentence without full stop.
pub fn headline(explanation: &Explanation) -> String {
    if let Some(history) = &explanation.history
        && explanation.verdict != Verdict::UnknownPhysics
    {
        return super::history::headline(explanation, history);
    }
    match explanation.verdict {
        Verdict::MissingPhysics if !explanation.references.is_empty() => {
            format!("Changed since the references: {}", names(explanation.findings.iter()))
        }
        Verdict::MissingPhysics if explanation.simulation.is_some() => {
            format!("Your simulation leaves out: {}", names(explanation.findings.iter()))
        }
        Verdict::MissingPhysics => found(&explanation.findings),
        Verdict::Adequate if explanation.simulation.is_some() => {
            "Your simulation leaves out nothing that this drive shows".into()
        }
        Verdict::Adequate if explanation.needs_ordinary => {
            "What every car has explains it; what is left does not repeat".into()
        }
        Verdict::Adequate => "The plain model is adequate".into(),
        Verdict::Unchanged => "Nothing has changed since the references".into(),
        Verdict::UnknownPhysics if explanation.findings.is_empty() => UNKNOWN.into(),
        // Else it would be looked for in the car first.
        Verdict::UnknownPhysics => {
            format!("{}; beside it something that no known effect explains", found(&explanation.findings))
        }
        Verdict::InsufficientExcitation => "This drive says too little to judge the model".into(),
    }
}

/// That there is something, and nothing else.
const UNKNOWN: &str = "Something is missing that no known effect explains";

/// More names than that are counted.
const MOST_NAMES: usize = 3;

fn found(findings: &[Finding]) -> String {
    // Beside what is unusual, what every car has is no news.
    let has_news = findings.iter().any(|finding| finding.kind != Nature::Ordinary);
    let told = || findings.iter().filter(move |finding| !has_news || finding.kind != Nature::Ordinary);
    let of = |of_sensors: bool| names(told().filter(|it| is_of_sensors(&it.effect) == of_sensors));
    let (physics, sensors) = (of(false), of(true));
    match (physics.as_str(), sensors.as_str()) {
        ("", "") => "Something is missing in the model".into(),
        (physics, "") => format!("Missing in the model: {physics}"),
        ("", sensors) => format!("Wrong in the measurement: {sensors}"),
        (physics, sensors) => format!("Missing in the model: {physics}; wrong in the measurement: {sensors}"),
    }
}

/// The first names, and how many more there are. Two wheels of another radius are one name.
fn names<'f>(findings: impl Iterator<Item = &'f Finding>) -> String {
    let mut all: Vec<String> = Vec::new();
    for name in findings.map(|finding| effect(&finding.effect, finding.channel.as_deref())) {
        if !all.contains(&name) {
            all.push(name);
        }
    }
    let mut names = all.clone();
    if all.len() > MOST_NAMES {
        names.truncate(MOST_NAMES - 1);
        names.push(format!("{} more", all.len() + 1 - MOST_NAMES));
    }
    list(&names)
}

/// How somebody's simulation lies beside the recording.
pub fn beside(simulated: &Simulated) -> String {
    let clock = match simulated.time_offset_s {
        0.0 => "begins with the recording".to_owned(),
        offset => format!(
            "begins {} s {} the recording",
            three(offset.abs()),
            if offset > 0.0 { "after" } else { "before" }
        ),
    };
    let steered = match simulated.steered_alike {
        Some(true) => {
            "It was steered as the recorded car was, so its difference from the recording is looked at."
        }
        Some(false) => {
            "It was steered otherwise than the recorded car, so the car that drives like it is compared, steered as recorded."
        }
        None => "It does not tell how it was steered: as recorded, it is supposed.",
    };
    let fits = in_order(simulated.emulated_fit.keys())
        .into_iter()
        .map(|name| format!("{} % of its {}", number(simulated.emulated_fit[name], 1), channel(name)));
    let fits: Vec<String> = fits.collect();
    format!("The simulation {clock}. {steered} The ordinary car that drives like it gives {}.", list(&fits))
}

/// What a recording is compared with.
pub fn compared_with(explanation: &Explanation) -> &'static str {
    match () {
        () if explanation.simulation.is_some() => "the simulation",
        () if explanation.history.is_some() => "the drives before",
        () => "the references",
    }
}

/// What the references or the simulation have of a number that is another one now; nothing of other findings.
pub fn reference(finding: &Finding) -> Option<String> {
    let was = finding.reference_value?;
    let name = finding.parameters.keys().next()?;
    let before = Finding { parameters: [(name.clone(), was)].into(), ..finding.clone() };
    Some(parameters(&before).first()?.value())
}

/// How much of the plain model's error on held-out driving a finding explains, by channel; nothing where it was not
/// measured, or less than a per cent.
pub fn explained(finding: &Finding) -> String {
    let all = in_order(finding.explained_share.keys()).into_iter().filter_map(|name| {
        let share = 100.0 * finding.explained_share.get(name)?;
        (share >= 1.0).then(|| format!("{} % of the error in {}", number(share, 0), channel(name)))
    });
    list(&all.collect::<Vec<_>>())
}

/// A drive whose squared error falls by a smaller share, the numbers refitted, says nothing of what was found.
const LEAST_SHOWN: f64 = 0.02;

/// How what was found does on other drives, a line each.
pub fn confirmed(explanation: &Explanation) -> Vec<String> {
    let of = |confirmed: &Confirmed| {
        let [unchanged, refitted] =
            [confirmed.gain_unchanged, confirmed.gain_refitted].map(|gain| number(100.0 * gain, 0));
        let fits = in_order(confirmed.fit.without.keys()).into_iter().filter_map(|name| {
            let (without, with) = (confirmed.fit.without.get(name)?, confirmed.fit.unchanged.get(name)?);
            Some(format!("{} {} to {} %", channel(name), number(*without, 1), number(*with, 1)))
        });
        let fits = list(&fits.collect::<Vec<_>>());
        if confirmed.gain_refitted < LEAST_SHOWN {
            return format!("{}: hardly shows it, whatever its numbers; fit of {fits}", confirmed.log);
        }
        format!(
            "{}: squared error falls by {unchanged} %, with refitted numbers by {refitted} %; fit of {fits}",
            confirmed.log
        )
    };
    explanation.confirm.iter().map(of).collect()
}

/// The recordings it is about.
pub fn recordings(explanation: &Explanation) -> Vec<&str> {
    let mut names: Vec<&str> = Vec::new();
    let blocks = explanation.split.iter().map(|block| block.recording.as_str());
    for name in explanation.traces.iter().map(|trace| trace.recording.as_str()).chain(blocks) {
        if !names.contains(&name) {
            names.push(name);
        }
    }
    names
}

/// How long, and what.
pub fn subject(explanation: &Explanation) -> String {
    let seconds = explanation.seconds;
    let long = if seconds < 600.0 {
        format!("{} s", number(seconds, 0))
    } else {
        format!("{} min", number(seconds / 60.0, 0))
    };
    match recordings(explanation).as_slice() {
        [] => format!("{long} of recording"),
        [one] => format!("{long} of {one}"),
        several => format!("{long} of {} recordings", several.len()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn two_wheels_of_another_radius_are_one_name() {
        let of = |effect: &str| Finding { effect: effect.into(), ..Finding::default() };
        let all = [of("tire_radius"), of("payload"), of("tire_radius")];
        assert_eq!(names(all.iter()), "unequal tire radii and payload");
    }
}
