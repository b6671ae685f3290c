//! The table of a scored set.

use std::collections::BTreeMap;

use serde_json::{Map, Value, json};

use super::part::{Cell, Part, full, joined, mean, median, text};
use super::score::{self, Score};
use super::share::Share;
use super::visible::DETECTABLE;

/// A true cause of the library, loud enough or not.
fn in_library(s: &Score) -> bool {
    s.kind == "library" || s.kind == "everything"
}

/// A hidden cause too weak to be seen, however it is called.
fn too_weak(s: &Score) -> bool {
    s.cause != "control" && !s.visible()
}

fn totals(scores: &[Score]) -> Part {
    let library = || scores.iter().filter(|s| in_library(s) && s.visible());
    let ordinary = || library().filter(|s| s.factor >= 1.0);
    let unknown = || scores.iter().filter(|s| s.kind == "unknown");
    let controls = || scores.iter().filter(|s| s.kind == "control");
    let weak = || scores.iter().filter(|s| too_weak(s));
    let said = || library().filter(|s| s.said());
    let right = || library().filter(|s| s.class);
    let row = |name: &str, share: Share| joined([vec![text(name)], full(share)]);
    Part {
        key: "totals",
        heading: format!(
            "Totals ({} recordings; visible: 2 ln LR of the truth at least {DETECTABLE})",
            scores.len()
        ),
        columns: vec!["what", "n", "%", "Wilson 95 %"],
        rows: vec![
            row("library, visible: cause named first", Share::of(library(), |s| s.named)),
            row("library, visible: class named first", Share::of(library(), |s| s.class)),
            row("library, visible: class in the first three", Share::of(library(), |s| s.in_three)),
            row("library, visible: missed (adequate)", Share::of(library(), |s| s.missed())),
            row("library, visible: called unknown", Share::of(library(), |s| s.called_unknown())),
            row("library, visible: something else named", Share::of(library(), |s| s.wrong())),
            row(
                "library, visible, class named: more than one finding",
                Share::of(right(), |s| s.findings > 1),
            ),
            row("library, ordinary strength: cause named first", Share::of(ordinary(), |s| s.named)),
            row("library, ordinary strength: class named first", Share::of(ordinary(), |s| s.class)),
            row(
                "library, ordinary strength: class in the first three",
                Share::of(ordinary(), |s| s.in_three),
            ),
            row(
                "outside the library: called unknown",
                Share::of(unknown(), |s| s.called_unknown() || s.named),
            ),
            row("outside the library: told as a law", Share::of(unknown(), Score::told_as_a_law)),
            row(
                "outside the library: wrongly named",
                Share::of(unknown(), |s| s.said() && !s.named && !s.told_as_a_law()),
            ),
            row("outside the library: missed (adequate)", Share::of(unknown(), |s| s.missed())),
            row("controls: false alarms", Share::of(controls(), |s| s.false_alarm())),
            row("too weak to be seen: false alarm", Share::of(weak(), |s| s.false_alarm())),
            row("too weak to be seen: named rightly all the same", Share::of(weak(), |s| s.named)),
            row(
                "something named: held-out fit better",
                Share::of(said().filter_map(|s| s.fit), |(before, after)| after > before),
            ),
            row(
                "something named: interval of the improvement above zero for a channel",
                Share::of(said().filter_map(|s| s.certain), |certain| certain),
            ),
            row(
                "cause named: its parameters within 2 std",
                Share::of(library().flat_map(|s| &s.stated), |p| p.within(2.0)),
            ),
            row("no answer", Share::of(scores, |s| s.verdict == "none given")),
        ],
    }
}

fn by_cause<'a>(scores: impl Iterator<Item = &'a Score>) -> BTreeMap<&'a str, Vec<&'a Score>> {
    let mut map: BTreeMap<&str, Vec<&Score>> = BTreeMap::new();
    scores.for_each(|s| map.entry(&s.cause).or_default().push(s));
    map
}

fn effects(scores: &[Score]) -> Part {
    let row = |(cause, list): (&str, Vec<&Score>)| {
        let share = |has: fn(&Score) -> bool| Cell::Share(Share::of(&list, |s| has(s)));
        let said = || list.iter().filter(|s| s.said());
        vec![
            text(cause),
            Cell::Number(Some(list.len() as f64), 0),
            share(|s| s.named),
            share(|s| s.class),
            share(|s| s.in_three),
            share(|s| s.missed()),
            share(|s| s.called_unknown()),
            Cell::Share(Share::of(said().filter_map(|s| s.fit), |(before, after)| after > before)),
            Cell::Share(Share::of(said().filter_map(|s| s.certain), |certain| certain)),
            Cell::Share(Share::of(list.iter().flat_map(|s| &s.stated), |p| p.within(2.0))),
            Cell::Number(mean(list.iter().filter_map(|s| s.overlap)), 2),
        ]
    };
    Part {
        key: "effects",
        heading: "Causes of the library where they are visible".into(),
        columns: vec![
            "hidden cause",
            "n",
            "named first",
            "class named",
            "in first three",
            "missed",
            "called unknown",
            "held-out better",
            "interval > 0",
            "parameter ≤ 2 std",
            "IoU",
        ],
        rows: by_cause(scores.iter().filter(|s| in_library(s) && s.visible())).into_iter().map(row).collect(),
    }
}

