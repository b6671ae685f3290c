//! `gripd view` on a live bus. (What it answers and refuses, and the page itself: `tests/commands/view`.)

use std::io::{BufRead, BufReader, Write};
use std::net::TcpStream;
use std::process::{Child, Stdio};

use super::*;

/// The server, killed when dropped, and what it tells.
struct View {
    process: Child,
    events: BufReader<TcpStream>,
}

impl View {
    fn start(interface: &str) -> Self {
        let mut command = Command::new(gripd());
        command.args(["-q", "view", "-i", interface, "--listen", "127.0.0.1:0", "-c"]).arg(demo_car());
        let mut process = command.stdout(Stdio::piped()).spawn().unwrap();
        let mut line = String::new();
        BufReader::new(process.stdout.take().unwrap()).read_line(&mut line).unwrap();
        let address = line.trim().strip_prefix("http://").unwrap().trim_end_matches('/').to_owned();
        let mut stream = TcpStream::connect(&address).unwrap();
        stream.set_read_timeout(Some(PATIENCE)).unwrap();
        write!(stream, "GET /events HTTP/1.1\r\nHost: {address}\r\n\r\n").unwrap();
        Self { process, events: BufReader::new(stream) }
    }

    /// Reads on until it tells this.
    #[track_caller]
    fn wait_for(&mut self, what: &str, holds: impl Fn(&serde_json::Value) -> bool) {
        let begun = Instant::now();
        loop {
            assert!(begun.elapsed() < PATIENCE, "waited in vain: {what}");
            let mut line = String::new();
            assert!(self.events.read_line(&mut line).unwrap() > 0, "the stream ended");
            let Some(data) = line.strip_prefix("data: ") else { continue };
            let told: serde_json::Value = serde_json::from_str(data).unwrap();
            if holds(&told["now"]) {
                return;
            }
        }
    }
}

impl Drop for View {
    fn drop(&mut self) {
        let _ = self.process.kill();
        let _ = self.process.wait();
    }
}

/// GIVEN a bus with a car WHEN a gripd on it comes and goes THEN the page is told so with its numbers, and nothing is sent.
#[test]
fn a_page_follows_a_live_bus_and_sends_nothing() {
    let Some(interface) = Interface::new("gs_view") else { return };
    let recorder = Recorder::start(interface.0);
    let mut view = View::start(interface.0);
    let traffic = Traffic::start(interface.0, frames(simulated_drive()));
    let tells = |words: &'static str| {
        move |now: &serde_json::Value| now["told"].as_str().is_some_and(|told| told.contains(words))
    };
    view.wait_for("that no gripd is there", tells("No gripd publishes on this bus"));
    let gripd = Gripd::start(&demo_car(), interface.0);
    view.wait_for("its estimates", |now| {
        tells("as a gripd on this bus publishes them")(now)
            && now["estimates"]["speed"].as_f64().is_some_and(|speed| speed > 1.0)
            && now["messages"].as_array().is_some_and(|messages| messages.len() == 7)
            && now["warn"] == false
    });
    let tally = gripd.end(SIGTERM);
    view.wait_for("that it is gone", tells("fallen silent"));
    drop(traffic);
    interface.set("down");
    view.wait_for("that the bus is down", tells("The interface is down"));
    let of_the_car = |frame: &Frame| (0x1A0..=0x1D0).contains(&frame.id.number());
    let all = recorder.frames();
    assert_eq!(all.iter().filter(|frame| is_published(frame)).count(), tally.published);
    assert!(all.iter().all(|frame| is_published(frame) || of_the_car(frame) || frame.id.number() == 0x7FF));
}
