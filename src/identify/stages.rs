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

/// The ordinary car's fit to the same recordings.
pub const BESIDE: &str = "the ordinary car beside it";

/// Of an identification. Tuned by five recordings (two of GTIs, the RAV4, the TTS, the demo's car): searches take 26 to 54 % of the
/// time without the ordinary car, profiles nearly all of the rest; that car takes about as long as the searches.
pub const STAGES: &[Stage] = &[
    Stage { name: "searching", takes: 1.0, after: 2.0 },
    Stage { name: "adding noise to the inputs", takes: 0.05, after: 2.4 },
    Stage { name: "without holding anything", takes: 0.2, after: 2.2 },
    Stage { name: "profiling", takes: 1.35, after: 1.02 },
    Stage { name: "free run", takes: 0.02, after: 1.0 },
    Stage { name: BESIDE, takes: 1.0, after: 0.0 },
];
