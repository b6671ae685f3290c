//! What an experiment is, and what comes out of one.

use crate::report::Plot;

/// Does what the thesis found come out here, too?
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Verdict {
    /// It does.
    Holds,
    /// It does not; the claim's note says why.
    Differs,
    /// Not the thesis's: our answer to what the thesis could not do, and it does what it should.
    Better,
    /// Our answer falls short of what it should do; the note says by how much and why.
    Short,
}

/// One thing the thesis says, or one that we add, with numbers.
#[derive(Clone, Debug)]
pub struct Claim {
    /// What is claimed.
    pub what: String,
    /// What the thesis got (read off its figure or text); empty where it is ours alone.
    pub thesis: String,
    /// What we get, with its unit.
    pub ours: String,
    /// Whether it holds. Decided by numbers, never written down beforehand.
    pub verdict: Verdict,
    /// Why, in one line: never empty with [`Verdict::Differs`] and [`Verdict::Short`].
    pub note: String,
}

impl Claim {
    /// A claim of the thesis that holds or differs; `note` gives the reason.
    pub fn new(what: &str, thesis: &str, ours: String, holds: bool, note: &str) -> Self {
        let verdict = if holds { Verdict::Holds } else { Verdict::Differs };
        Self { what: what.into(), thesis: thesis.into(), ours, verdict, note: note.into() }
    }

    /// Our own answer beside the thesis's.
    pub fn better(what: &str, ours: String, reached: bool, note: &str) -> Self {
        let verdict = if reached { Verdict::Better } else { Verdict::Short };
        Self { what: what.into(), thesis: String::new(), ours, verdict, note: note.into() }
    }
}

/// A plot laid out like the original.
#[derive(Clone, Debug)]
pub struct Picture {
    /// Name of its file, without extension, e.g. `figure_5_6`.
    pub name: String,
    /// Heading on the page.
    pub heading: String,
    /// The plot.
    pub plot: Plot,
    /// What to see in it.
    pub caption: String,
}

/// What came out of an experiment.
#[derive(Clone, Debug, Default)]
pub struct Outcome {
    /// Its claims, in the order of the thesis.
    pub claims: Vec<Claim>,
    /// Its pictures.
    pub pictures: Vec<Picture>,
}

/// An experiment that could not be carried out.
#[derive(Clone, Debug, thiserror::Error)]
#[error("figure {figure}: {reason}")]
pub struct ExperimentError {
    /// The figure.
    pub figure: &'static str,
    /// Why.
    pub reason: String,
}

/// One figure of the thesis.
#[derive(Clone, Copy)]
pub struct Experiment {
    /// Its number, e.g. `5.6`; several, where one experiment draws several: `4.5–4.7`.
    pub figure: &'static str,
    /// What it shows.
    pub title: &'static str,
    /// Carries it out. Deterministic.
    pub run: fn() -> Result<Outcome, String>,
}

/// An experiment and what came out.
pub struct Done {
    /// Which.
    pub experiment: Experiment,
    /// What.
    pub outcome: Result<Outcome, ExperimentError>,
}
