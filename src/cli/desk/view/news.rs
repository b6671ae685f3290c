//! What a page is told, as JSON.

use std::collections::BTreeMap;
use std::fmt::Write;

use serde::Serialize;
use serde_json::json;

use crate::cli::desk::watched::Subject;
use bus::watch::{
    Column, Heard, InputNow, Link, Row, Told, Traffic as Counted, Watch, Word, fault_words, quantity_label,
    quantity_shown, source_words, state_words,
};
use physics::estimates::{MuSource, State};
use physics::{Faults, Micros};

/// What does not change.
pub fn meta(subject: &Subject) -> String {
    let inputs: Vec<_> = subject.watch.inputs().map(|input| input.quantity.name()).collect();
    let driven: Vec<_> = subject.driven().into_iter().map(|wheel| wheel.name()).collect();
    let faults: Vec<String> = Faults::all().names().collect();
    json!({
        "name": subject.name,
        "version": env!("CARGO_PKG_VERSION"),
        "columns": Column::all().map(Column::name).collect::<Vec<_>>(),
        "inputs": inputs,
        "driven": driven,
        "states": State::ALL.map(State::name),
        "sources": MuSource::ALL.map(MuSource::name),
        "faults": faults,
    })
    .to_string()
}

/// Rows as arrays, separated by commas: the time in seconds, then the columns.
pub fn rows<'a>(rows: impl Iterator<Item = &'a Row>) -> (String, usize) {
    let (mut text, mut count) = (String::new(), 0);
    for row in rows {
        text += if count == 0 { "[" } else { ",[" };
        count += 1;
        // Writing to a string cannot fail.
        let _ = write!(text, "{:.1}", row.time.seconds());
        for value in row.values {
            text.push(',');
            push_number(&mut text, value);
        }
        text.push(']');
    }
    (text, count)
}

/// With five decimals at most, which is finer than what is published.
fn push_number(text: &mut String, value: f32) {
    if !value.is_finite() {
        *text += "null";
        return;
    }
    let start = text.len();
    let _ = write!(text, "{value:.5}");
    let digits = text.trim_end_matches('0').trim_end_matches('.').len();
    text.truncate(digits.max(start + 1));
    if text.get(start..) == Some("-0") {
        text.remove(start);
    }
}

