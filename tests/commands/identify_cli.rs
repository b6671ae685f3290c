//! `gripd identify` as its users meet it: the worked example of the guide, what it says and what it does not.

use std::fs;
use std::path::PathBuf;
use std::process::Output;

use serde_json::Value;
use tempfile::TempDir;
use testing::program::{gripd, project};

use crate::interactive::{data, stands_alone, titled};

/// A folder with the thesis's car in it, and recordings of its drives.
struct Place(TempDir);

impl Place {
    /// `settings` are the lines of `[identify]`.
    fn new(settings: &str) -> Self {
        let place = Self(TempDir::new().unwrap());
        place.configure(settings, &[]);
        place
    }

    /// The thesis's car with some texts replaced.
    fn configure(&self, settings: &str, changes: &[(&str, &str)]) {
        let mut text = fs::read_to_string(project("config/thesis.toml"))
            .unwrap()
            .replace("../dbc/thesis.dbc", project("dbc/thesis.dbc").to_str().unwrap());
        for (from, to) in changes {
            assert!(text.contains(from), "{from}");
            text = text.replace(from, to);
        }
        fs::write(self.path("car.toml"), text + settings).unwrap();
    }

    fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    /// Sim1, shorter, with this amplitude of the steering.
    fn drive(&self, log: &str, seconds: f64, amplitude: f64, seed: u64) {
        let scenario = fs::read_to_string(project("config/scenarios/sim1.toml"))
            .unwrap()
            .replace("duration_s = 200.0", &format!("duration_s = {seconds}"))
            .replace("\namplitude = 0.1\n", &format!("\namplitude = {amplitude}\n"));
        fs::write(self.path("drive.toml"), scenario).unwrap();
        let mut simulate = gripd();
        simulate.arg("simulate").arg(self.path("drive.toml")).arg("-c").arg(self.path("car.toml"));
        simulate.args(["--seed", &seed.to_string(), "-o"]).arg(self.path(log));
        let output = simulate.output().unwrap();
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    }

    fn run(&self, logs: &[&str], arguments: &[&str]) -> Output {
        let mut command = gripd();
        command.current_dir(self.0.path()).args(["identify", "-c", "car.toml"]).args(logs).args(arguments);
        command.output().unwrap()
    }

    fn json(&self, logs: &[&str], arguments: &[&str]) -> Value {
        let output = self.run(logs, &[arguments, &["--json", "-"]].concat());
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        serde_json::from_slice(&output.stdout).unwrap()
    }

    fn fails(&self, logs: &[&str], arguments: &[&str], code: i32) -> String {
        let output = self.run(logs, arguments);
        let stderr = String::from_utf8(output.stderr).unwrap();
        assert_eq!(output.status.code(), Some(code), "{stderr}");
        assert!(!stderr.contains("panicked"), "{stderr}");
        stderr
    }
}

const TWO: &[&str] = &["--parameters", "longitudinal_stiffness,lateral_stiffness", "--starts", "1"];

fn number(value: &Value) -> f64 {
    value.as_f64().unwrap_or_else(|| panic!("{value}"))
}

fn interval(report: &Value, name: &str) -> (f64, f64) {
    let ends = &report["parameters"][name]["ci95"];
    (number(&ends[0]), number(&ends[1]))
}

