//! An identification as text, as JSON, and as a page: the answer in words, then how sure it is, then what it explains.

mod drive;
mod json;
mod search;
mod snippet;
mod story;
mod text;

use self::story::{digits, number};
use crate::explain::Estimate;
use crate::pages::explain::words::{self, sentence};
use crate::report::{Page, Shift};
use identify::{Fits, Identified};

pub use json::{Report, report};
pub use story::Story;
pub use text::text;

/// The page.
pub fn html(story: &Story<'_>) -> String {
    let found = story.found;
    let stiffness = found.cornering_stiffness();
    let mut page = Page::new("gripd identify: the vehicle's parameters from recordings", &lead(story));
    let beside = drive::beside(story);
    page.facts(&beside.facts());
    let plots = beside.plots(0, |axis, plots| {
        plots.figure(beside.handling(axis, story.vehicle, super::axles::gradient(&stiffness)));
        search::starts(story).into_iter().for_each(|figure| plots.figure(figure));
        search::profiles(story).into_iter().for_each(|figure| plots.figure(figure));
        plots.marks.extend(drive::marks(story, axis));
    });
    page.plots(&plots);
    page.raw(&format!("<p class=\"aside\">{}</p>", plots.reading()));
    shifts(&mut page, story);
    page.heading("What was identified");
    let rows: Vec<Vec<String>> =
        found.parameters.iter().map(|parameter| text::row(parameter).to_vec()).collect();
    page.table_of_words(
        &["parameter", "unit", "the table's", "identified", "95 % interval", "identifiable"],
        &rows,
    );
    super::axles::section(&mut page, &stiffness);
    page.heading("How well a simulation without feedback fits");
    page.paragraph(
        "Driven by the recorded steering wheel and torques or wheel speeds, restarted each 20 s from what was \
         measured; 100 (1 − |y − ŷ| / |y − mean|) per cent, and the noise that is left where segments are tied \
         as the data allow.",
    );
    let columns = ["channel", "table's numbers, %", "identified, %", "noise", "unit"];
    let rows = |both: [&Fits; 2], count: usize| -> Vec<Vec<String>> {
        let rows = text::fit_rows(story, both);
        rows.iter().map(|row| row.iter().take(count).cloned().collect()).collect()
    };
    page.table(&columns, &rows([&found.before, &found.after], 5));
    if !story.held_out.is_empty() {
        page.paragraph(&format!("{}.", sentence(&text::held_out(story))));
        page.table(&columns[..3], &rows(story.predicted.each_ref(), 3));
    }
    page.heading("Where it comes from");
    page.notes(&[("Recordings", &recordings(story)), ("Search", &text::summary(story))]);
    for line in super::clocks::lines(&story.begins_utc()) {
        page.notes(&[("Clock", &line)]);
    }
    for untold in story.untold() {
        page.notes(&[("Not told", untold)]);
    }
    page.heading("How to read this");
    page.notes(NOTES);
    page.html()
}

/// The answer, in sentences.
fn lead(story: &Story<'_>) -> String {
    let found = story.found;
    let told: Vec<String> = found
        .parameters
        .iter()
        .filter(|parameter| parameter.identifiable && !is_sensors(parameter))
        .map(phrase)
        .collect();
    let open: Vec<String> = found.parameters.iter().filter(|it| !it.is_clear).map(named).collect();
    let mut text = match story.records {
        [one] => format!("{:.0} s of {} tell", found.seconds, one.name),
        several => format!("{:.0} s of {} recordings tell", found.seconds, several.len()),
    };
    text += &if told.is_empty() {
        " none of the vehicle's parameters asked for.".into()
    } else {
        format!(": {}.", told.join("; "))
    };
    if !open.is_empty() {
        text += &format!(" They do not tell {}.", words::list(&open));
    }
    for parameter in found.parameters.iter().filter(|parameter| parameter.is_in_doubt()) {
        text += &format!(" In doubt: {}.", text::in_doubt(parameter));
    }
    text
}

/// Name, value and interval.
fn phrase(parameter: &Identified) -> String {
    let decimals = digits(parameter.value, parameter.std);
    let (low, high) = parameter.ci95;
    let unit = if parameter.unit == "1" { String::new() } else { format!(" {}", parameter.unit) };
    format!(
        "{} {}{unit} (95 %: {} to {})",
        named(parameter),
        number(parameter.value, decimals),
        number(low, decimals),
        number(high, decimals)
    )
}

/// Its name in a sentence.
fn named(parameter: &Identified) -> String {
    let Identified { name, value, std, .. } = *parameter;
    words::ordinary(name, Estimate { value, std }).name
}

fn is_sensors(parameter: &Identified) -> bool {
    parameter.name.contains("_offset")
}

fn shifts(page: &mut Page, story: &Story<'_>) {
    let row = |parameter: &Identified| {
        let (prior, std) = parameter.prior;
        let [_, unit, before, after, ..] = text::row(parameter);
        let (low, high) = parameter.ci95;
        let after = match (parameter.identifiable, parameter.is_clear) {
            (true, _) => after,
            (false, true) => format!("{after}, in doubt"),
            (false, false) => "not identifiable".into(),
        };
        Shift {
            name: parameter.name.into(),
            unit,
            before: (std > 0.0).then_some([prior - 1.96 * std, prior, prior + 1.96 * std]),
            after: parameter.is_clear.then_some([low, parameter.value, high]),
            before_text: before,
            after_text: after,
        }
    };
    let rows: Vec<Shift> = story.found.parameters.iter().map(row).collect();
    page.shifts(
        "Before and after: 95 % intervals",
        ("the vehicle's table", "with the recordings"),
        &rows,
        "Each row has a scale of its own. A dot outside of the first bar: the table is wrong, or the equations are.",
    );
}

fn recordings(story: &Story<'_>) -> String {
    let one = |record: &identify::Record| {
        format!("{} ({:.0} s)", record.name, record.rows.len() as f64 * record.period_s)
    };
    story.records.iter().map(one).collect::<Vec<_>>().join(", ")
}

const NOTES: &[(&str, &str)] = &[
    (
        "the table's",
        "The configuration's [vehicle]: value ± standard deviation, counted as one more measurement. Offsets of \
         sensors and differences of the wheels' radii have a prior of their own.",
    ),
    (
        "95 % interval",
        "Where the true value is in 95 of 100 cases, if the equations hold. Residuals that are no white noise \
         (a road that is not flat, a model that is not quite right) widen it as much as the segments of the \
         recordings disagree; a vehicle table that is wrong in what it calls known does not.",
    ),
    (
        "identifiable",
        "The recordings alone tell it better than the table, and do not contradict it: a number more than three of the \
         table's standard deviations from the table's value is in doubt, whoever is wrong. What they do not tell is given \
         no number: drive \
         such that it matters (steer for the cornering stiffnesses, accelerate for the longitudinal one, go to \
         the limit for the friction).",
    ),
    (
        "profile",
        "How much worse everything else can make up for a wrong value: 2 ln of the likelihood ratio. Where it \
         passes 3.84 would be the 95 % interval if the residuals were white noise and the inputs exact; a flat \
         side means that there is no end.",
    ),
];
