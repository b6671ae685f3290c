//! What to drive next.

use std::fmt;

use physics::model::Scenario;
use serde::Serialize;

/// A manoeuvre, or advice in words.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ToDrive {
    /// The file that it was written to as a scenario, for `gripd simulate`.
    pub scenario: Option<String>,
    /// What, and what for.
    pub words: String,
    /// How probably what this answer leaves open is told by its name, if it is there in the size that was found.
    pub probability_to_tell: Option<Chance>,
    /// The manoeuvre: a word for it, and how this car drives it.
    #[serde(skip)]
    pub manoeuvre: Option<(&'static str, Box<Scenario>)>,
}

/// Probabilities, by this drive and with the manoeuvre.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Chance {
    /// By what was driven.
    pub now: f64,
    /// With one more drive.
    pub then: f64,
}

impl fmt::Display for Chance {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{:.0} → {:.0} %", 100.0 * self.now, 100.0 * self.then)
    }
}

impl From<String> for ToDrive {
    fn from(words: String) -> Self {
        Self { scenario: None, words, probability_to_tell: None, manoeuvre: None }
    }
}

impl From<&str> for ToDrive {
    fn from(words: &str) -> Self {
        words.to_owned().into()
    }
}
