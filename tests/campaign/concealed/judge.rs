//! What was found, and whether it is what was put in.

use std::collections::BTreeMap;
use std::fmt;

use serde_json::Value;

use super::plan::Case;

/// A finding, as far as it is looked at.
pub struct Found {
    effect: String,
    channel: Option<String>,
    kind: String,
    /// Other names for the same, on this drive.
    alike: Vec<String>,
    numbers: BTreeMap<String, (f64, f64)>,
}

/// What was said of a drive with something put in.
pub struct Said {
    /// Where it stands among what the control has not.
    pub place: Option<usize>,
    /// It is the first of those, or in a class of at most three with that one.
    pub is_in_class: bool,
    /// Something was said that the control does not have, under whatever name.
    pub is_noticed: bool,
    /// Something else was named, and is no other name for it.
    pub is_misled: bool,
    /// Error of its main number and standard deviation, both over its size; where it was named and its size is plain.
    pub error: Option<(f64, f64)>,
    found: String,
}

/// A case and what was said of it.
pub struct Judged {
    /// The change over what the ordinary car leaves, rms, in the channel where it is largest.
    pub strength: f64,
    /// How probably `--sensitivity` says of the unchanged drive that this is named.
    pub predicted: Option<f64>,
    pub alone: Said,
    pub beside: Option<Said>,
}

impl fmt::Display for Said {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let named = match self.place {
            Some(0) => "first",
            _ if self.is_in_class => "class",
            Some(_) => "yes",
            None if self.is_noticed => "noticed",
            None => "no",
        };
        write!(f, "{named} | {}", self.found)
    }
}

impl fmt::Display for Judged {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{:.2} | {:.2} | {}", self.strength, self.predicted.unwrap_or(f64::NAN), self.alone)?;
        self.beside.as_ref().map_or(Ok(()), |beside| write!(f, " | {beside}"))
    }
}

/// Compares the answer to a changed drive with that to the unchanged one.
pub fn judge(case: &Case, changed: &Value, control: &Value) -> Said {
    let [found, known] = [changed, control].map(found_in);
    let new: Vec<&Found> =
        found.iter().filter(|one| known.iter().all(|other| is_other(one, other))).collect();
    let is_it = |one: &Found| is_of(case, &one.effect, one.channel.as_deref());
    let is_alike = |one: &Found| {
        one.alike.len() <= 2
            && one.alike.iter().any(|name| {
                let (effect, channel) =
                    name.split_once(':').map_or((name.as_str(), None), |(a, b)| (a, Some(b)));
                effect == case.effect.name && (channel.is_none() || channel == case.effect.channel)
            })
    };
    let place = new.iter().position(|one| is_it(one));
    let verdict = |answer: &Value| answer["verdict"].as_str().map(str::to_owned);
    let is_unknown = |answer: &Value| verdict(answer).as_deref() == Some("unknown_physics");
    let error = place.and_then(|place| {
        let expected = case.expected()?;
        let (value, std) = main_number(case, new[place])?;
        Some(((value - expected) / expected.abs(), std / expected.abs()))
    });
    Said {
        place,
        is_in_class: new.first().is_some_and(|one| is_it(one) || is_alike(one)),
        is_noticed: !new.is_empty() || is_unknown(changed) && !is_unknown(control),
        is_misled: new.first().is_some_and(|one| one.kind != "ordinary" && !is_it(one) && !is_alike(one)),
        error,
        found: new.into_iter().map(told).collect::<Vec<_>>().join("; "),
    }
}

fn is_of(case: &Case, effect: &str, channel: Option<&str>) -> bool {
    effect == case.effect.name && channel == case.effect.channel
}

/// Of the two wheels of an axle one is as much too small as the other is too large.
fn main_number(case: &Case, found: &Found) -> Option<(f64, f64)> {
    let key = case.effect.number;
    let other = key.replace("_rl", "_rr");
    match found.numbers.get(key) {
        None if other != key => found.numbers.get(&other).map(|(value, std)| (-value, *std)),
        number => number.copied(),
    }
}

/// Is it another effect, or the same of another size?
fn is_other(one: &Found, other: &Found) -> bool {
    if (&one.effect, &one.channel) != (&other.effect, &other.channel) {
        return true;
    }
    one.numbers.iter().any(|(name, (value, std))| match other.numbers.get(name) {
        Some((before, deviation)) => (value - before).abs() > 2.0 * std.hypot(*deviation),
        None => true,
    })
}

/// The findings of an answer.
pub fn found_in(answer: &Value) -> Vec<Found> {
    let word = |value: &Value| value.as_str().unwrap_or_default().to_owned();
    let of = |finding: &Value| {
        let numbers = finding["parameters"].as_object().into_iter().flatten().filter_map(|(name, number)| {
            Some((name.clone(), (number["value"].as_f64()?, number["std"].as_f64()?)))
        });
        Found {
            effect: word(&finding["effect"]),
            channel: finding["channel"].as_str().map(str::to_owned),
            kind: word(&finding["kind"]),
            alike: finding["indistinguishable_from"].as_array().into_iter().flatten().map(word).collect(),
            numbers: numbers.collect(),
        }
    };
    answer["findings"].as_array().into_iter().flatten().map(of).collect()
}

/// In words.
pub fn told(found: &Found) -> String {
    let channel = found.channel.as_ref().map_or(String::new(), |channel| format!(" of {channel}"));
    let numbers = found.numbers.iter().map(|(name, (value, std))| format!("{name} {value:.4} ± {std:.4}"));
    let alike =
        if found.alike.is_empty() { String::new() } else { format!("; or {}", found.alike.join(", ")) };
    let numbers = numbers.collect::<Vec<_>>().join(", ");
    format!("{}{channel} ({}; {numbers}{alike})", found.effect, found.kind)
}
