//! The ordinary car, fitted by free runs: as lines, as a table, as JSON, and as a section of a page.

use std::collections::BTreeMap;
use std::fmt::Write;

use serde::Serialize;

use crate::explain::ordinary::{FreeTrace, Number, Ordinary};
use crate::explain::{ByChannel, Parts};
use crate::identify::CorneringStiffness;
use crate::pages::axles;
use crate::pages::clocks;
use crate::pages::explain::words;
use crate::report::{Color, Page, Plot};

/// What it predicts and what it leaves, a line each.
pub fn lines(ordinary: &Ordinary) -> Vec<String> {
    let mut all = vec![
        "relaxation, compliance, roll and a bend of the tires; delays, offsets and scale of each recording; driven by \
         steering and measured speed alone"
            .to_owned(),
    ];
    for (channel, fit) in &ordinary.fit.holdout {
        let mut line = format!(
            "{}: {fit:.1} % held out (the car as configured: {:.1} %)",
            plain(channel),
            ordinary.plain_fit.holdout.get(channel).copied().unwrap_or(f64::NAN)
        );
        if let Some(left) = ordinary.disturbances.get(channel) {
            let _ = write!(
                line,
                "; it leaves {} {} over {:.2} s",
                three(left.std),
                left.unit,
                left.time_constant_s
            );
        }
        if let Some(remaining) = ordinary.remaining.get(channel) {
            let _ = write!(
                line,
                ", of which {:.0} % follow from inputs and motion (by chance up to {:.0} %)",
                100.0 * remaining.share,
                100.0 * remaining.null
            );
        }
        all.push(line);
    }
    all.extend(ordinary.left_out.iter().map(|why| format!("left out: {why}")));
    all
}

/// As a person reads it.
pub fn text(ordinary: &Ordinary) -> String {
    let mut text = String::from("The ordinary car\n");
    for line in lines(ordinary) {
        let _ = writeln!(text, "  - {line}");
    }
    for line in clocks::lines(&ordinary.begins_utc) {
        let _ = writeln!(text, "  - {line}");
    }
    let _ = writeln!(text, "  - {}", axles::WHAT);
    for line in axles::lines(&ordinary.cornering_stiffness) {
        let _ = writeln!(text, "      {line}");
    }
    let _ = writeln!(text, "\n{:44} {:>12} {:>10}   {:>22}", "", "value", "std", "before");
    for number in &ordinary.numbers {
        let of =
            number.recording.as_ref().map_or(String::new(), |recording| format!(" of {}", file(recording)));
        let _ = writeln!(
            text,
            "{:44} {:>12} {:>10}   {:>11} ± {:<9}{}",
            format!("{}{of}", number.name),
            three(number.estimate.value),
            three(number.estimate.std),
            three(number.prior.value),
            three(number.prior.std),
            number.untold().map_or(String::new(), |why| format!(" {why}")),
        );
    }
    text
}

/// `--json` of identification: the contract's keys, and those of each recording.
#[derive(Serialize)]
pub struct Report {
    parameters: BTreeMap<String, Parameter>,
    recordings: BTreeMap<String, BTreeMap<String, Parameter>>,
    cornering_stiffness: CorneringStiffness,
    starts: Vec<Start>,
    fit: Parts<ByChannel>,
    left_out: Vec<String>,
    /// When recordings begin, in UTC, where their stamps are dates.
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    begins_utc: BTreeMap<String, String>,
    /// Sideslip of the free run, [s, rad], by recording.
    sideslip: BTreeMap<String, Vec<[f64; 2]>>,
    method: &'static str,
}

#[derive(Serialize)]
struct Parameter {
    value: f64,
    std: f64,
    ci95: [f64; 2],
    identifiable: bool,
    reason: String,
    prior: crate::explain::Estimate,
}

#[derive(Serialize)]
struct Start {
    from: BTreeMap<String, f64>,
    to: BTreeMap<String, f64>,
    cost: f64,
}