/// Cause against what was said first: `a 3, b 1`.
fn confusion(scores: &[Score], key: &'static str, heading: &str, chosen: impl Fn(&Score) -> bool) -> Part {
    let row = |(cause, list): (&str, Vec<&Score>)| {
        let mut said: BTreeMap<&str, usize> = BTreeMap::new();
        list.iter().for_each(|s| *said.entry(s.first()).or_default() += 1);
        let mut said: Vec<_> = said.into_iter().collect();
        said.sort_by(|a, b| b.1.cmp(&a.1).then(a.0.cmp(b.0)));
        let said: Vec<String> = said.into_iter().map(|(name, n)| format!("{name} {n}")).collect();
        vec![text(cause), Cell::Number(Some(list.len() as f64), 0), text(said.join(", "))]
    };
    Part {
        key,
        heading: heading.into(),
        columns: vec!["hidden", "n", "said first"],
        rows: by_cause(scores.iter().filter(|s| chosen(s))).into_iter().map(row).collect(),
    }
}

/// How often what is hidden is found, over how strong or how visible it is: `level` gives a place and a name.
fn power(
    scores: &[Score],
    key: &'static str,
    heading: &str,
    level: impl Fn(&Score) -> Option<(i64, String)>,
) -> Part {
    let mut levels: BTreeMap<(i64, String), Vec<&Score>> = BTreeMap::new();
    for s in scores.iter().filter(|s| s.cause != "control") {
        if let Some(level) = level(s) {
            levels.entry(level).or_default().push(s);
        }
    }
    let row = |((_, level), list): ((i64, String), Vec<&Score>)| {
        let known = || list.iter().filter(|s| !s.outside);
        let outside = || list.iter().filter(|s| s.outside);
        joined([
            vec![text(level)],
            full(Share::of(known(), |s| s.class)),
            vec![
                Cell::Share(Share::of(known(), |s| s.said() || s.called_unknown())),
                Cell::Share(Share::of(known(), |s| s.wrong())),
                Cell::Share(Share::of(outside(), |s| s.called_unknown())),
                Cell::Share(Share::of(outside(), |s| s.said())),
            ],
        ])
    };
    Part {
        key,
        heading: heading.into(),
        columns: vec![
            "at",
            "class named",
            "%",
            "Wilson 95 %",
            "anything announced",
            "something else named",
            "outside the library: called unknown",
            "outside: named",
        ],
        rows: levels.into_iter().map(row).collect(),
    }
}

fn strength(s: &Score) -> Option<(i64, String)> {
    let there = !s.cause.ends_with("_within_doubt");
    there.then(|| ((-1000.0 * s.factor) as i64, s.factor.to_string()))
}

fn visibility(s: &Score) -> Option<(i64, String)> {
    let edges = [10, 50, 200, 1000, 10_000, 100_000];
    let ratio = s.likelihood_ratio?;
    let place = edges.iter().take_while(|edge| ratio >= f64::from(**edge)).count();
    let name = match place {
        0 => format!("below {}", edges[0]),
        _ if place == edges.len() => format!("above {}", edges[place - 1]),
        _ => format!("{} – {}", edges[place - 1], edges[place]),
    };
    Some((place as i64, name))
}

