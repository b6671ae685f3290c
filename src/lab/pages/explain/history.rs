//! What changed from drive to drive, in words and as figures.

use std::path::Path;

use super::text::wrapped;
use super::words::{self, Shown, number, plus_minus, sentence, three, with_unit};
use crate::explain::{Change, Estimate, Explanation, History, InDrive, Order, Unchanged, Verdict};
use crate::report::interactive::{Figure, Numbers, Points, Shape, Source};
use crate::report::{Color, Page};

/// So many of what has not changed are named.
const MOST_NAMED: usize = 8;

/// Deviations of a 95 % interval.
const NORMAL_95: f64 = 1.96;

/// A change in a sentence without full stop: what, since when, and whether it grows.
pub fn sentence_of(history: &History, change: &Change) -> String {
    let name = name(&change.effect, change.channel.as_deref(), &change.parameter);
    let [first, last] = &change.since_ci;
    let since = short(history, &change.since);
    let since = if first == last {
        format!("since {since}")
    } else {
        format!("since {since} (95 %: {} to {})", short(history, first), short(history, last))
    };
    format!("{name} {since}: {}; {}", by_how_much(history, change), growth(change))
}

/// From the drives before to the last one.
fn by_how_much(history: &History, change: &Change) -> String {
    let since = history.drives.iter().position(|drive| drive.log == change.since).unwrap_or(0);
    let before: Vec<&InDrive> = change.values.iter().take(since.max(1)).collect();
    let mean = before.iter().map(|it| it.value).sum::<f64>() / before.len().max(1) as f64;
    let squares: f64 = before.iter().map(|it| it.std * it.std).sum();
    let before = Estimate { value: mean, std: squares.sqrt() / before.len().max(1) as f64 };
    let last = change.values.last().map_or(before, |it| Estimate { value: it.value, std: it.std });
    let [before, last] = [before, last].map(|it| shown(change, it));
    format!("{} before, {} in the last drive", plus_minus(before.estimate), last.value())
}

fn growth(change: &Change) -> String {
    let per_drive = change.trend_per_drive.zip(change.trend_ci95).map(|(value, [low, high])| {
        let of = |value: f64| shown(change, Estimate { value, std: 0.0 });
        let unit = of(value).unit;
        let [value, low, high] = [value, low, high].map(|value| three(of(value).estimate.value));
        format!("{} from drive to drive, 95 %: {low} to {high}", with_unit(&value, &unit))
    });
    match (change.grows, per_drive) {
        (Some(true), Some(trend)) => format!("it grows, by {trend}"),
        (Some(false), Some(trend)) => format!("since then it does not grow ({trend})"),
        _ => "one drive does not tell whether it grows".into(),
    }
}

/// What it is, with the effect that it is of.
fn name(effect: &str, channel: Option<&str>, parameter: &str) -> String {
    let own = words::parameter(effect, channel, parameter);
    // A number of the car is called by its name, what an effect has of it by both.
    if effect == parameter { own } else { format!("{} ({own})", words::effect(effect, channel)) }
}

fn shown(change: &Change, estimate: Estimate) -> Shown {
    words::shown(&change.parameter, change.channel.as_deref().unwrap_or(""), &change.unit, estimate)
}

/// A log's name without its folder, where the drives are told apart by that.
fn short<'h>(history: &'h History, log: &'h str) -> &'h str {
    let file = |log: &'h str| Path::new(log).file_name().and_then(|name| name.to_str()).unwrap_or(log);
    let own = file(log);
    if history.drives.iter().filter(|drive| file(&drive.log) == own).count() > 1 { log } else { own }
}

/// The drives in order.
fn drives(history: &History) -> String {
    let names: Vec<String> = history
        .drives
        .iter()
        .enumerate()
        .map(|(place, drive)| {
            let healthy = if drive.is_reference { " (reference)" } else { "" };
            let begins = drive.begins_utc.as_ref().map_or_else(String::new, |utc| format!(", {utc}"));
            format!("{}: {}{begins}{healthy}", place + 1, short(history, &drive.log))
        })
        .collect();
    let order = match history.order {
        Order::Recorded => "in the order of their own clock",
        Order::Given => {
            "in the order in which they were given, for they have no dates of their own that follow each other"
        }
    };
    format!("Drives {order}: {}.", names.join(", "))
}

