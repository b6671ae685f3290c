//! `gripd calibrate` as its users meet it: simulated ABS tests in, a mapping or the reason against one
//! out, and the mapping at work in `gripd replay`.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use gripd::model::TireKind;
use gripd::reproduce::abs_tests::{AbsTest, scenario};
use serde_json::Value;
use tempfile::TempDir;
use testing::program::{gripd, project};

const ASPHALT: AbsTest = AbsTest::settled(0.95, 95.0);
const GRAVEL: AbsTest = AbsTest::settled(0.55, 50.0);

/// `gripd`, which says nothing but what goes wrong.
fn quiet() -> Command {
    let mut command = gripd();
    command.arg("--quiet");
    command
}

/// A folder with recordings in it.
struct Place(TempDir);

impl Place {
    fn new() -> Self {
        Self(TempDir::new().unwrap())
    }

    fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    /// Simulates a drive to `name`.
    fn record(&self, name: &str, tests: &[AbsTest], seed: u64) -> PathBuf {
        self.record_rough(name, tests, seed, &[])
    }

    /// The same with roads that shake the wheels.
    fn record_rough(&self, name: &str, tests: &[AbsTest], seed: u64, rough: &[usize]) -> PathBuf {
        let mut drive = scenario(tests, TireKind::Piecewise).unwrap();
        for road in rough {
            drive.road[*road].roughness_mps = 0.12;
        }
        let toml = self.path("scenario.toml");
        fs::write(&toml, toml::to_string(&drive).unwrap()).unwrap();
        let log = self.path(name);
        let output = quiet()
            .arg("simulate")
            .arg(toml)
            .arg("-o")
            .arg(&log)
            .args(["--seed", &seed.to_string()])
            .output();
        assert_eq!(output.unwrap().status.code(), Some(0));
        log
    }

    fn calibrate(&self, logs: &[PathBuf]) -> (Output, Value) {
        let json = self.path("result.json");
        let mut command = quiet();
        command.arg("calibrate").arg("-c").arg(project("config/demo.toml")).args(logs);
        let output = command.arg("--json").arg(&json).output().unwrap();
        let value = fs::read(json).map_or(Value::Null, |text| serde_json::from_slice(&text).unwrap());
        (output, value)
    }

    /// The estimates, row by row.
    fn replay(&self, car: &Path, drive: &Path) -> Vec<BTreeMap<String, String>> {
        let estimates = self.path("estimates.csv");
        let mut command = quiet();
        command.args(["replay", "-c"]).arg(car).arg(drive).arg("--estimates").arg(&estimates);
        let replay = command.output().unwrap();
        assert_eq!(replay.status.code(), Some(0), "{}", text(&replay.stderr));
        csv::Reader::from_path(estimates).unwrap().deserialize().map(Result::unwrap).collect()
    }
}

fn text(bytes: &[u8]) -> &str {
    std::str::from_utf8(bytes).unwrap()
}

#[test]
fn two_surfaces_give_a_mapping_that_works_in_the_service() {
    let place = Place::new();
    let logs = [
        place.record("one.log", &[ASPHALT, GRAVEL, ASPHALT, GRAVEL], 1),
        place.record("two.log.gz", &[GRAVEL, ASPHALT, GRAVEL, ASPHALT], 2),
    ];
    let (output, json) = place.calibrate(&logs);
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
    let brakings = json["brakings"].as_array().unwrap();
    assert_eq!((brakings.len(), json["pairs"].as_u64().unwrap()), (8, 8), "{json:#}");
    for (braking, (mu, slope)) in
        brakings.iter().zip([(0.95, 95.0), (0.55, 50.0), (0.95, 95.0), (0.55, 50.0), (0.55, 50.0)])
    {
        assert!((braking["mu"].as_f64().unwrap() - mu).abs() < 0.04, "{braking}");
        // The data sheet's mass is 3 % low, and so are all forces' shares of the load.
        assert!((braking["slope"].as_f64().unwrap() - slope).abs() < 0.15 * slope, "{braking}");
        assert_eq!((&braking["pair"], &braking["reason"]), (&Value::Bool(true), &Value::Null));
    }
    let chosen = &json["chosen"];
    assert_eq!((chosen["kind"].as_str(), chosen["pairs"].as_u64()), (Some("linear"), Some(8)));
    assert_eq!(json["reason"], Value::Null);
    assert_eq!(json["fits"].as_array().unwrap().len(), 3);
    assert!(json["remarks"][0].as_str().unwrap().contains("no pair between slopes"), "{json:#}");

    // What is printed can be appended to the configuration as it is.
    let dbc = project("dbc/demo.dbc");
    let config = fs::read_to_string(project("config/demo.toml"))
        .unwrap()
        .replace("../dbc/demo.dbc", dbc.to_str().unwrap());
    let car = place.path("car.toml");
    fs::write(&car, config + "\n" + text(&output.stdout)).unwrap();
    let drive = place.record("drive.log", &[ASPHALT, GRAVEL, AbsTest::settled(0.2, 25.0)], 3);
    let rows = place.replay(&car, &drive);
    let number = |row: usize, name: &str| rows[row][name].parse::<f64>().ok();
    // Just before the brakings, 27 s into each surface of some 38 s.
    for (row, mu) in [(2600, 0.95), (2600 + 3830, 0.55)] {
        let (low, high) = (number(row, "mu_map_low").unwrap(), number(row, "mu_map_high").unwrap());
        let map = number(row, "mu_map").unwrap();
        assert!(low < mu && mu < high && high - low < 0.4, "{low} {map} {high}");
        assert_eq!((rows[row]["mu_source"].as_str(), rows[row]["mu_valid"].as_str()), ("slope_map", "0"));
    }
    // Ice is softer than anything calibrated on: no mapping.
    assert_eq!(number(2600 + 2 * 3830, "mu_map"), None);

    // The same gravel, but rough as none of the roads that the calibration saw.
    assert!(text(&output.stdout).contains("\nroughness_mps = [0.0"), "{}", text(&output.stdout));
    let rows = place.replay(&car, &place.record_rough("rough.log", &[ASPHALT, GRAVEL], 5, &[1]));
    let number = |row: usize, name: &str| rows[row][name].parse::<f64>().ok();
    assert!(number(2600, "mu_map").is_some());
    assert!(number(2600 + 3830, "slope_fl").is_some() && number(2600 + 3830, "roughness").unwrap() > 0.08);
    assert_eq!(number(2600 + 3830, "mu_map"), None);
}

