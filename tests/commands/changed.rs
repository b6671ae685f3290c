//! `gripd explain` beside healthy drives, and what it says that a drive could have told.

use std::path::Path;
use std::process::Output;

use serde_json::Value;
use tempfile::TempDir;
use testing::program::{gripd, project};

/// The demo's scenario, or part of it, on tires that bend as the demo's table has it and on equal wheels: each difference is found in a
/// search of its own (`other_tires` tries the tires).
pub fn plain(demo: &str) -> String {
    let (before, rest) = demo.split_once("[radius_difference]\n").unwrap();
    let (_, after) = rest.split_once("\n\n").unwrap();
    let equal = format!("{before}{after}");
    assert_eq!(equal.matches("tire = \"brush\"").count(), 1);
    equal.replace("tire = \"brush\"", "tire = \"piecewise\"")
}

/// The same of so many seconds on asphalt.
pub fn plain_demo(seconds: f64) -> String {
    let demo = std::fs::read_to_string(project("config/scenarios/demo.toml")).unwrap();
    plain(&demo).replace("duration_s = 120.0", &format!("duration_s = {seconds:.1}"))
}

/// Curves and braking of the demo's car for half a minute, with these seeds.
fn drives(names: &[(&str, &str)]) -> TempDir {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("scenario.toml"), plain_demo(30.0)).unwrap();
    for (name, seed) in names {
        run(folder.path(), &["-q", "simulate", "scenario.toml", "-o", name, "--seed", seed]);
    }
    folder
}

fn run(folder: &Path, arguments: &[&str]) -> Output {
    let output = gripd().current_dir(folder).args(arguments).output().unwrap();
    assert!(output.status.success(), "{arguments:?}: {}", String::from_utf8_lossy(&output.stderr));
    output
}

/// What `gripd explain` says as JSON.
fn explained(folder: &Path, arguments: &[&str]) -> Value {
    let config = project("config/demo.toml");
    let fixed = ["-q", "explain", "-c", config.to_str().unwrap(), "--json", "-"];
    serde_json::from_slice(&run(folder, &[&fixed[..], arguments].concat()).stdout).unwrap()
}

/// GIVEN a healthy drive, and another in which a wheel's radius was changed THEN beside it the wheel is named, and the page
/// says since when it is compared; an unchanged drive is unchanged.
#[test]
#[ignore = "long: two cars fitted, twice"]
fn a_changed_wheel_is_named_beside_a_healthy_drive() {
    let folder = drives(&[("healthy.log", "5"), ("new.log", "6")]);
    let config = project("config/demo.toml");
    let wheel = "kind = 'tire_radius', relative_difference_rl = -0.02";
    let conceal =
        ["-q", "conceal", "-c", config.to_str().unwrap(), "new.log", "--effect", wheel, "-o", "changed.log"];
    run(folder.path(), &conceal);
    let answer =
        explained(folder.path(), &["changed.log", "--reference", "healthy.log", "--html", "page.html"]);
    assert_eq!(answer["verdict"], "missing_physics", "{}", answer["findings"]);
    assert_eq!(answer["findings"][0]["effect"], "tire_radius", "{}", answer["findings"]);
    assert_eq!(answer["references"], serde_json::json!(["healthy.log"]));
    let page = std::fs::read_to_string(folder.path().join("page.html")).unwrap();
    assert!(page.contains("Changed since the references"));
    let answer = explained(folder.path(), &["new.log", "--reference", "healthy.log"]);
    assert_eq!(answer["verdict"], "unchanged", "{}", answer["findings"]);
    assert_eq!(answer["findings"], serde_json::json!([]));
}

/// What `--history` says of drives of the demo's car, the wheel of the last two of which is so much smaller.
fn over_drives(sizes: [f64; 2]) -> (TempDir, Value) {
    let names = ["one.log", "two.log", "three.log", "four.log"];
    let folder = drives(&[(names[0], "5"), (names[1], "6"), (names[2], "7"), (names[3], "8")]);
    let config = project("config/demo.toml");
    for (name, size) in names[2..].iter().zip(sizes).filter(|(_, size)| *size != 0.0) {
        let wheel = format!("kind = 'tire_radius', relative_difference_rl = {size}");
        let whole = format!("whole-{name}");
        std::fs::rename(folder.path().join(name), folder.path().join(&whole)).unwrap();
        let conceal =
            ["-q", "conceal", "-c", config.to_str().unwrap(), &whole, "--effect", &wheel, "-o", name];
        run(folder.path(), &conceal);
    }
    let answer = explained(folder.path(), &[&names[..], &["--history", "--html", "page.html"]].concat());
    (folder, answer)
}

