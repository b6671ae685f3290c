//! A car that drives for a day, and what goes wrong meanwhile.
//!
//! One engine gets a day of simulated driving, faults of the list drawn at random among it, reloads and restarts;
//! another one the same day without faults. Nothing may grow, no number may be none, what is flagged valid is judged
//! against the truth of the simulation, and the same day once more is published bit by bit as before.
//!
//! Every test run drives some minutes. A day, and other ones:
//!
//! ```text
//! GRIPD_SOAK_HOURS=24 GRIPD_SOAK_SEED=1 cargo test --release --test campaign soak -- --nocapture
//! ```

mod day;
mod memory;
mod road;
mod spoil;
mod verdict;

use rayon::prelude::*;
use road::Stretch;
use testing::setting::setting;

/// Simulated once: three hours of driving, 400 MB.
const MOST_STRETCHES: u64 = 30;

/// GIVEN a day of driving WHEN what the list has goes wrong again and again THEN nothing grows, no number is none,
/// little is valid that the faults made wrong, AND the same day once more is the same to the last bit.
#[test]
fn a_day_of_faults() {
    let hours: f64 = setting("GRIPD_SOAK_HOURS", 0.1);
    let seed = setting("GRIPD_SOAK_SEED", 1);
    // Stretches of some six minutes, from standing to standing; a long day goes over each of them several times.
    let count = ((hours * 10.0).ceil() as u64).min(MOST_STRETCHES);
    let stretches: Vec<Stretch> =
        (0..count).into_par_iter().map(|number| Stretch::draw(seed << 32 | number)).collect();
    let [first, second] = std::thread::scope(|scope| {
        [0, 1].map(|_| scope.spawn(|| day::drive(hours, seed, &stretches))).map(|day| day.join().unwrap())
    });
    println!("{first}");
    assert_eq!(first.digest, second.digest, "the second run is another one");
    assert!(first.seconds >= hours * 3600.0 && first.published > (200.0 * first.seconds) as u64, "{first}");
    // Not a byte more than after the first stretch, and not one request in between but at reloads and restarts.
    assert_eq!(first.memory.requests, 0, "{first}");
    assert_eq!(first.memory.grown_bytes, 0, "{first}");
    first.verdict.is_good();
}
