//! The black box: a recording for each new fault, which a replay takes and in which it finds the fault again.

use std::fs;
use std::os::unix::fs::PermissionsExt;
use std::path::{Path, PathBuf};
use std::rc::Rc;

use gripd::can::Frame;
use gripd::can::candump::Reader;
use gripd::service::{BlackBox, SavedState, Service, Sink, Tally, serve};
use gripd::{Config, Estimates, Faults, Micros, Sample};
use testing::demo_car as car;
use testing::fault::{Case, Fault, content, frame, sensor, timing};
use tokio::sync::Notify;

use super::playback::Playback;

/// What samples and estimates tell.
#[derive(Default)]
struct Told(Faults, u32);

impl Sink for Told {
    fn estimates(&mut self, _: &Sample, estimates: &Estimates) {
        self.0 |= estimates.faults;
        self.1 = estimates.surface_changes;
    }

    fn publish(&mut self, _: &Frame) {}
}

/// The service over these frames, with recordings into `folder`.
fn serve_all(config: &Config, frames: Vec<Frame>, folder: &Path) -> Tally {
    let engine = car::engine(config);
    let mut service = config.service.clone();
    service.record_faults = Some(folder.to_owned());
    let black_box = BlackBox::start(&service, "can0", "can0", &engine);
    assert!(black_box.is_some());
    let over = Rc::new(Notify::new());
    let link = Playback { frames: frames.into_iter(), over: Rc::clone(&over) };
    let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build().unwrap();
    let ended = async move { over.notified().await };
    let service = Service { black_box, ..Service::new(engine, link) };
    runtime.block_on(serve(service, &mut Told::default(), ended))
}

/// Recordings, the oldest first.
fn recordings(folder: &Path) -> Vec<PathBuf> {
    let mut paths: Vec<_> = fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()).collect();
    paths.retain(|path| path.to_str().unwrap().ends_with(".log.gz"));
    paths.sort();
    paths
}

fn frames(path: &Path) -> Vec<Frame> {
    let mut reader = Reader::open(path).unwrap();
    let frames = std::iter::from_fn(|| reader.next_frame().unwrap()).collect();
    assert_eq!(reader.stats().skipped_lines, 0);
    frames
}

/// What a replay of a recording tells, with what was learned until then, and how many changes of surface.
fn told_by_a_replay(config: &Config, recording: &Path) -> (Faults, u32) {
    let state = PathBuf::from(recording.to_str().unwrap().replace(".log.gz", ".state.toml"));
    let mut engine = car::engine(config);
    engine.restore(&SavedState::new(&state, config).load().unwrap().unwrap());
    let mut told = Told::default();
    frames(recording).iter().for_each(|frame| engine.frame(frame, &mut told));
    engine.finish(&mut told);
    let counted = Faults::all().iter().filter(|fault| engine.occurrences(*fault) > 0);
    (counted.fold(told.0, |told, fault| told | fault), told.1)
}

/// The clock of the recordings, and how long the drive lasts before the fault, s.
const CLOCK: Micros = Micros::from_millis(1_795_320_000_000);
const LEAD: Micros = Micros::from_millis(20_000);

/// The demo's drive, 30 s of it before the fault.
fn faulty(config: &Config, case: &Case) -> Vec<Frame> {
    let mut readings = car::readings().to_vec();
    readings.iter_mut().for_each(|reading| reading.time = reading.time - LEAD);
    let frames = match case.fault {
        Fault::Sensors(spoil) => {
            spoil(&mut readings);
            readings.sort_by_key(|reading| reading.time);
            car::frames_of(config, &readings)
        }
        Fault::Frames(spoil) => spoil(car::frames_of(config, &readings)),
    };
    let shifted = |mut frame: Frame| {
        frame.time = frame.time + CLOCK;
        frame
    };
    frames.into_iter().map(shifted).collect()
}

/// GIVEN any fault of the list, 30 s after the start WHEN the service records it THEN there is a recording that begins
/// 20 s before it, and a replay of it tells all that was told; AND without a fault there is none.
#[test]
fn a_replay_finds_every_fault_of_the_list_again() {
    let config = car::config();
    let nothing = Case { name: "nothing", ..Case::PLAIN };
    let cases = [frame::cases(), content::cases(), sensor::cases(), timing::cases()].into_iter().flatten();
    let mut problems = Vec::new();
    for case in std::iter::once(nothing).chain(cases) {
        let folder = tempfile::tempdir().unwrap();
        let all = faulty(&config, &case);
        let origin = all[0].time;
        let tally = serve_all(&config, all.clone(), folder.path());
        assert!(tally.published > 1000 && tally.dropped == 0);
        let recordings = recordings(folder.path());
        let told =
            recordings.iter().fold(Faults::empty(), |told, path| told | told_by_a_replay(&config, path).0);
        println!("{}: {} recordings, {told:?}", case.name, recordings.len());
        if !told.contains(case.told) {
            problems.push(format!("{}: a replay tells {told:?}, not {:?}", case.name, case.told));
        }
        if case.told.is_empty() && case.name == "nothing" && !recordings.is_empty() {
            problems.push(format!("{recordings:?} of a drive without faults"));
        }
        let Some(first) = recordings.first().filter(|_| !case.told.is_empty()) else { continue };
        let recorded = frames(first);
        // A clock that is set back by three seconds takes them off.
        let begins = (recorded[0].time - origin).seconds();
        if !(6.5..15.5).contains(&begins) {
            problems.push(format!("{}: begins after {begins} s", case.name));
        }
        // Every frame is there, as it came.
        let place = all.iter().position(|frame| *frame == recorded[0]).unwrap();
        assert_eq!(all[place..][..recorded.len()], recorded, "{}", case.name);
    }
    assert!(problems.is_empty(), "{}", problems.join("\n"));
}

