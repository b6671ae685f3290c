//! What was found, and whether it is what was put in.

use std::fmt;

use serde_json::Value;

use super::plan::Case;
use crate::found::{Found, findings, is_other, told};

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

impl Said {
    /// By its name, or in a class with that.
    pub fn is_named(&self) -> bool {
        self.place.is_some() || self.is_in_class
    }
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
    let [found, known] = [changed, control].map(findings);
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
