//! The scorer against constructed answers, and against `shared/trials/score.py` on thousands of them.

use std::path::{Path, PathBuf};
use std::process::Command;

use serde_json::{Map, Value, json};

use super::dice::Dice;
use super::part;
use super::score::{self, Score, overlap, score};
use super::table;

fn truth(kind: &str, cause: &str, ratio: f64) -> Value {
    json!({
        "kind": kind, "cause": cause, "accept": if kind == "unknown" { json!([]) } else { json!([cause]) },
        "fair": ["sensor_scale:lateral_acceleration"], "intervals": [[10.0, 20.0]], "whole_recording": false,
        "seconds": 100.0, "factor": 1.0, "likelihood_ratio_of_truth": ratio,
        "true_effect": { "roll_gain_rad_per_mps2": 0.006 },
        "true_parameters": { "m": 1500.0, "a": 1.0, "b": 1.5, "Cf": 100_000.0, "Ck": 40_000.0, "off_r": 0.001 },
    })
}

fn answer(verdict: &str, findings: &[(&str, Option<&str>)], ranking: &[(&str, Option<&str>)]) -> Value {
    let entry = |(effect, channel): &(&str, Option<&str>)| json!({ "effect": effect, "channel": channel });
    json!({
        "verdict": verdict, "findings": findings.iter().map(entry).collect::<Vec<_>>(),
        "ranking": ranking.iter().map(entry).collect::<Vec<_>>(),
    })
}

fn judged(kind: &str, cause: &str, answer: &Value) -> Score {
    score("trial_1", &truth(kind, cause, 500.0), Some(answer), None)
}

#[test]
fn the_first_finding_counts_and_its_class() {
    let accelerometer = Some("lateral_acceleration");
    let s = judged("library", "body_roll", &answer("missing_physics", &[("body_roll", None)], &[]));
    assert!(s.named && s.class && s.in_three && !s.wrong() && s.first() == "body_roll");
    let s =
        judged("library", "body_roll", &answer("missing_physics", &[("sensor_scale", accelerometer)], &[]));
    assert!(!s.named && s.class && s.in_three && !s.wrong());
    let second = &[("air_drag", None), ("body_roll", None)];
    let s = judged("library", "body_roll", &answer("missing_physics", second, &[]));
    assert!(!s.named && !s.class && s.in_three && s.wrong() && s.findings == 2);
    // The ranking fills up to three, without names that are there already.
    let ranking = &[("air_drag", None), ("cg_shift", None), ("body_roll", None), ("payload", None)];
    let s = judged("library", "body_roll", &answer("missing_physics", &[("air_drag", None)], ranking));
    assert!(s.in_three && s.order == ["air_drag", "cg_shift", "body_roll", "payload"]);
    let s = judged("library", "body_roll", &answer("adequate", &[], &[("body_roll", None)]));
    assert!(!s.named && !s.in_three && s.missed() && s.first() == "adequate");
    let s = judged("library", "body_roll", &answer("insufficient_excitation", &[], &[]));
    assert!(!s.missed() && !s.called_unknown() && s.first() == "insufficient_excitation");
}

#[test]
fn a_channel_names_a_sensor_only() {
    let s =
        judged("library", "body_roll", &answer("missing_physics", &[("body_roll", Some("yaw_rate"))], &[]));
    assert!(s.named, "a channel of physics is where it is seen");
    let with = |effect, channel| answer("missing_physics", &[(effect, Some(channel))], &[]);
    assert!(judged("library", "sensor_delay:yaw_rate", &with("sensor_delay", "yaw_rate")).named);
    assert!(!judged("library", "sensor_delay:yaw_rate", &with("sensor_delay", "steering_wheel_angle")).class);
    let swap = "wheel_speed_fl/wheel_speed_fr";
    assert!(judged("library", &format!("channel_swap:{swap}"), &with("channel_swap", swap)).named);
}

#[test]
fn delays_of_single_wheels_are_not_counted() {
    let wheel = ("sensor_delay", Some("wheel_speed_fl"));
    let s =
        judged("library", "body_roll", &answer("missing_physics", &[wheel, ("body_roll", None)], &[wheel]));
    assert!(s.named && s.findings == 1 && s.order == ["body_roll"]);
    let s = judged("control", "control", &answer("missing_physics", &[wheel], &[]));
    assert!(s.missed() && !s.false_alarm());
    // Their bias is.
    let bias = ("sensor_bias", Some("wheel_speed_fl"));
    assert!(judged("control", "control", &answer("missing_physics", &[bias], &[])).false_alarm());
}

