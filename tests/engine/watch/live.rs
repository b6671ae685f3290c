//! A bus that is listened to.

use gripd::can::memory_pair;
use gripd::watch::{Link, Listener, Source};

use super::*;

fn runtime() -> tokio::runtime::Runtime {
    tokio::runtime::Builder::new_current_thread().enable_all().build().unwrap()
}

#[test]
fn a_bus_is_heard_and_nothing_is_sent_on_it() {
    let inputs = frames("drive.log");
    let (mut car, ours) = memory_pair(1024);
    let mut source = Source::Live(Listener::of(ours.into()));
    let mut watch = Watch::new(&demo_car(), Estimator::Own).unwrap();
    runtime().block_on(async {
        assert_eq!(source.next().await, Happening::Link(Link::Up));
        watch.take(&Happening::Link(Link::Up), None);
        assert_eq!(car.recv().await, gripd::can::Event::Up);
        for frame in inputs.iter().take(5000) {
            car.try_send(frame).unwrap();
            let happening = source.next().await;
            assert_eq!(happening, Happening::Frame(*frame));
            watch.take(&happening, Some(frame.time));
        }
        assert_eq!(watch.round().state, Some(State::Running));
        assert!(watch.counts().frames_out > 1000, "its own engine publishes, but only to itself");
        let heard = tokio::time::timeout(std::time::Duration::from_millis(50), car.recv()).await;
        assert!(heard.is_err(), "something was sent: {heard:?}");
        drop(car);
        assert_eq!(source.next().await, Happening::Link(Link::Gone));
        watch.take(&Happening::Link(Link::Gone), None);
        assert_eq!(watch.link(), Some(Link::Gone));
        assert!(watch.faults().contains(Faults::BUS_DOWN));
    });
    assert!(source.now().unwrap() > Micros::from_seconds(1.7e9), "live it is the wall clock");
}

#[test]
fn interfaces_that_cannot_be_are_refused() {
    let _guard = runtime();
    let error = Listener::open(&demo_car(), Some("a/b"), &[]).err().unwrap();
    assert!(error.to_string().contains("a/b"), "{error}");
}
