//! A simulated drive as frames through the whole engine, each estimate beside what was true.

use gripd::can::Frame;
use gripd::cli::SimulatedFrames;
use gripd::dbc::Database;
use gripd::model::{Scenario, Simulation, Truth};
use gripd::service::{Engine, Sink};
use gripd::signals::Outputs;
use gripd::{Config, Estimates, Sample};

const CAR_DBC: &str = include_str!("../../dbc/demo.dbc");

/// Collects what the engine knows, beside what was true.
#[derive(Default)]
struct Record {
    truths: Vec<Truth>,
    rows: Vec<(Truth, Estimates)>,
}

impl Sink for Record {
    fn estimates(&mut self, sample: &Sample, estimates: &Estimates) {
        let place = self.truths.partition_point(|truth| truth.time < sample.time);
        if let Some(truth) = self.truths.get(place) {
            self.rows.push((*truth, *estimates));
        }
    }

    fn publish(&mut self, _frame: &Frame) {}
}

/// Drives a scenario through the engine of a car that sends what the demo's does; the engine does not look at the
/// signals of `without`.
pub fn drive(
    scenario: &Scenario,
    seed: u64,
    mut config: Config,
    without: &[&str],
) -> Vec<(Truth, Estimates)> {
    let database = Database::parse(CAR_DBC.as_bytes(), "demo.dbc").unwrap();
    let radius = scenario.vehicle.wheel_radius_m.value;
    let outputs = Outputs::compile(&config.signals, &database, radius).unwrap();
    config.signals.quantities.retain(|quantity, _| !without.contains(&quantity.name()));
    let output = gripd::signals::publish::built_in_database().unwrap();
    let mut engine = Engine::with_databases(&config, &database, &output).unwrap();
    let mut frames = SimulatedFrames::new(outputs);
    let mut record = Record::default();
    let mut simulation = Simulation::new(scenario, seed).unwrap();
    let mut sent = Vec::new();
    while let Some(tick) = simulation.next_tick() {
        record.truths.push(*tick.truth);
        frames.take(tick.readings, &mut |frame| sent.push(*frame));
        for frame in sent.drain(..) {
            engine.frame(&frame, &mut record);
        }
    }
    engine.finish(&mut record);
    record.rows
}
