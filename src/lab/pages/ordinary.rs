//! The ordinary car, fitted by free runs: as lines, as a table, as JSON, and as a section of a page.

use std::collections::BTreeMap;
use std::fmt::Write;

use serde::Serialize;

use crate::explain::ordinary::{Number, Ordinary};
use crate::explain::{ByChannel, Driven, Parts};
use crate::pages::axles;
use crate::pages::beside::{Beside, Channel, Drive, Model, Said};
use crate::pages::clocks;
use crate::pages::explain::words;
use crate::pages::file_name as file;
use crate::report::{Color, Page, wrapped};
use identify::CorneringStiffness;
use physics::model::Vehicle;

/// What it predicts and what it leaves, a line each.
pub fn lines(ordinary: &Ordinary) -> Vec<String> {
    let is_pressed = ordinary.numbers.iter().any(|number| number.name.starts_with("downforce."));
    let mut all = vec![format!(
        "relaxation, compliance, roll{} and a bend of the tires; delays, offsets and scale of each recording; driven by \
         steering and measured speed alone",
        if is_pressed { ", downforce" } else { "" },
    )];
    for (channel, fit) in &ordinary.fit.holdout {
        let mut line = format!(
            "{}: {} % held out (the car as configured: {} %)",
            plain(channel),
            words::number(*fit, 1),
            words::number(ordinary.plain_fit.holdout.get(channel).copied().unwrap_or(f64::NAN), 1)
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
    for line in lines(ordinary).into_iter().chain(clocks::lines(&ordinary.begins_utc)) {
        text += &wrapped("  - ", 4, &line);
    }
    text += &format!("\n{}", wrapped("", 0, axles::WHAT));
    for line in axles::lines(&ordinary.cornering_stiffness) {
        text += &wrapped("  - ", 4, &line);
    }
    let _ = writeln!(text, "\n{:44} {:>12} {:>10}   {:>22}", "", "value", "std", "before");
    for number in &ordinary.numbers {
        let of =
            number.recording.as_ref().map_or(String::new(), |recording| format!(" of {}", file(recording)));
        let begin = format!(
            "{:44} {:>12} {:>10}   {:>11} ± {:<9} ",
            format!("{}{of}", number.name),
            three(number.estimate.value),
            three(number.estimate.std),
            three(number.prior.value),
            three(number.prior.std),
        );
        text += &match number.untold() {
            Some(why) => wrapped(&begin, 6, &why),
            None => begin.trim_end().to_owned() + "\n",
        };
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
pub fn html(ordinary: &Ordinary, vehicle: &Vehicle) -> String {
    let mut page = Page::new("gripd identify: the ordinary car", "");
    for line in clocks::lines(&ordinary.begins_utc) {
        page.paragraph(&words::stopped(&line));
    }
    let beside = beside(ordinary);
    page.facts(&beside.facts());
    let stiffness = &ordinary.cornering_stiffness;
    let plots = beside.plots(0, |axis, plots| {
        plots.figure(beside.handling(axis, vehicle, axles::gradient(stiffness)));
    });
    page.plots(&plots);
    page.paragraph(&plots.reading());
    section(&mut page, ordinary);
    axles::section(&mut page, stiffness);
    page.html()
}

/// Its free runs beside those of the car as configured, and what was measured.
fn beside(ordinary: &Ordinary) -> Beside {
    let models = vec![
        Model { name: "car as configured, refitted", color: Color::Second },
        Model { name: "ordinary car", color: Color::First },
    ];
    let drive = |driven: &Driven| {
        let name = &driven.recording;
        let mut drive = Drive::new(name, &ordinary.driven, &ordinary.split);
        drive.begins_utc = ordinary.begins_utc.get(name).cloned();
        let own = |number: &&Number| {
            number.name == "yaw_rate_offset" && number.recording.as_ref().is_none_or(|it| it == name)
        };
        drive.yaw_rate_offset = ordinary.numbers.iter().find(own).map_or(0.0, |it| it.estimate.value);
        for trace in ordinary.traces.iter().filter(|trace| trace.recording == *name) {
            drive.channels.push(Channel {
                name: trace.channel.name().into(),
                unit: trace.channel.unit().into(),
                said: vec![Said::of_rows(&trace.rows, 3), Said::of_rows(&trace.rows, 2)],
            });
        }
        drive
    };
    let drives = ordinary.driven.iter().map(drive).collect();
    let mut beside = Beside { models, drives, error_is: "held-out error", ..Beside::default() };
    beside.disturbances.clone_from(&ordinary.disturbances);
    let [plain, own] = [Some(&ordinary.error.baseline), ordinary.error.ordinary.as_ref()];
    for channel in beside.channels() {
        let of = |parts: Option<&Parts<ByChannel>>| {
            parts.and_then(|it| it.holdout.get(&channel).copied()).unwrap_or(f64::NAN)
        };
        let errors = vec![of(plain), of(own)];
        beside.error.insert(channel, errors);
    }
    beside
}

/// Its section: what it predicts, and its numbers.
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
