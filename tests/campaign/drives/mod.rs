//! Can the published friction be trusted? Drives at random over the surfaces, cars and troubles that a gateway meets,
//! as frames through the whole engine, and what it says against what is true.
//!
//! The plant has magic-formula tires with load sensitivity; the estimators' own models do not. Every drive has a car of
//! three (true numbers apart from its data sheet), two or three surfaces, a manner of driving, and by chance a bank, a
//! load, worn tires, one slippery side, and an emergency braking at its end.
//!
//!     cargo test --release --test campaign drives::by_hand -- --ignored --nocapture
//!
//! drives all of it and prints the tables; `CAMPAIGN_COUNT` (210; 60 against the anchors), `CAMPAIGN_SEED` (1). Every
//! test run drives a few.

mod cars;
mod cornering;
mod cpu;
mod drive;
mod friction;
mod ideal;
mod judge;
mod known;
mod learner;
mod peers;
mod stiffness;

use drive::Drive;
use judge::Judgement;
use rayon::prelude::*;
use testing::driven;
use testing::results::Section;
use testing::setting::setting;

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

/// The observer to whom nearly everything is told: never surer than it may be, and surer than the service.
#[test]
fn what_could_be_known_at_best_is_more_than_what_is() {
    let known = known::of(&Drive::draw(7003));
    println!("{known}");
    assert!(known.covered() > 0.95, "{known}");
    assert!(known.by_the_ideal() > 2 * known.by_the_service(), "{known}");
}

/// For people, by name: no run of all tests has the time.
mod by_hand {
    use super::*;

    fn section<'a>(name: &'a str, header: &'a str) -> Section<'a> {
        Section { name, seed: "seeds 7001 to 7210", tolerance: 0.03, header }
    }

    #[test]
    #[ignore = "by hand: two minutes, 210 drives"]
    fn more_drives_by_the_use_of_friction() {
        let judgement = campaign(7001, 210);
        println!("{judgement}");
        let by_use = "use of friction | samples | truth in the interval | bounded, below 1.15 | mean width | valid | \
                      valid and off by more than 0.1";
        section("campaign", by_use).check(&judgement.rows());
        let of_drives = "drives | with an interval off by more than 0.1 | falls to less than half | noticed within 0.5 s | \
                         within 1 s | sideslip, where valid, rms";
        section("campaign_drives", of_drives).check(&[judgement.of_drives()]);
        section("campaign_stiffness", cornering::Cornering::HEADER).check(&[judgement.of_stiffness()]);
        assert!(judgement.covered() > 0.95);
    }

    #[test]
    #[ignore = "by hand: minutes, 210 drives"]
    fn how_much_of_what_can_be_known() {
        let known = (7001..7211)
            .into_par_iter()
            .map(|seed| known::of(&Drive::draw(seed)))
            .reduce(Default::default, known::Known::and);
        println!("{known}");
        section("campaign_ideal", known::Known::HEADER).check(&known.rows());
    }

    #[test]
    #[ignore = "by hand: minutes"]
    fn the_whole_campaign() {
        let judgement = campaign(setting("CAMPAIGN_SEED", 1), setting("CAMPAIGN_COUNT", 210));
        println!("{judgement}");
    }

    /// The same drives for all: gripd, the thesis's own filters, and a learner in the manner of openpilot's.
    #[test]
    #[ignore = "by hand: minutes"]
    fn against_the_anchors() {
        let (first, count) = (setting("CAMPAIGN_SEED", 1), setting("CAMPAIGN_COUNT", 60));
        let scores = |seed: u64| {
            let drive = peers::drive(&Drive::draw(seed));
            (stiffness::scores(&drive), friction::scores(&drive))
        };
        let all: Vec<_> = (first..first + count).into_par_iter().map(scores).collect();
        let (stiffness, friction): (Vec<_>, Vec<_>) = all.into_iter().unzip();

        println!("{count} drives\n{}", stiffness::Score::HEADER);
        for (i, (name, _)) in stiffness::PEERS.iter().enumerate() {
            let of_drives = stiffness.iter().map(|scores| scores[i].clone());
            println!("{}", of_drives.fold(stiffness::Score::default(), stiffness::Score::and).line(name));
        }
        for (place, from) in friction::USES.into_iter().enumerate() {
            for (i, (name, _)) in friction::PEERS.iter().enumerate() {
                let of_drives = friction.iter().map(|scores| scores[place][i]);
                let score = of_drives.fold(friction::Score::default(), friction::Score::and);
                if i == 0 {
                    println!("\n{}", score.header(from));
                }
                println!("{}", score.line(name));
            }
        }
        println!("\n| CPU | ns per sample |\n|---|---|");
        for (name, nanoseconds) in cpu::times(&peers::drive(&Drive::draw(first))) {
            println!("| {name} | {nanoseconds:.0} |");
        }
    }
}
