//! Findings of an answer, and what was put in among them. What the control has as well was not put in.

use std::collections::BTreeMap;

use serde_json::Value;

/// A finding, as far as it is looked at.
pub struct Found {
    pub effect: String,
    pub channel: Option<String>,
    pub kind: String,
    /// Other names for the same, on this drive.
    pub alike: Vec<String>,
    pub numbers: BTreeMap<String, (f64, f64)>,
}

impl Found {
    /// Its effect, with the quantity it is of.
    pub fn name(&self) -> String {
        self.channel.as_ref().map_or_else(|| self.effect.clone(), |of| format!("{}:{of}", self.effect))
    }
}

/// What was found besides what the control has, and where the effect stands among that.
pub fn judged(changed: &Value, control: &Value) -> (String, Option<usize>) {
    let [found, known] = [changed, control].map(|answer| findings(&answer["explained"]));
    let new: Vec<&Found> =
        found.iter().filter(|one| known.iter().all(|other| is_other(one, other))).collect();
    let truth = &changed["truth"]["effects"][0];
    let is_it =
        |one: &&Found| truth["effect"] == one.effect && truth["channel"].as_str() == one.channel.as_deref();
    let place = new.iter().position(is_it);
    (new.into_iter().map(told).collect::<Vec<_>>().join("; "), place)
}

/// How large the change is in the channel where it is largest beside what the ordinary car leaves there.
pub fn strength(truth: &Value) -> f64 {
    let channels = truth["channels"].as_object().into_iter().flatten();
    channels.filter_map(|(_, channel)| channel["strength"].as_f64()).fold(0.0, f64::max)
}

/// Is it another effect, or the same of another size?
pub fn is_other(one: &Found, other: &Found) -> bool {
    if (&one.effect, &one.channel) != (&other.effect, &other.channel) {
        return true;
    }
    one.numbers.iter().any(|(name, (value, std))| match other.numbers.get(name) {
        Some((before, deviation)) => (value - before).abs() > 2.0 * std.hypot(*deviation),
        None => true,
    })
}

/// What an answer has found.
pub fn findings(explained: &Value) -> Vec<Found> {
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
    explained["findings"].as_array().into_iter().flatten().map(of).collect()
}

/// How well the yaw rate is predicted on held-out driving, %, by the plain model and by the extended one, in a cell of a table.
pub fn held_out(explained: &Value) -> String {
    let fit = |of: &str| explained["fit"][of]["holdout"]["yaw_rate"].as_f64().unwrap_or(f64::NAN);
    format!("{:.1} → {:.1}", fit("baseline"), fit("extended"))
}

/// A finding in a cell of a table.
pub fn told(found: &Found) -> String {
    let channel = found.channel.as_ref().map_or(String::new(), |channel| format!(" of {channel}"));
    let numbers = found.numbers.iter().map(|(name, (value, std))| format!("{name} {value:.4} ± {std:.4}"));
    let alike =
        if found.alike.is_empty() { String::new() } else { format!("; or {}", found.alike.join(", ")) };
    let numbers = numbers.collect::<Vec<_>>().join(", ");
    format!("{}{channel} ({}; {numbers}{alike})", found.effect, found.kind)
}