/// GIVEN four drives, in the third of which a wheel is smaller, and smaller still in the fourth THEN it is told since when, with
/// its size in each, and that it grows; the page has it over the drives.
#[test]
#[ignore = "long: four drives searched"]
fn a_wheel_that_grows_smaller_is_told_since_when() {
    let (folder, answer) = over_drives([-0.01, -0.02]);
    assert_eq!(answer["verdict"], "missing_physics", "{}", answer["findings"]);
    let history = &answer["history"];
    let change = &history["changes"][0];
    assert_eq!(
        (&change["effect"], &change["parameter"]),
        (&"tire_radius".into(), &"relative_difference_rl".into())
    );
    assert_eq!((&change["since"], &change["grows"]), (&"three.log".into(), &true.into()), "{change}");
    assert_eq!(change["since_ci"], serde_json::json!(["three.log", "three.log"]));
    for (place, truth) in [0.0, 0.0, -0.01, -0.02].into_iter().enumerate() {
        let value = &change["values"][place];
        let (value, std) = (value["value"].as_f64().unwrap(), value["std"].as_f64().unwrap());
        assert!((value - truth).abs() < 4.0 * std.max(5e-4), "{change}");
    }
    let trend = change["trend_per_drive"].as_f64().unwrap();
    assert!((trend + 0.01).abs() < 0.003, "{change}");
    assert_eq!(history["changes"].as_array().unwrap().len(), 1, "{}", history["changes"]);
    assert_eq!(history["order"], "given", "simulated drives have no dates");
    let page = std::fs::read_to_string(folder.path().join("page.html")).unwrap();
    assert!(page.contains("Over the drives") && page.contains("since three.log"));
}

/// GIVEN four drives of the same car THEN nothing has changed, and it is said what would have been told.
#[test]
#[ignore = "long: four drives searched"]
fn drives_of_the_same_car_have_not_changed() {
    let (_folder, answer) = over_drives([0.0, 0.0]);
    assert_eq!(answer["verdict"], "unchanged", "{}", answer["findings"]);
    assert_eq!(answer["history"]["changes"], serde_json::json!([]));
    let numbers = answer["history"]["numbers"].as_array().unwrap();
    let stiffness = numbers.iter().find(|number| number["effect"] == "lateral_stiffness_front").unwrap();
    assert!(stiffness["told_from"].as_f64().unwrap() > 0.0, "{stiffness}");
    assert_eq!(stiffness["values"].as_array().unwrap().len(), 4);
}

/// GIVEN a drive WHEN asked what it could have told THEN each effect has its sizes in a unit, the smaller one for being seen,
/// and every pair its chance to be told apart.
#[test]
fn a_drive_tells_what_it_could_have_told() {
    let folder = drives(&[("drive.log", "5")]);
    let answer = explained(folder.path(), &["drive.log", "--sensitivity", "--html", "page.html"]);
    let effects = answer["effects"].as_array().unwrap();
    assert!(effects.len() > 15, "{}", effects.len());
    for effect in effects {
        let size = |key: &str| effect[key].as_f64();
        assert!(size("ordinary").unwrap() > 0.0 && effect["unit"].is_string(), "{effect}");
        if let (Some(seen), Some(named)) = (size("noticed_90"), size("named_90")) {
            assert!(seen > 0.0 && seen <= named, "{effect}");
        }
    }
    let page = std::fs::read_to_string(folder.path().join("page.html")).unwrap();
    assert!(page.contains("<svg") && page.contains("named from"));
    let answer = explained(folder.path(), &["drive.log", "--isolability"]);
    let count = answer["effects"].as_array().unwrap().len();
    assert_eq!(answer["detectable"].as_array().unwrap().len(), count);
    assert!(answer["separable"].as_array().unwrap().iter().all(|row| row.as_array().unwrap().len() == count));
}

