//! Recordings that are played.

use std::time::{Duration, Instant};

use gripd::watch::{Pace, Playback, Source};

use super::*;

fn runtime() -> tokio::runtime::Runtime {
    tokio::runtime::Builder::new_current_thread().enable_all().build().unwrap()
}

fn open(pace: Pace) -> Source {
    Source::Recording(Box::new(Playback::open(drive().join("drive.log"), pace).unwrap()))
}

#[test]
fn every_frame_comes_in_order_and_in_its_time() {
    let expected = frames("drive.log");
    for (pace, least) in [(Pace::AtOnce, 0.0), (Pace::Times(60.0), 0.45)] {
        runtime().block_on(async {
            let begun = Instant::now();
            let mut source = open(pace);
            assert_eq!(source.now(), None);
            for frame in &expected {
                assert_eq!(source.next().await, Happening::Frame(*frame));
                assert_eq!(source.now(), Some(frame.time));
            }
            assert_eq!(source.next().await, Happening::Over);
            assert_eq!(source.now(), Some(expected.last().unwrap().time));
            assert!(begun.elapsed() >= Duration::from_secs_f64(least), "{:?}", begun.elapsed());
        });
    }
}

#[test]
fn what_is_paused_stands_still_and_goes_on() {
    runtime().block_on(async {
        let mut source = open(Pace::Times(1.0));
        let first = source.next().await;
        let Source::Recording(playback) = &mut source else { panic!() };
        playback.pause(true);
        let shown = playback.now();
        let patience = Duration::from_millis(100);
        assert!(tokio::time::timeout(patience, source.next()).await.is_err(), "it plays on");
        let Source::Recording(playback) = &mut source else { panic!() };
        assert_eq!(playback.now(), shown);
        playback.pause(false);
        let Happening::Frame(first) = first else { panic!("{first:?}") };
        while let Happening::Frame(frame) = source.next().await {
            if frame.time > first.time {
                return;
            }
        }
        panic!("nothing came after the pause");
    });
}

#[test]
fn between_two_frames_time_goes_on_but_never_beyond_the_next() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("gap.log");
    std::fs::write(&path, "(10.000000) vcan0 1B0#00\n(10.300000) vcan0 1B0#00\n").unwrap();
    runtime().block_on(async {
        let mut source = Source::Recording(Box::new(Playback::open(path, Pace::Times(1.0)).unwrap()));
        assert!(matches!(source.next().await, Happening::Frame(_)));
        let mut seen = Vec::new();
        loop {
            let waited = tokio::time::timeout(Duration::from_millis(20), source.next()).await;
            let now = source.now().unwrap();
            seen.push(now);
            if waited.is_ok() {
                break;
            }
            assert!(now <= Micros(10_300_000), "{now}");
        }
        assert!(seen.is_sorted() && seen.len() > 3, "{seen:?}");
        assert_eq!(seen.last(), Some(&Micros(10_300_000)));
    });
}

#[test]
fn what_is_no_recording_is_said() {
    let folder = tempfile::tempdir().unwrap();
    assert!(Playback::open(folder.path().join("none.log"), Pace::AtOnce).is_err());
    let path = folder.path().join("words.log");
    std::fs::write(&path, "no frame\nin here\n").unwrap();
    runtime().block_on(async {
        let mut source = Source::Recording(Box::new(Playback::open(path, Pace::AtOnce).unwrap()));
        let Happening::Failed(reason) = source.next().await else { panic!() };
        assert!(reason.contains("words.log"), "{reason}");
    });
}
