//! What gripd does not listen to: itself, others of its kind, and what it does not need.

use super::traffic::play;
use super::*;

/// The demo drive's first two seconds, with its identifiers.
fn two_seconds() -> Vec<Frame> {
    let mut recording = frames(simulated_drive());
    let end = recording[0].time + Micros::from_millis(2_000);
    recording.retain(|frame| frame.time < end);
    recording
}

#[test]
fn it_takes_neither_its_own_frames_nor_those_of_a_second_one_for_input() {
    let Some(interface) = Interface::new("gs_two") else { return };
    let candump = Recorder::start(interface.0);
    let (first, second) = (Gripd::start(&demo_car(), interface.0), Gripd::start(&demo_car(), interface.0));
    let recording = two_seconds();
    play(interface.0, &recording);
    // And frames with its identifiers that nobody protected, as a broken gateway might loop them.
    let forged: Vec<Frame> = published_ids().iter().map(|id| data(id.number(), &[0xFF; 8])).collect();
    traffic::send_all(interface.0, &forged);
    wait_for("both to publish", || candump.published().len() > 2 * 300);
    std::thread::sleep(Duration::from_millis(200));
    let (first, second) = (first.end(SIGTERM), second.end(SIGTERM));
    assert_eq!((first.received, second.received), (recording.len(), recording.len()));
    wait_for("all of them", || {
        candump.published().len() == first.published + second.published + forged.len()
    });
    // Each tells of the other.
    assert!(first.foreign > 300 && second.foreign > 300, "{first:?} {second:?}");
    // What both publish does not depend on the other: each frame is there twice, with its counter.
    let of = |id: CanId| -> Vec<Vec<u8>> {
        let frames = candump.frames();
        let frames = traffic::until_silence(&frames);
        let own = frames.iter().filter(|f| f.id == id && f.data() != [0xFF; 8]);
        own.map(|f| f.data().to_vec()).collect()
    };
    let estimates = published_ids().into_iter().filter(|id| id.number() < 0x6A5);
    for id in estimates.filter(|_| first.late + second.late == 0) {
        let mut copies = std::collections::BTreeMap::new();
        for data in of(id) {
            *copies.entry(data).or_insert(0) += 1;
        }
        assert!(copies.values().all(|count| count % 2 == 0), "{id}");
    }
}

#[test]
fn the_kernel_keeps_what_is_not_needed_from_it() {
    let Some(interface) = Interface::new("gs_noise") else { return };
    let candump = Recorder::start(interface.0);
    let gripd = Gripd::start(&demo_car(), interface.0);
    let noise: Vec<Frame> = (0..5000).map(|n: u32| data(0x200 + n % 0x400, &n.to_be_bytes())).collect();
    let recording = two_seconds();
    traffic::send_all(interface.0, &noise);
    play(interface.0, &recording);
    traffic::send_all(interface.0, &noise);
    let is_noise = |frame: &Frame| (0x200..0x600).contains(&frame.id.number());
    wait_for("candump to have all of it", || {
        candump.frames().iter().filter(|f| is_noise(f)).count() == 10_000
    });
    let tally = gripd.end(SIGTERM);
    assert_eq!((tally.received, tally.dropped), (recording.len(), 0));
}
