//! What was found, on the terminal.

use super::super::clocks;
use super::{Story, digits, number};
use crate::report::wrapped;
use identify::{Fits, Identified, LongitudinalInput};

/// The whole text.
pub fn text(story: &Story<'_>) -> String {
    let found = story.found;
    let mut text = wrapped("", 0, &summary(story));
    for line in clocks::lines(&story.begins_utc()) {
        text += &wrapped("", 0, &line);
    }
    let rows: Vec<[String; 6]> = found.parameters.iter().map(row).collect();
    text.push('\n');
    let head = ["parameter", "unit", "the table's", "identified", "95 % interval", "told"].map(str::to_owned);
    table(&mut text, &head, &rows);
    for parameter in found.parameters.iter().filter(|parameter| parameter.is_in_doubt()) {
        text += &wrapped("in doubt: ", 4, &in_doubt(parameter));
    }
    let axles = super::super::axles::lines(&found.cornering_stiffness());
    if !axles.is_empty() {
        text += &format!("\n{}", wrapped("", 0, super::super::axles::WHAT));
        axles.iter().for_each(|line| text += &wrapped("  - ", 4, line));
    }
    for untold in story.untold() {
        text += &wrapped("not told: ", 4, untold);
    }
    text += "\nfree run restarted each 20 s: fit in per cent; noise that is left\n";
    let head = ["channel", "table's", "identified", "noise", "unit", ""].map(str::to_owned);
    table(&mut text, &head, &fit_rows(story, [&found.before, &found.after]));
    if !story.held_out.is_empty() {
        text += &wrapped("\n", 0, &held_out(story));
        let head = ["channel", "table's", "identified", "", "", ""].map(str::to_owned);
        let without_noise = |[name, before, after, ..]: [String; 6]| {
            [name, before, after, String::new(), String::new(), String::new()]
        };
        let [before, after] = &story.predicted;
        let rows: Vec<_> = fit_rows(story, [before, after]).into_iter().map(without_noise).collect();
        table(&mut text, &head, &rows);
    }
    text += &format!("\n{}", super::snippet::toml(story));
    text
}

/// A parameter of which recordings and table say different things, and what may be behind that.
pub fn in_doubt(parameter: &Identified) -> String {
    let doubt = parameter.doubt.as_ref();
    let (why, behind) = doubt.map_or(("", ""), |doubt| (doubt.why.as_str(), doubt.behind));
    format!("{} is {why}. What may be behind it: {behind}", parameter.name)
}

/// What was done, in a line or two.
pub fn summary(story: &Story<'_>) -> String {
    let found = story.found;
    let recordings = match story.records {
        [one] => one.name.clone(),
        several => format!("{} recordings", several.len()),
    };
    let forces = match found.drive {
        LongitudinalInput::Torque => "drive torque",
        LongitudinalInput::WheelSpeeds => "the driven wheels' speeds",
        LongitudinalInput::Slips => "slips",
        LongitudinalInput::Speed => "the measured speed",
    };
    let total: f64 = story.records.iter().map(|record| record.rows.len() as f64 * record.period_s).sum();
    format!(
        "{:.0} of {total:.0} s of {recordings} in {} segments; forces from {forces}; {}{}",
        found.seconds,
        found.segments,
        ends(story),
        match found.weight {
            1.0 => String::new(),
            weight => format!(
                "; segments differ more than noise explains, so that the recordings count 1/{:.0} beside the table",
                1.0 / weight
            ),
        }
    )
}

/// Ends this near, in standard deviations of each parameter, are the same.
const SAME_END: f64 = 0.5;

/// How the searches ended.
pub fn ends(story: &Story<'_>) -> String {
    let paths = &story.found.paths;
    let best = paths.iter().min_by(|a, b| a.cost.total_cmp(&b.cost));
    let is_best = |to: &[f64]| {
        let ends = to.iter().zip(best.map_or(&[][..], |path| &path.to)).zip(&story.found.parameters);
        ends.into_iter().all(|((to, best), parameter)| (to - best).abs() <= SAME_END * parameter.std)
    };
    let same = paths.iter().filter(|path| is_best(&path.to)).count();
    let lost = paths.iter().filter(|path| !path.cost.is_finite()).count();
    let mut text = match paths.len() {
        1 => "one search".into(),
        count => format!("{same} of {count} searches end at the best fit"),
    };
    if lost > 0 {
        text += &format!(", {lost} nowhere");
    }
    text
}

/// Cells of one parameter. What the recordings do not tell gets no number.
pub fn row(parameter: &Identified) -> [String; 6] {
    let (prior, prior_std) = parameter.prior;
    let decimals = digits(parameter.value, parameter.std);
    let unit = if parameter.unit == "1" { "" } else { parameter.unit };
    let before = if prior_std > 0.0 {
        let decimals = digits(prior, prior_std);
        format!("{} ± {}", number(prior, decimals), number(prior_std, decimals))
    } else {
        number(prior, digits(prior, 0.0))
    };
    let (value, interval) = if parameter.is_clear {
        let (low, high) = parameter.ci95;
        (
            format!("{} ± {}", number(parameter.value, decimals), number(parameter.std, decimals)),
            format!("{} … {}", number(low, decimals), number(high, decimals)),
        )
    } else {
        ("–".into(), "–".into())
    };
    let verdict = match (parameter.identifiable, parameter.reason.as_str()) {
        (true, "") => "yes".into(),
        (true, reason) => format!("yes; {reason}"),
        (false, reason) => format!("no: {reason}"),
    };
    [parameter.name.into(), unit.into(), before, value, interval, verdict]
}

/// What nothing was fitted to.
pub fn held_out(story: &Story<'_>) -> String {
    let names: Vec<&str> = story.held_out.iter().map(|record| record.name.as_str()).collect();
    format!("the same of {}, which nothing was fitted to, in per cent", names.join(", "))
}

/// Cells of each channel: name, fit before and after, noise, unit.
pub fn fit_rows(story: &Story<'_>, [before, after]: [&Fits; 2]) -> Vec<[String; 6]> {
    let found = story.found;
    let fit = |fits: &[(&'static str, f64)], name: &str| {
        let fit = fits.iter().find(|(channel, _)| *channel == name);
        fit.map_or_else(|| "–".into(), |(_, percent)| number(*percent, 1))
    };
    let row = |(channel, noise): &(identify::Output, f64)| {
        let (name, unit) = (channel.name(), channel.unit());
        let (before, after) = (fit(&before.percent, name), fit(&after.percent, name));
        [name.into(), before, after, number(*noise, digits(*noise, 0.0)), unit.into(), String::new()]
    };
    found.noise.iter().map(row).collect()
}

/// Further lines of a row are so far to the right.
const BELOW: usize = 6;

/// Columns as wide as their widest cell; what the last one says goes on below where there is no room for it.
fn table(text: &mut String, head: &[String; 6], rows: &[[String; 6]]) {
    let all = || std::iter::once(head).chain(rows);
    let widths: Vec<usize> =
        (0..6).map(|column| all().map(|row| row[column].chars().count()).max().unwrap_or(0)).collect();
    for row in all() {
        let begin: String =
            row.iter().zip(&widths).take(5).map(|(cell, &width)| format!("{cell:<width$}  ")).collect();
        let (begin, words) = if row[5].is_empty() { (begin.trim_end(), "") } else { (&*begin, &*row[5]) };
        *text += &wrapped(begin, BELOW, words);
    }
}
