//! What was found, on the terminal: as much as one reads at once.

use std::io::{self, Write};

use super::caveats;
use super::gain;
use super::tried::Tried;
use super::words::{self, number, sentence, signed, stopped};
use crate::explain::{ByChannel, Explanation, Finding, Ranked, ToDrive, Where};
use crate::report;

/// So many candidates of the ranking are named.
const MOST_RANKED: usize = 5;
/// So many stretches of time are named.
const MOST_INTERVALS: usize = 4;
/// Ordinary parameters that moved less, in standard deviations, are not named.
const LEAST_MOVE: f64 = 2.0;

/// Prints it.
///
/// # Errors
/// Those of the output.
pub fn print(explanation: &Explanation, output: &mut impl Write) -> io::Result<()> {
    output.write_all(text(explanation).as_bytes())
}

/// The whole text.
fn text(explanation: &Explanation) -> String {
    let mut text = String::new();
    words::answer(explanation).iter().for_each(|line| wrapped(&mut text, "", line));
    for line in caveats::used(explanation) {
        wrapped(&mut text, "Used: ", &stopped(&line));
    }
    if let Some(line) = caveats::tires(explanation) {
        wrapped(&mut text, "Tires: ", &stopped(&line));
    }
    for line in crate::pages::clocks::lines(&explanation.begins_utc) {
        wrapped(&mut text, "Clock: ", &line);
    }
    if !explanation.certain.is_empty() {
        text += "\nFirst of all, of the measurement (as `gripd check` says it)\n";
        for line in &explanation.certain {
            wrapped(&mut text, "  - ", &stopped(line));
        }
    }
    if let Some(simulated) = &explanation.simulation {
        wrapped(&mut text, "", &words::beside(simulated));
    }
    super::to_change::text(&mut text, explanation);
    for finding in &explanation.findings {
        text.push('\n');
        one(&mut text, explanation, finding);
    }
    if let Some(history) = &explanation.history {
        super::history::text(&mut text, history);
    }
    if explanation.findings.iter().all(|it| it.place == Where::default()) {
        place(&mut text, &explanation.place, "");
    }
    fit(&mut text, explanation);
    axles(&mut text, explanation);
    confirm(&mut text, explanation);
    if let Some(ordinary) = &explanation.ordinary {
        text += "\nThe ordinary car\n";
        for line in crate::pages::ordinary::lines(ordinary) {
            wrapped(&mut text, "  - ", &line);
        }
    }
    moved(&mut text, explanation);
    in_doubt(&mut text, explanation);
    to_drive(&mut text, &explanation.to_drive);
    if !explanation.measurement_chain.is_empty() {
        text += "\nMeasurement chain\n";
        for line in &explanation.measurement_chain {
            wrapped(&mut text, "  - ", &stopped(line));
        }
    }
    ranking(&mut text, explanation);
    text
}

/// What to drive, if there is anything.
pub fn to_drive(text: &mut String, all: &[ToDrive]) {
    if !all.is_empty() {
        *text += "\nTo drive next\n";
    }
    for it in all {
        wrapped(text, "  - ", &words::to_drive(it));
    }
}

fn one(text: &mut String, explanation: &Explanation, finding: &Finding) {
    let has_others = explanation.findings.len() > 1;
    let name = words::effect(&finding.effect, finding.channel.as_deref());
    *text += &format!("{} (probability {})\n", sentence(&name), words::probability(finding.probability));
    if !finding.about.is_empty() {
        wrapped(text, "  ", &stopped(&finding.about));
    }
    for row in words::parameters(finding) {
        wrapped(text, "  ", &format!("{} {}", row.name, row.value()));
    }
    if let Some(was) = words::reference(finding) {
        wrapped(text, &format!("  in {}: ", words::compared_with(explanation)), &was);
    }
    let explained = words::explained(finding);
    if !explained.is_empty() {
        wrapped(text, "  explains, held out: ", &explained);
    }
    let alike: Vec<String> =
        finding.indistinguishable_from.iter().map(|name| words::effect_named(name)).collect();
    if !alike.is_empty() {
        wrapped(text, "  could as well be: ", &words::list(&alike));
    }
    if !finding.to_tell_apart.is_empty() && (!alike.is_empty() || has_others) {
        wrapped(text, "  to tell: ", &finding.to_tell_apart);
    }
    for mechanism in finding.law.iter().flat_map(|law| &law.mechanisms) {
        wrapped(text, "  may come of: ", mechanism);
    }
    place(text, &finding.place, "  ");
    if let Some(at) = &finding.at_utc {
        wrapped(text, "  since: ", at);
    }
    if finding.place.intervals.is_empty() && !finding.place.recording.is_empty() {
        wrapped(text, "  of: ", &finding.place.recording);
    }
}

