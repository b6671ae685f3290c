//! The command: the page's data, parts of recordings, refusals.

use super::*;
use crate::interactive::stands_alone;

const PANELS: [&str; 12] = [
    "Speed",
    "Steering wheel",
    "Yaw rate",
    "Lateral acceleration",
    "Longitudinal acceleration",
    "Drive torque",
    "Brake pressure",
    "Sideslip and slip angles",
    "Cornering stiffness",
    "Slip slope of the driven wheels",
    "Friction, used and available",
    "What was valid, and what was wrong",
];

fn titles(data: &Value, kind: &str) -> Vec<String> {
    data[kind].as_array().unwrap().iter().map(|it| it["title"].as_str().unwrap().to_owned()).collect()
}

#[test]
fn a_page_is_one_file_with_everything_in_it() {
    let place = Place::new();
    let page = place.plotted("drive.log");
    stands_alone(&page);
    let data = data(&page);
    assert_eq!(titles(&data, "panels"), PANELS);
    assert_eq!(titles(&data, "figures"), ["Handling curve", "Use of the tires: g-g diagram", "Track"]);
    let rows = data["times"].as_array().unwrap().len();
    assert!(rows > 2900, "{rows}");
    for panel in data["panels"].as_array().unwrap() {
        for series in panel["series"].as_array().unwrap() {
            assert_eq!(series["values"].as_array().unwrap().len(), rows, "{}", series["name"]);
        }
        // An axis says its unit.
        let axis = panel["axis"].as_str().unwrap();
        assert!(axis.is_empty() || axis.contains([',', '/']) || axis.contains("coefficient"), "{axis}");
    }
    // Measured and estimated can be told apart without colours.
    let speed = titled(&data, "panels", "Speed");
    let sources: Vec<_> =
        speed["series"].as_array().unwrap().iter().map(|it| it["source"].as_str().unwrap()).collect();
    assert_eq!(sources, ["estimated", "measured", "measured", "measured", "measured"]);
}

#[test]
fn times_are_seconds_from_the_start_and_the_recordings_own() {
    let place = Place::new();
    place.write("first.log", repeated(1));
    let one = data(&place.plotted("first.log drive.log"));
    assert_eq!(one["clocks"][0]["from_s"], 0.0);
    let utc = one["clocks"][0]["utc_s"].as_f64().unwrap();
    assert!((utc - 1_760_000_000.0).abs() < 0.1, "{utc}");
    // The second recording's clock was never set; it stands a second behind the first one.
    assert_eq!(one["clocks"][1]["utc_s"], Value::Null);
    let from = one["clocks"][1]["from_s"].as_f64().unwrap();
    assert!((from - 31.0).abs() < 0.1, "{from}");
    assert_eq!(one["marks"][0]["name"], "drive.log");
    let last = one["times"].as_array().unwrap().last().unwrap().as_f64().unwrap();
    assert!((last - 61.0).abs() < 0.1, "{last}");
}

#[test]
fn a_part_has_its_samples_only_and_what_was_learned_before() {
    let place = Place::new();
    let part = data(&place.plotted("drive.log --from 20 --to 25"));
    let times: Vec<f64> =
        part["times"].as_array().unwrap().iter().map(|time| time.as_f64().unwrap()).collect();
    assert!(times.len() > 450 && times[0] >= 20.0 && times[times.len() - 1] <= 25.0);
    let slope = titled(&part, "panels", "Slip slope of the driven wheels");
    assert!(slope["series"][0]["values"][0].is_number(), "the estimators began before");
}

#[test]
fn a_panel_without_data_says_so() {
    let place = Place::new();
    // Without the message that carries torque and brake pressure.
    let without: String = drive().split_inclusive('\n').filter(|line| !line.contains(" 1D0#")).collect();
    place.write("drive.log", without);
    let data = data(&place.plotted("drive.log"));
    for title in ["Drive torque", "Brake pressure"] {
        let empty = titled(&data, "panels", title)["empty"].as_str().unwrap();
        assert!(empty.contains("never has a value"), "{empty}");
    }
    assert_eq!(titled(&data, "panels", "Yaw rate")["empty"], Value::Null);
    let answer = titled(&data, "figures", "Handling curve")["answer"].as_str().unwrap();
    assert!(answer.contains("nderstee"), "{answer}");
}

