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

/// Profiles, after which there may be stiffnesses that another car tells otherwise …
pub(super) const PROFILING: &str = "profiling";

/// … and after which there will be none.
pub(super) const PROFILING_LAST: &str = "profiling, the last";

/// The ordinary car's fit to the same recordings.
pub const BESIDE: &str = "the ordinary car beside it";

/// Of an identification. Tuned by five recordings (two of GTIs, the RAV4, the TTS, the demo's car): searches take 26 to 54 % of the
/// time without the ordinary car, profiles nearly all of the rest; that car takes about as long as the searches.
pub const STAGES: &[Stage] = &[
    Stage { name: "searching", takes: 1.0, after: 2.3 },
    Stage { name: "adding noise to the inputs", takes: 0.05, after: 2.3 },
    Stage { name: "without holding anything", takes: 0.05, after: 2.3 },
    Stage { name: PROFILING, takes: 1.6, after: 0.8 },
    Stage { name: PROFILING_LAST, takes: 1.6, after: 0.02 },
    Stage { name: "free run", takes: 0.02, after: 0.4 },
    Stage { name: BESIDE, takes: 0.8, after: 0.0 },
];