#[test]
fn where_there_is_nothing_to_find_anything_is_a_false_alarm() {
    let named = answer("missing_physics", &[("payload", None)], &[]);
    assert!(judged("control", "control", &named).false_alarm());
    assert!(judged("control", "control", &answer("unknown_physics", &[], &[])).false_alarm());
    assert!(!judged("control", "control", &answer("adequate", &[], &[])).false_alarm());
    assert!(!judged("control", "control", &answer("insufficient_excitation", &[], &[])).false_alarm());
    // A cause that is there, though nobody could see it.
    assert!(!judged("absorbable", "payload", &named).false_alarm());
    assert!(judged("absorbable", "air_drag", &named).false_alarm());
}

#[test]
fn what_no_library_has_is_to_be_called_unknown() {
    let s = judged("unknown", "slosh", &answer("unknown_physics", &[], &[("body_roll", None)]));
    assert!(s.called_unknown() && s.outside && s.visible() && !s.in_three);
    assert!(judged("unknown", "slosh", &answer("missing_physics", &[("body_roll", None)], &[])).wrong());
    let law = judged("unknown", "slosh", &answer("missing_physics", &[("law", None)], &[]));
    assert!(law.told_as_a_law() && !s.told_as_a_law());
    // Too weak to be seen it is no longer `unknown`, but still of no library.
    let weak = score("t", &truth("absorbable", "slosh", 20.0), None, None);
    assert!(weak.outside && !weak.visible() && weak.verdict == "none given");
}

#[test]
fn overlaps_are_intersection_over_union() {
    let near = |found: f64, expected: f64| assert!((found - expected).abs() < 0.01, "{found} {expected}");
    near(overlap(&[(10.0, 20.0)], &[(10.0, 20.0)], 100.0), 1.0);
    near(overlap(&[(10.0, 20.0)], &[(15.0, 25.0)], 100.0), 1.0 / 3.0);
    near(overlap(&[(0.0, 5.0), (50.0, 60.0)], &[(55.0, 60.0)], 100.0), 1.0 / 3.0);
    near(overlap(&[(10.0, 20.0)], &[(30.0, 40.0)], 100.0), 0.0);
    near(overlap(&[(90.0, 400.0)], &[(95.0, 100.0)], 100.0), 0.5);
    near(overlap(&[], &[(1.0, 2.0)], 100.0), 0.0);
}

#[test]
fn parameters_are_held_against_the_truth_and_their_std() {
    let mut given = answer("missing_physics", &[("body_roll", None)], &[]);
    given["findings"][0]["parameters"] =
        json!({ "roll_gain_rad_per_mps2": { "value": 0.0055, "std": 0.0003 } });
    // True: mass 1500 kg, front stiffness 100 000 N/rad over 1500·9.81·0.6 N, wheel 40 000 N over 1500·9.81/4 N.
    let (front, wheel) = (100_000.0 / (1500.0 * 9.81 * 0.6), 40_000.0 / (1500.0 * 9.81 / 4.0));
    let stated = |value: f64, std: f64| json!({ "value": value, "std": std });
    given["parameters"] = json!({
        "baseline": { "mass_kg": stated(1560.0, 20.0), "lateral_stiffness_front": stated(front + 0.3, 0.1),
            "longitudinal_stiffness": stated(wheel, 0.1), "yaw_rate_offset": stated(0.003, 0.001) },
        "extended": { "mass_kg": stated(1490.0, 20.0), "lateral_stiffness_front": stated(front + 0.4, 0.1),
            "longitudinal_stiffness": stated(wheel + 0.2, 0.1) },
    });
    given["improvement_ci95"] = json!({ "yaw_rate": [-0.1, 0.4], "lateral_acceleration": [0.2, 0.9] });
    given["fit"] = json!({
        "baseline": { "holdout": { "yaw_rate": 90.0, "speed": 80.0, "lateral_acceleration": null } },
        "extended": { "holdout": { "yaw_rate": 94.0, "speed": 82.0, "lateral_acceleration": 70.0 } },
    });
    let s = judged("library", "body_roll", &given);
    assert!(s.stated.len() == 1 && s.stated[0].within(2.0) && !s.stated[0].within(1.0));
    let moved: Vec<_> = s.moved.iter().map(|m| (m.name, m.before, m.after, m.closer)).collect();
    assert_eq!(moved.len(), 3, "{moved:?}");
    assert_eq!(moved[0], ("mass_kg", 3.0, 0.5, true));
    assert!(moved[1].0 == "longitudinal_stiffness" && !moved[1].3 && (moved[1].2 - 2.0).abs() < 1e-9);
    assert!(moved[2].0 == "lateral_stiffness_front" && (moved[2].1 - 3.0).abs() < 1e-9 && !moved[2].3);
    assert_eq!(s.fit, Some((85.0, 88.0)));
    assert_eq!(s.certain, Some(true));
    // A wrong name's parameters are not the cause's.
    given["findings"][0]["effect"] = json!("roll_steer");
    assert!(judged("library", "body_roll", &given).stated.is_empty());
}