#[test]
fn the_worked_example_finds_the_tires() {
    let place = Place::new("");
    place.drive("sim1.log", 30.0, 0.02, 1);
    let arguments =
        ["--parameters", "longitudinal_stiffness,lateral_stiffness", "--starts", "2", "--json", "o.json"];
    let output = place.run(&["sim1.log"], &[&arguments[..], &["--html", "o.html"]].concat());
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let text = String::from_utf8(output.stdout).unwrap();
    for part in ["longitudinal_stiffness", "35 ± 20", "[vehicle]\n", "lateral_stiffness_rear = { value = 11."]
    {
        assert!(text.contains(part), "{part} is not in\n{text}");
    }
    // The snippet is TOML that the configuration takes.
    let snippet = text.split_once("# gripd identify").unwrap().1;
    let table: toml::Table = snippet.split_once('\n').unwrap().1.parse().unwrap();
    assert!((table["vehicle"]["longitudinal_stiffness"]["value"].as_float().unwrap() - 50.0).abs() < 2.0);

    let report: Value = serde_json::from_slice(&fs::read(place.path("o.json")).unwrap()).unwrap();
    for (name, truth, prior) in [("longitudinal_stiffness", 50.0, 35.0), ("lateral_stiffness", 11.5, 8.0)] {
        let parameter = &report["parameters"][name];
        assert!((number(&parameter["value"]) / truth - 1.0).abs() < 0.03, "{parameter}");
        assert_eq!(parameter["identifiable"], true);
        let reason = parameter["reason"].as_str().unwrap();
        assert_eq!(reason.contains("one value for both axles"), name == "lateral_stiffness", "{reason}");
        // The axles of this car are alike.
        assert!(!reason.contains("differ"), "{reason}");
        assert_eq!(number(&parameter["prior"]["value"]), prior);
        let (low, high) = interval(&report, name);
        assert!(low < number(&parameter["value"]) && number(&parameter["value"]) < high);
        assert!(parameter["profile"].as_array().unwrap().len() >= 5);
    }
    let starts = report["starts"].as_array().unwrap();
    assert_eq!(starts.len(), 2);
    for start in starts {
        assert!(
            start["from"]["lateral_stiffness"].is_number() && start["to"]["lateral_stiffness"].is_number()
        );
        assert!(start["cost"].is_number());
    }
    let fit = |when: &str| number(&report["fit"][when]["yaw_rate"]);
    assert!(fit("after") > 90.0 && fit("before") < fit("after") - 10.0);
    assert!((number(&report["noise"]["yaw_rate"]) / 0.003 - 1.0).abs() < 0.3);

    let html = fs::read_to_string(place.path("o.html")).unwrap();
    for part in [
        "<!DOCTYPE html>",
        "Before and after",
        "A typical stretch",
        "Profile likelihood",
        "Where the searches",
    ] {
        assert!(html.contains(part), "{part}");
    }
    stands_alone(&html);
    assert!(!html.split_once("<main").unwrap().1.split_once("</main>").unwrap().0.contains("NaN"));
}

#[test]
fn slips_measured_beforehand_do_as_well() {
    let place = Place::new("profile = false\n");
    place.drive("sim1.log", 60.0, 0.02, 4);
    let report = place.json(&["sim1.log"], &[TWO, &["--drive", "slips"]].concat());
    assert_eq!(report["drive"], "slips");
    // Clipped slips with an offset estimated from the same noise: not as good as torque, near all the same.
    for (name, truth) in [("longitudinal_stiffness", 50.0), ("lateral_stiffness", 11.5)] {
        let value = number(&report["parameters"][name]["value"]);
        assert!((value / truth - 1.0).abs() < 0.1, "{name}: {value}");
    }
}

#[test]
fn several_recordings_tell_more_than_one() {
    let place = Place::new("profile = false\n");
    let logs = ["a.log", "b.log", "c.log"];
    for (log, seed) in logs.iter().zip(2..) {
        place.drive(log, 40.0, 0.02, seed);
    }
    let all = place.json(&logs, TWO);
    let each: Vec<Value> = logs.iter().map(|log| place.json(&[log], TWO)).collect();
    assert!(number(&all["seconds"]) > 2.9 * number(&each[0]["seconds"]));
    for name in ["longitudinal_stiffness", "lateral_stiffness"] {
        let width = |report: &Value| {
            let (low, high) = interval(report, name);
            high - low
        };
        let mean = each.iter().map(width).sum::<f64>() / 3.0;
        assert!(width(&all) < 0.8 * mean, "{name}: {} {mean}", width(&all));
    }
}

/// GIVEN a drive that nothing is fitted to THEN it changes no number, and is predicted better with the numbers found.
#[test]
fn a_drive_that_was_held_out_is_predicted() {
    let place = Place::new("profile = false\n");
    place.drive("fitted.log", 30.0, 0.02, 2);
    place.drive("held.log", 30.0, 0.03, 3);
    let alone = place.json(&["fitted.log"], TWO);
    assert!(alone["fit"].get("holdout").is_none());
    let arguments = [TWO, &["--holdout", "held.log", "--html", "o.html"]].concat();
    let report = place.json(&["fitted.log"], &arguments);
    assert_eq!(report["parameters"], alone["parameters"]);
    let fit = |when: &str| number(&report["fit"]["holdout"][when]["yaw_rate"]);
    assert!(fit("after") > 85.0 && fit("after") > fit("before") + 10.0, "{}", report["fit"]);
    let html = fs::read_to_string(place.path("o.html")).unwrap();
    let data = data(&html);
    assert_eq!(data["clocks"][1]["name"], "held.log");
    let shades = &titled(&data, "panels", "Yaw rate: error")["shades"][0];
    let from = number(&shades["times"][0]);
    assert!((from - number(&data["clocks"][1]["from_s"])).abs() < 0.1, "all of the second drive: {shades}");
    assert!(html.contains("Held-out error, yaw rate") && html.contains("which nothing was fitted to"));
}

