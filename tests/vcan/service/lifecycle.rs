//! Beginning and end: signals, what systemd is told, exit codes.

use std::process::Stdio;

use nix::fcntl::{FcntlArg, fcntl};

use super::*;

#[test]
fn it_ends_within_a_second_whatever_goes_on() {
    let Some(interface) = Interface::new("gs_end") else { return };
    for signal in [SIGINT, SIGTERM] {
        let idle = Gripd::start(&demo_car(), interface.0);
        assert_eq!(idle.end(signal).received, 0);

        let gripd = Gripd::start(&demo_car(), "gs_not_there");
        gripd.wait_for_log("does not exist");
        assert_eq!(gripd.end(signal).published, 0);

        interface.set("down");
        let gripd = Gripd::start(&demo_car(), interface.0);
        gripd.wait_for_log("is down");
        gripd.end(signal);
        interface.set("up");

        let candump = Recorder::start(interface.0);
        let gripd = Gripd::start(&demo_car(), interface.0);
        let _car = Traffic::start(interface.0, frames(simulated_drive()));
        candump.wait_for_more(12, "publishing");
        assert!(gripd.end(signal).published >= 12);
    }
}

#[test]
fn it_ends_within_a_second_on_a_flooded_bus() {
    let Some(interface) = Interface::new("gs_flood") else { return };
    let candump = Recorder::start(interface.0);
    let gripd = Gripd::start(&demo_car(), interface.0);
    let _flood = traffic::Flood::start(interface.0, frames(simulated_drive()));
    // On such a bus candump loses frames, too, and a busy guest falls behind: then rounds would be too late and are dropped.
    wait_for("rounds under the flood", || {
        candump.published_count() >= 17 || gripd.log().contains("it would have been too late")
    });
    gripd.end(SIGTERM);
}

#[test]
fn nobody_needs_to_read_its_log() {
    let Some(interface) = Interface::new("gs_nolog") else { return };
    let candump = Recorder::start(interface.0);
    let mut gripd = Command::new(gripd())
        .args(["run", "-vv", "-i", interface.0, "-c"])
        .arg(demo_car())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    drop(gripd.stderr.take());
    let _car = Traffic::start(interface.0, frames(simulated_drive()));
    candump.wait_for_more(60, "publishing without a log");
    assert_eq!(gripd.try_wait().unwrap(), None);
    process::send_signal(&gripd, SIGTERM);
    assert!(gripd.wait().unwrap().success());
}

/// GIVEN a log that fills a pipe which nobody empties THEN the loop goes on and is alive, and ends when it is to.
#[test]
#[ignore = "long: 23 s"]
fn a_reader_of_its_log_that_hangs_holds_up_nothing() {
    let Some(interface) = Interface::new("gs_stuck") else { return };
    let candump = Recorder::start(interface.0);
    let mut gripd = Command::new(gripd())
        .args(["run", "-v", "-i", interface.0, "-c"])
        .arg(demo_car())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    // Smaller than the first dozen lines of errors.
    let pipe = gripd.stderr.take().unwrap();
    fcntl(&pipe, FcntlArg::F_SETPIPE_SZ(4096)).unwrap();
    let _car = Traffic::start(interface.0, frames(simulated_drive()));
    candump.wait_for_more(60, "publishing");
    for _ in 0..100 {
        assert!(run("cansend", &format!("{} 20000088#0000000000000000", interface.0)));
    }
    candump.wait_for_more(300, "publishing with a log that is stuck");
    process::send_signal(&gripd, SIGTERM);
    let ended = Instant::now();
    assert!(gripd.wait().unwrap().success());
    assert!(ended.elapsed() < Duration::from_secs(1), "{:?}", ended.elapsed());
    let mut said = Vec::new();
    std::io::Read::read_to_end(&mut { pipe }, &mut said).unwrap();
    // No line fits any more.
    assert!(said.len() > 3800, "the pipe was not full: {} bytes", said.len());
}

#[test]
fn systemd_is_told_of_readiness_state_and_end() {
    let Some(interface) = Interface::new("gs_notify") else { return };
    let gripd = Gripd::start(&demo_car(), interface.0);
    gripd.wait_for_notification("STATUS=the input interface is up");
    interface.set("down");
    gripd.wait_for_notification("STATUS=waiting for the input interface");
    assert!(!gripd.was_told("WATCHDOG=1"), "nobody asked for it");
    gripd.signal(SIGTERM);
    gripd.wait_for_notification("STOPPING=1");
    let told = gripd.notifications();
    let (first, last) = (&told[0].1, &told[told.len() - 1].1);
    assert_eq!((first.as_str(), last.as_str()), ("READY=1", "STOPPING=1"));
}

#[test]
fn it_is_ready_though_the_interface_is_not_there() {
    if Interface::new("gs_ready").is_none() {
        return;
    }
    let gripd = Gripd::start(&demo_car(), "gs_absent");
    gripd.wait_for_notification("STATUS=waiting for the input interface");
    gripd.end(SIGTERM);
}

#[test]
fn the_watchdog_hears_of_it_twice_as_often_as_it_wants_to() {
    let Some(interface) = Interface::new("gs_dog") else { return };
    let period = Duration::from_millis(400);
    let gripd = Gripd::spawn(&demo_car(), interface.0, &[("WATCHDOG_USEC", "400000")]);
    // Busy, idle, without interface: the watchdog must not notice any of it.
    {
        let _car = Traffic::start(interface.0, frames(simulated_drive()));
        std::thread::sleep(2 * period);
    }
    std::thread::sleep(2 * period);
    interface.remove();
    std::thread::sleep(2 * period);
    let told = gripd.notifications();
    let beats: Vec<Instant> = told.iter().filter(|(_, t)| t == "WATCHDOG=1").map(|(when, _)| *when).collect();
    assert!((8..=13).contains(&beats.len()), "{} in {:?}", beats.len(), 6 * period);
    for pair in beats.windows(2) {
        assert!(pair[1] - pair[0] < period, "{:?} apart", pair[1] - pair[0]);
    }
    gripd.end(SIGTERM);
}

#[test]
fn what_cannot_work_ends_at_once_with_its_exit_code() {
    let Some(interface) = Interface::new("gs_exit") else { return };
    let code = |config: &Path, interface: &str| {
        let mut gripd = Gripd::spawn(config, interface, &[]);
        let code = gripd.ends().code();
        wait_for("its message", || gripd.log().contains("gripd: "));
        assert!(!gripd.was_told("READY=1"));
        (code, gripd.log())
    };
    let (status, log) = code(Path::new("no/such.toml"), interface.0);
    assert!(status == Some(2) && log.contains("no/such.toml"), "{status:?} {log}");
    let (status, log) = code(&demo_car(), "not a name");
    assert!(status == Some(2) && log.contains("not a name"), "{status:?} {log}");
    let (status, log) = code(&demo_car(), "lo");
    assert!(status == Some(1) && log.contains("lo is not a CAN interface"), "{status:?} {log}");
}
