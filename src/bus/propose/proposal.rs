//! What is proposed, with its reasons.

use serde::{Serialize, Serializer};

use super::evidence::Evidence;
use physics::Quantity;

/// A `[signals]` table for a person to confirm.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Proposal {
    /// Every quantity, in the order of [`Quantity::ALL`].
    pub quantities: Vec<Choice>,
    /// What concerns several of them.
    pub notes: Vec<String>,
    /// Seconds of driving that the data's part is founded on; none without a recording.
    pub driven_s: Option<f64>,
    /// A message that was chosen goes as an FD frame.
    pub fd: bool,
}

/// One quantity's signal, if there is one.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Choice {
    /// Which.
    #[serde(serialize_with = "name")]
    pub quantity: Quantity,
    /// How sure it is.
    pub confidence: Confidence,
    /// Where it comes from; with [`Confidence::NotFound`] the best that there is, if anything.
    pub mapping: Option<Mapped>,
    /// How well name, unit and range fit, 0 to 1.
    pub names: f64,
    /// How well the recordings fit.
    pub data: Option<Evidence>,
    /// Why, in words.
    pub why: String,
    /// Other signals that may be it, best first.
    pub alternatives: Vec<Alternative>,
    /// Signals that are called so and do not behave so.
    pub contradicted: Vec<Alternative>,
    /// What was put right since it was proposed, in words.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub repaired: Vec<String>,
}

/// How sure a choice is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Confidence {
    /// Nothing fits.
    NotFound,
    /// Look at it before you use it.
    Unsure,
    /// By the names, or by the data alone.
    Likely,
    /// Names and data agree.
    Sure,
}

impl Confidence {
    /// `sure`, `likely`, `unsure`, `not found`.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Sure => "sure",
            Self::Likely => "likely",
            Self::Unsure => "unsure",
            Self::NotFound => "not found",
        }
    }
}

/// Another signal, and why it was not taken.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Alternative {
    /// `MESSAGE.Signal`.
    pub signal: String,
    /// As [`Choice::names`].
    pub names: f64,
    /// What the recordings say of it, in words; empty without a recording.
    pub data: String,
}

/// A quantity's entry in `[signals]`, key by key.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Mapped {
    /// `MESSAGE.Signal`, or the parts to be added, coarse first.
    pub signals: Vec<String>,
    /// The bit that is 1 where the value is negative.
    pub sign: Option<String>,
    /// Signals that must allow the value.
    pub valid: Vec<String>,
    /// Raw values at which they do.
    pub valid_when: Vec<u64>,
    /// −1, where it is the wrong way round.
    pub gain: Option<f64>,
    /// SI.
    pub offset: Option<f64>,
    /// Where the file has none, or a wrong one.
    pub unit: Option<String>,
    /// Raw codes that are no measurements.
    pub not_available: Vec<i64>,
    /// How late a value is in its frame.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub delay_ms: Option<f64>,
    /// The message's counter, least significant part first.
    pub counter: Vec<String>,
    /// At how much it starts over, where its bits could hold more.
    pub counter_modulo: Option<u64>,
}

#[allow(clippy::trivially_copy_pass_by_ref, reason = "serde wants it so")]
fn name<S: Serializer>(quantity: &Quantity, serializer: S) -> Result<S::Ok, S::Error> {
    serializer.serialize_str(quantity.name())
}

impl Proposal {
    /// What is required and not found, each as its alternatives.
    pub fn missing(&self) -> Vec<Vec<Quantity>> {
        Quantity::lacking(|quantity| self.has(quantity))
    }

    /// Is a signal proposed for it?
    pub fn has(&self, quantity: Quantity) -> bool {
        self.choice(quantity).is_some_and(|choice| choice.confidence > Confidence::NotFound)
    }

    /// What is proposed for a quantity.
    pub fn choice(&self, quantity: Quantity) -> Option<&Choice> {
        self.quantities.iter().find(|choice| choice.quantity == quantity)
    }
}
