//! The first screen: the answer in words, and its numbers.

use super::caveats;
use super::gain;
use super::plots;
use super::tried;
use super::words::{self, number, sentence, signed, stopped};
use crate::explain::{Explanation, Finding, Verdict};
use crate::pages::clocks;
use crate::report::{Fact, Page, escape};

/// Writes it.
pub fn write(page: &mut Page, explanation: &Explanation) {
    let class = match explanation.verdict {
        Verdict::MissingPhysics => "missing",
        Verdict::UnknownPhysics => "unknown",
        Verdict::Adequate | Verdict::Unchanged => "adequate",
        Verdict::InsufficientExcitation => "little",
    };
    page.raw(&format!(
        "<header class=\"answer\"><p class=\"eyebrow\">gripd explain · {}</p>\n\
         <p class=\"verdict {class}\">{}</p>\n<h1>{}</h1>",
        escape(&words::subject(explanation)),
        escape(words::verdict(explanation.verdict)),
        escape(&words::headline(explanation))
    ));
    for line in &explanation.certain {
        page.raw(&format!(
            "<p class=\"lead\">First of all, of the measurement: {}</p>",
            escape(&stopped(line))
        ));
    }
    for paragraph in lead(explanation).into_iter().chain(explanation.simulation.as_ref().map(words::beside)) {
        page.raw(&format!("<p class=\"lead\">{}</p>", escape(&paragraph)));
    }
    for line in clocks::lines(&explanation.begins_utc) {
        page.paragraph(&stopped(&line));
    }
    for line in caveats::used(explanation) {
        page.raw(&format!("<p class=\"aside\">Used: {}</p>", escape(&stopped(&line))));
    }
    if let Some(line) = caveats::tires(explanation) {
        page.raw(&format!("<p class=\"aside\">Tires: {}</p>", escape(&stopped(&line))));
    }
    if explanation.verdict == Verdict::InsufficientExcitation {
        to_drive(page, explanation);
    }
    page.facts(&facts_of(explanation));
    // The first one stands above, where it decides.
    let above = usize::from(explanation.verdict != Verdict::Adequate);
    let others = explanation.findings.get(above..).unwrap_or_default();
    if !others.is_empty() {
        page.raw("<ul class=\"also\">");
        for finding in others {
            page.raw(&format!("<li>{}</li>", escape(&also(finding))));
        }
        page.raw("</ul>");
    }
    let notes = explanation.measurement_chain.len();
    if notes > 0 {
        let what = if notes == 1 { "one remark".into() } else { format!("{notes} remarks") };
        page.raw(&format!(
            "<p class=\"aside\">The audit of the measurement chain has <a href=\"#chain\">{what}</a>.</p>"
        ));
    }
    page.raw("</header>");
}

/// What to drive, as a list.
pub fn to_drive(page: &mut Page, explanation: &Explanation) {
    if explanation.to_drive.is_empty() {
        return;
    }
    page.raw("<ul class=\"drive\">");
    for line in &explanation.to_drive {
        page.raw(&format!("<li>{}</li>", escape(&words::to_drive(line))));
    }
    page.raw("</ul>");
}

fn lead(explanation: &Explanation) -> Vec<String> {
    let tried = tried::count(explanation) + &tried::kinds(explanation);
    match explanation.verdict {
        Verdict::MissingPhysics => explanation
            .findings
            .first()
            .map(|finding| format!("{}{}", about(finding), class(finding)))
            .into_iter()
            .collect(),
        Verdict::Adequate if explanation.simulation.is_some() => vec![format!(
            "The recording minus the simulation is what sensors, road and noise leave: none of {tried}, and no other number \
             of the car, adds anything that data held out of the fit confirm."
        )],
        Verdict::Adequate if explanation.is_by_ordinary => vec![format!(
            "Driven by steering and measured speed alone, a car with what every car has predicts driving it was not \
             fitted to; none of {tried} adds anything that data held out of the fit confirm, and what is left does not \
             repeat: the road, and noise."
        )],
        Verdict::Adequate => vec![format!(
            "With its ordinary parameters refitted, it says what there is to say: none of {tried} adds anything \
             that data held out of the fit confirm. {}",
            follows(explanation)
        )],
        Verdict::Unchanged if explanation.history.is_some() => vec![format!(
            "One car with its own sensors for each drive predicts them all; none of {tried} is another one since any of the \
             drives, beyond what drives of one car differ by."
        )],
        Verdict::Unchanged => vec![format!(
            "One car with its own sensors for each drive predicts them all; none of {tried} is there now beyond what the \
             references have and differ by."
        )],
        Verdict::UnknownPhysics => {
            let gains = gain::gains(explanation);
            let better = gains.iter().filter(|gain| gain.points() > 0.0).count();
            vec![
                format!(
                    "The plain model misses something structured{}, but none of {tried} clears the bar.",
                    place(explanation)
                ),
                match better {
                    0 => "A correction without a name does not help on held-out data, either.".into(),
                    all if all == gains.len() => {
                        "A correction without a name, fitted there, makes the simulation better on data it was \
                         not fitted to: something real is missing."
                            .into()
                    }
                    some => format!(
                        "A correction without a name, fitted there, makes {some} of {} channels better on data it \
                         was not fitted to, and the others worse: a hint, and no more.",
                        gains.len()
                    ),
                },
            ]
        }
        Verdict::InsufficientExcitation => vec![format!(
            "{} excite too little of what a missing effect would show in. That nothing was found does not mean \
             that nothing is missing.{}",
            sentence(&words::subject(explanation)),
            if explanation.to_drive.is_empty() { "" } else { " To drive:" }
        )],
    }
}

