//! SIGHUP on a real bus: what is read anew takes over, or what was there stays; no frame is lost either way.

use gripd::signals::e2e::next_counter;

use super::*;

/// The demo drive's first seconds.
fn recording(seconds: i64) -> Vec<Frame> {
    let mut recording = frames(simulated_drive());
    let end = recording[0].time + Micros::from_millis(1000 * seconds);
    recording.retain(|frame| frame.time < end);
    recording
}

/// Each message's counter counts on, whatever happened.
#[track_caller]
fn no_counter_jumps(published: &[Frame]) {
    for id in published_ids() {
        let counters = counters(published, id);
        assert!(counters.len() > 10, "{id}: {} frames", counters.len());
        for pair in counters.windows(2) {
            assert_eq!(pair[1], next_counter(pair[0]), "{id}");
        }
    }
}

/// Counts its frames in the log each second.
fn counts(text: String) -> String {
    text + "\n[service]\nreport_every_s = 1\n"
}

/// What was sent last may still wait in the kernel, and a service that is told to end reads no more.
fn wait_until_read(gripd: &Gripd, frames: usize) {
    gripd.wait_for_log(&format!("received={frames} "));
}

/// What is told to systemd of a reload, in order: the text before `=` or the whole line.
fn told(gripd: &Gripd) -> Vec<String> {
    let told = gripd.notifications().into_iter().map(|(_, line)| line);
    let told =
        told.filter(|line| ["RELOADING", "MONOTONIC_USEC", "READY"].iter().any(|s| line.starts_with(s)));
    told.map(|line| line.split_once('=').map_or(line.clone(), |(key, _)| key.to_owned())).collect()
}

#[test]
fn good_and_broken_configurations_while_frames_flow() {
    let Some(interface) = Interface::new("gs_hup") else { return };
    let car = edited_car(counts);
    let good = std::fs::read_to_string(car.path()).unwrap();
    let candump = Recorder::start(interface.0);
    let gripd = Gripd::start(car.path(), interface.0);
    gripd.wait_for_log("the input interface is up");
    let recording = recording(10);
    let (tally, published) = std::thread::scope(|scope| {
        let traffic = scope.spawn(|| traffic::play(interface.0, &recording));
        candump.wait_for_more(60, "publishing");
        gripd.signal(SIGHUP);
        gripd.wait_for_log("the new configuration is in use; the estimators go on");
        std::fs::write(car.path(), good.replace("mass_kg", "mass_pound")).unwrap();
        gripd.signal(SIGHUP);
        gripd.wait_for_log("the new configuration is refused");
        gripd.wait_for_notification(
            "STATUS=the new configuration is refused, see the log; the one before is in use",
        );
        candump.wait_for_more(60, "publishing in spite of it");
        let faults = |frame: &Frame| u16::from_le_bytes([frame.data()[5], frame.data()[6]]);
        let refused = |frame: &Frame| frame.id.number() == 0x6A5 && faults(frame) & 1 << 15 != 0;
        wait_for("the fault bit", || candump.published().last_chunk::<7>().unwrap().iter().any(refused));
        std::fs::write(car.path(), good.replace("valid_when = 1", "valid_when = 1, timeout_ms = 150"))
            .unwrap();
        gripd.signal(SIGHUP);
        gripd.wait_for_log("the estimators begin anew with what was learned");
        wait_for("no fault bit", || !candump.published().last_chunk::<7>().unwrap().iter().any(refused));
        traffic.join().unwrap();
        assert!(gripd.log().contains("`mass_pound`"), "{}", gripd.log());
        let words = ["READY", "RELOADING", "MONOTONIC_USEC", "READY", "RELOADING", "MONOTONIC_USEC", "READY"];
        assert_eq!(told(&gripd)[..7], words);
        wait_until_read(&gripd, recording.len());
        let tally = gripd.end(SIGTERM);
        wait_for("all of them", || candump.published().len() == tally.published);
        (tally, candump.published())
    });
    assert_eq!((tally.received, tally.dropped, tally.unsent), (recording.len(), 0, 0));
    if tally.late == 0 {
        no_counter_jumps(&published);
    }
}

