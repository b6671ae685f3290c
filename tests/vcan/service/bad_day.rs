//! Old data, other senders, a silent car, an end, a clock that is set: what receivers hear of the service then.

use std::sync::mpsc::RecvTimeoutError;

use gripd::Faults;
use nix::sys::signal::Signal::{SIGCONT, SIGSTOP};

use super::faults::told;
use super::*;

/// What was published since there were so many frames.
fn since(candump: &Recorder, count: usize) -> Vec<Frame> {
    candump.published().split_off(count)
}

/// Times of the rounds' first frames, s.
fn rounds(published: &[Frame]) -> Vec<f64> {
    let first = published.iter().filter(|frame| frame.id.number() == 0x6A0);
    first.map(|frame| frame.time.seconds()).collect()
}

/// Pauses of more than three cycles: after how many seconds, and how long.
fn pauses(times: &[f64]) -> Vec<(f64, f64)> {
    let gaps = times.windows(2).map(|pair| (pair[0] - times[0], pair[1] - pair[0]));
    gaps.filter(|(_, gap)| *gap > 0.06).collect()
}

fn is_told(published: &[Frame], faults: Faults) -> bool {
    published.iter().any(|frame| told(frame).contains(faults))
}

/// May anything in it be acted upon, or is anything there?
fn is_empty(frame: &Frame) -> bool {
    let data = frame.data();
    match frame.id.number() {
        0x6A0 => data[2..] == [0xFF, 0xFF, 0xFF, 0xFF, 0x0F, 0xFF],
        0x6A1 => data[2..] == [0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0x7F],
        0x6A4 => data[7] & 0x80 == 0,
        0x6A5 => data[1] >> 4 & 7 == 3,
        _ => true,
    }
}

/// GIVEN a stall of three seconds THEN what comes afterwards is of the present, and no more than the cycle gives.
#[test]
fn after_a_stall_nothing_old_is_sent() {
    let Some(interface) = Interface::new("gs_stall") else { return };
    let candump = Recorder::start(interface.0);
    let gripd = Gripd::start(&demo_car(), interface.0);
    let _car = Traffic::start(interface.0, frames(simulated_drive()));
    candump.wait_for_more(700, "publishing");
    gripd.signal(SIGSTOP);
    std::thread::sleep(Duration::from_millis(200));
    let known = candump.published().len();
    std::thread::sleep(Duration::from_secs(3));
    gripd.signal(SIGCONT);
    candump.wait_for_more(700, "publishing after the stall");
    let after = since(&candump, known);
    let times = rounds(&after);
    for (place, first) in times.iter().enumerate() {
        for (more, last) in times[place..].iter().enumerate() {
            // As they come off the queue of a busy guest, they may be some milliseconds apart.
            let by_rate = (last - first + 0.01) / 0.02 + 1.0;
            assert!(more as f64 + 1.0 <= by_rate + 1.0, "{more} rounds in {} s", last - first);
        }
    }
    let in_the_first_two_seconds = times.iter().filter(|time| **time < times[0] + 2.0).count();
    assert!(is_told(&after, Faults::DROPPED));
    gripd.wait_for_log("a round was dropped, it would have been too late");
    let tally = gripd.end(SIGTERM);
    println!("{in_the_first_two_seconds} rounds in the 2 s after a stall of 3 s; {tally:?}");
    println!("pauses {:?}", pauses(&times));
    // 150 rounds of seven frames were due in three seconds.
    assert!(tally.late > 100 * 7, "{tally:?}");
    assert!(in_the_first_two_seconds <= 102, "{in_the_first_two_seconds}");
}