fn place(text: &mut String, place: &Where, indent: &str) {
    if !place.equation.is_empty() {
        wrapped(text, &format!("{indent}where: "), &place.equation);
    }
    if !place.channels.is_empty() {
        let channels: Vec<String> = place.channels.iter().map(|name| words::channel(name)).collect();
        wrapped(text, &format!("{indent}seen in: "), &channels.join(", "));
    }
    if !place.regimes.is_empty() {
        wrapped(text, &format!("{indent}when driving: "), &place.regimes.join("; "));
    }
    if !place.intervals.is_empty() {
        let when = words::intervals(place, MOST_INTERVALS);
        let of = if place.recording.is_empty() { String::new() } else { format!(" of {}", place.recording) };
        wrapped(text, &format!("{indent}at: "), &(when + &of));
    }
}

fn fit(text: &mut String, explanation: &Explanation) {
    let (before, after) = (&explanation.fit.baseline.holdout, &explanation.fit.extended.holdout);
    if !before.values().any(|fit| fit.is_finite()) {
        return;
    }
    *text += "\nFit on held-out data, %\n";
    let is_extended = before != after && !after.is_empty();
    let row = |name: &str| {
        let of = |fits: &ByChannel| fits.get(name).copied().unwrap_or(f64::NAN);
        let (before, after) = (of(before), of(after));
        let mut row = [words::channel(name), number(before, 1), String::new(), String::new(), String::new()];
        if is_extended {
            let interval = explanation.improvement_ci95.get(name);
            row[2] = number(after, 1);
            row[3] = signed(after - before, 1);
            row[4] = interval
                .map_or(String::new(), |[low, high]| format!("{} to {}", signed(*low, 1), signed(*high, 1)));
        }
        row
    };
    let rows: Vec<[String; 5]> = words::in_order(before.keys()).into_iter().map(row).collect();
    if is_extended {
        let names = match explanation.simulation {
            Some(_) => ["", "simulation", "with that", "gain", "95 % interval"],
            None => ["", "plain", "extended", "gain", "95 % interval"],
        };
        table(text, &names.map(str::to_owned), &rows);
    } else {
        table(text, &[const { String::new() }; 5], &rows);
    }
    let error = |name| Some(format!("{} {}", words::channel(name), gain::error(explanation, name)?));
    let errors: Vec<String> = words::in_order(before.keys()).into_iter().filter_map(error).collect();
    if !errors.is_empty() {
        wrapped(text, "  error there: ", &errors.join(", "));
    }
}

fn axles(text: &mut String, explanation: &Explanation) {
    let lines = crate::pages::axles::lines(&explanation.cornering_stiffness);
    if !lines.is_empty() {
        text.push('\n');
        wrapped(text, "", crate::pages::axles::WHAT);
        lines.iter().for_each(|line| wrapped(text, "  - ", line));
    }
}

/// What was found, on other drives.
fn confirm(text: &mut String, explanation: &Explanation) {
    if explanation.confirm.is_empty() {
        return;
    }
    *text += "\nOn other drives of the same car, what was found taken over as it is\n";
    for line in words::confirmed(explanation) {
        wrapped(text, "  - ", &stopped(&line));
    }
}

fn moved(text: &mut String, explanation: &Explanation) {
    if explanation.findings.is_empty() {
        return;
    }
    let parameters = &explanation.parameters;
    let rows: Vec<[String; 5]> = parameters
        .extended
        .iter()
        .filter_map(|(name, after)| {
            let before = parameters.baseline.get(name)?;
            let by = (after.value - before.value).abs() / after.std.min(before.std).max(f64::MIN_POSITIVE);
            let (before, after) = (words::ordinary(name, *before), words::ordinary(name, *after));
            let said = |shown: &words::Shown| words::plus_minus(shown.estimate);
            (by.is_finite() && by >= LEAST_MOVE)
                .then(|| [after.name.clone(), said(&before), "→".into(), said(&after), after.unit])
        })
        .collect();
    if !rows.is_empty() {
        *text += "\nOrdinary parameters, plain → extended\n";
        table(text, &[const { String::new() }; 5], &rows);
    }
}

