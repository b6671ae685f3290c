//! The process itself: a loop that hangs.

use std::os::unix::net::UnixDatagram;
use std::process::Command;
use std::time::{Duration, Instant};

use gripd::can::{Bus, Frame, memory_pair};
use gripd::service::{Service, Sink, serve};
use testing::demo_car as car;

/// How long the loop hangs in [`child::hanging_service`], and how often systemd wants a sign of life.
const HANG: Duration = Duration::from_millis(1500);
const PERIOD: Duration = Duration::from_millis(200);

/// GIVEN the loop hangs while it handles a frame THEN there is no sign of life meanwhile, and there was before and is
/// afterwards: it is the estimation that feeds the watchdog, not a timer beside it.
#[test]
fn the_watchdog_hears_nothing_while_the_loop_hangs() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("notify");
    let socket = UnixDatagram::bind(&path).unwrap();
    let mut child = Command::new(std::env::current_exe().unwrap())
        .args(["--ignored", "--exact", "faults::process::child::hanging_service"])
        .env("NOTIFY_SOCKET", &path)
        .env("WATCHDOG_USEC", PERIOD.as_micros().to_string())
        .env_remove("WATCHDOG_PID")
        .stdout(std::process::Stdio::null())
        .spawn()
        .unwrap();
    let mut beats = Vec::new();
    let mut buffer = [0; 256];
    loop {
        let length = socket.recv(&mut buffer).unwrap();
        match &buffer[..length] {
            b"WATCHDOG=1\n" => beats.push(Instant::now()),
            b"STOPPING=1\n" => break,
            _ => {}
        }
    }
    assert!(child.wait().unwrap().success());
    let pauses: Vec<Duration> = beats.windows(2).map(|pair| pair[1] - pair[0]).collect();
    let place = pauses
        .iter()
        .position(|pause| *pause > HANG - PERIOD)
        .unwrap_or_else(|| panic!("no long pause: {pauses:?}"));
    assert!(place >= 2 && place + 2 < pauses.len(), "{pauses:?}");
    assert!(pauses.iter().filter(|pause| **pause > 2 * PERIOD).count() == 1, "{pauses:?}");
}

/// Takes very long over one frame.
struct Hangs {
    left: u32,
}

impl Sink for Hangs {
    fn publish(&mut self, _: &Frame) {
        self.left = self.left.saturating_sub(1);
        if self.left == 1 {
            std::thread::sleep(HANG);
        }
    }
}

/// What tests start, in a process of its own.
mod child {
    use super::*;

    #[test]
    #[ignore = "child: started by the test above"]
    fn hanging_service() {
        let (mut sender, link) = memory_pair(64);
        let traffic = std::thread::spawn(move || {
            for frame in &car::drive()[..6000] {
                sender.try_send(frame).unwrap();
                std::thread::sleep(Duration::from_millis(1));
            }
        });
        let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build().unwrap();
        let over = async {
            while !traffic.is_finished() {
                tokio::time::sleep(Duration::from_millis(50)).await;
            }
        };
        let service = Service::new(car::engine(&car::config()), Bus::from(link));
        // After a second or so of traffic.
        let tally = runtime.block_on(serve(service, &mut Hangs { left: 400 }, over));
        assert!(tally.published > 300, "{tally:?}");
    }
}