/// GIVEN inputs of 10 Hz WHEN nothing holds anybody up THEN each frame's round is sent.
#[test]
fn slow_inputs_lose_nothing() {
    let Some(interface) = Interface::new("gs_tenhz") else { return };
    let mut recording = frames(simulated_drive());
    // As if the car sent all it knows ten times a second.
    let begun = recording[0].time;
    recording.retain(|frame| (frame.time - begun).0 % 100_000 < 20_000);
    let mut kept = std::collections::BTreeSet::new();
    recording.retain(|frame| kept.insert((frame.id, (frame.time - begun).0 / 100_000)));
    let candump = Recorder::start(interface.0);
    let (ends, ended) = std::sync::mpsc::channel::<()>();
    // How long the guest stands still, from before the service starts.
    let guest = std::thread::spawn(move || {
        let mut hiccup = Duration::ZERO;
        loop {
            let before = Instant::now();
            if ended.recv_timeout(Duration::from_millis(2)) != Err(RecvTimeoutError::Timeout) {
                return hiccup;
            }
            hiccup = hiccup.max(before.elapsed());
        }
    });
    let gripd = Gripd::start(&demo_car(), interface.0);
    let _car = Traffic::start(interface.0, recording);
    candump.wait_for_more(7 * 30, "publishing");
    std::thread::sleep(Duration::from_secs(3));
    let tally = gripd.end(SIGTERM);
    drop(ends);
    let hiccup = guest.join().unwrap();
    println!("{tally:?}; {hiccup:?} without the guest");
    // Where the guest stands still for half a cycle, the frames of two rounds are read at once, and the older is given
    // up, as it has to be: that slow inputs alone cost none is shown in `rounds`, on a clock of its own.
    let is_busy = hiccup > Duration::from_millis(10) && 2 * tally.late < tally.published;
    assert!(tally.unsent == 0 && (tally.late == 0 || is_busy), "{tally:?}, {hiccup:?}");
}

/// GIVEN somebody who sends our identifiers THEN that is told while it lasts, said once, and counted.
#[test]
fn somebody_else_under_our_name() {
    for own_output in [false, true] {
        let (Some(car), Some(output)) = (Interface::new("gs_for0"), Interface::new("gs_for1")) else {
            return;
        };
        let publishes = if own_output { output.0 } else { car.0 };
        let config = edited_car(|text| format!("{text}\n[publish]\ninterface = \"{publishes}\"\n"));
        let candump = Recorder::start(publishes);
        let gripd = Gripd::start(config.path(), car.0);
        let _traffic = Traffic::start(car.0, frames(simulated_drive()));
        candump.wait_for_more(700, "publishing");
        assert!(!is_told(&candump.published(), Faults::FOREIGN_SENDER), "of its own frames");
        // With the right checksum, as it was published a while ago.
        let forged = candump.published().into_iter().find(|frame| frame.id.number() == 0x6A0).unwrap();
        for _ in 0..50 {
            traffic::send_all(publishes, &[forged]);
            std::thread::sleep(Duration::from_millis(20));
        }
        // A request is nobody's statement.
        assert!(run("cansend", &format!("{publishes} 6A0#R")));
        gripd.wait_for_log("another node sends 6A0");
        assert!(is_told(&candump.published(), Faults::FOREIGN_SENDER));
        let known = candump.published().len();
        candump.wait_for_more(70, "publishing afterwards");
        assert!(!is_told(&since(&candump, known + 14), Faults::FOREIGN_SENDER), "it is over");
        assert_eq!(gripd.log().matches("another node sends").count(), 1);
        let tally = gripd.end(SIGTERM);
        println!("{tally:?}");
        assert_eq!(tally.foreign, 50);
    }
}

/// GIVEN a car that falls silent, and an end, THEN receivers are told of both, with nothing that could be acted upon.
#[test]
fn a_silent_car_and_an_end() {
    let Some(interface) = Interface::new("gs_silent") else { return };
    let candump = Recorder::start(interface.0);
    let gripd = Gripd::start(&demo_car(), interface.0);
    let traffic = Traffic::start(interface.0, frames(simulated_drive()));
    candump.wait_for_more(700, "publishing");
    drop(traffic);
    std::thread::sleep(Duration::from_millis(400));
    let known = candump.published().len();
    std::thread::sleep(Duration::from_secs(2));
    let silent = since(&candump, known);
    let times = rounds(&silent);
    println!("{} rounds in 2 s of a silent car", times.len());
    // A hundred, but for pauses of the whole guest.
    assert!((50..=102).contains(&times.len()), "{}", times.len());
    assert!(silent.iter().all(is_empty), "something is said to be there");
    assert!(is_told(&silent, Faults::TIMEOUT) && !is_told(&silent, Faults::ENDING));
    // From the last round of the drive to the first one of the silence.
    let all = rounds(&candump.published());
    let gap = all.windows(2).map(|pair| pair[1] - pair[0]).fold(0.0, f64::max);
    println!("{gap:.3} s without a round, pauses {:?}", pauses(&all));
    assert!(gap < 1.0, "{gap} s");
    let tally = gripd.end(SIGTERM);
    wait_for("all of them", || candump.published().len() == tally.published);
    let published = candump.published();
    let last = &published[published.len() - published_ids().len()..];
    assert!(is_told(last, Faults::ENDING) && last.iter().all(is_empty));
    assert!(!is_told(&published[..published.len() - last.len()], Faults::ENDING));
}

