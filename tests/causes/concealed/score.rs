//! One answer against its truth: the credits of `shared/trials/score.py`, and what that script does not look at.
//!
//! Credit: *named* = the first finding is the hidden cause; *class* also takes the names that no test could tell apart
//! from it on that very recording; *first three* looks at the findings, then at the ranking. Delays of single wheel
//! speeds exist in every recording and are not counted.

use std::collections::BTreeMap;

use serde_json::{Map, Value};

use super::cause::{CAUSES, Sort};
use super::visible::DETECTABLE;

/// What became of one ordinary parameter between the plain and the extended model.
#[derive(Clone, Debug)]
pub struct Moved {
    pub name: &'static str,
    /// |error| over the stated standard deviation, before and after.
    pub before: f64,
    pub after: f64,
    /// Whether its error became smaller.
    pub closer: bool,
}

/// One parameter of the effect: true, stated, stated standard deviation.
#[derive(Clone, Debug)]
pub struct Stated {
    pub name: String,
    pub truth: f64,
    pub value: f64,
    pub std: f64,
}

impl Stated {
    pub fn within(&self, stds: f64) -> bool {
        (self.value - self.truth).abs() <= stds * self.std
    }
}

/// One recording's score.
#[derive(Clone, Debug)]
pub struct Score {
    pub name: String,
    pub kind: String,
    /// `control` where nothing is hidden.
    pub cause: String,
    /// Whether no library has it.
    pub outside: bool,
    pub factor: f64,
    pub likelihood_ratio: Option<f64>,
    pub verdict: String,
    /// Names, best first: the findings, then the ranking.
    pub order: Vec<String>,
    /// How many of these are findings.
    pub findings: usize,
    pub named: bool,
    pub class: bool,
    pub in_three: bool,
    pub whole_recording: bool,
    pub overlap: Option<f64>,
    /// Mean held-out fit of the plain and of the extended model, per cent.
    pub fit: Option<(f64, f64)>,
    /// Whether the interval of the held-out improvement is above zero for at least one channel.
    pub certain: Option<bool>,
    pub stated: Vec<Stated>,
    pub moved: Vec<Moved>,
    pub seconds: Option<f64>,
    /// Of each of several causes: is it among the findings?
    pub found: Vec<bool>,
    /// Every finding: how probable it is said to be, whether it is right, whether every car has it.
    pub said_of: Vec<Said>,
}

/// One finding.
#[derive(Clone, Copy, Debug)]
pub struct Said {
    pub probability: f64,
    pub is_right: bool,
    pub is_ordinary: bool,
}

impl Score {
    /// Whether physics was said to be missing, and which.
    pub fn said(&self) -> bool {
        self.verdict == "missing_physics"
    }

    pub fn missed(&self) -> bool {
        self.verdict == "adequate"
    }

    pub fn called_unknown(&self) -> bool {
        self.verdict == "unknown_physics"
    }

    /// Whether a wrong thing was named.
    pub fn wrong(&self) -> bool {
        self.said() && !self.class
    }

    /// Whether a law was told first, which has a place and a form and claims no mechanism.
    pub fn told_as_a_law(&self) -> bool {
        self.said() && self.order.first().is_some_and(|first| first == "law")
    }

    /// Whether something was announced where there is nothing to find.
    pub fn false_alarm(&self) -> bool {
        self.called_unknown() || self.said() && !self.named
    }

    /// Whether there is a hidden cause that a perfect test would see on this recording.
    pub fn visible(&self) -> bool {
        matches!(self.kind.as_str(), "library" | "everything" | "unknown")
            && self.likelihood_ratio.is_none_or(|ratio| ratio >= DETECTABLE)
    }

    /// What was said first: an effect, or the verdict.
    pub fn first(&self) -> &str {
        if self.said() { self.order.first().map_or("", String::as_str) } else { &self.verdict }
    }
}

