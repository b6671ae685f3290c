//! Where simulation and recording differ: equation, channels, driving, time.

use super::words::{self, sentence};
use super::{courses, formula};
use crate::explain::{CourseEstimate, Explanation, Finding, Trace, Where};
use crate::report::{Color, Page, Panel, Plot, Row, Timeline, escape};

/// More recordings are not drawn unless something is in them.
const MOST_RECORDINGS: usize = 4;

/// Writes it.
pub fn write(page: &mut Page, explanation: &Explanation) {
    let place = &explanation.place;
    let is_somewhere = !place.equation.is_empty() || !place.channels.is_empty();
    let heading = if is_somewhere { "Where they differ" } else { "What was driven" };
    page.section("where", heading, "");
    if is_somewhere {
        page.raw("<dl class=\"place\">");
        about(page, place);
        page.raw("</dl>");
    }
    for recording in words::recordings(explanation) {
        timeline(page, explanation, recording);
    }
    for finding in &explanation.findings {
        if let Some(series) = &finding.series {
            course(page, finding, series);
        }
    }
}

/// Equation, channels and driving, as entries of a list.
pub fn about(page: &mut Page, place: &Where) {
    let channels: Vec<String> = place.channels.iter().map(|name| words::channel(name)).collect();
    let one =
        |term: &str, text: &str| format!("<div><dt>{term}</dt><dd>{}</dd></div>", escape(&sentence(text)));
    let many = |term: &str, words: &[String]| {
        let items: Vec<String> =
            words.iter().map(|word| format!("<li>{}</li>", formula::html(word))).collect();
        format!("<div><dt>{term}</dt><dd><ul class=\"chips\">{}</ul></dd></div>", items.concat())
    };
    if !place.equation.is_empty() {
        page.raw(&one("Equation or sensor", &place.equation));
    }
    if !channels.is_empty() {
        page.raw(&many("Seen in", &channels));
    }
    if !place.regimes.is_empty() {
        page.raw(&many("When driving", &place.regimes));
    }
}

fn timeline(page: &mut Page, explanation: &Explanation, recording: &str) {
    let all = words::recordings(explanation);
    let is_of =
        |place: &Where| place.recording == recording || (place.recording.is_empty() && all.len() == 1);
    let mut rows = Vec::new();
    let mut add = |name: String, place: &Where, color: Color| {
        if is_of(place) && !place.intervals.is_empty() {
            rows.push(Row { name, stretches: place.intervals.clone(), color });
        }
    };
    add("where the plain model differs from the recording".into(), &explanation.place, Color::Second);
    for finding in &explanation.findings {
        // The only finding's place is that of the mismatch: once is enough.
        if explanation.findings.len() > 1 || finding.place.intervals != explanation.place.intervals {
            let name = words::effect(&finding.effect, finding.channel.as_deref());
            add(format!("where {name} shows"), &finding.place, Color::First);
        }
    }
    if rows.is_empty() && all.len() > MOST_RECORDINGS {
        return;
    }
    let of_recording = || explanation.traces.iter().filter(|trace| trace.recording == recording);
    let blocks = || explanation.split.iter().filter(|block| block.recording == recording);
    let ends = of_recording()
        .flat_map(|trace| trace.t.first().into_iter().chain(trace.t.last()).copied())
        .chain(blocks().flat_map(|block| block.t));
    let (start, end) =
        ends.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), t| (low.min(t), high.max(t)));
    let timeline = Timeline {
        title: format!("Where it differs in {recording}"),
        time: start..end,
        shade: "held out of the fit".into(),
        shaded: blocks().filter(|block| block.is_holdout).map(|block| block.t).collect(),
        panels: orientation(of_recording()),
        rows,
    };
    let heading = if timeline.rows.is_empty() { "Speed and turning" } else { "When" };
    let heading = if all.len() > 1 { format!("{heading}: {recording}") } else { heading.into() };
    if start < end {
        page.timeline(&heading, &timeline, "");
    }
}

/// Speed and lateral acceleration, or what is nearest to them.
fn orientation<'a>(traces: impl Iterator<Item = &'a Trace>) -> Vec<Panel> {
    let traces: Vec<&Trace> = traces.collect();
    let first = |names: &[&str]| {
        names.iter().find_map(|name| traces.iter().copied().find(|trace| trace.channel == *name))
    };
    let speed = first(&["speed", "vehicle_speed", "wheel_speed_rl", "wheel_speed_fl"]);
    let lateral = first(&["lateral_acceleration", "yaw_rate"]);
    let panel = |trace: &Trace| {
        let (factor, unit) = words::shown_unit(&trace.channel, &trace.unit);
        let all = [f64::NEG_INFINITY, f64::INFINITY];
        Panel {
            name: format!("{}, {unit}", words::channel(&trace.channel)),
            points: courses::series(trace, &trace.measured, factor, all),
        }
    };
    speed.into_iter().chain(lateral).map(panel).collect()
}

/// How something varied, with what is known of it.
fn course(page: &mut Page, finding: &Finding, course: &CourseEstimate) {
    let of = finding.channel.as_deref().unwrap_or("");
    let (factor, unit) = words::shown_unit(of, &course.unit);
    let name = sentence(&words::effect(&finding.effect, finding.channel.as_deref()));
    let rows: Vec<(f64, f64, f64)> = course
        .t
        .iter()
        .zip(&course.value)
        .zip(&course.std)
        .map(|((t, value), std)| (*t, factor * (value - 2.0 * std), factor * (value + 2.0 * std)))
        .collect();
    let values: Vec<(f64, f64)> =
        course.t.iter().zip(&course.value).map(|(t, value)| (*t, factor * value)).collect();
    // The band may be wide where nothing is known; the course must stay visible.
    let Some(core) = courses::range(values.iter().map(|point| point.1).chain([0.0])) else { return };
    let Some(band) = courses::range(rows.iter().flat_map(|row| [row.1, row.2]).chain([0.0])) else { return };
    let room = core.end - core.start;
    let y = band.start.max(core.start - room)..band.end.min(core.end + room);
    let (Some(from), Some(to)) = (course.t.first(), course.t.last()) else { return };
    let plot = Plot::new(&name, &courses::axis(&unit), *from..*to, y)
        .height(200)
        .band("± 2 standard deviations", Color::First, rows.into_iter())
        .line("as estimated", Color::First, values.into_iter());
    let recording = &finding.place.recording;
    let caption = if recording.is_empty() { String::new() } else { format!("Over {recording}.") };
    courses::draw(page, &format!("{name}: its course"), &plot, &caption);
}