#[test]
fn a_hundred_hangups_in_a_second() {
    let Some(interface) = Interface::new("gs_storm") else { return };
    let candump = Recorder::start(interface.0);
    let gripd = Gripd::start(&demo_car(), interface.0);
    gripd.wait_for_log("the input interface is up");
    let recording = recording(5);
    std::thread::scope(|scope| {
        let traffic = scope.spawn(|| traffic::play(interface.0, &recording));
        candump.wait_for_more(60, "publishing");
        for _ in 0..100 {
            gripd.signal(SIGHUP);
            std::thread::sleep(Duration::from_millis(10));
        }
        traffic.join().unwrap();
    });
    wait_for("the last of them", || gripd.log().matches("is in use; the estimators go on").count() >= 2);
    std::thread::sleep(Duration::from_millis(1500));
    let reloads = gripd.log().matches("is in use; the estimators go on").count();
    assert!((2..=6).contains(&reloads), "{reloads} reloads");
    let published = candump.published();
    let tally = gripd.end(SIGTERM);
    assert_eq!((tally.received, tally.dropped, tally.unsent), (recording.len(), 0, 0));
    if tally.late == 0 {
        no_counter_jumps(&published);
    }
}

/// The kernel's filters follow the mapping, in both directions, on the open socket.
#[test]
fn other_signals_are_let_through() {
    let Some(interface) = Interface::new("gs_filter") else { return };
    let without_drive = |text: String| {
        let lines = text.lines().filter(|line| !line.contains("= \"DRIVE."));
        lines.map(|line| format!("{line}\n")).collect::<String>()
    };
    let car = edited_car(|text| counts(without_drive(text)));
    let gripd = Gripd::start(car.path(), interface.0);
    gripd.wait_for_log("the input interface is up");
    let drive = data(0x1D0, &[0; 6]);
    let wheels = data(0x1A0, &[0; 8]);
    let five = |frame: Frame| traffic::send_all(interface.0, &[frame; 5]);
    five(drive);
    five(wheels);
    let whole = edited_car(counts);
    std::fs::copy(whole.path(), car.path()).unwrap();
    gripd.signal(SIGHUP);
    gripd.wait_for_log("identifiers=4");
    five(drive);
    five(wheels);
    std::fs::write(car.path(), without_drive(std::fs::read_to_string(whole.path()).unwrap())).unwrap();
    gripd.signal(SIGHUP);
    wait_for("the third", || gripd.log().matches("the new configuration is in use").count() == 2);
    five(drive);
    five(wheels);
    wait_until_read(&gripd, 4 * 5);
    assert_eq!(gripd.end(SIGTERM).received, 4 * 5);
}

#[test]
fn another_interface_takes_a_restart() {
    let (Some(one), Some(_other)) = (Interface::new("gs_one"), Interface::new("gs_other")) else { return };
    let car = edited_car(|text| text.replace("interface = \"vcan0\"", "interface = \"gs_one\""));
    let text = std::fs::read_to_string(car.path()).unwrap();
    let gripd = Gripd::start(car.path(), one.0);
    let other = counts(text.replace("gs_one", "gs_other")) + "record_files = 7\n";
    std::fs::write(car.path(), other).unwrap();
    gripd.signal(SIGHUP);
    gripd.wait_for_log("bus.interface has changed: it is opened at the start only");
    gripd.wait_for_log("service.record_faults, record_files or record_bytes has changed");
    gripd.wait_for_log("the new configuration is in use");
    traffic::send_all(one.0, &[data(0x1A0, &[0; 8])]);
    wait_until_read(&gripd, 1);
    assert_eq!(gripd.end(SIGTERM).received, 1);
}