/// Numbers that are not taken over.
fn in_doubt(text: &mut String, explanation: &Explanation) {
    if explanation.in_doubt.is_empty() {
        return;
    }
    *text += "\nIn doubt (--apply leaves them as they were, unless --force)\n";
    for doubted in caveats::in_doubt(explanation) {
        wrapped(text, "  - ", &stopped(&doubted.line()));
    }
}

fn ranking(text: &mut String, explanation: &Explanation) {
    let tried = Tried::of(explanation);
    let one = |it: &&Ranked| {
        format!("{} {}", words::effect(&it.effect, it.channel.as_deref()), signed(it.score, 0))
    };
    let mut best: Vec<String> = tried.own.iter().take(MOST_RANKED).map(one).collect();
    best.extend(tried.nothing());
    if !best.is_empty() {
        text.push('\n');
        let count = explanation.ranking.len();
        wrapped(text, &format!("Best of {count} tried (2 ln odds): "), &best.join(", "));
    }
}

/// Words in lines, the first one after `head`, the others as far to the right as its text begins (but
/// not further than a little).
pub(super) fn wrapped(text: &mut String, head: &str, words: &str) {
    let blank = head.chars().take_while(|letter| matches!(letter, ' ' | '-')).count();
    let indent = if blank == head.chars().count() { blank } else { blank + 2 };
    *text += &report::wrapped(head, indent, words);
}

/// Columns as wide as their widest cell; the first to the left, numbers to the right.
pub(super) fn table(text: &mut String, head: &[String; 5], rows: &[[String; 5]]) {
    let has_head = head.iter().any(|cell| !cell.is_empty());
    let all = || has_head.then_some(head).into_iter().chain(rows);
    let width = |column: usize| all().map(|row| row[column].chars().count()).max().unwrap_or(0);
    let widths = [0, 1, 2, 3, 4].map(width);
    for row in all() {
        let mut line = format!("  {:<1$}", row[0], widths[0]);
        for (column, cell) in row.iter().enumerate().skip(1) {
            let width = widths[column];
            line += &if column == 4 { format!("  {cell}") } else { format!("  {cell:>width$}") };
        }
        *text += line.trim_end();
        text.push('\n');
    }
}

#[cfg(test)]
mod tests {
    use super::super::sample;
    use super::*;

    #[test]
    fn a_finding_is_told_in_a_screen() {
        let text = text(&sample::missing());
        for part in [
            "Missing physics",
            "Missing in the model: load transfer",
            "probability 97 %",
            "height of the centre of gravity 0.553 ± 0.021 m",
            "could as well be: body roll at the accelerometer",
            "where: lateral force balance",
            "Fit on held-out data, %",
            "front cornering stiffness",
            "→",
            "Best of",
        ] {
            assert!(text.contains(part), "{part} is missing in\n{text}");
        }
        assert!(!text.contains("NaN") && !text.contains("inf"), "{text}");
        assert!(text.lines().all(|line| line.chars().count() <= report::WIDTH), "{text}");
        assert!(text.lines().count() < 50, "{text}");
    }

    #[test]
    fn what_to_change_in_somebody_s_model_is_told() {
        let text = text(&sample::beside_a_simulation());
        let words = text.split_whitespace().collect::<Vec<_>>().join(" ");
        for part in [
            "What to change in your model - Your model has no load transfer",
            "Takes away 40 % in yaw rate",
            "second pass: Moved by more than its uncertainty",
            "In a second pass, with all of it in both runs, the numbers of one finding moved",
        ] {
            assert!(words.contains(part), "{part} is missing in\n{text}");
        }
        assert!(text.lines().all(|line| line.chars().count() <= report::WIDTH), "{text}");
    }

    #[test]
    fn every_verdict_is_told() {
        for (explanation, sentence) in sample::all() {
            let text = text(&explanation);
            assert!(text.contains(sentence), "{sentence} is missing in\n{text}");
        }
        let text = text(&sample::insufficient());
        assert!(text.contains("To drive next\n  - Steady turns"), "{text}");
    }

    #[test]
    fn long_lines_are_broken_and_go_on_below_their_beginning() {
        let mut text = String::new();
        wrapped(&mut text, "  - ", &"word ".repeat(40));
        let lines: Vec<&str> = text.lines().collect();
        assert!(lines.len() > 1 && lines[0].starts_with("  - word") && lines[1].starts_with("    word"));
        assert!(lines.iter().all(|line| line.len() <= report::WIDTH));
    }
}