fn ordinary(scores: &[Score]) -> Part {
    let lists: [(&str, Vec<&Score>); 2] = [
        ("the cause's class named", scores.iter().filter(|s| in_library(s) && s.class).collect()),
        ("something else named", scores.iter().filter(|s| in_library(s) && s.wrong()).collect()),
    ];
    let mut rows = Vec::new();
    for (which, list) in lists {
        let mut names: Vec<&str> = list.iter().flat_map(|s| &s.moved).map(|m| m.name).collect();
        names.sort_unstable();
        names.dedup();
        for name in std::iter::once("all").chain(names) {
            let moved =
                || list.iter().flat_map(|s| &s.moved).filter(move |m| name == "all" || m.name == name);
            let within = |z: fn(&score::Moved) -> f64| Cell::Share(Share::of(moved(), |m| z(m) <= 2.0));
            rows.push(vec![
                text(which),
                text(name),
                Cell::Share(Share::of(moved(), |m| m.closer)),
                Cell::Number(mean(moved().map(|m| m.before)), 2),
                Cell::Number(mean(moved().map(|m| m.after)), 2),
                Cell::Number(median(moved().map(|m| m.before)), 2),
                Cell::Number(median(moved().map(|m| m.after)), 2),
                within(|m| m.before),
                within(|m| m.after),
            ]);
        }
    }
    Part {
        key: "ordinary_parameters",
        heading: "Ordinary parameters: plain model → extended model, against the truth".into(),
        columns: vec![
            "where",
            "parameter",
            "closer to the truth",
            "mean error/std before",
            "mean after",
            "median before",
            "median after",
            "≤ 2 std before",
            "≤ 2 std after",
        ],
        rows,
    }
}

fn time(scores: &[Score]) -> Part {
    let seconds = || scores.iter().filter_map(|s| s.seconds);
    let most = seconds().fold(None, |m: Option<f64>, x| Some(m.map_or(x, |m| m.max(x))));
    Part {
        key: "seconds",
        heading: "Seconds for one recording, as run here".into(),
        columns: vec!["recordings", "median", "mean", "most"],
        rows: vec![vec![
            Cell::Number(Some(seconds().count() as f64), 0),
            Cell::Number(median(seconds()), 1),
            Cell::Number(mean(seconds()), 1),
            Cell::Number(most, 1),
        ]],
    }
}

/// Every recording that was not answered as it should.
fn failures(scores: &[Score]) -> Part {
    let right = |s: &Score| match s.kind.as_str() {
        "library" | "everything" => s.class,
        "unknown" => s.called_unknown() || s.named,
        "several" => s.found.iter().all(|found| *found),
        _ => !s.false_alarm(),
    };
    let row = |s: &Score| {
        let first: Vec<&str> = s.order.iter().take(3).map(String::as_str).collect();
        vec![
            text(&s.name),
            text(&s.kind),
            text(&s.cause),
            Cell::Number(Some(s.factor), 2),
            Cell::Number(s.likelihood_ratio, 0),
            text(&s.verdict),
            text(first.join(", ")),
        ]
    };
    Part {
        key: "failures",
        heading: "Not answered as it should".into(),
        columns: vec!["recording", "kind", "hidden", "×", "2 ln LR", "verdict", "first three"],
        rows: scores.iter().filter(|s| !right(s)).map(row).collect(),
    }
}

/// All parts.
pub fn parts(scores: &[Score]) -> Vec<Part> {
    vec![
        totals(scores),
        effects(scores),
        power(scores, "power_over_factor", "Power over the strength (1 is ordinary)", strength),
        power(scores, "power_over_visibility", "Power over the visible 2 ln LR", visibility),
        confusion(scores, "confusion_visible", "Said first, where the cause is visible", Score::visible),
        confusion(
            scores,
            "confusion_too_weak",
            "Said first, where the cause is too weak to be seen",
            too_weak,
        ),
        confusion(scores, "confusion_controls", "Said first, where nothing is hidden", |s| {
            s.kind == "control"
        }),
        ordinary(scores),
        time(scores),
        failures(scores),
    ]
}

/// As JSON: every part as a list of rows, the credits as `score.py` counts them, and every recording.
pub fn json(parts: &[Part], scores: &[Score]) -> Value {
    let mut all: Map<String, Value> = parts.iter().map(|part| (part.key.to_owned(), part.json())).collect();
    let credits = score::totals(scores);
    all.insert(
        "credits".into(),
        credits.into_iter().map(|(name, (mean, n))| (name, json!({ "mean": mean, "n": n }))).collect(),
    );
    let recordings = scores.iter().map(|s| {
        let stated: Vec<Value> = s
            .stated
            .iter()
            .map(|p| json!({ "name": p.name, "truth": p.truth, "value": p.value, "std": p.std }))
            .collect();
        let recording = json!({
            "kind": s.kind, "cause": s.cause, "factor": s.factor, "likelihood_ratio": s.likelihood_ratio,
            "verdict": s.verdict, "first": s.order.iter().take(3).collect::<Vec<_>>(), "findings": s.findings,
            "named": s.named, "class": s.class, "overlap": s.overlap, "fit": s.fit, "certain": s.certain,
            "parameters": stated, "seconds": s.seconds,
        });
        (s.name.clone(), recording)
    });
    all.insert("recordings".into(), Value::Object(recordings.collect()));
    Value::Object(all)
}