/// In one sentence what came out.
pub fn headline(explanation: &Explanation, history: &History) -> String {
    match explanation.verdict {
        Verdict::Unchanged => "Nothing has changed from the first drive to the last".into(),
        Verdict::MissingPhysics => {
            let of = |change: &Change| {
                let name = words::effect(&change.effect, change.channel.as_deref());
                let grows = if change.grows == Some(true) { ", growing" } else { "" };
                format!("{name} since {}{grows}", short(history, &change.since))
            };
            format!("Changed: {}", words::list(&history.changes.iter().map(of).collect::<Vec<_>>()))
        }
        _ => "The drives do not tell whether something has changed".into(),
    }
}

/// What would have been told of what has not changed, the clearest first.
fn would_be_told(history: &History) -> Vec<String> {
    let mut all: Vec<(&Unchanged, f64)> =
        history.numbers.iter().filter_map(|it| Some((it, it.told_from?))).collect();
    all.sort_by(|a, b| (a.1 / a.0.ordinary).total_cmp(&(b.1 / b.0.ordinary)));
    let of = |(it, from): &(&Unchanged, f64)| {
        let channel = it.channel.as_deref();
        let size = words::size(&it.parameter, channel.unwrap_or(""), &it.unit, *from);
        format!("{} by {size}", name(&it.effect, channel, &it.parameter))
    };
    all.iter().take(MOST_NAMED).map(of).collect()
}

/// As text.
pub fn text(text: &mut String, history: &History) {
    *text += "\nOver the drives\n";
    wrapped(text, "  - ", &drives(history));
    for change in &history.changes {
        wrapped(text, "  - ", &(sentence(&sentence_of(history, change)) + "."));
        let of = |(place, it): (usize, &InDrive)| {
            let shown = shown(change, Estimate { value: it.value, std: it.std });
            format!("{}: {}", place + 1, shown.value())
        };
        let values: Vec<String> = change.values.iter().enumerate().map(of).collect();
        wrapped(text, "    drive ", &values.join(", "));
    }
    let told = would_be_told(history);
    if !told.is_empty() {
        let what = if history.changes.is_empty() { "A change" } else { "Another change" };
        let words = format!(
            "{what} from the middle of the drives on would be told with 90 % probability: {}.",
            words::list(&told)
        );
        wrapped(text, "  - ", &words);
    }
}

/// As a part of the page.
pub fn section(page: &mut Page, history: &History) {
    page.section("history", "Over the drives", "");
    page.paragraph(&drives(history));
    for change in &history.changes {
        page.paragraph(&(sentence(&sentence_of(history, change)) + "."));
    }
    let told = would_be_told(history);
    if !told.is_empty() {
        page.heading("As they were");
        page.paragraph(&format!(
            "A change from the middle of the drives on would be told with 90 % probability: {}.",
            words::list(&told)
        ));
    }
}

/// Each change over the drives, and the numbers that are told best.
pub fn figures(history: &History) -> Vec<Figure> {
    let mut figures: Vec<Figure> = history
        .changes
        .iter()
        .map(|change| {
            let of = (change.effect.as_str(), change.channel.as_deref(), change.parameter.as_str());
            let since = history.drives.iter().position(|drive| drive.log == change.since);
            let figure = figure(history, of, &change.unit, &change.values, since);
            Figure { answer: format!("Another one since {}.", short(history, &change.since)), ..figure }
        })
        .collect();
    let mut told: Vec<&Unchanged> =
        history.numbers.iter().filter(|it| it.told_from.is_some_and(|from| from <= it.ordinary)).collect();
    told.sort_by(|a, b| {
        let share = |it: &Unchanged| it.told_from.unwrap_or(f64::INFINITY) / it.ordinary;
        share(a).total_cmp(&share(b))
    });
    figures.extend(told.into_iter().take(MOST_NAMED).map(|it| {
        let of = (it.effect.as_str(), it.channel.as_deref(), it.parameter.as_str());
        figure(history, of, &it.unit, &it.values, None)
    }));
    figures
}

