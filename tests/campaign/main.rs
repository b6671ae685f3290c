//! Can the published friction be trusted? Drives at random over the surfaces, cars and troubles that a gateway meets,
//! as frames through the whole engine, and what it says against what is true.
//!
//! The plant has magic-formula tires with load sensitivity; the estimators' own models do not. Every drive has a car of
//! three (true numbers apart from its data sheet), two or three surfaces, a manner of driving, and by chance a bank, a
//! load, worn tires, one slippery side, and an emergency braking at its end.
//!
//!     cargo test --release --test campaign -- --ignored --nocapture
//!
//! drives all of it and prints the tables; `CAMPAIGN_COUNT` (210), `CAMPAIGN_SEED` (1). Every test run drives a few.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)] // Tests.

mod cars;
mod drive;
#[path = "../support/driven.rs"]
mod driven;
mod judge;
mod surface;

use std::sync::Mutex;
use std::sync::atomic::{AtomicU64, Ordering};

use drive::Drive;
use judge::Judgement;

/// Drives so many, two at a time, and puts the judgements together in the order of the seeds.
fn campaign(first: u64, count: u64) -> Judgement {
    let next = AtomicU64::new(0);
    let all = Mutex::new(Vec::new());
    std::thread::scope(|scope| {
        for _ in 0..2 {
            scope.spawn(|| {
                loop {
                    let number = next.fetch_add(1, Ordering::Relaxed);
                    if number >= count {
                        break;
                    }
                    let drive = Drive::draw(first + number);
                    let judgement = judge::judge(&drive);
                    all.lock().unwrap().push((number, judgement));
                }
            });
        }
    });
    let mut all = all.into_inner().unwrap();
    all.sort_by_key(|(number, _)| *number);
    all.into_iter().fold(Judgement::default(), |sum, (_, judgement)| sum.and(judgement))
}

fn setting(name: &str, usual: u64) -> u64 {
    std::env::var(name).ok().and_then(|text| text.parse().ok()).unwrap_or(usual)
}

/// What holds today, on a few drives; the whole campaign is the measure of what does not hold yet.
#[test]
fn a_few_drives_keep_the_truth_in_the_interval() {
    let judgement = campaign(7001, 6);
    println!("{judgement}");
    assert!(judgement.samples() > 30_000, "{judgement}");
    assert!(judgement.covered() > 0.95, "{judgement}");
    assert!(judgement.at_the_limit() > 500, "no drive came near its limits: {judgement}");
}

#[test]
#[ignore = "minutes; for people"]
fn the_whole_campaign() {
    let judgement = campaign(setting("CAMPAIGN_SEED", 1), setting("CAMPAIGN_COUNT", 210));
    println!("{judgement}");
}
