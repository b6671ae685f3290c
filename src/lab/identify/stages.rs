//! How long the stages of a search take, one beside the other: what time is left is told by it.

/// A stage as its mark names it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stage {
    /// Its name.
    pub name: &'static str,
    /// How long it takes; the first stage of a search takes 1.
    pub takes: f64,
    /// How long what comes after it takes, as far as is known then.
    pub after: f64,
}

/// Of an identification. Tuned by five recordings (two of GTIs, the RAV4, the TTS, the demo's car): searches take 26 to 54 % of the
/// time, profiles nearly all of the rest.
pub const STAGES: &[Stage] = &[
    Stage { name: "searching", takes: 1.0, after: 1.0 },
    Stage { name: "adding noise to the inputs", takes: 0.05, after: 1.4 },
    Stage { name: "without holding anything", takes: 0.2, after: 1.2 },
    Stage { name: "profiling", takes: 1.35, after: 0.02 },
    Stage { name: "free run", takes: 0.02, after: 0.0 },
];
