//! Frames at the wrong time, and too many of them.

use std::time::{Duration, Instant};

use gripd::can::{Bus, Frame, memory_pair};
use gripd::service::{Service, serve};
use gripd::{Faults, Micros};

use super::car;
use super::case::{self, Case, FROM, Fault, UNTIL, meanwhile};
use super::heard::{self, Heard};

fn at(frame: &Frame, time: Micros) -> Frame {
    let mut moved = *frame;
    moved.time = time;
    moved
}

#[test]
fn faults_of_timing() {
    let cases = [
        Case {
            name: "frames out of order by up to 15 ms",
            fault: Fault::Frames(|mut frames| {
                for pair in frames.chunks_mut(5).filter(|some| meanwhile(some[0].time)) {
                    pair.reverse();
                }
                frames
            }),
            told: Faults::COUNTER | Faults::TIME,
            ..Case::PLAIN
        },
        Case {
            name: "silence for five seconds",
            fault: Fault::Frames(|mut frames| {
                frames.retain(|frame| !meanwhile(frame.time));
                frames
            }),
            told: Faults::TIME | Faults::TIMEOUT,
            within: (5.1, 0.3),
            ..Case::PLAIN
        },
        Case {
            name: "bursts: a gateway that hands on every 100 ms",
            fault: Fault::Frames(|frames| {
                let hundred = Micros::from_millis(100);
                let late =
                    |f: &Frame| if meanwhile(f.time) { at(f, f.time.next_multiple_of(hundred)) } else { *f };
                let mut frames: Vec<Frame> = frames.iter().map(late).collect();
                frames.sort_by_key(|frame| frame.time);
                frames
            }),
            within: (0.0, 0.2),
            ..Case::PLAIN
        },
        Case {
            name: "a clock that is set back by three seconds",
            fault: Fault::Frames(|frames| {
                let back = |f: &Frame| {
                    if f.time.seconds() >= FROM { at(f, f.time - Micros::from_millis(3000)) } else { *f }
                };
                frames.iter().map(back).collect()
            }),
            told: Faults::TIME,
            until: FROM,
            ..Case::PLAIN
        },
        Case {
            name: "a message at a fifth of its rate",
            fault: Fault::Frames(|frames| {
                let kept =
                    |f: &Frame| f.id.number() != 0x1C0 || !meanwhile(f.time) || f.time.0 / 10_000 % 5 == 0;
                frames.into_iter().filter(kept).collect()
            }),
            within: (0.0, 0.1),
            ..Case::PLAIN
        },
    ];
    case::check(&car::config(), car::readings(), &cases);
}

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
