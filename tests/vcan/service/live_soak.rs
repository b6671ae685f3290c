//! GIVEN 2,000 frames a second WHEN the link flaps and the configuration is read anew, again and again, THEN every frame
//! that the kernel took is received or counted as dropped, what is published is what a replay of the same bus gives,
//! frame for frame (nothing stale, nothing lost), and it comes about as late as a bare echo.
//!
//! Every test run does it for 20 s. For 20 minutes:
//!
//! ```text
//! CARGO_TARGET_X86_64_UNKNOWN_LINUX_GNU_RUNNER=$PWD/tests/vcan/run.sh VCAN_TIMEOUT=2000 GRIPD_LIVE_SOAK_S=1200 \
//!     cargo test --release --test vcan live_soak -- --nocapture
//! ```

use super::lateness::{Echo, Sender, Wakes, drive, heard, used_by};
use super::log::Log;
use super::*;
use testing::setting::setting;

#[test]
#[ignore = "long: 20 s"]
fn flaps_and_reloads_lose_nothing() {
    let Some(interface) = Interface::new("gs_soak") else { return };
    let seconds: u64 = setting("GRIPD_LIVE_SOAK_S", 20);
    let car = edited_car(|text| text);
    let recording = drive(2000);
    let log = Log::start(interface.0);
    let gripd = Gripd::start(car.path(), interface.0);
    gripd.wait_for_log("the input interface is up");
    let echo = Echo::start(interface.0, Wakes::Question, &[]);
    let sender = Sender::start(interface.0, recording);
    let (mut flaps, mut reloads, mut early) = (0, 0, 0);
    let begun = Instant::now();
    while begun.elapsed() < Duration::from_secs(seconds) {
        std::thread::sleep(Duration::from_millis(2500));
        gripd.signal(SIGHUP);
        reloads += 1;
        std::thread::sleep(Duration::from_millis(2500));
        if reloads % 2 == 1 {
            interface.set("down");
            std::thread::sleep(Duration::from_millis(300));
            interface.set("up");
            flaps += 1;
        }
        if early == 0 && begun.elapsed() * 4 > Duration::from_secs(seconds) {
            early = used_by(gripd.id()).1;
        }
    }
    std::thread::sleep(Duration::from_secs(1));
    let (cpu_s, late) = used_by(gripd.id());
    let sent = sender.stop();
    drop(echo);
    let file = log.end();
    let reloaded = gripd.log().matches("the new configuration is in use; the estimators go on").count();
    let tally = gripd.end(SIGTERM);
    let mut heard = heard(&file, car.path(), (tally.unsent + tally.late) as u64, true);
    println!(
        "{seconds} s, {flaps} flaps, {reloads} reloads ({reloaded} taken over): {sent} frames sent, {tally:?}, CPU {:.1} %, \
         {early} KiB after a quarter, {late} KiB at the end",
        100.0 * cpu_s / begun.elapsed().as_secs_f64()
    );
    println!("| | count | p50 | p99 | p99.9 | most, ms |\n|---|---|---|---|---|---|");
    println!("{}", heard.first.row("first frame of a round"));
    println!("{}", heard.last.row("last frame of a round"));
    println!("{}", heard.echo.row("bare echo"));
    assert_eq!((tally.received + tally.dropped) as u64, sent);
    // A link that goes down takes no more than a round, and what waited: where the machine is starved, rounds are late.
    assert!(tally.published as u64 > heard.published);
    assert!(tally.unsent <= 14 * flaps + tally.late, "{tally:?}");
    assert_eq!(reloaded, reloads);
    assert!(late < early + 1024, "{early} KiB, then {late}");
}