const NAMES: [(&str, Option<&str>); 10] = [
    ("body_roll", None),
    ("air_drag", None),
    ("road_bank", Some("yaw_rate")),
    ("sensor_delay", Some("wheel_speed_rl")),
    ("sensor_delay", Some("yaw_rate")),
    ("sensor_scale", Some("lateral_acceleration")),
    ("channel_swap", Some("wheel_speed_fl/wheel_speed_fr")),
    ("sensor_bias", Some("yaw_rate")),
    ("payload", None),
    ("cg_shift", None),
];
const KEYS: [&str; 9] = [
    "body_roll",
    "air_drag",
    "road_bank",
    "sensor_delay:yaw_rate",
    "sensor_scale:lateral_acceleration",
    "channel_swap:wheel_speed_fl/wheel_speed_fr",
    "sensor_bias:yaw_rate",
    "payload",
    "cg_shift",
];

fn random_intervals(dice: &mut Dice) -> Value {
    let count = dice.below(4);
    (0..count)
        .map(|_| {
            let from = dice.between(-2.0, 95.0);
            json!([from, from + dice.between(0.0, 20.0)])
        })
        .collect()
}

fn random_truth(dice: &mut Dice) -> Value {
    let kind =
        *dice.pick(&["library", "library", "library", "everything", "unknown", "absorbable", "control"]);
    let mut names = |most: usize| -> Value {
        let count = dice.below(most + 1);
        (0..count).map(|_| json!(dice.pick(&KEYS))).collect()
    };
    let (accept, fair) = (names(2), names(2));
    json!({
        "kind": kind, "expected": "", "cause": if kind == "control" { Value::Null } else { json!("air_drag") },
        "accept": accept, "fair": fair, "intervals": random_intervals(dice),
        "whole_recording": dice.chance(0.5), "seconds": 100.0, "factor": 1.0,
        "likelihood_ratio_of_truth": dice.between(0.0, 1e3),
    })
}

fn random_answer(dice: &mut Dice) -> Value {
    let verdict = *dice.pick(&[
        "missing_physics",
        "missing_physics",
        "adequate",
        "unknown_physics",
        "insufficient_excitation",
    ]);
    let place = |dice: &mut Dice| match dice.below(4) {
        0 => Value::Null,
        1 => json!({}),
        2 => json!({ "equation": "yaw moment balance" }),
        _ => json!({ "intervals": random_intervals(dice) }),
    };
    let entries = |dice: &mut Dice, most: usize| -> Vec<Value> {
        let count = dice.below(most + 1);
        (0..count)
            .map(|_| {
                let (effect, channel) = *dice.pick(&NAMES);
                json!({ "effect": effect, "channel": channel, "where": place(dice) })
            })
            .collect()
    };
    let findings = entries(dice, if verdict == "missing_physics" { 3 } else { 0 });
    let fit = |dice: &mut Dice| match dice.below(4) {
        0 => Value::Null,
        1 => json!({ "holdout": { "speed": dice.between(50.0, 99.0), "yaw_rate": null } }),
        _ => {
            json!({ "holdout": { "speed": dice.between(50.0, 99.0), "yaw_rate": dice.between(50.0, 99.0) } })
        }
    };
    json!({
        "verdict": verdict, "findings": findings, "ranking": entries(dice, 6), "where": place(dice),
        "fit": { "baseline": fit(dice), "extended": fit(dice) },
    })
}

/// `score.py` of the shared data, where it and a Python are there.
fn script() -> Option<PathBuf> {
    let script = testing::shared("trials/score.py")?;
    let python = Command::new("python3").arg("--version").output().is_ok_and(|o| o.status.success());
    if !python {
        eprintln!("skipped: no python3");
    }
    python.then_some(script)
}

