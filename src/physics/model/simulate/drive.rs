//! A simulated drive as the estimators see it, beside its truth.

use super::{Simulation, Truth};
use crate::model::{Scenario, Vehicle};
use crate::{Sample, Sensors};

/// A drive: samples, and what was true at each of them.
#[derive(Clone, Debug)]
pub struct SimulatedDrive {
    /// The car as it truly is.
    pub vehicle: Vehicle,
    /// What is measured, and how noisy.
    pub sensors: Sensors,
    /// What the sensors said.
    pub samples: Vec<Sample>,
    /// The truth at each sample's time.
    pub truth: Vec<Truth>,
}

impl SimulatedDrive {
    /// Simulates a scenario whose sensors all read at the truth's period, undelayed: the readings of
    /// one instant are a sample. There is no bus between, and so nothing is rounded to a DBC's steps.
    ///
    /// # Errors
    /// What is wrong with the scenario.
    pub fn simulate(scenario: &Scenario, seed: u64) -> Result<Self, String> {
        let mut simulation = Simulation::new(scenario, seed).map_err(|e| e.to_string())?;
        let sensors = scenario.sensors.promised();
        let elapsed_s = f64::from(scenario.truth_period_ms) * 1e-3;
        let mut drive = Self { vehicle: scenario.vehicle.clone(), sensors, samples: vec![], truth: vec![] };
        while let Some(tick) = simulation.next_tick() {
            let mut sample = Sample::empty(tick.truth.time, elapsed_s);
            for reading in tick.readings {
                sample.set(reading.quantity, reading.value);
            }
            drive.samples.push(sample);
            drive.truth.push(*tick.truth);
        }
        Ok(drive)
    }
}
