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
#[path = "../support/setting.rs"]
mod setting;
mod surface;

use drive::Drive;
use judge::Judgement;
use rayon::prelude::*;
use setting::setting;

/// Drives so many, and puts the judgements together in the order of the seeds.
fn campaign(first: u64, count: u64) -> Judgement {
    let all: Vec<_> =
        (first..first + count).into_par_iter().map(|seed| judge::judge(&Drive::draw(seed))).collect();
    all.into_iter().fold(Judgement::default(), Judgement::and)
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
