//! What comes out of an identification.

use std::fmt;

use super::doubt::Doubt;
use super::free_run::{Fits, fits};
use super::longitudinal_input::LongitudinalInput;
use super::motion::Output;
use super::parameter::Values;
use super::record::Record;
use super::setup;
use physics::model::Vehicle;

/// One parameter as it came out.
#[derive(Clone, Debug, PartialEq)]
pub struct Identified {
    /// Its name.
    pub name: &'static str,
    /// Its unit; 1 for ratios.
    pub unit: &'static str,
    /// Its value, in its unit.
    pub value: f64,
    /// Standard deviation, in its unit.
    pub std: f64,
    /// 95 % interval.
    pub ci95: (f64, f64),
    /// Does the recording say something about it?
    pub identifiable: bool,
    /// If not, why not; else empty or what else is to be known.
    pub reason: String,
    /// Does the recording alone tell it, with an interval that has two ends? Identifiable is what beside that can be believed.
    pub is_clear: bool,
    /// Why it is not to be taken over, whatever the recordings tell.
    pub doubt: Option<Doubt>,
    /// The vehicle's table's value and standard deviation.
    pub prior: (f64, f64),
    /// 2 ln(likelihood ratio) to the optimum at values of it, all others refitted.
    pub profile: Vec<(f64, f64)>,
}

impl Identified {
    /// Says something more beside its verdict.
    pub(super) fn note(&mut self, words: &str) {
        let before = if self.reason.is_empty() { "" } else { "; " };
        self.reason = format!("{}{before}{words}", self.reason);
    }

    /// Does it end at a bound, or do the recordings tell it and contradict the table?
    pub fn is_in_doubt(&self) -> bool {
        self.doubt.as_ref().is_some_and(|doubt| self.is_clear || doubt.at_bound)
    }
}

/// A search, from and to.
#[derive(Clone, Debug, PartialEq)]
pub struct Path {
    /// Where it began, in the order of the parameters.
    pub from: Vec<f64>,
    /// Where it ended.
    pub to: Vec<f64>,
    /// The cost there; infinite if it came to no end.
    pub cost: f64,
    /// Simulations of everything.
    pub iterations: u32,
}

/// What came out.
#[derive(Clone, Debug)]
pub struct Identification {
    /// The free parameters.
    pub parameters: Vec<Identified>,
    /// Correlation of their errors.
    pub correlation: Vec<Vec<f64>>,
    /// The searches.
    pub paths: Vec<Path>,
    /// All numbers at the optimum.
    pub values: Values,
    /// How the forces came in.
    pub drive: LongitudinalInput,
    /// Seconds that were used.
    pub seconds: f64,
    /// Segments.
    pub segments: usize,
    /// Noise that is left, by channel; not-a-number where there is none.
    pub noise: Vec<(Output, f64)>,
    /// What comes between two segments beyond the equations: m/s, m/s, rad/s; infinite if not tied.
    pub between: [f64; 3],
    /// How much the recordings count beside the table: 1 where the residuals are white noise, less where segments differ
    /// more than that explains.
    pub weight: f64,
    /// Fits of a free run restarted each 20 s, before and after.
    pub before: Fits,
    /// After.
    pub after: Fits,
}

impl Identification {
    /// How a free run predicts recordings that nothing was fitted to: with the table's numbers, and with those found.
    pub fn predicts(&self, records: &[Record], vehicle: &Vehicle) -> [Fits; 2] {
        let records = setup::prepared(records, vehicle, self.drive);
        [&Values::of(vehicle), &self.values].map(|values| fits(&records, vehicle, values, self.drive))
    }

    /// What was found of a parameter, in its unit, if it was free.
    pub fn value(&self, name: &str) -> Option<f64> {
        self.parameters.iter().find(|it| it.name == name).map(|it| it.value)
    }
}

impl fmt::Display for Identified {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} = {:.5} ± {:.2}", self.name, self.value, self.std)
    }
}
