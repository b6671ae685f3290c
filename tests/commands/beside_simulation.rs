//! `gripd explain --simulation`: somebody's simulation beside a recording of the same drive.

use std::path::Path;
use std::process::Output;

use tempfile::TempDir;
use testing::program::{gripd, project};

/// A drive of the demo's car as a recording, and what was true as another program's table.
fn drive() -> TempDir {
    let folder = tempfile::tempdir().unwrap();
    let demo = std::fs::read_to_string(project("config/scenarios/demo.toml")).unwrap();
    let scenario = demo.replace("duration_s = 120.0", "duration_s = 30.0");
    std::fs::write(folder.path().join("scenario.toml"), scenario).unwrap();
    let output = gripd()
        .current_dir(folder.path())
        .args(["-q", "simulate", "scenario.toml", "-o", "drive.log", "--truth", "truth.csv"])
        .output()
        .unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    folder
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
        &["--simulation", "truth.csv", "--json", "answer.json", "--html", "page.html"],
    );
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
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
