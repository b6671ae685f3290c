//! The simulated drive: frames one after the other, and what was true beside them.

use std::collections::VecDeque;

use crate::cli::desk::simulate::SimulatedFrames;
use bus::can::Frame;
use bus::signals::Outputs;
use physics::model::{Scenario, ScenarioError, Simulation, Truth};

/// A drive that goes on as its frames are asked for.
pub struct Drive {
    simulation: Simulation,
    frames: SimulatedFrames,
    waiting: VecDeque<Frame>,
    truth: Vec<Truth>,
}

impl Drive {
    /// Prepares it; nothing has moved yet.
    pub fn new(scenario: &Scenario, seed: u64, outputs: Outputs) -> Result<Self, ScenarioError> {
        let simulation = Simulation::new(scenario, seed)?;
        let frames = SimulatedFrames::new(outputs);
        Ok(Self { simulation, frames, waiting: VecDeque::with_capacity(16), truth: Vec::new() })
    }

    /// The car's next frame; `None` when the drive is over.
    pub fn next_frame(&mut self) -> Option<Frame> {
        while self.waiting.is_empty() {
            let tick = self.simulation.next_tick()?;
            self.truth.push(*tick.truth);
            let waiting = &mut self.waiting;
            self.frames.take(tick.readings, &mut |frame| waiting.push_back(*frame));
        }
        self.waiting.pop_front()
    }

    /// What was true so far, a row for each tick.
    pub fn into_truth(self) -> Vec<Truth> {
        self.truth
    }
}
