//! A car with all wheels driven: no wheel rolls freely, and the slip slope comes from the speed that the
//! accelerometer carries on (`estimate/overall_slope`).

use std::fmt::Write as _;
use std::path::Path;

use gripd::model::{DrivenAxle, Scenario, Truth};
use gripd::{Config, Estimates};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use testing::driven;
use testing::results::Section;

const CAR: &str = include_str!("../../config/demo.toml");
const DEMO: &str = include_str!("../../config/scenarios/demo.toml");
/// Since when, slope and friction.
const ROADS: [(f64, f64, f64); 3] = [(0.0, 95.0, 1.0), (200.0, 40.0, 0.7), (400.0, 95.0, 1.0)];
const SECONDS: f64 = 600.0;

/// Speeds up and brakes by turns, between 8 and 30 m/s, over hills; the accelerometer is `late_ms` late.
fn scenario(seed: u64, late_ms: f64) -> Scenario {
    let mut dice = ChaCha8Rng::seed_from_u64(seed);
    let (mut speeds, mut times, mut grades, mut roads) =
        (String::new(), String::new(), String::new(), String::new());
    let mut at = 0.0;
    while at < SECONDS {
        let speed = dice.random_range(8.0..30.0);
        let until = at + dice.random_range(3.0..11.0);
        write!(speeds, "[{at}, {speed}], [{until}, {speed}], ").unwrap();
        at = until + dice.random_range(3.0..6.0);
    }
    for corner in 0..=75 {
        write!(times, "{}, ", 8 * corner).unwrap();
        write!(grades, "{}, ", dice.random_range(-0.035..0.035)).unwrap();
    }
    for (from, slope, friction) in ROADS {
        writeln!(
            roads,
            "[[road]]\nfrom_s = {from}\ntransition_s = 0.1\nname = \"road\"\nslope = {slope}\nfriction = {friction}"
        )
        .unwrap();
    }
    let vehicle = DEMO.find("[vehicle]").unwrap()..DEMO.find("[radius_difference]").unwrap();
    let sensors = &DEMO[DEMO.find("[sensors.wheel_speed]").unwrap()..];
    let late = format!("offset = -0.03\ndelay_ms = {late_ms}");
    let text = format!(
        "duration_s = {SECONDS}\ninitial_speed_mps = 15.0\n{}[radius_difference]\nfl = 0.001\nrl = 0.01\nrr = 0.0095\n\
         {roads}[abs]\n[driver]\nacceleration_max_mps2 = 2.5\ndeceleration_max_mps2 = 4.0\n\
         [[driver.speed_mps]]\nkind = \"points\"\npoints = [{speeds}]\n\
         [[driver.speed_mps]]\nkind = \"random\"\nrms = 3.0\ncorrelation_time_s = 3.0\n\
         [[steering_wheel_angle]]\nkind = \"random\"\nrms = 0.08\ncorrelation_time_s = 1.0\n\
         [[effect]]\nkind = \"road_grade\"\nseries = {{ t = [{times}], value = [{grades}] }}\n{}",
        &DEMO[vehicle],
        sensors.replace("offset = -0.03\ndelay_ms = 3.0", &late)
    );
    let mut scenario = Scenario::parse(&text).unwrap_or_else(|error| panic!("{error}\n{text}"));
    scenario.vehicle.driven_axle = DrivenAxle::All;
    scenario
}

fn drive(scenario: &Scenario, seed: u64, without: &[&str], mut take: impl FnMut(&Truth, &Estimates)) {
    let mut config = Config::parse(CAR, Path::new("demo.toml")).unwrap();
    config.vehicle.driven_axle = DrivenAxle::All;
    driven::drive(
        scenario,
        seed,
        config,
        without,
        |reading| *reading,
        |_, truth, estimates| {
            take(truth, estimates);
        },
    );
}

fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    values[values.len() / 2]
}

/// GIVEN brakings from different speeds on hills WHEN the accelerometer is in time, or late THEN the slope is found,
/// its interval holds it, and another road is noticed.
#[test]
fn the_slope_is_found_though_no_wheel_rolls() {
    let mut rows = Vec::new();
    for (seed, late_ms) in [(1, 3.0), (2, 3.0), (3, 30.0)] {
        let (mut errors, mut samples, mut outside) = (Vec::new(), 0.0, 0.0);
        let mut changes = Vec::new();
        drive(&scenario(seed, late_ms), seed, &[], |truth, estimates| {
            let at = truth.time.seconds();
            if changes.len() < estimates.surface_changes as usize {
                changes.push(at);
            }
            samples += 1.0;
            if !estimates.slope_valid {
                return;
            }
            for (slope, truth) in estimates.slope.iter().zip(truth.slope) {
                let slope = slope.unwrap();
                errors.push((slope.value / truth - 1.0).abs());
                outside += f64::from(u8::from((slope.value - truth).abs() > 1.96 * slope.std));
            }
        });
        let (share, outside) = (errors.len() as f64 / samples / 4.0, outside / errors.len() as f64);
        let error = median(errors);
        rows.push(format!(
            "{late_ms} ms | {:.0} % | {:.1} % | {:.1} % | {}",
            100.0 * share,
            100.0 * error,
            100.0 * outside,
            changes.len()
        ));
        assert!(share > 0.7 && error < 0.15 && outside < 0.15, "{share} {error} {outside}");
        let noticed = |from: f64| changes.iter().any(|at| (from..from + 60.0).contains(at));
        assert!(noticed(ROADS[1].0) && noticed(ROADS[2].0) && changes.len() <= 4, "{changes:?}");
    }
    let section = Section {
        name: "all_driven",
        seed: "seeds 1 to 3",
        tolerance: 0.02,
        header: "accelerometer late by | slope valid | off by, in the median | outside its 95 % interval | changes noticed, of 2",
    };
    section.check(&rows);
}

/// GIVEN no accelerometer along the car, or a drive at a steady speed THEN nothing is known, and that is said.
#[test]
fn without_an_accelerometer_or_without_forces_there_is_none() {
    let mut silent = 0;
    drive(&scenario(1, 3.0), 1, &["longitudinal_acceleration"], |_, estimates| {
        assert_eq!((estimates.slope, estimates.slope_valid), ([None; 4], false));
        silent += 1;
    });
    assert!(silent > 50_000);
    let mut steady = scenario(1, 3.0);
    let speed = vec![toml::from_str("kind = \"points\"\npoints = [[0, 15], [1, 15]]").unwrap()];
    steady.driver.as_mut().unwrap().speed_mps = speed;
    steady.duration_s = 120.0;
    drive(&steady, 1, &[], |_, estimates| assert!(!estimates.slope_valid));
}
