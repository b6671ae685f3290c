//! Unit tests of trials.

use super::super::super::super::bench::recorded;
use super::super::super::inputs::Held;
use super::*;
use physics::model::effect;
use predict::Torque;

/// GIVEN a load that may be there from the start, and one that may come later or that references may have had THEN only
/// the first is no less than none.
#[test]
fn nobody_takes_out_what_never_was_in() {
    let (vehicle, _) = recorded("");
    let kind = effect::named("payload").unwrap();
    let onset = kind.onset().unwrap();
    let least = |at: f64, of: Scope| {
        let candidate = Candidate {
            kind,
            channel: None,
            free: vec![0, 1],
            fixed: vec![(onset, at)],
            live: None,
            stretches: Vec::new(),
        };
        let trial = Trial::new(What::Effect(candidate), of, 1.0);
        let free = trial.free(&trial.put_into(&Model::plain(&vehicle, Torque::Recorded)));
        free.iter().find(|free| trial.is_main(free)).unwrap().bounds.0
    };
    assert_eq!(least(-1.0, Scope::Car), 0.0);
    assert!(least(20.0, Scope::Car) < 0.0 && least(-1.0, Scope::Since(1)) < 0.0);
}

/// GIVEN another road from 2 s after the beginning on, for half of the drive, and from the first moment to the last THEN the
/// first only is a patch that takes the car's place.
#[test]
fn a_patch_of_nearly_the_whole_drive_is_there_nearly_always() {
    let (vehicle, recording) = recorded("");
    let drive = FreeDrive::new(&recording, &vehicle, Held::EveryThird, 600.0).unwrap();
    let (first, last) = (drive.time(0), drive.time(drive.points()));
    let patch = |stretch: [f64; 2]| {
        let candidate = Candidate {
            kind: effect::named("friction_change").unwrap(),
            channel: None,
            free: vec![0],
            fixed: Vec::new(),
            live: None,
            stretches: vec![stretch],
        };
        Trial::new(What::Effect(candidate), Scope::Car, 1.0)
    };
    assert!(patch([first + 2.0, f64::INFINITY]).is_nearly_always_there(&drive));
    assert!(!patch([0.5 * (first + last), f64::INFINITY]).is_nearly_always_there(&drive));
    assert!(!patch([f64::NEG_INFINITY, f64::INFINITY]).is_nearly_always_there(&drive));
}