/// GIVEN the demo's drive over three surfaces WHEN the service records the changes THEN a replay of each recording notices
/// one, too.
#[test]
fn a_replay_finds_changes_of_surface_again() {
    let config = car::config();
    let mut simulate = testing::program::gripd();
    let scenario = testing::program::project("config/scenarios/demo.toml");
    let output = simulate.args(["-q", "simulate"]).arg(scenario).args(["-o", "-"]).output().unwrap();
    let folder = tempfile::tempdir().unwrap();
    serve_all(&config, testing::bus::frames(&output.stdout), folder.path());
    let recordings = recordings(folder.path());
    let of_surface = recordings.iter().filter(|path| path.to_str().unwrap().contains("-surface"));
    let noticed: Vec<u32> = of_surface.map(|path| told_by_a_replay(&config, path).1).collect();
    println!("{recordings:?}: {noticed:?}");
    assert!(!noticed.is_empty() && noticed.iter().all(|count| *count > 0), "{recordings:?}: {noticed:?}");
}

/// Every message of an identifier is left out for a second, again and again.
fn with_gaps(config: &Config, gaps: &[i64]) -> Vec<Frame> {
    let mut all = faulty(config, &Case { name: "gaps", ..Case::PLAIN });
    let id = all[0].id;
    let origin = all[0].time;
    all.retain(|frame| {
        let second = (frame.time - origin).0 / Micros::PER_SECOND;
        frame.id != id || !gaps.contains(&second)
    });
    all
}

/// GIVEN a fault that comes and goes THEN its recording goes on until it has been away for ten seconds.
#[test]
fn what_flaps_is_one_recording() {
    let config = car::config();
    let folder = tempfile::tempdir().unwrap();
    serve_all(&config, with_gaps(&config, &[10, 14, 18, 22]), folder.path());
    let recordings = recordings(folder.path());
    assert_eq!(recordings.len(), 1, "{recordings:?}");
    assert!(recordings[0].to_str().unwrap().ends_with("-timeout.log.gz"), "{recordings:?}");
    assert!(told_by_a_replay(&config, &recordings[0]).0.contains(Faults::TIMEOUT));
}

/// GIVEN a clock that is set back by an hour THEN what happens afterwards is recorded all the same.
#[test]
fn after_a_clock_was_set_back_by_an_hour() {
    let config = car::config();
    let folder = tempfile::tempdir().unwrap();
    let mut all = with_gaps(&config, &[25]);
    let middle = all.len() / 2;
    all[middle..].iter_mut().for_each(|frame| frame.time = frame.time - Micros::from_millis(3_600_000));
    serve_all(&config, all, folder.path());
    let recordings = recordings(folder.path());
    assert_eq!(recordings.len(), 1, "{recordings:?}");
    let (told, _) = told_by_a_replay(&config, &recordings[0]);
    assert!(told.contains(Faults::TIMEOUT), "{told:?}");
}

/// GIVEN a folder that cannot be had, or not be written WHEN there is a fault THEN the service publishes as without.
#[test]
fn a_folder_that_cannot_be_written_does_not_stop_the_service() {
    let config = car::config();
    let folder = tempfile::tempdir().unwrap();
    let frames = || with_gaps(&config, &[10]);
    let usual = serve_all(&config, frames(), &folder.path().join("faults"));
    assert_eq!(recordings(&folder.path().join("faults")).len(), 1);
    let nowhere = folder.path().join("no/such/folder");
    assert_eq!(serve_all(&config, frames(), &nowhere), usual);
    fs::write(folder.path().join("file"), "").unwrap();
    assert_eq!(serve_all(&config, frames(), &folder.path().join("file")), usual);
    let locked = folder.path().join("locked");
    fs::create_dir(&locked).unwrap();
    fs::set_permissions(&locked, fs::Permissions::from_mode(0o500)).unwrap();
    assert_eq!(serve_all(&config, frames(), &locked), usual);
    fs::set_permissions(&locked, fs::Permissions::from_mode(0o700)).unwrap();
}

/// Where it goes, and what is refused.
#[test]
fn where_it_is_recorded() {
    let parse = |service: &str| {
        Config::parse(&format!("{}\n[service]\n{service}", car::text()), Path::new("/etc/gripd/gripd.toml"))
    };
    let place = |service: &str| parse(service).unwrap().service.record_faults;
    assert_eq!(place(""), None);
    assert_eq!(place("record_faults = \"faults\""), Some("/etc/gripd/faults".into()));
    assert_eq!(place("record_faults = \"/var/lib/x\""), Some("/var/lib/x".into()));
    assert_eq!(place("record_faults = \"\""), Some("".into()));
    let engine = car::engine(&car::config());
    let nowhere = parse("record_faults = \"\"").unwrap().service;
    assert!(BlackBox::start(&nowhere, "can0", "can0", &engine).is_none());
    for (line, key) in
        [("record_files = 0", "service.record_files"), ("record_bytes = 99", "service.record_bytes")]
    {
        let error = parse(line).unwrap_err().to_string();
        assert!(error.contains(key) && error.contains("too little"), "{error}");
    }
}
