//! The question and its answer.

use super::chain::{ChainReport, Standing};
use super::model::Model;
use super::ordinary::{Asked, Ordinary};
use super::result::Explanation;
use physics::model::Vehicle;
use physics::model::effect::{EffectConfig, Kind};
use predict::Recording;

/// What there is to explain.
#[derive(Debug)]
pub struct Case<'a> {
    /// The car, with what is uncertain of it.
    pub vehicle: &'a Vehicle,
    /// Effects that the configuration switches on: they belong to the plain model here.
    pub effects: &'a [EffectConfig],
    /// Recordings, references first and the held-out ones last.
    pub recordings: &'a [Recording],
    /// How many of them are healthy drives of the car. With any the question is what the others have that they have not.
    pub references: usize,
    /// Are the others drives in time order? Then the question is what changed on the way, and since when.
    pub in_order: bool,
    /// How many of them the user has set apart.
    pub held_out: usize,
    /// What the audit of the measurement chain says of each.
    pub chain: &'a [ChainReport],
    /// What could be missing: [`KINDS`](physics::model::effect::KINDS), or some of them.
    pub library: &'a [&'static Kind],
    /// For what is drawn at random.
    pub seed: u64,
}

impl Case<'_> {
    /// The same as a question to the ordinary car, beside which is searched if `searches` says so.
    pub(super) fn asked<'s>(&'s self, searches: &'s dyn Fn(&Ordinary) -> bool) -> Asked<'s> {
        Asked {
            library: self.library,
            searches,
            references: self.references,
            in_order: self.in_order,
            zero_is_still: self.zero_is_still(),
            held_out: self.held_out,
            seed: self.seed,
        }
    }

    /// Does each gyroscope of those that are no references read the same while the car stands, before and after the drive?
    fn zero_is_still(&self) -> bool {
        let mut asked = self.chain.iter().skip(self.references).peekable();
        asked.peek().is_some() && asked.all(|of| of.standing.as_ref().is_some_and(Standing::is_still))
    }
}

/// An answer with the model it speaks of.
#[derive(Debug)]
pub struct Answer<'a> {
    /// The answer.
    pub explanation: Explanation,
    /// The extended model, with its courses smoothed over all readings of the first recording.
    pub model: Model<'a>,
}
