//! What others may rely on, whatever happens: nothing old is sent as new.

use gripd::Faults;
use gripd::can::Frame;
use testing::demo_car as car;
use testing::fault::{FROM, UNTIL, meanwhile};
use testing::heard::{self, Heard};

/// The drive without some of its frames while the fault lasts, through the engine.
fn without(lost: impl Fn(&Frame) -> bool) -> Heard {
    let mut heard = Heard::default();
    let mut engine = car::engine(&car::config());
    let there = car::drive().iter().filter(|frame| !(meanwhile(frame.time) && lost(frame)));
    there.for_each(|frame| engine.frame(frame, &mut heard));
    heard::protected(&heard.frames);
    heard
}

/// Is a signal's value in this frame?
fn is_there(frame: &Frame, signal: &str) -> bool {
    !heard::is_not_available(frame, signal)
}

/// GIVEN a sensor falls silent WHEN its time-out and the wait for late frames are over THEN what stands on it is sent
/// as not available until it is back.
#[test]
fn a_silent_sensor_takes_its_results_along() {
    let heard = without(|frame| frame.id.number() == 0x1B0);
    let motion: Vec<_> = heard::of(&heard.frames, "GRIP_MOTION").collect();
    let at = |from: f64, to: f64| motion.iter().filter(move |f| (from..to).contains(&f.time.seconds()));
    assert!(at(FROM - 1.0, FROM).all(|frame| is_there(frame, "Sideslip")));
    assert!(at(FROM + 0.26, UNTIL).count() > 200);
    assert!(at(FROM + 0.26, UNTIL).all(|frame| !is_there(frame, "Sideslip")));
    assert!(at(FROM + 0.26, UNTIL).all(|frame| is_there(frame, "Speed")), "the wheels still turn");
    assert!(at(UNTIL + 1.0, UNTIL + 10.0).any(|frame| is_there(frame, "Sideslip")));
}

/// GIVEN silence on the bus THEN nothing is sent, and the first thing afterwards is not what was known before.
#[test]
fn a_silent_bus_is_answered_by_silence() {
    let heard = without(|_| true);
    let meanwhile = heard.frames.iter().filter(|frame| meanwhile(frame.time)).count();
    assert_eq!(meanwhile, 0);
    let first = heard::of(&heard.frames, "GRIP_MOTION").find(|frame| frame.time.seconds() >= UNTIL).unwrap();
    assert!(!is_there(first, "Speed") && !is_there(first, "Sideslip"), "{first:?}");
    let status = heard.frames.iter().rposition(|frame| frame.time == first.time).unwrap();
    let faults = heard::faults(&heard.frames[status - 1..=status]);
    assert!(faults[0].contains(Faults::TIME), "{faults:?}");
}
