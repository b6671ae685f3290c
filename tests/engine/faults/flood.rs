//! Too many frames.

use std::time::{Duration, Instant};

use gripd::Faults;
use gripd::can::{Bus, Frame, memory_pair};
use gripd::service::{Service, serve};
use testing::demo_car as car;
use testing::fault::UNTIL;
use testing::heard::{self, Heard};

/// GIVEN 10⁵ frames a second for two seconds, from another thread, WHEN the queue is short THEN what does not fit is
/// dropped, oldest first, and counted to the last frame; AND the service is as before afterwards.
#[test]
fn a_flood_is_counted() {
    const RATE: usize = 100_000;
    let (mut sender, link) = memory_pair(64);
    let drive = car::drive();
    let (before, after) = (&drive[..3000], &drive[3000..6000]);
    let flood: Vec<Frame> = (0..2 * RATE).map(|n| before[before.len() - 1 - n % 4]).collect();
    let (done, over) = tokio::sync::oneshot::channel();
    let traffic = std::thread::spawn(move || {
        let begun = Instant::now();
        for frame in before {
            sender.try_send(frame).unwrap();
            std::thread::sleep(Duration::from_micros(20));
        }
        for (number, frame) in flood.iter().enumerate() {
            sender.try_send(frame).unwrap();
            if number % 1000 == 0 {
                let due = Duration::from_secs_f64(number as f64 / RATE as f64);
                std::thread::sleep(due.saturating_sub(begun.elapsed()));
            }
        }
        for frame in after {
            sender.try_send(frame).unwrap();
            std::thread::sleep(Duration::from_micros(50));
        }
        std::thread::sleep(Duration::from_millis(100));
        done.send(()).unwrap();
        drop(sender);
    });
    let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build().unwrap();
    let mut heard = Heard::default();
    let service = Service::new(car::engine(&car::config()), Bus::from(link));
    let ended = async { over.await.unwrap() };
    let tally = runtime.block_on(serve(service, &mut heard, ended));
    traffic.join().unwrap();
    let sent = before.len() + 2 * RATE + after.len();
    assert_eq!(tally.received + tally.dropped, sent as u64, "{tally:?}");
    heard::protected(&heard.frames);
    assert!(tally.dropped > 100_000, "a thousand at once do not fit: {tally:?}");
    assert!(heard::faults(&heard.frames).iter().any(|faults| faults.contains(Faults::DROPPED)));
    assert!(heard.samples.last().unwrap().time.seconds() < UNTIL + 10.0);
}