#[test]
fn one_surface_is_refused_and_every_braking_listed() {
    let place = Place::new();
    let hasty = AbsTest::too_soon(0.5, 45.0);
    let tests = [ASPHALT, ASPHALT, ASPHALT, ASPHALT, ASPHALT, ASPHALT, hasty];
    let (output, json) = place.calibrate(&[place.record("drive.log", &tests, 4)]);
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
    assert_eq!((json["pairs"].as_u64(), &json["chosen"]), (Some(6), &Value::Null), "{json:#}");
    let reason = json["reason"].as_str().unwrap();
    assert!(reason.contains("not spread enough"), "{reason}");
    let last = json["brakings"].as_array().unwrap().last().unwrap();
    assert_eq!(last["pair"], Value::Bool(false));
    let printed = text(&output.stdout);
    assert!(printed.contains(last["reason"].as_str().unwrap()) && printed.contains(reason), "{printed}");
    // A refusal leaves nothing that could be taken for a mapping.
    assert!(printed.lines().all(|line| line.starts_with('#')), "{printed}");
}

#[test]
fn without_brakings_or_the_signal_it_says_what_is_missing() {
    let place = Place::new();
    let gentle = fs::read_to_string(project("config/scenarios/demo.toml"))
        .unwrap()
        .replace("duration_s = 120.0", "duration_s = 12.0");
    fs::write(place.path("gentle.toml"), gentle).unwrap();
    let log = place.path("gentle.log");
    quiet().arg("simulate").arg(place.path("gentle.toml")).arg("-o").arg(&log).output().unwrap();
    let (output, json) = place.calibrate(std::slice::from_ref(&log));
    assert_eq!(output.status.code(), Some(1));
    assert!(text(&output.stderr).contains("no ABS braking"), "{}", text(&output.stderr));
    assert_eq!(json["pairs"], 0);

    let foreign = place.path("foreign.log");
    fs::write(&foreign, "(1.000000) can0 7FF#00\n(1.010000) can0 7FF#00\n").unwrap();
    let (output, _) = place.calibrate(&[foreign]);
    assert_eq!(output.status.code(), Some(1));
    assert!(text(&output.stderr).contains("none of the needed identifiers"), "{}", text(&output.stderr));

    let (output, _) = place.calibrate(&[place.path("absent.log")]);
    assert_eq!(output.status.code(), Some(1));
    assert!(text(&output.stderr).contains("absent.log"));

    let config = fs::read_to_string(project("config/demo.toml")).unwrap();
    let without = place.path("without.toml");
    fs::write(&without, config.replace("abs_active = \"DRIVE.AbsActive\"", "")).unwrap();
    let output = quiet().args(["calibrate", "-c"]).arg(&without).arg(&log).output().unwrap();
    assert_eq!(output.status.code(), Some(2));
    assert!(text(&output.stderr).contains("signals.abs_active"), "{}", text(&output.stderr));

    let config = project("config/demo.toml");
    let output = quiet().args(["calibrate", "-c"]).arg(config).arg(&log).arg("--json").arg(&log).output();
    assert_eq!(output.unwrap().status.code(), Some(2));
    assert!(fs::metadata(&log).unwrap().len() > 1000, "the recording is still there");
}

#[test]
fn a_mapping_that_cannot_be_is_a_configuration_error_with_its_key() {
    let place = Place::new();
    let config = fs::read_to_string(project("config/demo.toml")).unwrap()
        + "\n[estimators.mapping]\nkind = \"linear\"\ncoefficients = [0.008, 0.2]\ncovariance = [[1e-6, 0.0], \
           [0.0, 1e-3]]\nresidual_std = 0.04\nslope_range = [90.0, 50.0]\npairs = 9\n";
    fs::write(place.path("car.toml"), config).unwrap();
    let output = quiet().args(["check", "-c"]).arg(place.path("car.toml")).output().unwrap();
    assert_eq!(output.status.code(), Some(2));
    assert!(text(&output.stderr).contains("estimators.mapping.slope_range"), "{}", text(&output.stderr));
}
