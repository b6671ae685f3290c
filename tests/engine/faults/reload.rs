//! A configuration that is read anew while the service runs.

use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::Duration;

use gripd::config::ConfigError;
use gripd::estimates::State;
use gripd::service::Survived;
use gripd::{Config, Faults, Micros};

use super::service::{self, Happens};
use testing::heard::{self, Heard};
use testing::{demo_car as car, program};

/// The drive, through one engine up to a frame and through another from there on.
fn drive_across(config: &Config, place: usize) -> (Heard, Survived) {
    let (before, after) = car::drive().split_at(place);
    let mut heard = Heard::default();
    let mut first = car::engine(&car::config());
    before.iter().for_each(|frame| first.frame(frame, &mut heard));
    let mut second = car::engine(config);
    let survived = second.take_over(first, &mut heard);
    after.iter().for_each(|frame| second.frame(frame, &mut heard));
    second.finish(&mut heard);
    assert_eq!(second.counts().frames_in as usize, car::drive().len());
    assert_eq!(second.counts().samples as usize, heard.samples.len());
    (heard, survived)
}

fn in_one_go() -> Heard {
    let mut heard = Heard::default();
    let mut engine = car::engine(&car::config());
    car::drive().iter().for_each(|frame| engine.frame(frame, &mut heard));
    engine.finish(&mut heard);
    heard
}

/// No sample twice, none left out for longer than it takes to hear of all quantities.
#[track_caller]
fn samples_go_on(heard: &Heard, longest: Micros) {
    for pair in heard.samples.windows(2) {
        let step = pair[1].time - pair[0].time;
        assert!(step > Micros(0) && step <= longest, "{step:?} at {}", car::seconds(pair[0].time));
    }
}

/// GIVEN nothing that the estimates stand on has changed WHEN the configuration is read anew, at whatever frame
/// THEN nobody can tell from what is published.
#[test]
fn what_has_not_changed_goes_on_bit_for_bit() {
    let expected = in_one_go();
    let service =
        car::with(&[("# report_every_s = 60 ", "report_every_s = 5 "), ("# [service] ", "[service] ")]);
    for place in [0, 1, 100, 5000, 5001, 5002, 5003, 9000, car::drive().len()] {
        let (heard, survived) = drive_across(&service, place);
        assert_eq!(survived, Survived::Everything);
        assert!(heard.samples == expected.samples && heard.frames == expected.frames, "at frame {place}");
    }
}

/// GIVEN another time-out or another estimator's setting THEN the samples go on, what was learned stays, and no
/// counter jumps.
#[test]
fn what_is_measured_otherwise_starts_from_what_was_learned() {
    let timeout = car::with(&[("valid_when = 1 }", "valid_when = 1, timeout_ms = 150 }")]);
    let mut minimum = car::config();
    minimum.estimators.minimum_speed_mps = 5.0;
    for config in [timeout, minimum] {
        let place = car::drive().len() * 3 / 4;
        let (heard, survived) = drive_across(&config, place);
        assert_eq!(survived, Survived::Learned);
        heard::protected(&heard.frames);
        samples_go_on(&heard, Micros::from_millis(60));
        let last = heard.estimates.last().unwrap();
        let offsets = last.slip_offset.iter().flatten().count();
        assert_eq!(offsets, 2, "slip offsets are learned from whole drives: {:?}", last.slip_offset);
        let expected = in_one_go().estimates.last().unwrap().slip_offset;
        for (is, was) in last.slip_offset.iter().zip(expected) {
            let error = is.zip(was).map_or(0.0, |(is, was)| (is.value - was.value).abs());
            assert!(error < 2e-3, "{:?} {expected:?}", last.slip_offset);
        }
        // For a moment there are no estimates: that is said, and nothing older is told.
        let at = car::drive()[place].time;
        let first = heard::of(&heard.frames, "GRIP_STATUS").find(|frame| frame.time >= at).unwrap();
        assert!([State::Starting as u64, State::Running as u64].contains(&heard::bits(first, "State")));
    }
}

/// GIVEN another car WHEN its configuration is read THEN nothing of the one before is left but the counters.
#[test]
fn another_car_starts_from_its_own_table() {
    let heavier = car::with(&[("mass_kg = { value = 1450.0", "mass_kg = { value = 2450.0")]);
    let turned =
        car::with(&[("\"INERTIAL.AccelerationY\"", "{ signal = \"INERTIAL.AccelerationY\", gain = -1.0 }")]);
    for config in [heavier, turned] {
        let place = car::drive().len() / 2;
        let (heard, survived) = drive_across(&config, place);
        assert_eq!(survived, Survived::Nothing);
        heard::protected(&heard.frames);
        samples_go_on(&heard, Micros::from_millis(60));
        let after = heard.estimates.iter().find(|e| e.time > car::drive()[place].time).unwrap();
        assert_eq!((after.slope, after.cornering), ([None; 4], [None; 2]));
    }
}