/// Value and interval over the drives.
fn figure(
    history: &History,
    (effect, channel, parameter): (&str, Option<&str>, &str),
    unit: &str,
    values: &[InDrive],
    since: Option<usize>,
) -> Figure {
    let name = name(effect, channel, parameter);
    let of = |it: &InDrive| {
        let estimate = Estimate { value: it.value, std: it.std };
        words::shown(parameter, channel.unwrap_or(""), unit, estimate)
    };
    let shown: Vec<Shown> = values.iter().map(of).collect();
    let unit = shown.first().map_or("", |it| it.unit.as_str());
    let axis = if unit.is_empty() { name.clone() } else { format!("{name}, {unit}") };
    let mut figure = Figure::new(&sentence(&name), "drive", &axis);
    let points = |name: &str, color: Color, shape: Shape, places: Vec<(f64, f64)>| Points {
        name: name.into(),
        source: Source::Measured,
        color,
        shape,
        times: Numbers::default(),
        x: Numbers::rounded(places.iter().map(|it| it.0).collect(), 1),
        y: Numbers::new(places.iter().map(|it| it.1).collect()),
        shade: None,
    };
    let ends = |it: &Shown| {
        let Estimate { value, std } = it.estimate;
        [value - NORMAL_95 * std, value + NORMAL_95 * std]
    };
    let at = |place: usize| place as f64 + 1.0;
    // One line with holes in it: an upright piece for each drive.
    let bars = shown.iter().enumerate().flat_map(|(place, it)| {
        let [low, high] = ends(it);
        [(at(place), low), (at(place), high), (at(place), f64::NAN)]
    });
    figure.points.push(points("95 % interval", Color::First, Shape::Path, bars.collect()));
    let middles = shown.iter().enumerate().map(|(place, it)| (at(place), it.estimate.value));
    figure.points.push(points("value", Color::First, Shape::Rings, middles.collect()));
    if let Some(place) = since {
        let all = || shown.iter().flat_map(ends).filter(|it| it.is_finite());
        let ends = [all().fold(f64::INFINITY, f64::min), all().fold(f64::NEG_INFINITY, f64::max)];
        let line = ends.map(|end| (at(place) - 0.5, end));
        figure.points.push(points("since", Color::Notice, Shape::Path, line.to_vec()));
    }
    let last = values.last().map_or("", |it| short(history, &it.log));
    let first = values.first().map_or("", |it| short(history, &it.log));
    figure.caption = format!("From {first} (1) to {last} ({}).", number(values.len() as f64, 0));
    figure
}

#[cfg(test)]
mod tests {
    use super::super::sample;
    use super::*;

    fn history() -> History {
        let log = |place: usize| format!("drives/{place}.log");
        let drive = |place| crate::explain::Drive {
            log: log(place),
            begins: None,
            begins_utc: None,
            is_reference: false,
        };
        let values = [0.0, 0.0002, -0.0151, -0.0148].into_iter().enumerate();
        let change = Change {
            effect: "tire_radius".into(),
            channel: None,
            parameter: "relative_difference_rl".into(),
            unit: "1".into(),
            since: log(2),
            since_ci: [log(2), log(3)],
            values: values.map(|(place, value)| InDrive { log: log(place), value, std: 0.0004 }).collect(),
            grows: Some(false),
            trend_per_drive: Some(0.0003),
            trend_ci95: Some([-0.0009, 0.0015]),
        };
        let unchanged = Unchanged {
            effect: "lateral_stiffness_front".into(),
            channel: None,
            parameter: "lateral_stiffness_front".into(),
            unit: "1/rad".into(),
            values: (0..4).map(|place| InDrive { log: log(place), value: 12.0, std: 0.3 }).collect(),
            told_from: Some(1.5),
            ordinary: 2.4,
        };
        let drives = (0..4).map(drive).collect();
        History { order: Order::Given, drives, changes: vec![change], numbers: vec![unchanged] }
    }

    #[test]
    fn a_change_is_told_with_its_drive_and_without_growth() {
        let mut text = String::new();
        super::text(&mut text, &history());
        for part in [
            "since 2.log (95 %: 2.log to 3.log)",
            "rear left wheel",
            "0.010 ± 0.028 before, −1.48 ± 0.04 % in the last drive",
            "does not grow (0.0300 % from drive to drive, 95 %: −0.0900 to 0.150)",
            "3: −1.51 ± 0.04 %",
            "front cornering stiffness by 1.50 1/rad",
            "in the order in which they were given",
        ] {
            assert!(
                text.split_whitespace().collect::<Vec<_>>().join(" ").contains(part),
                "{part} not in\n{text}"
            );
        }
    }

    #[test]
    fn the_page_has_a_panel_for_each_number() {
        let mut explanation = sample::missing();
        explanation.history = Some(history());
        let page = super::super::page(&explanation);
        assert!(page.contains("Over the drives") && !page.contains("NaN"));
        assert!(page.matches("95 % interval").count() >= 2);
        assert!(headline(&explanation, &history()).contains("since 2.log"));
        let verdict = |verdict| Explanation { verdict, ..explanation.clone() };
        assert!(headline(&verdict(Verdict::Unchanged), &history()).starts_with("Nothing has changed"));
        assert!(headline(&verdict(Verdict::InsufficientExcitation), &history()).contains("do not tell"));
    }
}