/// The name of a finding or of a candidate: `effect`, or `effect:channel` of a sensor.
fn key(finding: &Value) -> String {
    let effect = finding["effect"].as_str().unwrap_or_default();
    match finding["channel"].as_str() {
        Some(channel) if effect.starts_with("sensor") || effect == "channel_swap" => {
            format!("{effect}:{channel}")
        }
        _ => effect.to_owned(),
    }
}

fn counted(finding: &Value) -> bool {
    let of_a_wheel = finding["channel"].as_str().is_some_and(|c| c.starts_with("wheel_speed"));
    finding["effect"] != "sensor_delay" || !of_a_wheel
}

fn list(value: &Value) -> &[Value] {
    value.as_array().map_or(&[], Vec::as_slice)
}

fn names(value: &Value) -> Vec<&str> {
    list(value).iter().filter_map(Value::as_str).collect()
}

fn intervals(value: &Value) -> Option<Vec<(f64, f64)>> {
    let pairs = value.as_array()?.iter();
    pairs.map(|pair| Some((pair.get(0)?.as_f64()?, pair.get(1)?.as_f64()?))).collect()
}

/// Intersection over union of two sets of intervals on a grid of 50 ms.
pub fn overlap(one: &[(f64, f64)], two: &[(f64, f64)], seconds: f64) -> f64 {
    const GRID: f64 = 0.05;
    let n = (seconds / GRID) as usize + 1;
    let mark = |set: &[(f64, f64)]| {
        let mut marks = vec![false; n];
        for (from, to) in set {
            let (from, to) = ((from / GRID).max(0.0) as usize, ((to / GRID).max(0.0) as usize + 1).min(n));
            marks[from.min(to)..to].fill(true);
        }
        marks
    };
    let (one, two) = (mark(one), mark(two));
    let pairs = || one.iter().zip(&two);
    let either = pairs().filter(|(a, b)| **a || **b).count();
    let both = pairs().filter(|(a, b)| **a && **b).count();
    if either == 0 { 1.0 } else { both as f64 / either as f64 }
}

/// Means over the channels that both models report.
fn held_out(fit: &Value) -> Option<(f64, f64)> {
    let (before, after) = (fit["baseline"]["holdout"].as_object()?, fit["extended"]["holdout"].as_object()?);
    let both: Vec<(f64, f64)> =
        before.iter().filter_map(|(channel, b)| Some((b.as_f64()?, after.get(channel)?.as_f64()?))).collect();
    let n = both.len() as f64;
    (n > 0.0).then(|| (both.iter().map(|p| p.0).sum::<f64>() / n, both.iter().map(|p| p.1).sum::<f64>() / n))
}

/// The ordinary parameters of the truth, in the names of the car file and of the answer.
fn ordinary(truth: &Value) -> Vec<(&'static str, f64)> {
    let of = |key: &str| truth["true_parameters"][key].as_f64();
    let (Some(m), Some(a), Some(b)) = (of("m"), of("a"), of("b")) else { return Vec::new() };
    let weight = m * super::car::G;
    let found = [
        ("mass_kg", Some(m)),
        ("cg_to_front_m", Some(a)),
        ("yaw_inertia_kgm2", of("Iz")),
        ("wheel_radius_m", of("R")),
        ("wheel_inertia_kgm2", of("J")),
        ("steering_ratio", of("ratio")),
        ("longitudinal_stiffness", of("Ck").map(|k| k / (weight / 4.0))),
        ("lateral_stiffness_front", of("Cf").map(|c| c * (a + b) / (weight * b))),
        ("lateral_stiffness_rear", of("Cr").map(|c| c * (a + b) / (weight * a))),
        ("friction", of("inv_mu").map(|i| 1.0 / i)),
        // The practice set means the angle that is to be added to the reading.
        ("steering_wheel_angle_offset", of("off_sw").filter(|_| truth["source"] == "momentum")),
        ("yaw_rate_offset", of("off_r")),
        ("lateral_acceleration_offset", of("off_ay")),
        ("longitudinal_acceleration_offset", of("off_ax")),
    ];
    found.into_iter().filter_map(|(name, value)| Some((name, value?))).collect()
}