/// Everything.
pub fn report(ordinary: &Ordinary) -> Report {
    let parameter = |number: &Number| {
        let half = 1.96 * number.estimate.std;
        let untold = number.untold();
        Parameter {
            value: number.estimate.value,
            std: number.estimate.std,
            ci95: [number.estimate.value - half, number.estimate.value + half],
            identifiable: untold.is_none(),
            reason: untold.unwrap_or_default(),
            prior: number.prior,
        }
    };
    let of_the_car = || ordinary.numbers.iter().filter(|number| number.recording.is_none());
    let mut recordings: BTreeMap<String, BTreeMap<String, Parameter>> = BTreeMap::new();
    for number in &ordinary.numbers {
        if let Some(recording) = &number.recording {
            recordings.entry(recording.clone()).or_default().insert(number.name.clone(), parameter(number));
        }
    }
    let count = ordinary.numbers.first().map_or(0, |number| number.starts.len());
    let start = |k: usize| Start {
        from: of_the_car().map(|number| (number.name.clone(), number.starts[k][0])).collect(),
        to: of_the_car().map(|number| (number.name.clone(), number.starts[k][1])).collect(),
        cost: of_the_car().next().map_or(f64::NAN, |number| number.starts[k][2]),
    };
    Report {
        parameters: of_the_car().map(|number| (number.name.clone(), parameter(number))).collect(),
        recordings,
        cornering_stiffness: ordinary.cornering_stiffness.clone(),
        starts: (0..count).map(start).collect(),
        fit: ordinary.fit.clone(),
        left_out: ordinary.left_out.clone(),
        begins_utc: ordinary.begins_utc.clone(),
        sideslip: ordinary.sideslip.iter().cloned().collect(),
        method: "ordinary",
    }
}

/// A page of its own.
pub fn html(ordinary: &Ordinary) -> String {
    let mut page = Page::new("gripd identify: the ordinary car", "");
    for line in clocks::lines(&ordinary.begins_utc) {
        page.paragraph(&words::stopped(&line));
    }
    section(&mut page, ordinary);
    page.html()
}

/// Its section: what it predicts, its numbers, measured beside predicted.
pub fn section(page: &mut Page, ordinary: &Ordinary) {
    page.section("ordinary", "The ordinary car", "");
    for line in lines(ordinary) {
        page.paragraph(&line);
    }
    let row = |number: &Number| {
        let [value, before] =
            [number.estimate, number.prior].map(|estimate| words::ordinary(&number.name, estimate));
        vec![
            words::sentence(&value.name),
            number.recording.as_deref().map_or("the car", file).to_owned(),
            value.value(),
            before.value(),
            // The number at the bound stands beside it, in the unit of the page.
            match number.is_at_bound {
                true => "the search ends at the bound: the equations do not fit here".to_owned(),
                false => number.untold().unwrap_or_default(),
            },
        ]
    };
    let rows: Vec<Vec<String>> = ordinary.numbers.iter().map(row).collect();
    page.table_of_words(&["number", "of", "value", "before", ""], &rows);
    for trace in &ordinary.traces {
        if let Err(why) = plotted(page, trace) {
            page.paragraph(&format!("A plot could not be drawn: {why}"));
        }
    }
}

fn plotted(page: &mut Page, trace: &FreeTrace) -> Result<(), crate::report::PlotError> {
    let finite = trace.rows.iter().filter(|row| row.iter().all(|value| value.is_finite()));
    let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
    for row in finite {
        (low, high) = (low.min(row[1]).min(row[2]), high.max(row[1]).max(row[2]));
    }
    let heading = format!("{}, {}", file(&trace.recording), plain(trace.channel.name()));
    let ends = trace.rows.first().zip(trace.rows.last()).filter(|_| low < high);
    let Some((first, last)) = ends else {
        page.paragraph(&format!("{heading}: no values to draw."));
        return Ok(());
    };
    let plot = Plot::new(&heading, trace.channel.unit(), first[0]..last[0], low..high)
        .height(200)
        .line("measured", Color::Truth, trace.rows.iter().map(|row| (row[0], row[1])))
        .line("by steering and speed alone", Color::First, trace.rows.iter().map(|row| (row[0], row[2])));
    page.plot(&heading, &plot, "")
}

/// A quantity in words.
fn plain(channel: &str) -> String {
    channel.replace('_', " ")
}

/// Three digits that mean something.
fn three(value: f64) -> String {
    if value == 0.0 || !value.is_finite() {
        return format!("{value}");
    }
    let digits = (2 - value.abs().log10().floor() as i32).clamp(0, 8) as usize;
    format!("{value:.digits$}")
}

/// A recording without its folder.
fn file(path: &str) -> &str {
    path.rsplit('/').next().unwrap_or(path)
}
