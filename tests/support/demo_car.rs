//! The demo's car and a drive of it, as frames.

use std::sync::OnceLock;

use gripd::can::Frame;
use gripd::cli::SimulatedFrames;
use gripd::model::{Reading, Scenario, Simulation};
use gripd::service::Engine;
use gripd::signals::Outputs;
use gripd::{Config, Micros};

use crate::program::project;

pub fn text() -> String {
    std::fs::read_to_string(project("config/demo.toml")).unwrap()
}

pub fn config() -> Config {
    with(&[])
}

/// The demo's car with parts of its configuration exchanged.
pub fn with(edits: &[(&str, &str)]) -> Config {
    let edited = edits.iter().fold(text(), |text, (was, is)| {
        assert_eq!(text.matches(was).count(), 1, "{was}");
        text.replace(was, is)
    });
    let mut config = Config::parse(&edited, &project("config/demo.toml")).unwrap();
    // These cars send a message once for each of their readings, and a late one by itself.
    config.signals.sampling.rate_watch = false;
    config
}

pub fn engine(config: &Config) -> Engine {
    Engine::new(config).unwrap()
}

/// 40 s of the demo's drive: asphalt, curves, a firm braking.
pub fn drive() -> &'static [Frame] {
    static DRIVE: OnceLock<Vec<Frame>> = OnceLock::new();
    DRIVE.get_or_init(|| frames_of(&config(), readings()))
}

/// What the sensors say in it.
pub fn readings() -> &'static [Reading] {
    static READINGS: OnceLock<Vec<Reading>> = OnceLock::new();
    READINGS.get_or_init(|| simulated(&[]))
}

/// The same, slowing down to walking pace from 10 to 15 s.
pub fn stopping() -> &'static [Reading] {
    static READINGS: OnceLock<Vec<Reading>> = OnceLock::new();
    READINGS.get_or_init(|| {
        simulated(&[("[0, 15], [8, 22],", "[0, 15], [5, 15], [10, 1.5], [15, 1.5], [20, 20],")])
    })
}

fn simulated(edits: &[(&str, &str)]) -> Vec<Reading> {
    let text = std::fs::read_to_string(project("config/scenarios/demo.toml")).unwrap();
    let edits = [&[("duration_s = 120.0", "duration_s = 40.0")], edits].concat();
    let text = edits.iter().fold(text, |text, (was, is)| {
        assert_eq!(text.matches(was).count(), 1, "{was}");
        text.replace(was, is)
    });
    let scenario: Scenario = toml::from_str(&text).unwrap();
    let mut simulation = Simulation::new(&scenario, 1).unwrap();
    let mut readings = Vec::new();
    while let Some(tick) = simulation.next_tick() {
        readings.extend_from_slice(tick.readings);
    }
    readings
}

/// Readings, in order of time, as the car's frames.
pub fn frames_of(config: &Config, readings: &[Reading]) -> Vec<Frame> {
    let database = config.input_database().unwrap();
    let outputs = Outputs::compile(&config.signals, &database, config.vehicle.wheel_radius_m.value).unwrap();
    let (mut simulated, mut frames) = (SimulatedFrames::new(outputs), Vec::new());
    simulated.take(readings, &mut |frame| frames.push(*frame));
    assert!(frames.len() > 10_000);
    frames
}

/// Seconds since the drive's first frame.
pub fn seconds(time: Micros) -> f64 {
    (time - drive()[0].time).seconds()
}