fn moved(truth: &Value, parameters: &Value) -> Vec<Moved> {
    let error = |which: &str, name: &str, truth: f64| -> Option<(f64, f64)> {
        let stated = &parameters[which][name];
        let (value, std) = (stated["value"].as_f64()?, stated["std"].as_f64()?);
        (std > 0.0).then(|| ((value - truth).abs(), (value - truth).abs() / std))
    };
    ordinary(truth)
        .into_iter()
        .filter_map(|(name, value)| {
            let (before, after) = (error("baseline", name, value)?, error("extended", name, value)?);
            Some(Moved { name, before: before.1, after: after.1, closer: after.0 < before.0 })
        })
        .collect()
}

fn stated(truth: &Value, finding: &Value) -> Vec<Stated> {
    let Some(truths) = truth["true_effect"].as_object() else { return Vec::new() };
    truths
        .iter()
        .filter_map(|(name, value)| {
            let given = &finding["parameters"][name];
            let (truth, value, std) = (value.as_f64()?, given["value"].as_f64()?, given["std"].as_f64()?);
            Some(Stated { name: name.clone(), truth, value, std })
        })
        .collect()
}

/// Scores one answer; `None` where the program gave none.
pub fn score(name: &str, truth: &Value, answer: Option<&Value>, seconds: Option<f64>) -> Score {
    let nothing = Value::Null;
    let answer = answer.unwrap_or(&nothing);
    let findings: Vec<&Value> = list(&answer["findings"]).iter().filter(|f| counted(f)).collect();
    let mut verdict = answer["verdict"].as_str().unwrap_or("none given").to_owned();
    if verdict == "missing_physics" && findings.is_empty() {
        verdict = "adequate".into();
    }
    let mut order: Vec<String> = findings.iter().map(|f| key(f)).collect();
    for candidate in list(&answer["ranking"]).iter().filter(|f| counted(f)) {
        let candidate = key(candidate);
        if !order.contains(&candidate) {
            order.push(candidate);
        }
    }
    let accept = names(&truth["accept"]);
    let fair = [accept.clone(), names(&truth["fair"])].concat();
    let said = verdict == "missing_physics";
    let first = order.first().map(String::as_str).filter(|_| said);
    let kind = truth["kind"].as_str().unwrap_or_default().to_owned();

    let announced = list(&answer["findings"]).first();
    let place = announced.map(|f| &f["where"]).filter(|w| w.as_object().is_some_and(|o| !o.is_empty()));
    let place = place.unwrap_or(&answer["where"]);
    let true_intervals = intervals(&truth["intervals"]).unwrap_or_default();
    let overlap = match intervals(&place["intervals"]) {
        Some(found) if kind != "control" && !true_intervals.is_empty() => {
            Some(overlap(&found, &true_intervals, truth["seconds"].as_f64().unwrap_or(0.0)))
        }
        _ => None,
    };
    let improvement = answer["improvement_ci95"].as_object().filter(|channels| !channels.is_empty());
    let right = findings.iter().find(|f| accept.contains(&key(f).as_str()));
    let of_causes: Vec<Vec<&str>> = match list(&truth["causes"]) {
        [] => vec![fair.clone()],
        several => several.iter().map(|one| [names(&one["accept"]), names(&one["fair"])].concat()).collect(),
    };
    let is_right = |finding: &&&Value| of_causes.iter().any(|of| of.contains(&key(finding).as_str()));
    let said_of = findings.iter().map(|finding| Said {
        probability: finding["probability"].as_f64().unwrap_or(f64::NAN),
        is_right: is_right(&finding),
        is_ordinary: finding["kind"] == "ordinary",
    });
    let is_found = |of: &Vec<&str>| findings.iter().any(|finding| of.contains(&key(finding).as_str()));
    let outside =
        kind == "unknown" || CAUSES.iter().any(|c| c.sort == Sort::Unknown && truth["cause"] == c.key);
    Score {
        outside,
        name: name.to_owned(),
        cause: truth["cause"].as_str().unwrap_or("control").to_owned(),
        factor: truth["factor"].as_f64().unwrap_or(1.0),
        likelihood_ratio: truth["likelihood_ratio_of_truth"].as_f64(),
        findings: findings.len(),
        named: first.is_some_and(|f| accept.contains(&f)),
        class: first.is_some_and(|f| fair.contains(&f)),
        in_three: said && order.iter().take(3).any(|f| fair.contains(&f.as_str())),
        found: of_causes.iter().map(is_found).collect(),
        said_of: said_of.collect(),
        whole_recording: truth["whole_recording"].as_bool().unwrap_or(false),
        overlap,
        fit: held_out(&answer["fit"]),
        certain: improvement.map(|c| c.values().any(|i| i[0].as_f64().is_some_and(|low| low > 0.0))),
        stated: right.filter(|_| said).map(|finding| stated(truth, finding)).unwrap_or_default(),
        moved: moved(truth, &answer["parameters"]),
        seconds,
        kind,
        verdict,
        order,
    }
}

