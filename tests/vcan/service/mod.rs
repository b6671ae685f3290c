//! The service itself, as a process on real (virtual) CAN interfaces.
//!
//! Each test makes interfaces of its own. Where that is not allowed they say so and pass;
//! `tests/vcan/run.sh` is cargo's runner for a place where it is.

mod bad_day;
mod black_box;
mod campaign;
mod faults;
mod isolation;
mod lateness;
mod lifecycle;
mod links;
mod live_soak;
mod log;
mod metrics;
mod monitor;
mod others;
mod process;
mod reload;
mod show;
mod traffic;
mod view;
mod wrong_bus;

use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::OnceLock;
use std::time::{Duration, Instant};

use gripd::can::candump::{Reader, Writer};
use gripd::can::{CanId, Frame};
use gripd::{Micros, dbc::Database};
use nix::sys::signal::Signal::{SIGHUP, SIGINT, SIGTERM};
use process::{Gripd, gripd};
use testing::program::project;
use testing::vcan::{Interface, PATIENCE, run};
use traffic::{Recorder, Traffic};

/// The demo car's configuration.
fn demo_car() -> PathBuf {
    project("config/demo.toml")
}

/// The demo car's configuration with an edit, as a file that can be edited again.
fn edited_car(edit: impl FnOnce(String) -> String) -> tempfile::NamedTempFile {
    let text = std::fs::read_to_string(demo_car()).unwrap();
    let dbc = project("dbc/demo.dbc");
    let text = text.replace("\"../dbc/demo.dbc\"", &format!("\"{}\"", dbc.display()));
    let file = tempfile::Builder::new().suffix(".toml").tempfile().unwrap();
    std::fs::write(file.path(), edit(text)).unwrap();
    file
}

/// 20 s of a simulated drive of the demo car, made by `gripd simulate`.
fn simulated_drive() -> &'static Path {
    static MADE: OnceLock<PathBuf> = OnceLock::new();
    MADE.get_or_init(|| {
        let folder = Path::new(env!("CARGO_TARGET_TMPDIR"));
        let scenario = std::fs::read_to_string(project("config/scenarios/demo.toml")).unwrap();
        let shorter = scenario.replace("duration_s = 120.0", "duration_s = 20.0");
        assert_ne!(scenario, shorter, "the scenario has another length now");
        let (scenario, log) = (folder.join("vcan_service.toml"), folder.join("vcan_service.log"));
        std::fs::write(&scenario, shorter).unwrap();
        let mut simulate = Command::new(gripd());
        simulate.arg("simulate").arg(&scenario).arg("-o").arg(&log);
        assert!(simulate.status().unwrap().success());
        log
    })
}

/// Frames of a recording.
fn frames(log: &Path) -> Vec<Frame> {
    let mut reader = Reader::open(log).unwrap();
    std::iter::from_fn(|| reader.next_frame().unwrap()).collect()
}

/// Identifiers that gripd publishes on.
fn published_ids() -> Vec<CanId> {
    let database = Database::load(&project("dbc/gripd.dbc")).unwrap();
    database.messages().iter().map(|message| message.id).collect()
}

/// The counters of a published message, frame by frame.
fn counters(recorded: &[Frame], id: CanId) -> Vec<u8> {
    recorded.iter().filter(|frame| frame.id == id).map(|frame| frame.data()[1] & 15).collect()
}

/// Is it one of the messages that gripd publishes?
fn is_published(frame: &Frame) -> bool {
    (0x6A0..=0x6A6).contains(&frame.id.number()) && !frame.id.is_extended()
}

fn data(number: u32, bytes: &[u8]) -> Frame {
    Frame::data_frame(Micros(0), CanId::standard(number).unwrap(), bytes).unwrap()
}

/// Waits until something holds; it fails if it never does.
#[track_caller]
fn wait_for(what: &str, mut holds: impl FnMut() -> bool) {
    let begun = Instant::now();
    while !holds() {
        assert!(begun.elapsed() < PATIENCE, "waited in vain: {what}");
        std::thread::sleep(Duration::from_millis(10));
    }
}