#[derive(Serialize)]
struct Now {
    time: f64,
    told: String,
    /// Something is wrong with that.
    warn: bool,
    /// Beside the clock.
    remark: String,
    own: bool,
    source: &'static str,
    estimates: BTreeMap<&'static str, Option<f32>>,
    words: BTreeMap<&'static str, &'static str>,
    faults: Vec<(String, &'static str)>,
    inputs: Vec<Input>,
    messages: Vec<Message>,
    traffic: Vec<Traffic>,
}

#[derive(Serialize)]
struct Input {
    label: &'static str,
    value: Option<f64>,
    unit: &'static str,
    decimals: usize,
    age_ms: Option<f64>,
    state: &'static str,
}

#[derive(Serialize)]
struct Message {
    name: String,
    rate: f64,
    age_ms: Option<f64>,
    state: &'static str,
    crc_errors: u64,
    counter_errors: u64,
}

#[derive(Serialize)]
struct Traffic {
    name: String,
    id: String,
    rate: f64,
    age_ms: Option<f64>,
}

/// How it is now. `remark` is of the recording: that it is over, or why it broke off.
pub fn now(watch: &Watch, remark: &str) -> String {
    let row = watch.last_row();
    let estimate = |column: Column| match column {
        Column::Estimate(name) => Some((name, Some(row.get(column)).filter(|value| value.is_finite()))),
        Column::Input(_) => None,
    };
    let (told, warn) = told(watch, remark);
    let now = Now {
        time: watch.now().seconds(),
        told,
        warn,
        remark: remark.to_owned(),
        own: watch.told() == Told::ByOwn,
        source: source_words(watch.last_round().mu_source),
        estimates: Column::all().filter_map(estimate).collect(),
        words: watch.messages().map(|(heard, word)| (heard.name(), word_of(word).0)).collect(),
        faults: faults(watch),
        inputs: watch.inputs().map(input).collect(),
        messages: watch.messages().map(|(heard, word)| message(watch, heard, word)).collect(),
        traffic: watch.traffic().iter().map(|traffic| of_traffic(watch, traffic)).collect(),
    };
    // Numbers and words: there is nothing in it that JSON could not take.
    serde_json::to_string(&now).unwrap_or_else(|_| "null".into())
}

fn told(watch: &Watch, remark: &str) -> (String, bool) {
    let (mut text, mut warn) = match watch.link() {
        Some(Link::Down) => ("The interface is down; waiting for it. ".to_owned(), true),
        Some(Link::Gone) => ("There is no such interface; waiting for it. ".to_owned(), true),
        Some(Link::Up) | None => (String::new(), false),
    };
    let round = watch.round();
    let (words, is_wrong) = match watch.told() {
        Told::ByBus => ("Estimates as a gripd on this bus publishes them", false),
        Told::Silent => ("The gripd on this bus has fallen silent: what is shown is old", true),
        Told::Never => (
            "No gripd publishes on this bus; `gripd view --estimate` estimates here, and sends nothing",
            true,
        ),
        Told::ByOwn => ("Estimates made here, from the inputs; nothing is sent", false),
    };
    text += words;
    warn |= is_wrong;
    if !remark.is_empty() {
        // What it did then it does no more.
        text += &format!("; {remark}.");
    } else if round.state.is_none() {
        text += ".";
    } else {
        text += &format!("; {}.", state_words(round.state));
    }
    if let Some(silence) = watch.silence().filter(|silence| *silence > Micros(1_000_000)) {
        text += &format!(" Nothing has come for {:.0} s.", silence.seconds());
        warn = true;
    }
    if watch.dropped() > 0 {
        text += &format!(" {} frames were lost on the way here.", watch.dropped());
    }
    if let (count, Some(error)) = watch.errors() {
        text += &format!(" {count} errors on the bus; last: {error}.");
    }
    (text, warn)
}

fn faults(watch: &Watch) -> Vec<(String, &'static str)> {
    let named =
        |fault: Faults| (fault.names().next().unwrap_or_default().replace('_', " "), fault_words(fault));
    watch.faults().iter().map(named).collect()
}

fn milliseconds(age: Micros) -> f64 {
    (1000.0 * age.seconds()).round()
}

fn input(input: InputNow) -> Input {
    let (factor, unit, decimals) = quantity_shown(input.quantity);
    let state = match (input.newest, input.is_stale, input.is_doubted) {
        (None, ..) => "never came",
        (_, true, _) => "stale",
        (_, _, true) => "left out: others contradict it, or it says that it is not valid",
        _ => "",
    };
    Input {
        label: quantity_label(input.quantity),
        value: input.newest.map(|(value, _)| factor * value),
        unit,
        decimals,
        age_ms: input.newest.map(|(_, age)| milliseconds(age)),
        state,
    }
}

fn word_of(word: Word) -> (&'static str, Option<Micros>) {
    match word {
        Word::Never => ("never", None),
        Word::Fresh(age) => ("fresh", Some(age)),
        Word::Stale(age) => ("stale", Some(age)),
    }
}

fn message(watch: &Watch, heard: &Heard, word: Word) -> Message {
    let (state, age) = word_of(word);
    Message {
        name: heard.name().to_owned(),
        rate: heard.traffic().rate(watch.now()),
        age_ms: age.map(milliseconds),
        state,
        crc_errors: heard.crc_errors,
        counter_errors: heard.counter_errors,
    }
}

fn of_traffic(watch: &Watch, traffic: &Counted) -> Traffic {
    Traffic {
        name: traffic.name().to_owned(),
        id: traffic.id().to_string(),
        rate: traffic.rate(watch.now()),
        age_ms: traffic.last().map(|last| milliseconds((watch.now() - last).max(Micros(0)))),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_short_and_never_wrong_json() {
        let shown = |value: f32| {
            let mut text = String::from("x,");
            push_number(&mut text, value);
            text
        };
        for (value, expected) in [
            (0.0, "x,0"),
            (-0.0, "x,0"),
            (-0.000_001, "x,0"),
            (10.0, "x,10"),
            (-0.25, "x,-0.25"),
            (43.75, "x,43.75"),
            (f32::NAN, "x,null"),
            (f32::INFINITY, "x,null"),
            (65_535.0, "x,65535"),
        ] {
            assert_eq!(shown(value), expected);
        }
        assert!(shown(1e30).parse::<f64>().is_err() && shown(1e30).starts_with("x,1"));
    }
}