/// The finding's sentence.
pub fn about(finding: &Finding) -> String {
    let name = sentence(&words::effect(&finding.effect, finding.channel.as_deref()));
    match finding.about.trim() {
        "" => name + ".",
        about if about.ends_with('.') => format!("{name}: {about}"),
        about => format!("{name}: {about}."),
    }
}

/// What else it could be, in a sentence after others.
fn class(finding: &Finding) -> String {
    let names: Vec<String> =
        finding.indistinguishable_from.iter().map(|name| words::effect_named(name)).collect();
    if names.is_empty() {
        return String::new();
    }
    format!(" This recording cannot tell it from {}.", words::list(&names))
}

/// The main number of a finding: what it is, and its value.
pub fn main_number(finding: &Finding) -> Option<(String, String)> {
    let rows = words::parameters(finding);
    let main = rows.iter().find(|row| row.is_main).or(rows.first())?;
    Some((main.name.clone(), main.value()))
}

/// One of the further findings, in a line.
fn also(finding: &Finding) -> String {
    let main = main_number(finding).map_or(String::new(), |(name, value)| format!("{name} {value}, "));
    format!(
        "{}: {main}probability {}",
        sentence(&words::effect(&finding.effect, finding.channel.as_deref())),
        words::probability(finding.probability)
    )
}

/// Where it shows, to go on with a sentence.
fn place(explanation: &Explanation) -> String {
    let place = &explanation.place;
    let channels: Vec<String> = place.channels.iter().map(|name| words::channel(name)).collect();
    let mut text = String::new();
    if !place.equation.is_empty() {
        text += &format!(" in the {}", place.equation.trim_start_matches("the "));
    }
    if !channels.is_empty() {
        text += &format!(", seen in {}", words::list(&channels));
    }
    if !place.regimes.is_empty() {
        text += &format!(" ({})", place.regimes.join("; "));
    }
    text
}

/// How well it follows what was held out, by the channel that it follows least.
fn follows(explanation: &Explanation) -> String {
    let fits = explanation.fit.baseline.holdout.iter().filter(|(_, fit)| fit.is_finite());
    match fits.min_by(|a, b| a.1.total_cmp(b.1)) {
        Some((channel, fit)) => format!(
            "Simulated without feedback, its error there has at most {} % of the variance that was recorded \
             ({}), noise included.",
            number(100.0 * words::left_of_variance(*fit), 1),
            words::channel(channel)
        ),
        None => String::new(),
    }
}

fn facts_of(explanation: &Explanation) -> Vec<Fact> {
    let mut facts = Vec::new();
    let first = explanation.findings.first().filter(|_| explanation.verdict != Verdict::Adequate);
    if let Some(finding) = first {
        if let Some((name, value)) = main_number(finding) {
            facts.push(Fact { name: sentence(&name), value, note: "± one standard deviation".into() });
        }
        facts.push(Fact {
            name: "Probability".into(),
            value: words::probability(finding.probability),
            note: format!("among {}", tried::count(explanation)),
        });
    }
    let gains = gain::gains(explanation);
    let gain = gains.first().filter(|gain| gain.points() > 0.0);
    if let Some(gain) = gain.filter(|_| explanation.verdict != Verdict::Adequate) {
        let error = gain::error(explanation, gain.channel);
        facts.extend(error.map(|value| Fact {
            name: format!("Held-out error, {}", words::channel(gain.channel)),
            value,
            note: format!("root mean square; {}", plots::names(explanation).join(" → ")),
        }));
        let note = match gain.interval {
            Some([low, high]) => format!(
                "{} points; 95 %: {} to {}",
                signed(gain.points(), 1),
                signed(low, 1),
                signed(high, 1)
            ),
            None => format!("{} points", signed(gain.points(), 1)),
        };
        facts.push(Fact {
            name: format!("Held-out fit, {}", words::channel(gain.channel)),
            value: format!("{} → {} %", number(gain.from, 1), number(gain.to, 1)),
            note,
        });
    } else {
        let fits = explanation.fit.baseline.holdout.iter().filter(|(_, fit)| fit.is_finite());
        let fits =
            fits.filter(|(name, _)| matches!(name.as_str(), "yaw_rate" | "lateral_acceleration" | "speed"));
        facts.extend(fits.map(|(name, fit)| {
            let both = explanation.fit.extended.holdout.get(name).filter(|extended| *extended != fit);
            let error =
                gain::error(explanation, name).map_or(String::new(), |error| format!("error {error}; "));
            let (value, of) = match both {
                Some(extended) => (
                    format!("{} → {} %", number(*fit, 1), number(*extended, 1)),
                    plots::names(explanation).join(" → "),
                ),
                None => (format!("{} %", number(*fit, 1)), "plain model, parameters refitted".into()),
            };
            Fact {
                name: format!("Held-out fit, {}", words::channel(name)),
                value,
                note: format!("{error}{of}"),
            }
        }));
    }
    facts
}