#[test]
fn what_the_drive_does_not_tell_gets_no_number() {
    let place = Place::new("profile = false\n");
    // Straight on, at a fraction of the friction.
    place.configure("profile = false\n", &[("friction = 1.0", "friction = { value = 1.0, std = 0.2 }")]);
    place.drive("straight.log", 30.0, 0.0, 1);
    let names =
        ["--parameters", "longitudinal_stiffness,lateral_stiffness_front,lateral_stiffness_rear,friction"];
    let arguments = [&names[..], &["--starts", "1"]].concat();
    let report = place.json(&["straight.log"], &arguments);
    assert_eq!(report["parameters"]["longitudinal_stiffness"]["identifiable"], true);
    for name in ["lateral_stiffness_front", "lateral_stiffness_rear", "friction"] {
        let parameter = &report["parameters"][name];
        assert_eq!(parameter["identifiable"], false, "{name}: {parameter}");
        assert!(parameter["reason"].as_str().unwrap().len() > 20, "{name}: {parameter}");
    }
    let far = report["parameters"]["friction"]["reason"].as_str().unwrap();
    assert!(far.starts_with("the tires are far from their limit: only 0."), "{far}");
    let output = place.run(&["straight.log"], &arguments);
    let text = String::from_utf8(output.stdout).unwrap();
    let row = text.lines().find(|line| line.starts_with("friction")).unwrap();
    assert!(row.contains("no: ") && row.contains("–"), "{row}");
    assert!(text.lines().all(|line| line.chars().count() <= 100), "{text}");
    assert!(!text.contains("friction = {"), "{text}");
}

/// GIVEN a table that is sure of softer tires than the car has THEN recordings and table are said to contradict each other, the
/// number is not taken over, and by force it is.
#[test]
fn what_contradicts_the_table_is_taken_over_by_force_only() {
    let place = Place::new("profile = false\n");
    let unsure = "lateral_stiffness_front = { value = 8.0, std = 4.0 }";
    place.configure("profile = false\n", &[(unsure, "lateral_stiffness_front = { value = 8.0, std = 0.8 }")]);
    place.drive("sim1.log", 30.0, 0.02, 1);
    let report = place.json(&["sim1.log"], &[TWO, &["--apply", "new.toml"]].concat());
    let parameter = &report["parameters"]["lateral_stiffness"];
    assert_eq!(parameter["identifiable"], false, "{parameter}");
    assert!(parameter["reason"].as_str().unwrap().contains("contradict"), "{parameter}");
    let doubt = &parameter["doubt"];
    assert!(number(&doubt["deviations"]) > 3.0 && doubt["at_bound"] == false, "{doubt}");
    assert!(doubt["behind"].as_str().unwrap().contains("gripd check"), "{doubt}");
    assert!(report["parameters"]["longitudinal_stiffness"]["doubt"].is_null());

    let output = place.run(&["sim1.log"], TWO);
    let text = String::from_utf8(output.stdout).unwrap();
    assert!(text.contains("in doubt: lateral_stiffness is "), "{text}");
    assert!(!text.contains("lateral_stiffness_front = {"), "{text}");

    let stiffness = |name: &str| {
        let text = fs::read_to_string(place.path(name)).unwrap();
        let table: toml::Table = text.parse().unwrap();
        let of = |key: &str| table["vehicle"][key]["value"].as_float().unwrap();
        (text.clone(), of("lateral_stiffness_front"), of("longitudinal_stiffness"))
    };
    let (text, lateral, longitudinal) = stiffness("new.toml");
    assert!(text.starts_with("# Written by gripd identify") && text.contains("left as they were"), "{text}");
    assert!(lateral == 8.0 && (longitudinal - 50.0).abs() < 2.0, "{lateral} {longitudinal}");
    place.run(&["sim1.log"], &[TWO, &["--apply", "forced.toml", "--force"]].concat());
    let (text, lateral, _) = stiffness("forced.toml");
    assert!(text.contains("taken over by --force"), "{text}");
    assert!((lateral - 11.5).abs() < 0.5, "{lateral}");
    assert!(place.fails(&["sim1.log"], &["--force"], 2).contains("--apply"));
}

