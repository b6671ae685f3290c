//! A simulated drive as frames through the whole engine, each sample and estimate beside what was true.

use std::collections::VecDeque;

use gripd::can::Frame;
use gripd::cli::SimulatedFrames;
use gripd::dbc::Database;
use gripd::model::{Reading, Scenario, Simulation, Truth};
use gripd::service::{Engine, Sink};
use gripd::signals::Outputs;
use gripd::{Config, Estimates, Sample};

pub const CAR_DBC: &str = include_str!("../../dbc/demo.dbc");

/// Hands on what the engine knows, beside what was true.
struct Beside<F> {
    /// Not older than the samples to come: hours of driving need no more memory than minutes.
    truths: VecDeque<Truth>,
    take: F,
}

impl<F: FnMut(&Sample, &Truth, &Estimates)> Sink for Beside<F> {
    fn estimates(&mut self, sample: &Sample, estimates: &Estimates) {
        while self.truths.front().is_some_and(|truth| truth.time < sample.time) {
            self.truths.pop_front();
        }
        if let Some(truth) = self.truths.front() {
            (self.take)(sample, truth, estimates);
        }
    }

    fn publish(&mut self, _frame: &Frame) {}
}

/// Drives a scenario through the engine of a car that sends what the demo's does; the engine does not look at the
/// signals of `without`. What the sensors read is sent as `sent_as` makes it.
pub fn drive(
    scenario: &Scenario,
    seed: u64,
    config: Config,
    without: &[&str],
    sent_as: fn(&Reading) -> Reading,
    take: impl FnMut(&Sample, &Truth, &Estimates),
) {
    let database = Database::parse(CAR_DBC.as_bytes(), "demo.dbc").unwrap();
    drive_on(&database, scenario, seed, config, without, sent_as, take);
}

/// The same with a bus of another car.
pub fn drive_on(
    database: &Database,
    scenario: &Scenario,
    seed: u64,
    mut config: Config,
    without: &[&str],
    sent_as: fn(&Reading) -> Reading,
    take: impl FnMut(&Sample, &Truth, &Estimates),
) {
    let radius = scenario.vehicle.wheel_radius_m.value;
    let outputs = Outputs::compile(&config.signals, database, radius).unwrap();
    config.signals.quantities.retain(|quantity, _| !without.contains(&quantity.name()));
    let output = gripd::signals::publish::built_in_database().unwrap();
    let mut engine = Engine::with_databases(&config, database, &output).unwrap().with_thesis();
    let mut frames = SimulatedFrames::new(outputs);
    let mut beside = Beside { truths: VecDeque::new(), take };
    let mut simulation = Simulation::new(scenario, seed).unwrap();
    let (mut sent, mut readings) = (Vec::new(), Vec::new());
    while let Some(tick) = simulation.next_tick() {
        beside.truths.push_back(*tick.truth);
        readings.clear();
        readings.extend(tick.readings.iter().map(sent_as));
        frames.take(&readings, &mut |frame| sent.push(*frame));
        for frame in sent.drain(..) {
            engine.frame(&frame, &mut beside);
        }
    }
    engine.finish(&mut beside);
}
