//! `gripd explain --simulation`: somebody's simulation beside a recording of the same drive.

use std::path::Path;
use std::process::{Command, Output};

use tempfile::TempDir;
use testing::program::{gripd, project};

/// A drive of the demo's car as a recording, and what was true as another program's table.
fn drive() -> TempDir {
    let folder = tempfile::tempdir().unwrap();
    simulate(folder.path(), 30.0, "", ["drive.log", "truth.csv"]);
    folder
}

/// So many seconds of the demo's drive with something more in its scenario, as a recording and as a table of what was true.
fn simulate(folder: &Path, seconds: f64, more: &str, [log, truth]: [&str; 2]) {
    let demo = std::fs::read_to_string(project("config/scenarios/demo.toml")).unwrap();
    let scenario = demo.replace("duration_s = 120.0", &format!("duration_s = {seconds:.1}"));
    std::fs::write(folder.join("scenario.toml"), scenario + more).unwrap();
    succeeded(gripd().current_dir(folder).args([
        "-q",
        "simulate",
        "scenario.toml",
        "-o",
        log,
        "--truth",
        truth,
    ]));
}

fn succeeded(command: &mut Command) {
    let output = command.output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
}

fn explain(folder: &Path, arguments: &[&str]) -> Output {
    let config = project("config/demo.toml");
    let fixed = ["-q", "explain", "-c", config.to_str().unwrap(), "drive.log"];
    gripd().current_dir(folder).args(fixed).args(arguments).output().unwrap()
}

/// GIVEN a simulation without the noise and the road of the recording THEN it leaves out nothing, and the answer says how the
/// two lie beside each other.
#[test]
#[ignore = "long: a car fitted to a simulation"]
fn a_simulation_of_the_same_car_leaves_out_nothing() {
    let folder = drive();
    let output = explain(
        folder.path(),
        &[
            "--simulation",
            "truth.csv",
            "--json",
            "answer.json",
            "--html",
            "page.html",
            "--apply",
            "found.toml",
        ],
    );
    // There is nothing to apply.
    let said = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(1), "{said}");
    assert!(said.contains("--apply has nothing to write to found.toml: nothing was found"), "{said}");
    assert!(!folder.path().join("found.toml").exists());
    let answer = std::fs::read_to_string(folder.path().join("answer.json")).unwrap();
    let answer: serde_json::Value = serde_json::from_str(&answer).unwrap();
    assert_eq!(answer["verdict"], "adequate", "{}", answer["findings"]);
    assert_eq!(answer["simulation"]["steered_alike"], true, "{}", answer["simulation"]);
    assert_eq!(answer["simulation"]["time_offset_s"], 0.0, "{}", answer["simulation"]);
    let page = std::fs::read_to_string(folder.path().join("page.html")).unwrap();
    assert!(page.contains("Your simulation leaves out nothing"));
}

/// GIVEN tables that cannot be compared THEN each is refused with its place and what to do, before any fit.
#[test]
fn what_cannot_be_compared_is_refused_in_words() {
    let folder = drive();
    let rows = |yaw_rate: fn(f64) -> String| -> String {
        (0..3000).map(|i| f64::from(i) * 0.01).map(|t| format!("{t:.2},{}\n", yaw_rate(t))).collect()
    };
    let weaving = &rows(|t| format!("{:.6}", (2.9 * t * t.sqrt()).sin()));
    let short: String = weaving.lines().take(500).map(|row| format!("{row}\n")).collect();
    for (table, expected) in [
        (format!("t,yaw_rate [parsec]\n{weaving}"), "unit \"parsec\" is not known"),
        (format!("t,yaw_rate [m/s]\n{weaving}"), "does not measure this quantity"),
        (format!("zeit,yaw_rate [rad/s]\n{weaving}"), "no column of time; call it `t [s]`"),
        (format!("t,yaw_rate,Yaw rate\n{weaving}"), "two columns are called yaw_rate"),
        (format!("t,yaw_rate\n{weaving}"), "is of another drive"),
        (format!("t,yaw_rate\n{short}"), "12 s are needed"),
        ("t,yaw_rate\n0.0,0.1\n0.1,zero\n".to_owned(), "line 3: yaw_rate is `zero`"),
        ("t,yaw_rate\n0.0,0.1\n0.0,0.1\n".to_owned(), "line 3: the time goes from 0 s to 0 s"),
        ("t,yaw_rate\n".to_owned(), "there are no rows in it"),
    ] {
        std::fs::write(folder.path().join("simulation.csv"), &table).unwrap();
        let output = explain(folder.path(), &["--simulation", "simulation.csv"]);
        let said = String::from_utf8_lossy(&output.stderr);
        let head = &table[..table.len().min(60)];
        assert_eq!(output.status.code(), Some(1), "{head}: {said}");
        assert!(said.contains("simulation.csv") && said.contains(expected), "{head}: {said}");
    }
    let two = explain(folder.path(), &["drive.log", "--simulation", "truth.csv"]);
    assert_eq!(two.status.code(), Some(2), "{}", String::from_utf8_lossy(&two.stderr));
}

