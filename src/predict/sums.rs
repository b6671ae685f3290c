//! What a pass over a drive is asked for, and what it gives.

use nalgebra::DMatrix;

use super::algebra::{Column, Gain, Square};
use super::grid::STEP_S;
use super::trajectory::Derivatives;
use physics::Quantity;
use physics::model::effect::Readings;

/// Blocks in which sums are kept, s. Numerical: longer than innovations are correlated.
pub const BLOCK_S: f64 = 5.0;

/// Which readings the filter may look at.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum UsedReadings {
    /// All.
    #[default]
    All,
    /// Those of every other second, from the first or from the second one.
    EveryOther(bool),
}

impl UsedReadings {
    /// May it look at a reading of this time, s?
    pub fn include(self, t: f64) -> bool {
        match self {
            Self::All => true,
            Self::EveryOther(odd) => (t.floor() as i64 % 2 == 1) == odd,
        }
    }
}

/// What a pass gives beside its sums.
#[derive(Default)]
pub struct PassOptions<'a> {
    /// Which readings the filter may look at.
    pub readings: UsedReadings,
    /// Every innovation of the first car.
    pub innovations: Option<&'a mut Vec<Innovation>>,
    /// Every step of the first car.
    pub steps: Option<&'a mut Vec<Filtered>>,
}

/// Sums over one block of a drive.
#[derive(Clone, Debug)]
pub struct BlockSums {
    /// Which drive.
    pub drive: usize,
    /// From, to, s.
    pub t: (f64, f64),
    /// Products of the whitened innovations (first) and their derivatives by each difference (the others,
    /// with changed sign: how much a step takes away).
    pub gram: DMatrix<f64>,
    /// A column for each difference that is looked at alone: products of its derivatives with all those, and with
    /// themselves (last).
    pub alone: DMatrix<f64>,
    /// Σ ln s.
    pub log_s: f64,
    /// Σ e²/s by quantity.
    pub square: Readings,
    /// Σ e² − (s − r²): estimates r² with `of`.
    pub excess: Readings,
    /// Readings by quantity.
    pub of: [usize; Quantity::COUNT],
}

/// What comes of the steps of a block.
pub(super) struct BlockOutput {
    /// Of each reading.
    pub(super) gains: Vec<Gain>,
    /// Of each reading.
    pub(super) errors: Vec<f64>,
    /// Of each step.
    pub(super) derivatives: Vec<Derivatives>,
    pub(super) sums: BlockSums,
}

impl BlockOutput {
    pub(super) fn new(drive: usize, between: (usize, usize)) -> Self {
        let sums = BlockSums::empty(drive, between);
        Self { gains: Vec::new(), errors: Vec::new(), derivatives: Vec::new(), sums }
    }

    /// Keeps the sums only.
    pub(super) fn forget_steps(&mut self) {
        self.gains.clear();
        self.errors.clear();
        self.derivatives.clear();
    }
}

/// The innovation of a reading.
#[derive(Clone, Copy, Debug)]
pub struct Innovation {
    /// Time, s.
    pub t: f64,
    /// Quantity.
    pub channel: u8,
    /// Measured.
    pub value: f64,
    /// Measured minus predicted.
    pub error: f64,
    /// Standard deviation it should have.
    pub std: f64,
}

/// A step of the first car, for smoothing.
#[derive(Clone, Copy, Debug)]
pub struct Filtered {
    /// Grid point at the step's end.
    pub k: usize,
    /// Does the step begin a run?
    pub begins: bool,
    /// From the last filtered state to the predicted one.
    pub a: Square,
    /// Predicted state and covariance.
    pub predicted: (Column, Square),
    /// Filtered state and covariance.
    pub filtered: (Column, Square),
}

/// A reading beside what a simulation, or a prediction by one step, has for it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Comparison {
    /// Time, s.
    pub t: f64,
    /// Quantity.
    pub channel: u8,
    /// Measured.
    pub measured: f64,
    /// Simulated.
    pub simulated: f64,
}

impl BlockSums {
    fn empty(drive: usize, (from, to): (usize, usize)) -> Self {
        Self {
            drive,
            t: (from as f64 * STEP_S, to as f64 * STEP_S),
            gram: DMatrix::zeros(0, 0),
            alone: DMatrix::zeros(0, 0),
            log_s: 0.0,
            square: [0.0; Quantity::COUNT],
            excess: [0.0; Quantity::COUNT],
            of: [0; Quantity::COUNT],
        }
    }
}