/// GIVEN a drive WHEN the service ends in the middle of it THEN the last round says so.
#[test]
fn an_end_in_the_middle_of_a_drive() {
    let Some(interface) = Interface::new("gs_last") else { return };
    let candump = Recorder::start(interface.0);
    let gripd = Gripd::start(&demo_car(), interface.0);
    let _car = Traffic::start(interface.0, frames(simulated_drive()));
    candump.wait_for_more(700, "publishing");
    let tally = gripd.end(SIGTERM);
    wait_for("all of them", || candump.published().len() == tally.published);
    let published = candump.published();
    let last = &published[published.len() - published_ids().len()..];
    assert!(is_told(last, Faults::ENDING) && last.iter().all(is_empty));
}

/// Sets the clock of the guest, which is nobody else's; elsewhere nothing is touched.
pub(super) fn set_clock(by_s: f64) -> bool {
    let is_guest =
        std::fs::read_to_string("/proc/cpuinfo").is_ok_and(|info| info.contains("User Mode Linux"));
    if !is_guest {
        println!("skipped: the clock is set in a guest only");
        return false;
    }
    let now = std::time::SystemTime::now().duration_since(std::time::UNIX_EPOCH).unwrap().as_secs_f64();
    run("date", &format!("-s @{:.6}", now + by_s))
}

/// GIVEN a clock that is set by anything from a twentieth of a second to an hour THEN rounds go on, and stay valid.
#[test]
fn a_clock_that_is_set() {
    let Some(interface) = Interface::new("gs_clock") else { return };
    let candump = Recorder::start(interface.0);
    let gripd = Gripd::start(&demo_car(), interface.0);
    let _car = Traffic::start(interface.0, frames(simulated_drive()));
    candump.wait_for_more(7 * 100, "publishing");
    for step in [-0.05, -0.5, -0.95, 0.5, 3.0, -3600.0, 3600.0] {
        let known = candump.published().len();
        let begun = Instant::now();
        // By a clock that is not set: how many rounds there are in a second, and the longest pause.
        let (mut longest, mut last, mut count) = (Duration::ZERO, begun, candump.published_count());
        let (mut set, mut looked, mut hiccup) = (false, Instant::now(), Duration::ZERO);
        while begun.elapsed() < Duration::from_millis(1500) {
            if !set && begun.elapsed() > Duration::from_millis(300) {
                if !set_clock(step) {
                    return;
                }
                set = true;
            }
            // The whole guest may stand still for a while, on a machine that is busy.
            hiccup = hiccup.max(looked.elapsed());
            looked = Instant::now();
            let now = candump.published_count();
            if now > count {
                longest = longest.max(last.elapsed());
                (last, count) = (Instant::now(), now);
            }
            std::thread::sleep(Duration::from_millis(2));
        }
        let after = since(&candump, known);
        let rounds = after.iter().filter(|frame| frame.id.number() == 0x6A0).count();
        println!(
            "set by {step} s: {rounds} rounds in 1.5 s, at most {longest:?} without one; {hiccup:?} without the guest"
        );
        assert!(!is_told(&after, Faults::TIME | Faults::TIMEOUT), "after {step} s");
        assert!(rounds >= 50 || hiccup > Duration::from_millis(100), "after {step} s");
        assert!(longest < Duration::from_millis(50) + 2 * hiccup, "after {step} s: {longest:?}");
    }
    gripd.end(SIGTERM);
}
