//! Every fault bit: on the bus, in the metrics and in what `--stats` counts.

use gripd::can::Frame;
use gripd::dbc::Database;
use gripd::service::{Engine, Sink};
use gripd::signals::publish::built_in_database;
use gripd::{Config, Estimates, Faults, Micros, Quantity, Sample};
use testing::program;

#[derive(Default)]
struct Heard {
    frames: Vec<Frame>,
    estimates: Vec<Estimates>,
}

impl Sink for Heard {
    fn estimates(&mut self, _sample: &Sample, estimates: &Estimates) {
        self.estimates.push(*estimates);
    }

    fn publish(&mut self, frame: &Frame) {
        self.frames.push(*frame);
    }
}

/// The faults that a round tells, both messages together.
fn told(frames: &[Frame], layout: &Database) -> Faults {
    let bits = |name: &str| {
        let message = layout.message(name).unwrap();
        let frame = frames.iter().rfind(|frame| frame.id == message.id).unwrap();
        message.signal("Faults").unwrap().bits(frame.data()).unwrap() as u32
    };
    Faults::from_bits_retain(bits("GRIP_STATUS") | bits("GRIP_STATUS_2") << 16)
}

fn car(edit: impl FnOnce(&mut Config)) -> Engine {
    let mut config = Config::load(&program::project("config/demo.toml")).unwrap();
    edit(&mut config);
    Engine::new(&config).unwrap()
}

/// The demo's drive.
fn drive() -> Vec<Frame> {
    let log = tempfile::NamedTempFile::with_suffix(".log").unwrap();
    let scenario = program::project("config/scenarios/demo.toml");
    let mut simulate = program::gripd();
    simulate.args(["-q", "simulate"]).arg(scenario).arg("-o").arg(log.path());
    assert!(simulate.status().unwrap().success());
    let mut reader = gripd::can::candump::Reader::open(log.path()).unwrap();
    std::iter::from_fn(|| reader.next_frame().unwrap()).collect()
}

#[test]
fn each_bit_is_told_counted_and_named() {
    let layout = built_in_database().unwrap();
    let drive = drive();
    let (some, more) = drive[..2000].split_at(1000);
    for fault in Faults::all().iter() {
        let (mut engine, mut heard) = (car(|_| ()), Heard::default());
        some.iter().for_each(|frame| engine.frame(frame, &mut heard));
        assert!(!told(&heard.frames, &layout).contains(fault), "{fault:?} is told of a sound drive");
        let before = engine.occurrences(fault);
        heard.frames.clear();
        engine.report(fault);
        for frame in more {
            engine.frame(frame, &mut heard);
            if !heard.frames.is_empty() {
                break;
            }
        }
        assert!(told(&heard.frames, &layout).contains(fault), "{fault:?} is not told");
        assert_eq!(engine.occurrences(fault), before + 1, "{fault:?}");
        let name = fault.names().next().unwrap();
        let count = engine.fault_counts().iter().find(|(counted, _)| *counted == name);
        assert_eq!(count.map(|(_, count)| count), Some(before + 1), "{name} in --stats");
    }
}

/// What the estimators say of themselves is counted once each time that it begins.
#[test]
fn a_doubt_of_the_estimators_is_counted() {
    // A gyro mounted upside down.
    let mut engine = car(|config| {
        config.signals.quantities.get_mut(&Quantity::YawRate).unwrap().gain = Some(-1.0);
        config.signals.sampling.cross_checks = false;
    });
    let mut heard = Heard::default();
    drive().iter().for_each(|frame| engine.frame(frame, &mut heard));
    let doubted = heard.estimates.iter().map(|estimates| estimates.faults.contains(Faults::INCONSISTENT));
    let begun = doubted.scan(false, |before, now| Some(now && !std::mem::replace(before, now)));
    let begun = begun.filter(|begun| *begun).count() as u64;
    assert!(begun > 0, "the filter believes a wrong gyro");
    assert_eq!(engine.occurrences(Faults::INCONSISTENT), begun);
    assert_eq!(engine.fault_counts().get(Faults::INCONSISTENT), begun);
}

/// GIVEN a second steering message with half the angle, right behind the first, THEN that is told and neither is used; and
/// of the drive alone it is not.
#[test]
fn an_input_that_two_nodes_send_is_not_used() {
    let drive = drive();
    let from = drive[0].time + Micros::from_millis(10_000);
    let until = from + Micros::from_millis(10_000);
    let end = until + Micros::from_millis(5_000);
    for (forged, watched) in [(false, true), (true, true), (true, false)] {
        let (mut engine, mut heard) =
            (car(|config| config.signals.sampling.rate_watch = watched), Heard::default());
        let mut told_after = None;
        for frame in drive.iter().filter(|frame| frame.time < end) {
            engine.frame(frame, &mut heard);
            if forged && frame.id.number() == 0x1C0 && (from..until).contains(&frame.time) {
                let half = i16::from_le_bytes([frame.data()[0], frame.data()[1]]) / 2;
                let mut data = frame.data().to_vec();
                data[..2].copy_from_slice(&half.to_le_bytes());
                let second = Frame::data_frame(frame.time + Micros(500), frame.id, &data).unwrap();
                engine.frame(&second, &mut heard);
            }
            if engine.occurrences(Faults::SENT_TWICE) > 0 {
                told_after = told_after.or(Some((frame.time - from).seconds()));
            }
        }
        println!("forged: {forged}, watched: {watched}: told after {told_after:?} s");
        assert_eq!(told_after.is_some(), forged && watched);
        if let Some(after) = told_after {
            assert!(after < 1.0, "{after} s");
            // Its values are not there while it lasts, and so nothing that stands on them is valid.
            let doubtful = |e: &&Estimates| (from + Micros::from_millis(2_000)..until).contains(&e.time);
            assert!(heard.estimates.iter().filter(doubtful).all(|e| e.faults.contains(Faults::SENT_TWICE)));
            assert!(heard.estimates.iter().filter(doubtful).all(|e| !e.cornering_valid && !e.motion.valid));
            assert!(!heard.estimates.last().unwrap().faults.contains(Faults::SENT_TWICE), "it is over");
        }
    }
}