/// Lively steering, for some seconds.
const WEAVE: &str = "[[steering_wheel_angle]]\nkind = \"sine\"\namplitude = 0.35\nfrequency_hz = 0.31\n\
                     [[steering_wheel_angle]]\nkind = \"sine\"\namplitude = 0.2\nfrequency_hz = 0.83\n";

/// GIVEN a car whose tires relax, and a simulation whose tires do not THEN the page says what to change in the model, the
/// second pass is in the answer, and `--apply` writes the effect and nothing else of the car.
#[test]
#[ignore = "long: a car fitted to a simulation"]
fn what_is_left_out_is_told_to_the_modeller_and_applied() {
    let folder = tempfile::tempdir().unwrap();
    simulate(folder.path(), 44.0, WEAVE, ["other.log", "model.csv"]);
    let relaxing = format!("{WEAVE}[[effect]]\nkind = \"relaxation_length\"\nlength_m = 0.7\n");
    simulate(folder.path(), 44.0, &relaxing, ["drive.log", "truth.csv"]);
    let outputs = ["--json", "answer.json", "--html", "page.html", "--apply", "found.toml"];
    let output = explain(folder.path(), &[&["--simulation", "model.csv"], &outputs[..]].concat());
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let read = |name: &str| std::fs::read_to_string(folder.path().join(name)).unwrap();
    let answer: serde_json::Value = serde_json::from_str(&read("answer.json")).unwrap();
    let first = &answer["findings"][0];
    assert_eq!(first["effect"], "relaxation_length", "{}", answer["findings"]);
    let second = &first["second_pass"];
    assert!(second["evidence"].as_f64().unwrap() > 24.0, "{second}");
    assert!(second["explained_share"]["yaw_rate"].as_f64().unwrap() > 0.1, "{second}");
    assert!(second["without"]["yaw_rate"]["rms"].as_f64().unwrap() > 1e-3, "{second}");
    let page = read("page.html");
    let change = page.split_once("What to change in your model").expect("a table of what to change").1;
    assert!(change.contains("too early"), "no time by which side forces are early");
    assert!(page.contains("your simulation with what was found"));
    // The file is the configuration, and the effect.
    let applied = read("found.toml");
    let effect = applied.split_once("kind = \"relaxation_length\"").expect("the effect").1;
    let length = effect.lines().find_map(|line| line.strip_prefix("length_m = ")).expect("its length");
    let length: toml_edit::Value = length.parse().unwrap();
    let length = length.as_float().or_else(|| length.as_inline_table()?.get("value")?.as_float()).unwrap();
    assert!((length - 0.7).abs() < 0.2, "{length}");
    let kept = std::fs::read_to_string(project("config/demo.toml")).unwrap();
    let vehicle =
        |text: &str| text.split_once("[vehicle]").unwrap().1.split_once("\n[").unwrap().0.to_owned();
    assert_eq!(vehicle(&applied), vehicle(&kept));
    assert!(String::from_utf8(output.stdout).unwrap().contains("What to change in your model"));
}

/// GIVEN the guide's bicycle WHEN it is driven by what `replay` decodes THEN its table is one that explain reads, and its yaw
/// rate is nearly the car's.
#[test]
fn the_guide_s_bicycle_drives() {
    if Command::new("python3").arg("--version").output().is_err() {
        println!("skipped: there is no python3");
        return;
    }
    let folder = drive();
    let config = project("config/demo.toml");
    let mut replay = gripd();
    replay.current_dir(folder.path()).args(["-q", "replay", "-c"]).arg(config).arg("drive.log");
    succeeded(replay.args(["--samples", "samples.csv", "-o", "published.log"]));
    let guide = std::fs::read_to_string(project("src/guide/explain-a-mismatch.md")).unwrap();
    let script = guide.split_once("```python\n").unwrap().1.split_once("```").unwrap().0;
    std::fs::write(folder.path().join("bicycle.py"), script).unwrap();
    let mut python = Command::new("python3");
    succeeded(python.current_dir(folder.path()).args(["bicycle.py", "samples.csv", "model.csv"]));
    let column = |file: &str, name: &str| -> Vec<f64> {
        let text = std::fs::read_to_string(folder.path().join(file)).unwrap();
        let place = text.lines().next().unwrap().split(',').position(|cell| cell == name).unwrap();
        text.lines()
            .skip(1)
            .map(|row| row.split(',').nth(place).unwrap().parse().unwrap_or(f64::NAN))
            .collect()
    };
    let (model, measured) = (column("model.csv", "yaw_rate [rad/s]"), column("samples.csv", "yaw_rate"));
    let sums = model.iter().zip(&measured).filter(|(_, measured)| measured.is_finite());
    let (error, all) = sums.fold((0.0, 0.0), |(error, all), (model, measured)| {
        (error + (model - measured).powi(2), all + measured * measured)
    });
    assert!(model.len() > 2500 && error < 0.1 * all, "{} rows, {error} of {all}", model.len());
}
