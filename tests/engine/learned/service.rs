//! The service with a file: it saves, goes on from there, refuses, and is never stopped by it.

use std::fs;
use std::os::unix::fs::PermissionsExt;
use std::path::Path;

use gripd::Config;
use gripd::can::Frame;
use gripd::service::{Engine, Keeper, SavedState, Service, Sink, Tally, serve};
use tempfile::TempDir;

use super::super::playback::Playback;
use super::{FIRST, SECOND, after_the_first_drive, demo_car, frames, project};

struct Nobody;

impl Sink for Nobody {
    fn publish(&mut self, _: &Frame) {}
}

/// The service over a recording, from its start to its end.
fn serve_drive(log: &str, path: &Path, every_s: u64) -> Tally {
    let car = demo_car();
    let mut engine = Engine::new(&car).unwrap();
    let keeper = Keeper::start(SavedState::new(path, &car), every_s, &mut engine);
    let over = std::rc::Rc::new(tokio::sync::Notify::new());
    let link = Playback { frames: frames(log).into_iter(), over: over.clone() };
    let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build().unwrap();
    let ended = async move { over.notified().await };
    runtime.block_on(serve(Service { keeper, ..Service::new(engine, link) }, &mut Nobody, ended))
}

fn names(folder: &Path) -> Vec<String> {
    let entries = fs::read_dir(folder).unwrap();
    let mut names: Vec<_> = entries.map(|e| e.unwrap().file_name().into_string().unwrap()).collect();
    names.sort();
    names
}

/// GIVEN no file WHEN the service runs THEN there is one, what the replay of the same drive would write but
/// for samples that wait for later frames; AND the next drive adds to it.
#[test]
fn the_service_saves_at_its_end_and_goes_on_from_there() {
    let folder = TempDir::new().unwrap();
    let path = folder.path().join("state.toml");
    for (every_s, begun) in [(0, 0.0), (10, 43.9)] {
        assert!(serve_drive(FIRST, &path, every_s).published > 10_000);
        let learned = SavedState::new(&path, &demo_car()).load().unwrap().unwrap();
        assert!((begun + 40.0..begun + 45.0).contains(&learned.driving_s), "{learned:?}");
        assert!(learned.slip_offset[0].is_some() && learned.yaw_rate_offset.is_some());
        let all = ["state.toml", "state.toml.before"];
        assert_eq!(names(folder.path()), all[..if begun > 0.0 { 2 } else { 1 }]);
    }
}

/// GIVEN a file that is damaged, and beside it what the last drive began with, WHEN the service starts THEN it goes on
/// from that; AND who takes the file away, or forgets, takes that away, too.
#[test]
fn a_damaged_file_has_one_to_fall_back_on() {
    let folder = after_the_first_drive();
    let path = folder.path().join("learned.toml");
    let state = SavedState::new(&path, &demo_car());
    let first = state.load().unwrap().unwrap();
    serve_drive(SECOND, &path, 10);
    let second = state.load().unwrap().unwrap();
    assert!(second.driving_s > first.driving_s + 30.0);
    let good = fs::read(&path).unwrap();
    fs::write(&path, &good[..good.len() / 2]).unwrap();
    let taken = state.take_up();
    assert_eq!((taken.learned, taken.may_write, taken.refused), (Some(first), true, true));
    // The next one begins with what there was before, and is damaged itself: there is nothing to go back to twice.
    assert_eq!(names(folder.path()), ["learned.toml.before", "learned.toml.refused"]);
    fs::write(&path, &good).unwrap();
    assert_eq!(state.take_up().learned, Some(second));
    assert_eq!(names(folder.path()), ["learned.toml", "learned.toml.before", "learned.toml.refused"]);
    state.save_forgotten(&first).unwrap();
    assert_eq!(names(folder.path()), ["learned.toml", "learned.toml.refused"]);
    state.take_up();
    fs::remove_file(&path).unwrap();
    assert_eq!(state.take_up().learned, None);
    assert_eq!(names(folder.path()), ["learned.toml.refused"]);
}

/// GIVEN a file that is not right, and what a writer left that lost its power, WHEN the service starts THEN
/// it runs from nothing, keeps the file aside, and tidies up.
#[test]
fn the_service_moves_aside_what_it_refuses() {
    let folder = after_the_first_drive();
    let path = folder.path().join("learned.toml");
    let good = fs::read(&path).unwrap();
    let mut damaged = good.clone();
    let place = damaged.len() / 2;
    damaged[place] ^= 1;
    fs::write(&path, &damaged).unwrap();
    fs::write(folder.path().join(".learned.toml.4711-0.part"), &good[..100]).unwrap();
    assert!(serve_drive(SECOND, &path, 10).published > 10_000);
    assert_eq!(names(folder.path()), ["learned.toml", "learned.toml.refused"]);
    assert!(fs::read(folder.path().join("learned.toml.refused")).unwrap() == damaged);
    let learned = SavedState::new(&path, &demo_car()).load().unwrap().unwrap();
    assert!(learned.driving_s < 45.0, "it began anew: {learned:?}");
}

/// GIVEN a place that cannot be written, or is none WHEN the service runs THEN it publishes as if it could.
#[test]
fn what_cannot_be_written_does_not_stop_the_service() {
    let folder = TempDir::new().unwrap();
    let nowhere = folder.path().join("no/such/folder/state.toml");
    let everything = serve_drive(FIRST, &nowhere, 5).published;
    assert!(everything > 10_000);
    // A folder in the file's place is no file that could be moved away.
    let a_folder = folder.path().join("folder");
    fs::create_dir(&a_folder).unwrap();
    assert_eq!(serve_drive(FIRST, &a_folder, 5).published, everything);
    let locked = folder.path().join("locked");
    fs::create_dir(&locked).unwrap();
    fs::set_permissions(&locked, fs::Permissions::from_mode(0o500)).unwrap();
    assert_eq!(serve_drive(FIRST, &locked.join("state.toml"), 5).published, everything);
    fs::set_permissions(&locked, fs::Permissions::from_mode(0o700)).unwrap();
    assert_eq!(names(folder.path()), ["folder", "locked"]);
}

/// Where it is kept: as configured, else where systemd says, else nowhere.
#[test]
fn where_it_is_kept() {
    let text = fs::read_to_string(project("config/demo.toml")).unwrap();
    let place = |service: &str, directory: Option<&str>| {
        let config =
            Config::parse(&format!("{text}\n{service}"), Path::new("/etc/gripd/gripd.toml")).unwrap();
        let state = SavedState::of_service(&config, directory.map(std::ffi::OsStr::new));
        state.map(|state| state.path().to_str().unwrap().to_owned())
    };
    assert_eq!(place("", None), None);
    assert_eq!(place("", Some("/var/lib/gripd")), Some("/var/lib/gripd/learned.toml".into()));
    assert_eq!(place("", Some("/var/lib/a:/var/lib/b")), Some("/var/lib/a/learned.toml".into()));
    assert_eq!(place("[service]\nstate_file = \"s.toml\"", Some("/x")), Some("/etc/gripd/s.toml".into()));
    assert_eq!(place("[service]\nstate_file = \"\"", Some("/var/lib/gripd")), None);
    let own = format!("{text}\n[service]\nstate_file = \"gripd.toml\"");
    let error = Config::parse(&own, Path::new("/etc/gripd/gripd.toml")).unwrap_err().to_string();
    assert!(error.contains("service.state_file"), "{error}");
}
