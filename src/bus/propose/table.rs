//! A proposal as a configuration file, every line with its reason.

use std::fmt::Write;
use std::path::Path;

use super::proposal::{Alternative, Choice, Confidence, Mapped, Proposal};

/// A configuration that gripd itself accepts, as far as the required quantities were found. `dbc` as it is to stand
/// in it: relative to the file.
pub fn table(proposal: &Proposal, dbc: &[&Path]) -> String {
    let by = "Proposed by `gripd map` from";
    signals(proposal, dbc, by, "Look at every line before you use it.") + VEHICLE + "\n"
}

/// Everything before `[vehicle]`, with a first comment that begins and ends so.
pub fn signals(proposal: &Proposal, dbc: &[&Path], by: &str, end: &str) -> String {
    let mut out = String::new();
    let founded = match proposal.driven_s {
        Some(seconds) => format!("names and {seconds:.0} s of driving"),
        None => "names alone: with a recorded drive signs and units could be told".to_owned(),
    };
    comment(&mut out, &format!("{by} {founded}. {end}"));
    for note in &proposal.notes {
        let end = if note.ends_with(['.', '?', '!']) { "" } else { "." };
        comment(&mut out, &format!("Note: {note}{end}"));
    }
    line(&mut out, "");
    let fd = if proposal.fd { "\nfd = true" } else { "" };
    line(&mut out, &format!("[bus]\ninterface = \"can0\"   # that of the gateway on this bus{fd}\n"));
    let files: Vec<String> = dbc.iter().map(|path| quoted(&path.to_string_lossy())).collect();
    line(&mut out, &format!("[dbc]\ninput = [{}]\n\n[signals]", files.join(", ")));
    for choice in &proposal.quantities {
        entry(&mut out, choice);
    }
    out
}

/// No DBC has it, and the program does not do without.
const VEHICLE: &str = "\
[vehicle]
# Nothing of this is from the car: an ordinary one, for the data sheet's numbers to be put in.
mass_kg = { value = 1500.0, std = 300.0 }
wheelbase_m = { value = 2.65, std = 0.15 }
cg_to_front_m = { value = 1.2, std = 0.15 }
wheel_radius_m = { value = 0.31, std = 0.02 }
steering_ratio = { value = 15.5, std = 2.0 }
driven_axle = \"front\"";

fn entry(out: &mut String, choice: &Choice) {
    let name = choice.quantity.name();
    comment(out, &format!("{name}: {}: {}.", choice.confidence.name(), choice.why));
    for repaired in &choice.repaired {
        comment(out, &format!("{name}, put right: {repaired}"));
    }
    for other in &choice.contradicted {
        comment(out, &format!("not {}, though it is called so: {}", other.signal, reason(other)));
    }
    for other in &choice.alternatives {
        comment(out, &format!("or {} ({:.2}{})", other.signal, other.names, with(other)));
    }
    match (&choice.mapping, choice.confidence) {
        (None, _) => line(out, &format!("# {name} =")),
        (Some(mapped), Confidence::NotFound) => line(out, &format!("# {name} = {}", value(mapped))),
        (Some(mapped), _) => line(out, &format!("{name} = {}", value(mapped))),
    }
    line(out, "");
}

fn reason(other: &Alternative) -> &str {
    if other.data.is_empty() { "it does not behave so" } else { &other.data }
}

fn with(other: &Alternative) -> String {
    if other.data.is_empty() { String::new() } else { format!("; {}", other.data) }
}

/// The entry's value: a name, or a table of one line.
fn value(mapped: &Mapped) -> String {
    let mut keys = Vec::new();
    match mapped.signals.as_slice() {
        [one] => keys.push(format!("signal = {}", quoted(one))),
        several => keys.push(format!("sum = {}", list(several))),
    }
    keys.extend(mapped.sign.iter().map(|sign| format!("sign = {}", quoted(sign))));
    if !mapped.valid.is_empty() {
        keys.push(format!("valid = {}", one_or_list(&mapped.valid)));
        match mapped.valid_when.as_slice() {
            [0] => {}
            [one] => keys.push(format!("valid_when = {one}")),
            several => keys.push(format!("valid_when = {several:?}")),
        }
    }
    keys.extend(mapped.gain.map(|gain| format!("gain = {gain:?}")));
    keys.extend(mapped.offset.map(|offset| format!("offset = {offset:?}")));
    keys.extend(mapped.unit.iter().map(|unit| format!("unit = {}", quoted(unit))));
    if !mapped.not_available.is_empty() {
        keys.push(format!("not_available = {:?}", mapped.not_available));
    }
    keys.extend(mapped.delay_ms.map(|late| format!("delay_ms = {late:?}")));
    if !mapped.counter.is_empty() {
        keys.push(format!("counter = {}", one_or_list(&mapped.counter)));
    }
    keys.extend(mapped.counter_modulo.map(|modulo| format!("counter_modulo = {modulo}")));
    match (mapped.signals.as_slice(), keys.as_slice()) {
        ([one], [_]) => quoted(one),
        _ => format!("{{ {} }}", keys.join(", ")),
    }
}

fn one_or_list(names: &[String]) -> String {
    if let [one] = names { quoted(one) } else { list(names) }
}

fn list(names: &[String]) -> String {
    let names: Vec<String> = names.iter().map(|name| quoted(name)).collect();
    format!("[{}]", names.join(", "))
}

/// A TOML string; names of DBC files may hold anything.
fn quoted(text: &str) -> String {
    let mut out = String::from("\"");
    for letter in text.chars() {
        match letter {
            '"' | '\\' => out.extend(['\\', letter]),
            control if control.is_control() => {
                // Writing to a string cannot fail.
                let _ = write!(out, "\\u{:04X}", u32::from(control));
            }
            other => out.push(other),
        }
    }
    out.push('"');
    out
}

/// Columns of a comment.
const WIDTH: usize = 97;

/// A comment, broken into lines.
pub(super) fn comment(out: &mut String, text: &str) {
    let mut width = 0;
    for word in text.split_whitespace() {
        if width == 0 || width + word.chars().count() > WIDTH {
            out.push_str(if width == 0 { "#" } else { "\n#  " });
            width = 1;
        }
        out.push(' ');
        // What a file calls its signals cannot end the comment.
        out.extend(word.chars().filter(|letter| !letter.is_control()));
        width += word.chars().count() + 1;
    }
    out.push('\n');
}

fn line(out: &mut String, text: &str) {
    out.push_str(text);
    out.push('\n');
}
