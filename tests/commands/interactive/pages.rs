//! What the pages of `explain`, `identify` and `replay` show of a simulated drive.

use std::fs;
use std::path::PathBuf;
use std::time::Duration;

use tempfile::TempDir;
use testing::program::{gripd, project};

use super::*;
use crate::changed::plain;

/// Demo drives on one road, whose driver steers more than the demo's.
struct Garage(TempDir);

/// Bends at several speeds, beside the demo's own random ones.
const STEERING: &str = "[[steering_wheel_angle]]\nkind = \"sine\"\namplitude = 0.5\nfrequency_hz = 0.23\n\n";

impl Garage {
    fn new(seconds: u32, effect: &str) -> Self {
        let garage = Self(TempDir::new().unwrap());
        let demo = plain(&fs::read_to_string(project("config/scenarios/demo.toml")).unwrap());
        let (before, rest) = demo.split_once("[[road]]\nfrom_s = 45.0").unwrap();
        let (_, chain) = rest.split_once("# The ordinary measuring chain").unwrap();
        let scenario = format!("{before}[abs]\n\n{STEERING}{effect}\n#{chain}")
            .replace("duration_s = 120.0", &format!("duration_s = {seconds}.0"));
        fs::write(garage.path("drive.toml"), scenario).unwrap();
        garage.run(&["simulate", "drive.toml", "-o", "drive.log"]);
        garage
    }

    fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    #[track_caller]
    fn run(&self, arguments: &[&str]) {
        let output = gripd().current_dir(self.0.path()).arg("-q").args(arguments).output().unwrap();
        assert!(output.status.success(), "{arguments:?}: {}", String::from_utf8_lossy(&output.stderr));
    }

    /// The page of a command on the drive.
    #[track_caller]
    fn page(&self, arguments: &[&str]) -> String {
        let config = project("config/demo.toml");
        let (command, options) = arguments.split_first().unwrap();
        let fixed = [command, "-c", config.to_str().unwrap(), "drive.log", "--html", "page.html"];
        self.run(&[&fixed[..], options].concat());
        let page = fs::read_to_string(self.path("page.html")).unwrap();
        stands_alone(&page);
        page
    }
}

fn titles(data: &Value, kind: &str) -> Vec<String> {
    data[kind].as_array().unwrap().iter().map(|it| it["title"].as_str().unwrap().to_owned()).collect()
}

/// All panels of a page zoom together, the cursor is everywhere, and it suits every screen.
fn looked_at(garage: &Garage, panels: usize) {
    let Some(mut browser) = Browser::start() else { return };
    let tab = open(&mut browser, &garage.path("page.html"));
    let (from, to) = shown(&mut browser, &tab, panels);
    assert!(to > from);
    browser.evaluate(&tab, "gripd.show(20, 30)");
    assert_eq!(shown(&mut browser, &tab, panels), (20.0, 30.0));
    browser.evaluate(&tab, "gripd.point(25)");
    let numbers = "[...document.querySelectorAll('#panels .legend b')].filter((it) => it.textContent).length";
    assert!(browser.evaluate(&tab, numbers).as_u64().unwrap() as usize >= panels);
    let here = "document.querySelectorAll('#figures .here:not([hidden])').length";
    assert!(browser.evaluate(&tab, here).as_u64().unwrap() >= 1, "no place on the track");
    browser.evaluate(&tab, "gripd.reset()");
    let (first, last) = shown(&mut browser, &tab, panels);
    assert!((first - from).abs() < 1e-6 && (last - to).abs() < 1e-6, "{first} to {last}");
    suits_every_screen(&mut browser, &tab);
    std::thread::sleep(Duration::from_millis(200));
    assert_eq!(browser.complaints(), Vec::<String>::new());
}

#[test]
#[ignore = "long: explains a drive, in a browser"]
fn explain_shows_both_models_their_errors_and_what_was_found() {
    let late = "[[effect]]\nkind = \"sensor_delay\"\nchannel = \"yaw_rate\"\ndelay_s = 0.08\n";
    let garage = Garage::new(40, late);
    let page = garage.page(&["explain"]);
    let data = data(&page);
    let panels = titles(&data, "panels");
    assert_eq!(
        panels[..4],
        ["Yaw rate", "Yaw rate: error", "Lateral acceleration", "Lateral acceleration: error"]
    );
    let yaw_rate = titled(&data, "panels", "Yaw rate");
    let names: Vec<&str> =
        yaw_rate["series"].as_array().unwrap().iter().map(|it| it["name"].as_str().unwrap()).collect();
    assert_eq!(names[..2], ["measured", "plain model"]);
    // The error is the difference of what is drawn above it, and small beside it.
    let error = titled(&data, "panels", "Yaw rate: error");
    assert!(error["shades"][0]["name"].as_str().unwrap().contains("held out"), "{}", error["shades"]);
    assert!(error["caption"].as_str().unwrap().contains("°/s"), "{}", error["caption"]);
    let row = |series: &Value| -> Vec<f64> {
        series["values"].as_array().unwrap().iter().map(|it| it.as_f64().unwrap_or(f64::NAN)).collect()
    };
    let rows = [row(&yaw_rate["series"][0]), row(&yaw_rate["series"][1]), row(&error["series"][0])];
    let off = (0..rows[0].len()).map(|k| rows[0][k] - rows[1][k] - rows[2][k]).filter(|it| it.is_finite());
    assert!(off.map(f64::abs).fold(0.0, f64::max) < 0.5, "°/s");
    for title in ["Where they differ", "Speed", "Steering wheel"] {
        assert!(panels.iter().any(|it| it == title), "{title}: {panels:?}");
    }
    let figures = titles(&data, "figures");
    for title in ["Handling curve", "Track"] {
        assert!(figures.iter().any(|it| it == title), "{title}: {figures:?}");
    }
    looked_at(&garage, 6);
}

#[test]
#[ignore = "long: in a browser"]
fn identify_shows_what_it_fitted_and_what_it_predicts() {
    let garage = Garage::new(45, "");
    let page = garage.page(&["identify", "--starts", "2"]);
    let data = data(&page);
    assert_eq!(titles(&data, "panels")[..2], ["Yaw rate", "Yaw rate: error"]);
    let figures = titles(&data, "figures");
    for title in ["Handling curve", "Track", "Where the searches began and ended"] {
        assert!(figures.iter().any(|it| it == title), "{title}: {figures:?}");
    }
    looked_at(&garage, 6);
    let page = garage.page(&["identify", "--method", "ordinary"]);
    let error = super::data(&page);
    let error = titled(&error, "panels", "Yaw rate: error");
    assert!(error["shades"][0]["name"].as_str().unwrap().contains("held out"), "{}", error["shades"]);
    assert!(page.contains("Held-out error, yaw rate"));
    looked_at(&garage, 6);
}

#[test]
#[ignore = "long: in a browser"]
fn replay_shows_its_estimates_and_what_was_learned() {
    let garage = Garage::new(90, "");
    let page = garage.page(&["replay"]);
    let data = data(&page);
    for title in ["Cornering stiffness", "Friction, used and available", "What was valid, and what was wrong"]
    {
        titled(&data, "panels", title);
    }
    assert!(page.contains("What was learned") && page.contains("Cornering stiffness, front"));
    looked_at(&garage, 10);
}