/// GIVEN another period and fewer messages THEN those that are left go on counting.
#[test]
fn what_is_published_can_change() {
    let slower =
        car::with(&[("[vehicle]\n", "[publish]\nperiod_ms = 50\nmessages = [\"GRIP_STATUS\"]\n[vehicle]\n")]);
    let place = car::drive().len() / 2;
    let (heard, survived) = drive_across(&slower, place);
    assert_eq!(survived, Survived::Everything);
    heard::protected(&heard.frames);
    let at = car::drive()[place].time;
    let after: Vec<_> = heard.frames.iter().filter(|frame| frame.time > at).collect();
    assert_eq!(after.len(), heard::of(&heard.frames, "GRIP_STATUS").filter(|f| f.time > at).count());
    let seconds = car::drive().last().map(|last| (last.time - at).seconds()).unwrap();
    assert!((after.len() as f64 - 20.0 * seconds).abs() < 3.0, "{} in {seconds} s", after.len());
}

fn broken() -> Result<Config, ConfigError> {
    Config::parse("[dbc]\ninput = 3", &program::project("config/demo.toml"))
}

/// A frame each millisecond, so that files are read meanwhile.
fn slowly(frames: &[gripd::can::Frame]) -> Vec<Happens> {
    let pause = Happens::Pause(Duration::from_millis(1));
    service::frames(frames).into_iter().flat_map(|frame| [frame, pause.clone()]).collect()
}

/// GIVEN a configuration that cannot be used WHEN it is read THEN the one before stays, the status says so until
/// there is a good one again, and no frame is lost meanwhile.
#[test]
fn a_broken_configuration_is_refused_and_told_of_until_it_is_mended() {
    let readings = Arc::new(AtomicUsize::new(0));
    let count = Arc::clone(&readings);
    // Broken, a DBC that is not there, a signal that is not there, then good.
    let read = move || match count.fetch_add(1, Ordering::Relaxed) {
        0 => broken(),
        1 => Ok(car::with(&[("../dbc/demo.dbc", "nowhere.dbc")])),
        2 => Ok(car::with(&[("\"WHEELS.SpeedFL\"", "\"WHEELS.SpeedXX\"")])),
        3 => panic!("as a bug would"),
        _ => Ok(car::config()),
    };
    let drive = &car::drive()[..8000];
    let (fast, slow) = (&drive[..2000], &drive[2000..]);
    let mut script = service::frames(fast);
    for part in slow.chunks(1200) {
        script.push(Happens::Hangups(1));
        script.extend(slowly(part));
    }
    let ran = service::run(script, read);
    assert_eq!(readings.load(Ordering::Relaxed), 5);
    assert_eq!(ran.tally.received as usize, drive.len());
    heard::protected(&ran.heard.frames);
    let told: Vec<bool> =
        heard::faults(&ran.heard.frames).iter().map(|f| f.contains(Faults::CONFIG)).collect();
    let changes: Vec<bool> = told.windows(2).filter(|pair| pair[0] != pair[1]).map(|pair| pair[1]).collect();
    assert_eq!((told[0], changes), (false, vec![true, false]));
    assert_eq!(ran.retuned.len(), 1, "only for the good one");
    // As if nothing had happened.
    let mut expected = Heard::default();
    let mut engine = car::engine(&car::config());
    drive.iter().for_each(|frame| engine.frame(frame, &mut expected));
    assert!(ran.heard.samples == expected.samples);
}

/// GIVEN hundreds of hangups WHEN they come faster than files can be read THEN files are read once a second at
/// most, the last time after the last hangup, and what is published is what it would have been.
#[test]
fn a_storm_of_hangups_does_no_harm() {
    let readings = Arc::new(AtomicUsize::new(0));
    let count = Arc::clone(&readings);
    let drive = &car::drive()[..6000];
    let mut script = service::frames(&drive[..4000]);
    for frame in drive[4000..].chunks(20) {
        script.push(Happens::Hangups(3));
        script.extend(slowly(frame));
    }
    script.push(Happens::Pause(Duration::from_millis(1100)));
    let begun = std::time::Instant::now();
    let ran = service::run(script, move || {
        count.fetch_add(1, Ordering::Relaxed);
        Ok(car::config())
    });
    let readings = readings.load(Ordering::Relaxed) as f64;
    let seconds = begun.elapsed().as_secs_f64();
    assert!((2.0..=seconds + 1.0).contains(&readings), "{readings} readings in {seconds} s");
    let mut expected = Heard::default();
    let mut engine = car::engine(&car::config());
    drive.iter().for_each(|frame| engine.frame(frame, &mut expected));
    assert!(ran.heard.frames == expected.frames);
    assert_eq!(ran.retuned.len() as f64, readings);
}

/// GIVEN a quantity more WHEN it is configured THEN the bus is asked for its frames before they are needed.
#[test]
fn the_bus_is_asked_for_what_the_new_configuration_needs() {
    let mut script = service::frames(&car::drive()[..100]);
    script.push(Happens::Hangups(1));
    script.push(Happens::Pause(Duration::from_millis(300)));
    let without_drive = || {
        Ok(car::with(&[
            ("brake_pressure = \"DRIVE.BrakePressure\"\n", ""),
            ("drive_torque = \"DRIVE.AxleTorque\"\n", ""),
            ("brake_active = \"DRIVE.BrakePedal\"\n", ""),
            ("abs_active = \"DRIVE.AbsActive\"\n", ""),
        ]))
    };
    let ran = service::run(script, without_drive);
    let ids: Vec<u32> = ran.retuned[0].ids.iter().flatten().map(|id| id.number()).collect();
    // And whatever comes under the names of what is published.
    assert_eq!(ids, [0x1A0, 0x1B0, 0x1C0, 0x6A0, 0x6A1, 0x6A2, 0x6A3, 0x6A4, 0x6A5, 0x6A6]);
}