/// GIVEN a car that pulls when it brakes, as no effect of the library has it THEN it is told as a law with its number, helps on
/// another drive of the car as well as there, and is written so that other commands take it.
#[test]
#[ignore = "long: explains a recording, with the whole grammar"]
fn a_law_is_found_confirmed_and_applied() {
    let folder = drives(&[]);
    let law = "\n[[effect]]\nkind = 'law'\nplace = 'front slip angle'\nexpression = 'coefficient * a_x'\n\
               coefficient = 0.001\n";
    std::fs::write(folder.path().join("pulls.toml"), plain_demo(24.0) + law).unwrap();
    for (name, seed) in [("one.log", "7"), ("other.log", "8")] {
        run(folder.path(), &["-q", "simulate", "pulls.toml", "-o", name, "--seed", seed]);
    }
    let answer = explained(folder.path(), &["one.log", "--confirm", "other.log", "--apply", "car.toml"]);
    let first = &answer["findings"][0];
    assert_eq!((&first["effect"], &first["kind"]), (&"law".into(), &"law".into()), "{first}");
    assert_eq!(first["place"], "front slip angle");
    assert!(first["expression"].as_str().unwrap().ends_with("*a_x"), "{first}");
    assert_eq!(first["terms"][0]["unit"], "rad/(m/s²)", "{first}");
    let coefficient = first["terms"][0]["coefficient"]["value"].as_f64().unwrap();
    assert!((coefficient / 0.001 - 1.0).abs() < 0.2, "{first}");
    let confirmed = &answer["confirm"][0];
    let gain = |key: &str| confirmed[key].as_f64().unwrap();
    assert!(gain("gain_unchanged") > 0.5, "{confirmed}");
    assert!(gain("gain_refitted") > gain("gain_unchanged"), "{confirmed}");
    run(folder.path(), &["-q", "replay", "-c", "car.toml", "other.log", "--estimates", "estimates.csv"]);
}

/// GIVEN a table that is sure of half the car's yaw inertia THEN the file that is written has the answer's own verdict, tells what is
/// in doubt, and leaves it as it was, unless by force. The car's own effects are in it, and every comment of the file.
#[test]
fn the_applied_file_says_what_the_answer_says() {
    let folder = drives(&[("drive.log", "5")]);
    let demo = std::fs::read_to_string(project("config/demo.toml")).unwrap();
    let inertia = "yaw_inertia_kgm2 = { value = 2400.0, std = 250.0 }";
    assert!(demo.contains(inertia));
    let demo = demo
        .replace(inertia, "yaw_inertia_kgm2 = { value = 1200.0, std = 60.0 }")
        .replace("../dbc/demo.dbc", project("dbc/demo.dbc").to_str().unwrap());
    let own =
        "# From the bench.\n[[effect]]\nkind = \"radius_growth\" # little\nrelative_per_mps_squared = 1e-8\n";
    std::fs::write(folder.path().join("wrong.toml"), format!("{demo}\n{own}")).unwrap();
    let part = ["-q", "explain", "-c", "wrong.toml", "drive.log", "--from", "8", "--json", "answer.json"];
    let apply = |to: &[&str]| run(folder.path(), &[&part[..], &["--apply"], to].concat());
    let text = apply(&["new.toml"]).stdout;
    let text = String::from_utf8(text).unwrap();
    let read = |name: &str| std::fs::read_to_string(folder.path().join(name)).unwrap();
    let answer: Value = serde_json::from_str(&read("answer.json")).unwrap();
    let doubt = &answer["in_doubt"]["yaw_inertia_kgm2"];
    assert!(doubt["deviations"].as_f64().unwrap() > 3.0, "{doubt}");
    assert!(text.contains("In doubt") && text.contains("Yaw inertia"), "{text}");
    let new = read("new.toml");
    let head = new.replace("\n# ", " ");
    for line in text.lines().take(2) {
        assert!(head.contains(line), "{line} is not in\n{new}");
    }
    let inertia = |text: &str| {
        let table: toml::Table = text.parse().unwrap();
        table["vehicle"]["yaw_inertia_kgm2"]["value"].as_float().unwrap()
    };
    assert!(inertia(&new) == 1200.0 && new.contains("# yaw_inertia_kgm2 = "), "{new}");
    assert!(new.contains(own), "{new}");
    for comment in demo.lines().filter_map(|line| line.split_once('#')).map(|(_, comment)| comment) {
        assert!(new.contains(comment), "{comment} is not in\n{new}");
    }
    apply(&["forced.toml", "--force"]);
    assert!(inertia(&read("forced.toml")) > 1290.0, "{}", read("forced.toml"));
    run(folder.path(), &["-q", "check", "-c", "forced.toml"]);
}