/// The lines `score.py` prints: mean and count of each credit.
pub fn totals(scores: &[Score]) -> BTreeMap<String, (f64, usize)> {
    let mut lists: BTreeMap<String, Vec<f64>> = BTreeMap::new();
    let mut add = |name: String, value: f64| lists.entry(name).or_default().push(value);
    let truth = |yes: bool| f64::from(u8::from(yes));
    for s in scores {
        match s.kind.as_str() {
            kind @ ("library" | "everything") => {
                add(format!("{kind}: named"), truth(s.named));
                add(format!("{kind}: class named"), truth(s.class));
                add(format!("{kind}: class in top 3"), truth(s.in_three));
                add(format!("{kind}: missed (adequate)"), truth(s.missed()));
                add(format!("{kind}: called unknown"), truth(s.called_unknown()));
                if s.said() {
                    if kind == "library" {
                        add("library: more than one finding".into(), truth(s.findings > 1));
                    }
                    if let Some((before, after)) = s.fit {
                        add("held-out fit improved".into(), truth(after > before));
                        add("held-out gain, points".into(), after - before);
                    }
                }
            }
            "unknown" => {
                add("outside the library: called unknown".into(), truth(s.called_unknown() || s.named));
                add("outside the library: wrongly named".into(), truth(s.said() && !s.named));
                add("outside the library: missed".into(), truth(s.missed()));
            }
            "several" => {}
            _ => add("nothing to find: false alarm".into(), truth(s.false_alarm())),
        }
        if let Some(share) = s.overlap {
            let which = if s.whole_recording { "effects present throughout" } else { "local effects" };
            add(format!("overlap, {which}"), share);
        }
    }
    let mean = |list: Vec<f64>| (list.iter().sum::<f64>() / list.len() as f64, list.len());
    lists.into_iter().map(|(name, list)| (name, mean(list))).collect()
}

/// Scores a whole set with the answers of a folder; seconds as `program.rs` left them.
pub fn all(truths: &Map<String, Value>, answers: &std::path::Path) -> Vec<Score> {
    let read = |file: String| -> Option<Value> {
        serde_json::from_str(&std::fs::read_to_string(answers.join(file)).ok()?).ok()
    };
    truths
        .iter()
        .map(|(name, truth)| {
            let seconds = read(format!("runs/{name}.json")).and_then(|run| run["seconds"].as_f64());
            score(name, truth, read(format!("{name}.json")).as_ref(), seconds)
        })
        .collect()
}