#[test]
fn credits_are_those_of_the_shared_script() {
    let Some(script) = script() else { return };
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("scoring-{}", std::process::id()));
    std::fs::create_dir_all(&folder).unwrap();
    let mut dice = Dice::new(99, 0);
    let (mut truths, mut seen) = (Map::new(), 0);
    for i in 0..1500 {
        let name = format!("trial_{i:04}");
        truths.insert(name.clone(), random_truth(&mut dice));
        if dice.chance(0.98) {
            let answer = random_answer(&mut dice);
            std::fs::write(folder.join(format!("{name}.json")), answer.to_string()).unwrap();
        }
    }
    std::fs::write(folder.join("truth.json"), Value::Object(truths.clone()).to_string()).unwrap();
    let ours = score::totals(&score::all(&truths, &folder));
    let output = Command::new("python3").arg(script).arg(&folder).arg(&folder).output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    for line in String::from_utf8(output.stdout).unwrap().lines() {
        // label   0.123  (45)
        let Some((rest, count)) = line.strip_suffix(')').and_then(|l| l.rsplit_once('(')) else { continue };
        let Some((label, mean)) = rest.trim().rsplit_once(' ') else { continue };
        let (theirs, count): (f64, usize) = (mean.parse().unwrap(), count.parse().unwrap());
        let (mean, n) = ours[label.trim()];
        assert!(n == count && (mean - theirs).abs() < 6e-4, "{label}: {mean} of {n}, {theirs} of {count}");
        seen += 1;
    }
    std::fs::remove_dir_all(&folder).unwrap();
    assert_eq!(seen, ours.len(), "{ours:?}");
}

#[test]
fn the_table_counts_what_was_scored() {
    let named = answer("missing_physics", &[("body_roll", None)], &[]);
    let wrong = answer("missing_physics", &[("air_drag", None)], &[]);
    let unknown = answer("unknown_physics", &[], &[]);
    let adequate = answer("adequate", &[], &[]);
    let mut control = truth("control", "x", 0.0);
    control["cause"] = Value::Null;
    let mut scores: Vec<Score> = [&named, &named, &wrong, &unknown, &adequate]
        .map(|a| score("t", &truth("library", "body_roll", 900.0), Some(a), Some(2.0)))
        .into();
    scores.extend([&adequate, &wrong].map(|a| score("c", &control, Some(a), Some(4.0))));
    scores.push(score("w", &truth("absorbable", "body_roll", 20.0), Some(&adequate), None));
    scores.push(score("u", &truth("unknown", "slosh", 5000.0), Some(&unknown), None));
    let parts = table::parts(&scores);
    let values = table::json(&parts, &scores);
    let row = |part: &str, column: &str, name: &str| -> Value {
        let rows = values[part].as_array().unwrap();
        rows.iter().find(|r| r[column] == name).unwrap_or_else(|| panic!("{part}: no {name}")).clone()
    };
    let share = |value: &Value| (value["hits"].as_u64().unwrap(), value["of"].as_u64().unwrap());
    let total = |name: &str| share(&row("totals", "what", name)["n"]);
    assert_eq!(total("library, visible: cause named first"), (2, 5));
    assert_eq!(total("library, visible: missed (adequate)"), (1, 5));
    assert_eq!(total("controls: false alarms"), (1, 2));
    assert_eq!(total("outside the library: called unknown"), (1, 1));
    assert_eq!(total("too weak to be seen: false alarm"), (0, 1));
    let effect = row("effects", "hidden cause", "body_roll");
    assert_eq!(share(&effect["called unknown"]), (1, 5));
    assert_eq!(
        row("confusion_visible", "hidden", "body_roll")["said first"],
        "body_roll 2, adequate 1, air_drag 1, unknown_physics 1"
    );
    assert_eq!(row("confusion_controls", "hidden", "control")["said first"], "adequate 1, air_drag 1");
    assert_eq!(row("confusion_too_weak", "hidden", "body_roll")["n"], 1.0);
    assert_eq!(share(&row("power_over_visibility", "at", "200 – 1000")["class named"]), (2, 5));
    assert_eq!(share(&row("power_over_visibility", "at", "10 – 50")["class named"]), (0, 1));
    assert_eq!(values["failures"].as_array().unwrap().len(), 4);
    assert_eq!(values["seconds"][0]["median"], 2.0);
    let page = part::markdown(&parts);
    assert!(page.contains("| controls: false alarms | 1/2 | 50.0 | 9.5 – 90.5 |"), "{page}");
}
