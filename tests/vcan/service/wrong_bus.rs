//! GIVEN interfaces that change their names while the service runs THEN it goes with the name, and sends not one frame
//! on a bus that is not the one it was told.

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex};
use std::thread::JoinHandle;

use socketcan::{CanSocket, EmbeddedFrame, Id, Socket};

use super::*;
use testing::vcan::must;

/// Hears what is published on one interface, whatever it is called.
pub(super) struct Ear {
    heard: Arc<Mutex<Vec<Instant>>>,
    stop: Arc<AtomicBool>,
    thread: Option<JoinHandle<()>>,
}

impl Ear {
    pub(super) fn at(interface: &Interface) -> Self {
        let socket = CanSocket::open_iface(interface.index()).unwrap();
        socket.set_read_timeout(Duration::from_millis(50)).unwrap();
        let (heard, stop) = (Arc::new(Mutex::new(Vec::new())), Arc::new(AtomicBool::new(false)));
        let (hears, stopped) = (Arc::clone(&heard), Arc::clone(&stop));
        let ids: Vec<u32> = published_ids().iter().map(|id| id.number()).collect();
        let thread = std::thread::spawn(move || {
            while !stopped.load(Ordering::Relaxed) {
                // A timeout, or a link that is down just now.
                let Ok(frame) = socket.read_frame() else { continue };
                if let Id::Standard(id) = frame.id()
                    && ids.contains(&u32::from(id.as_raw()))
                {
                    hears.lock().unwrap().push(Instant::now());
                }
            }
        });
        Self { heard, stop, thread: Some(thread) }
    }

    fn count(&self) -> usize {
        self.heard.lock().unwrap().len()
    }

    /// What it has heard since it was asked last.
    pub(super) fn take(&self) -> usize {
        std::mem::take(&mut *self.heard.lock().unwrap()).len()
    }

    /// The first so many are none to be asked for.
    pub(super) fn forget(&self, count: usize) {
        self.heard.lock().unwrap().drain(..count);
    }

    #[track_caller]
    fn wait_for_more(&self, count: usize, when: &str) {
        let before = self.count();
        wait_for(when, || self.count() >= before + count);
    }
}

impl Drop for Ear {
    fn drop(&mut self) {
        self.stop.store(true, Ordering::Relaxed);
        let _ = self.thread.take().map(JoinHandle::join);
    }
}

fn link(what: &str) {
    must("ip", &format!("link {what}"));
}

/// Until it has heard what was sent before.
fn settle() {
    std::thread::sleep(Duration::from_millis(200));
}

/// Both down, their names exchanged, both up: what two adapters do that are found in another order. Gives how much
/// `ear` had heard before the names changed.
pub(super) fn swap(one: &str, other: &str, ear: &Ear) -> usize {
    link(&format!("set {one} down"));
    link(&format!("set {other} down"));
    settle();
    let heard = ear.count();
    for step in [
        format!("set {one} name gs_between"),
        format!("set {other} name {one}"),
        format!("set gs_between name {other}"),
        format!("set {one} up"),
        format!("set {other} up"),
    ] {
        link(&step);
    }
    heard
}

#[test]
fn two_interfaces_that_swap_names_while_all_send() {
    let (Some(named), Some(other)) = (Interface::new("gs_wb0"), Interface::new("gs_wb1")) else { return };
    let mut ears = [Ear::at(&named), Ear::at(&other)];
    let gripd = Gripd::start(&demo_car(), named.0);
    let _cars = [named.0, other.0].map(|name| Traffic::start(name, frames(simulated_drive())));
    ears[0].wait_for_more(60, "publishing");
    assert_eq!(ears[1].count(), 0);
    for round in 0..3 {
        let before = ears[0].count();
        let since = swap(named.0, other.0, &ears[0]);
        ears[1].wait_for_more(350, "publishing on the interface that has the name now");
        let wrong = ears[0].count() - since;
        println!("swap {round}: {wrong} frames on the wrong bus, {before} before it on the right one");
        assert_eq!(wrong, 0);
        ears.reverse();
    }
    let log = gripd.log();
    assert!(log.contains("the input interface does not exist"), "it was gone for a while:\n{log}");
    gripd.end(SIGTERM);
}

#[test]
fn a_link_renamed_away_and_a_new_one_in_its_place() {
    let Some(old) = Interface::new("gs_wb2") else { return };
    let at_old = Ear::at(&old);
    let gripd = Gripd::start(&demo_car(), old.0);
    let _car = Traffic::start(old.0, frames(simulated_drive()));
    at_old.wait_for_more(60, "publishing");
    link("set gs_wb2 down");
    settle();
    let before = at_old.count();
    link("set gs_wb2 name gs_wb3");
    let away = Interface("gs_wb3");
    away.set("up");
    // There is none of that name: nothing is sent anywhere.
    std::thread::sleep(Duration::from_millis(500));
    assert_eq!(at_old.count(), before, "frames on an interface with another name");
    gripd.wait_for_log("the input interface does not exist");
    assert!(Interface::create(old.0));
    let at_new = Ear::at(&old);
    at_new.wait_for_more(350, "publishing on the new one");
    assert_eq!(at_old.count(), before);
    gripd.end(SIGTERM);
}

#[test]
fn an_output_of_its_own_that_is_renamed() {
    let (Some(car), Some(output)) = (Interface::new("gs_wb4"), Interface::new("gs_wb5")) else { return };
    let Some(other) = Interface::new("gs_wb6") else { return };
    let config = edited_car(|text| format!("{text}\n[publish]\ninterface = \"gs_wb5\"\n"));
    let (right, wrong) = (Ear::at(&output), Ear::at(&other));
    let gripd = Gripd::start(config.path(), car.0);
    let _car = Traffic::start(car.0, frames(simulated_drive()));
    right.wait_for_more(60, "publishing");
    assert_eq!(wrong.count(), 0);
    let before = swap(output.0, other.0, &right);
    wrong.wait_for_more(350, "publishing on the interface that has the name now");
    assert_eq!(right.count(), before, "frames on an interface with another name");
    gripd.wait_for_log("the output interface does not exist");
    gripd.end(SIGTERM);
}
