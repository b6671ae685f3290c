//! The demo's car and a drive of it, as frames.

use std::path::{Path, PathBuf};
use std::sync::OnceLock;

use gripd::can::Frame;
use gripd::cli::SimulatedFrames;
use gripd::model::{Scenario, Simulation};
use gripd::service::Engine;
use gripd::signals::Outputs;
use gripd::{Config, Micros};

/// A file of the project.
pub fn project(path: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join(path)
}

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
    Config::parse(&edited, &project("config/demo.toml")).unwrap()
}

pub fn engine(config: &Config) -> Engine {
    Engine::new(config).unwrap()
}

/// 40 s of the demo's drive: asphalt, curves, a firm braking.
pub fn drive() -> &'static [Frame] {
    static DRIVE: OnceLock<Vec<Frame>> = OnceLock::new();
    DRIVE.get_or_init(|| {
        let text = std::fs::read_to_string(project("config/scenarios/demo.toml")).unwrap();
        let shorter = text.replace("duration_s = 120.0", "duration_s = 40.0");
        assert_ne!(text, shorter, "the scenario has another length now");
        let scenario: Scenario = toml::from_str(&shorter).unwrap();
        let config = config();
        let outputs = Outputs::compile(
            &config.signals,
            &config.input_database().unwrap(),
            scenario.vehicle.wheel_radius_m.value,
        );
        let mut frames = SimulatedFrames::new(outputs.unwrap());
        let mut simulation = Simulation::new(&scenario, 1).unwrap();
        let mut drive = Vec::new();
        while let Some(tick) = simulation.next_tick() {
            frames.take(tick.readings, &mut |frame| drive.push(*frame));
        }
        assert!(drive.len() > 10_000);
        drive
    })
}

/// Seconds since the drive's first frame.
pub fn seconds(time: Micros) -> f64 {
    (time - drive()[0].time).seconds()
}
