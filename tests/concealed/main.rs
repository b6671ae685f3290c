//! The proof of `gripd explain`: recordings of a second, independent vehicle simulator in which one cause is concealed.
//!
//! Nothing of gripd's library takes part in making them. The program under test is given what a user has, the log, the
//! network description and the car file with its doubts; the truth stays here.
//!
//! Write recordings (no program needed):
//!     CONCEALED_OUT=/tmp/fresh cargo test --release --test concealed -- --ignored write_the_recordings --nocapture
//! The proof, on the program built with this test:
//!     cargo test --release --test concealed -- --ignored the_whole_table --nocapture
//! makes the recordings that are not there, answers those that have no answer, scores, and writes `table.md` and
//! `table.json` beside them. What is interrupted goes on when said again; a folder with a set from elsewhere (the
//! practice trials) is answered and scored as it is.
//!
//! Environment: CONCEALED_OUT (a folder below `target/tmp`), CONCEALED_SEED (1), CONCEALED_COUNT (210, a sixth of them
//! controls), CONCEALED_FACTOR (1,0.3,0.1: times the ordinary strength, dealt in turn), CONCEALED_ONLY (causes
//! separated by commas), CONCEALED_LENGTH (s; drawn from 90 to 120), CONCEALED_JOBS (2), CONCEALED_LOOK (1; 0 leaves out how visible each cause is),
//! CONCEALED_PROGRAM (another gripd), CONCEALED_SECONDS (1200, after which an answer does not count).
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)] // Tests.

mod alternatives;
mod bus;
mod car;
mod cause;
mod dice;
mod drive;
mod hidden;
mod physics;
mod program;
mod recording;
mod sample;
mod score;
mod scoring;
mod sensors;
mod set;
mod share;
mod table;
mod tire;
mod trust;
mod visible;

use std::path::PathBuf;

use program::Program;
use set::{Set, Wish, setting};

fn folder() -> PathBuf {
    PathBuf::from(setting("CONCEALED_OUT", String::from(concat!(env!("CARGO_TARGET_TMPDIR"), "/concealed"))))
}

#[test]
#[ignore = "writes recordings to CONCEALED_OUT; for people"]
fn write_the_recordings() {
    Set::open(&folder()).complete(&Wish::from_environment().orders());
}

#[test]
#[ignore = "hours; for people"]
fn the_whole_table() {
    let set = Set::open(&folder());
    if set.is_foreign() {
        println!("{}: a set from elsewhere, scored as it is", set.folder.display());
    } else {
        set.complete(&Wish::from_environment().orders());
    }
    let answers = Program::found().answer(&set);
    let scores = score::all(&set.truths(), &answers);
    let parts = table::parts(&scores);
    let page = table::markdown(&parts);
    std::fs::write(set.folder.join("table.md"), &page).unwrap();
    let values = serde_json::to_string_pretty(&table::json(&parts, &scores)).unwrap();
    std::fs::write(set.folder.join("table.json"), values).unwrap();
    println!("{page}");
    assert!(scores.iter().all(|s| s.verdict != "none given"), "recordings without an answer");
}