/// GIVEN a reference that is not there, or two questions at once THEN it is refused before anything is read.
#[test]
fn what_cannot_be_asked_is_refused() {
    let folder = drives(&[("drive.log", "5")]);
    let config = project("config/demo.toml");
    let refused = |arguments: &[&str]| {
        let fixed = ["-q", "explain", "-c", config.to_str().unwrap(), "drive.log"];
        let output = gripd().current_dir(folder.path()).args(fixed).args(arguments).output().unwrap();
        (output.status.code(), String::from_utf8_lossy(&output.stderr).into_owned())
    };
    let (code, told) = refused(&["--reference", "nowhere.log"]);
    assert!(code != Some(0) && told.contains("nowhere.log"), "{code:?} {told}");
    let (code, told) = refused(&["--confirm", "nowhere.log"]);
    assert!(code != Some(0) && told.contains("nowhere.log"), "{code:?} {told}");
    let (code, told) = refused(&["--sensitivity", "--isolability"]);
    assert_eq!(code, Some(2), "{told}");
    let (code, told) = refused(&["--verify"]);
    assert!(code == Some(2) && told.contains("--sensitivity"), "{code:?} {told}");
    let (code, told) = refused(&["--sensitivity", "--verify=no_such_effect"]);
    assert!(code == Some(2) && told.contains("no such effect"), "{code:?} {told}");
    let (code, told) = refused(&["--history"]);
    assert!(code == Some(2) && told.contains("two LOGs"), "{code:?} {told}");
    let (code, told) = refused(&["--history", "drive.log", "--confirm", "drive.log"]);
    assert!(code == Some(2) && told.contains("--confirm"), "{code:?} {told}");
}

mod by_hand {
    use super::*;

    /// GIVEN a prediction WHEN it is verified THEN each size stands with what was predicted and found; a second run takes what the
    /// first one has done, and does the rest.
    #[test]
    #[ignore = "by hand: a drive explained a dozen times, minutes"]
    fn what_a_drive_could_have_told_is_verified_and_goes_on() {
        let folder = drives(&[("drive.log", "5")]);
        let config = project("config/demo.toml");
        let ask = ["-q", "explain", "-c", config.to_str().unwrap(), "drive.log", "--sensitivity"];
        let ask =
            [&ask[..], &["--verify=sensor_scale:yaw_rate", "--json", "answer.json", "--html", "page.html"]]
                .concat();
        let said = String::from_utf8(run(folder.path(), &ask).stdout).unwrap();
        assert!(said.contains("Verified") && said.contains("predicted chance"), "{said}");
        let read = |name: &str| -> Value {
            serde_json::from_str(&std::fs::read_to_string(folder.path().join(name)).unwrap()).unwrap()
        };
        let answer = read("answer.json");
        let runs = answer["verified"]["runs"].as_array().unwrap();
        assert_eq!(runs.len(), 12, "six sizes of both signs");
        let double = runs.iter().filter(|run| run["predicted"].as_f64().unwrap() > 0.99);
        assert!(double.clone().count() > 0 && double.clone().all(|run| run["noticed"] == true), "{runs:?}");
        let bins = answer["verified"]["bins"].as_array().unwrap();
        assert_eq!(bins.iter().map(|bin| bin["count"].as_u64().unwrap()).sum::<u64>(), 12, "{bins:?}");
        assert!(std::fs::read_to_string(folder.path().join("page.html")).unwrap().contains("Verified"));
        // As if it had been ended before the last one; the first one's answer is made to be recognized.
        let mut kept = read("answer.json.verified");
        let done = kept["done"].as_array_mut().unwrap();
        done.pop();
        done[0]["found"] = serde_json::json!(["taken from the file"]);
        std::fs::write(folder.path().join("answer.json.verified"), kept.to_string()).unwrap();
        run(folder.path(), &ask);
        let again = read("answer.json");
        let runs = again["verified"]["runs"].as_array().unwrap();
        assert_eq!(runs.len(), 12);
        assert_eq!(
            runs.iter().filter(|run| run["found"] == serde_json::json!(["taken from the file"])).count(),
            1
        );
    }
}
