//! How long the stages of an explanation take.

use identify::Stage;

pub(super) const ORDINARY: &str = "the ordinary car";
pub(super) const FIRST: &str = "beyond the ordinary car, before anything else";
pub(super) const BESIDE: &str = "the plain model beside it";
pub(super) const BESIDE_OPEN: &str = "the plain model beside it, before what to drive next";
pub(super) const PLAIN: &str = "fitting the plain model";
pub(super) const NAMING: &str = "naming";
pub(super) const MORE: &str = "looking for more";
pub(super) const AGAIN: &str = "the same with tires of another kind";
pub(super) const DISTURBED: &str = "the same beside disturbances of road and engine";
pub(super) const EVERYTHING: &str = "fitting to everything";
pub(super) const UNKNOWN: &str = "what could be explained";
pub(super) const BEYOND: &str = "beyond the ordinary car";
pub(super) const PROVING: &str = "proving";
pub(super) const PROVING_OPEN: &str = "proving, before what to drive next";
pub(super) const DRIVES: &str = "the car of all drives";
pub(super) const CHANGES: &str = "what has changed";
pub(super) const SIMULATION: &str = "a car that drives like the simulation";
pub(super) const LEFT_OUT: &str = "what the simulation leaves out";
pub(super) const NEXT_DRIVE: &str = "what to drive next";

const fn stage(name: &'static str, takes: f64, after: f64) -> Stage {
    Stage { name, takes, after }
}

/// Of an explanation, one beside the other; the fit of the ordinary car takes 1. Tuned by five recordings (two of GTIs, the RAV4, the
/// TTS, the demo's car), and again by the RAV4, a GTI and the TTS.
pub const STAGES: &[Stage] = &[
    stage(ORDINARY, 1.0, 1.7),
    stage(FIRST, 0.9, 0.8),
    stage(BESIDE, 0.65, 0.1),
    stage(BESIDE_OPEN, 0.65, 1.2),
    stage(PLAIN, 0.3, 2.5),
    stage(NAMING, 1.25, 1.5),
    stage(MORE, 1.5, 1.0),
    stage(AGAIN, 3.0, 1.7),
    stage(DISTURBED, 3.0, 1.7),
    stage(EVERYTHING, 1.0, 0.7),
    stage(UNKNOWN, 0.1, 0.6),
    stage(BEYOND, 0.75, 0.05),
    stage(PROVING, 0.05, 0.0),
    stage(PROVING_OPEN, 0.05, 1.1),
    stage(DRIVES, 1.0, 1.5),
    stage(CHANGES, 1.5, 0.0),
    stage(SIMULATION, 1.0, 1.5),
    stage(LEFT_OUT, 1.5, 0.0),
    stage(NEXT_DRIVE, 1.1, 0.0),
];

/// Of a fit of the ordinary car alone.
pub const FIT_STAGES: &[Stage] = &[stage(ORDINARY, 1.0, 0.0)];

#[cfg(test)]
mod tests {
    use crate::explain::bench::recorded;
    use crate::explain::ordinary::{Asked, Ordinary};

    #[test]
    fn a_fit_counts_itself_to_its_end() {
        let (vehicle, recording) = recorded("");
        assert_eq!(recording.work.share(), None);
        let seen = recording.work.clone();
        Ordinary::of(&vehicle, &[], &[recording], Asked::CAR).unwrap();
        let share = seen.share().unwrap();
        assert!(share > 0.95, "{share}");
    }
}