/// GIVEN a file with comments, an effect of its own and paths THEN what `--apply` writes elsewhere is that file but for the
/// numbers and the paths, and it can be used; a second one replaces the first one's head.
#[test]
fn comments_and_paths_survive() {
    let place = Place::new("");
    place.drive("a.log", 10.0, 0.02, 1);
    fs::copy(project("dbc/thesis.dbc"), place.path("car.dbc")).unwrap();
    let effect =
        "\n# From the bench.\n[[effect]]\nkind = \"payload\" # two people\nmass_kg = 100.0\n\n# The end.\n";
    let service = "\n[service]\nstate_file = \"state.toml\" # to be\nmetrics = \"127.0.0.1:9100\"\n";
    let dbc = project("dbc/thesis.dbc");
    place.configure(&format!("{service}{effect}"), &[(dbc.to_str().unwrap(), "car.dbc")]);
    fs::create_dir(place.path("new")).unwrap();
    place.json(&["a.log"], &[TWO, &["--apply", "new/car.toml"]].concat());
    let read = |name: &str| fs::read_to_string(place.path(name)).unwrap();
    let (old, new) = (read("car.toml"), read("new/car.toml"));
    let (head, body) = new.split_once("\n\n").unwrap();
    assert!(head.starts_with("# Written by gripd identify: car.toml"), "{new}");
    assert_eq!(old.lines().count(), body.lines().count(), "{new}");
    let mut changed = Vec::new();
    for (old, new) in old.lines().zip(body.lines()).filter(|(old, new)| old != new) {
        let comment = |line: &str| line.split_once('#').map(|(_, comment)| comment.to_owned());
        assert_eq!(comment(old), comment(new));
        changed.push(old.split(' ').next().unwrap().to_owned());
    }
    changed.sort();
    let numbers = ["lateral_stiffness_front", "lateral_stiffness_rear", "longitudinal_stiffness"];
    assert_eq!(changed, [&["input"], &numbers[..], &["state_file"]].concat());
    let folder = place.path("").canonicalize().unwrap();
    for file in ["car.dbc", "state.toml"] {
        assert!(new.contains(&format!("\"{}\"", folder.join(file).display())), "{new}");
    }
    let mut check = gripd();
    check.current_dir(place.0.path()).args(["-q", "check", "-c", "new/car.toml", "a.log"]);
    let output = check.output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));

    // Lines as Windows ends them stay so.
    fs::write(place.path("car.toml"), new.replace('\n', "\r\n")).unwrap();
    place.json(&["a.log"], &[TWO, &["--apply", "again.toml"]].concat());
    let again = read("again.toml");
    assert_eq!(again.matches("# Written by").count(), 1, "{again}");
    assert_eq!(again.matches('\n').count(), new.matches('\n').count(), "{again}");
    assert_eq!(again.matches("\r\n").count(), again.matches('\n').count(), "{again}");
}

#[test]
fn errors_say_whose_turn_it_is() {
    let place = Place::new("");
    place.drive("a.log", 4.0, 0.02, 1);
    let unknown = place.fails(&["a.log"], &["--parameters", "mass"], 2);
    assert!(unknown.contains("`mass` is no parameter") && unknown.contains("mass_kg"), "{unknown}");
    assert!(place.fails(&["a.log"], &["--method", "best"], 2).contains("free_run"));
    assert!(place.fails(&["a.log"], &["--starts", "0"], 2).contains("--starts <N>"));
    let unusable = place.fails(&["a.log"], &["--parameters", "brake_torque_per_bar_front_nm"], 2);
    assert!(unusable.contains("has no value to start from"), "{unusable}");
    assert!(place.fails(&["a.log"], &["--json", "a.log"], 2).contains("another name"));
    assert!(place.fails(&["a.log"], &["--json", "x", "--html", "x"], 2).contains("two results"));
    assert!(place.fails(&["none.log"], &[], 1).contains("none.log"));
    assert!(place.fails(&[], &[], 2).contains("LOGS"));

    fs::write(place.path("other.log"), "(0.0) can0 123#00\n(1.0) can0 123#00\n").unwrap();
    assert!(place.fails(&["other.log"], &[], 1).contains("other.log: nothing to identify from"));
    place.drive("short.log", 0.5, 0.02, 1);
    assert!(place.fails(&["short.log"], &[], 1).contains("record a longer drive"));

    place.configure("segment_s = 0\n", &[]);
    let key = place.fails(&["a.log"], &[], 2);
    assert!(key.contains("car.toml") && key.contains("identify.segment_s = 0"), "{key}");
    place.configure("segments = 2\n", &[]);
    assert!(place.fails(&["a.log"], &[], 2).contains("segments"));
    place.configure("drive = \"slips\"\n", &[("driven_axle = \"front\"", "driven_axle = \"all\"")]);
    assert!(place.fails(&["a.log"], &[], 2).contains("undriven wheel"));
}

#[test]
fn replay_takes_the_same_car() {
    let place = Place::new("");
    place.drive("a.log", 10.0, 0.02, 1);
    let mut replay = gripd();
    replay.current_dir(place.0.path()).args(["replay", "-c", "car.toml", "a.log", "--stats", "stats.json"]);
    assert!(replay.output().unwrap().status.success());
    let stats: Value = serde_json::from_slice(&fs::read(place.path("stats.json")).unwrap()).unwrap();
    assert!(number(&stats["samples"]) > 990.0 && number(&stats["frames_out"]) > 2000.0, "{stats}");
    assert_eq!(stats["faults"].as_object().unwrap().values().map(number).sum::<f64>(), 0.0, "{stats}");
}
