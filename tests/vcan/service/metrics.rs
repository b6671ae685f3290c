//! Counts for whoever watches, while frames flow.

use std::io::{Read, Write};
use std::os::unix::net::UnixStream;

use super::*;

/// The answer to a scrape.
fn scrape(socket: &Path) -> String {
    let mut stream = UnixStream::connect(socket).unwrap();
    stream.write_all(b"GET /metrics HTTP/1.1\r\nHost: gripd\r\n\r\n").unwrap();
    let mut answer = String::new();
    stream.read_to_string(&mut answer).unwrap();
    answer
}

fn value(answer: &str, name: &str) -> usize {
    let line = answer.lines().find(|line| line.split(' ').next() == Some(name));
    line.unwrap_or_else(|| panic!("no {name} in {answer}")).rsplit(' ').next().unwrap().parse().unwrap()
}

/// GIVEN readers that ask all the time, and some that never do, THEN they hear what is counted, and no frame is lost.
#[test]
fn what_is_counted_can_be_read_and_disturbs_nobody() {
    let Some(interface) = Interface::new("gs_metric") else { return };
    // In memory: in the guest, not every file system can hold a socket.
    let folder = tempfile::tempdir_in("/dev/shm").unwrap();
    let socket = folder.path().join("metrics");
    let car = edited_car(|text| format!("{text}\n[service]\nmetrics = \"{}\"\n", socket.display()));
    let gripd = Gripd::start(car.path(), interface.0);
    gripd.wait_for_log("metrics at");
    let mut recording = frames(simulated_drive());
    let end = recording[0].time + Micros::from_millis(5_000);
    recording.retain(|frame| frame.time < end);
    let silent: Vec<UnixStream> = (0..3).map(|_| UnixStream::connect(&socket).unwrap()).collect();
    std::thread::scope(|scope| {
        let traffic = scope.spawn(|| traffic::play(interface.0, &recording));
        while !traffic.is_finished() {
            assert!(scrape(&socket).starts_with("HTTP/1.1 200 OK"));
        }
    });
    drop(silent);
    wait_for("all frames", || value(&scrape(&socket), "gripd_frames_received_total") == recording.len());
    interface.set("down");
    wait_for("word of the link", || value(&scrape(&socket), "gripd_input_up") == 0);
    gripd.signal(SIGHUP);
    wait_for("word of the reload", || value(&scrape(&socket), "gripd_reloads_accepted_total") == 1);
    let answer = scrape(&socket);
    assert!(answer.contains("gripd_state{state=\"running\"} 1"), "{answer}");
    let tally = gripd.end(SIGTERM);
    assert_eq!((tally.received, tally.dropped, tally.unsent), (recording.len(), 0, 0));
    assert_eq!(value(&answer, "gripd_frames_published_total"), tally.published);
    assert!(!socket.exists());
}