#[test]
fn what_cannot_be_done_is_refused_with_its_reason() {
    let place = Place::new();
    place.write("other.log", "(0.000000) vcan0 123#00\n(1.000000) vcan0 123#01\n");
    for (arguments, code, reason) in [
        ("drive.log", 2, "--html"),
        ("--html page.html", 2, "<LOGS>"),
        ("missing.log --html page.html", 1, "missing.log"),
        ("other.log --html page.html", 1, "none of the needed identifiers"),
        ("drive.log --html nowhere/page.html", 1, "is there such a folder?"),
        ("drive.log --html drive.log", 2, "is read from and would be written to"),
        ("drive.log --html page.html --from 50", 2, "are of 0.0 to 30.0 s"),
        ("drive.log --html page.html --from=-1", 2, "zero or more"),
        ("drive.log --html page.html --from 5 --to 5", 2, "more than --from"),
        ("drive.log --html page.html --from nan", 2, "is neither seconds"),
    ] {
        let output = place.plot(arguments);
        let told = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(code), "{arguments}: {told}");
        assert!(told.contains(reason), "{arguments}: {told}");
        assert!(!place.path("page.html").exists(), "{arguments}: half a page is left");
    }
    assert!(fs::read_to_string(place.path("drive.log")).unwrap() == drive());
}

#[test]
fn of_a_damaged_recording_what_could_be_read_is_drawn() {
    let place = Place::new();
    let packed = zstd::encode_all(drive().as_bytes(), 3).unwrap();
    place.write("cut.log.zst", &packed[..packed.len() * 2 / 3]);
    let output = place.plot("cut.log.zst --html page.html");
    let told = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(1), "{told}");
    assert!(told.contains("cut.log.zst"), "{told}");
    let page = fs::read_to_string(place.path("page.html")).unwrap();
    assert!(data(&page)["times"].as_array().unwrap().len() > 100);
}

#[test]
fn the_standard_output_has_the_page_and_nothing_else() {
    let place = Place::new();
    let output = place.plot("drive.log --html -");
    let text = String::from_utf8(output.stdout).unwrap();
    assert!(text.starts_with("<!DOCTYPE html>") && text.ends_with("</html>\n"));
    assert!(text == place.plotted("drive.log"), "the same input gives the same page");
}

/// Four minutes of bends at three speeds, in place of the demo's driver.
const BENDS: &str = r#"[driver]
[[driver.speed_mps]]
kind = "points"
points = [[0, 12], [60, 12], [80, 18], [140, 18], [160, 25], [230, 25]]
[[steering_wheel_angle]]
kind = "points"
points = [
    [5, 0], [8, 0.6], [16, 0.6], [20, -0.7], [30, -0.7], [34, 0], [90, 0], [93, 0.4], [105, 0.4], [108, -0.35],
    [120, -0.35], [125, 0], [165, 0], [168, 0.25], [180, 0.25], [184, -0.25], [200, -0.25], [204, 0],
]
[[steering_wheel_angle]]
kind = "random"
rms = 0.02
correlation_time_s = 2.0

"#;

#[test]
fn the_understeer_gradient_of_a_simulated_car_is_in_its_interval() {
    let place = Place::new();
    // On one road, with tires that do not bend: the gradient is (1 / front − 1 / rear) stiffness.
    let demo = fs::read_to_string(project("config/scenarios/demo.toml")).unwrap();
    let (before, rest) = demo.split_once("[[road]]\nfrom_s = 45.0").unwrap();
    let (_, chain) = rest.split_once("# The ordinary measuring chain").unwrap();
    let scenario = format!("{before}[abs]\n\n{BENDS}#{chain}")
        .replace("duration_s = 120.0", "duration_s = 230.0")
        .replace("tire = \"brush\"", "tire = \"linear\"");
    let truth_deg_per_g = (1.0_f64 / 13.0 - 1.0 / 16.0).to_degrees();
    assert!(scenario.contains("lateral_stiffness_front = 13.0\nlateral_stiffness_rear = 16.0"));
    place.write("bends.toml", scenario);
    let simulate = "simulate bends.toml -o bends.log";
    let simulated = gripd().current_dir(place.0.path()).args(simulate.split(' ')).status().unwrap();
    assert!(simulated.success());
    let data = data(&place.plotted("bends.log"));
    let figure = titled(&data, "figures", "Handling curve");
    let line = figure["lines"].as_array().unwrap().last().unwrap();
    let of = |y: &Value| {
        let at = |list: &Value, place: usize| list[place].as_f64().unwrap();
        9.81 * (at(y, 2) - at(y, 1)) / (at(&line["x"], 2) - at(&line["x"], 1))
    };
    let (low, high) = (of(&line["interval"][0]), of(&line["interval"][1]));
    assert!((low..=high).contains(&truth_deg_per_g), "{low} to {high} ° per g for {truth_deg_per_g}");
    assert!(high - low < 0.2, "{}", figure["answer"]);
}
