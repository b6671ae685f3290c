//! Interfaces that are not there yet, go down, vanish and come back while the service runs.

use super::*;

/// The demo car's configuration, publishing on another interface.
fn publishing_on(output: &str) -> tempfile::NamedTempFile {
    edited_car(|text| format!("{text}\n[publish]\ninterface = \"{output}\"\n"))
}

#[test]
fn an_interface_that_comes_later() {
    if Interface::new("gs_late0").is_none() {
        return;
    }
    let gripd = Gripd::start(&demo_car(), "gs_late");
    gripd.wait_for_log("does not exist");
    let Some(interface) = Interface::new("gs_late") else { return };
    let candump = Recorder::start(interface.0);
    let _car = Traffic::start(interface.0, frames(simulated_drive()));
    candump.wait_for_more(60, "publishing once the interface is there");
    gripd.wait_for_log("the input interface is up");
    gripd.end(SIGTERM);
}

#[test]
fn down_and_up_while_frames_flow() {
    let Some(interface) = Interface::new("gs_updown") else { return };
    let candump = Recorder::start(interface.0);
    let gripd = Gripd::start(&demo_car(), interface.0);
    let _car = Traffic::start(interface.0, frames(simulated_drive()));
    for round in 0..3 {
        candump.wait_for_more(30, &format!("publishing in round {round}"));
        interface.set("down");
        std::thread::sleep(Duration::from_millis(400));
        interface.set("up");
    }
    candump.wait_for_more(30, "publishing after the last time");
    gripd.wait_for_log("the input interface is down");
    gripd.end(SIGTERM);
}

#[test]
fn removed_and_made_again_while_frames_flow() {
    let Some(interface) = Interface::new("gs_again") else { return };
    let gripd = Gripd::start(&demo_car(), interface.0);
    let _car = Traffic::start(interface.0, frames(simulated_drive()));
    for round in 0..3 {
        let candump = Recorder::start(interface.0);
        candump.wait_for_more(30, &format!("publishing in round {round}"));
        drop(candump);
        interface.remove();
        std::thread::sleep(Duration::from_millis(200));
        assert!(Interface::create(interface.0));
    }
    let candump = Recorder::start(interface.0);
    candump.wait_for_more(30, "publishing after the last time");
    // The gap is told: the status says that the bus was down, then no more.
    let log = gripd.log();
    assert_eq!(log.matches("the input interface does not exist").count(), 3, "{log}");
    gripd.end(SIGTERM);
}

#[test]
fn what_is_published_can_go_onto_another_bus() {
    let (Some(car), Some(other)) = (Interface::new("gs_in"), Interface::new("gs_out")) else { return };
    let config = publishing_on(other.0);
    let (on_the_cars, on_the_other) = (Recorder::start(car.0), Recorder::start(other.0));
    let gripd = Gripd::start(config.path(), car.0);
    let traffic = Traffic::start(car.0, frames(simulated_drive()));
    on_the_other.wait_for_more(60, "publishing on the other");
    drop(traffic);
    let tally = gripd.end(SIGTERM);
    assert_eq!(on_the_cars.published().len(), 0);
    wait_for("all of them", || on_the_other.published().len() == tally.published);
    let frames = on_the_other.frames();
    assert!(frames.iter().all(|frame| is_published(frame) || frame.id.number() == 0x7FF));
}

/// The output waits for its interface beside an input that is never silent.
#[test]
fn the_output_alone_comes_later_and_comes_back() {
    let Some(car) = Interface::new("gs_busy") else { return };
    let config = publishing_on("gs_lateout");
    let gripd = Gripd::start(config.path(), car.0);
    let _traffic = Traffic::start(car.0, frames(simulated_drive()));
    gripd.wait_for_log("the output interface does not exist");
    gripd.wait_for_log("a frame was not sent");
    let Some(output) = Interface::new("gs_lateout") else { return };
    let candump = Recorder::start(output.0);
    candump.wait_for_more(60, "publishing once the output is there");
    output.set("down");
    gripd.wait_for_log("the output interface is down");
    output.set("up");
    candump.wait_for_more(60, "publishing once the output is up again");
    drop(candump);
    output.remove();
    std::thread::sleep(Duration::from_millis(500));
    assert!(Interface::create(output.0));
    let candump = Recorder::start(output.0);
    candump.wait_for_more(60, "publishing once the output is made again");
    // Hundreds were not sent; that is not told hundreds of times.
    let complaints = gripd.log().matches("a frame was not sent").count();
    let tally = gripd.end(SIGTERM);
    assert!(tally.unsent > 100 && complaints < 10, "{complaints} complaints, {tally:?}");
}

#[test]
fn a_bus_that_is_too_slow_for_it_costs_frames_and_nothing_else() {
    let (Some(car), Some(slow)) = (Interface::new("gs_fast"), Interface::new("gs_slow")) else { return };
    let config = publishing_on(slow.0);
    let candump = Recorder::start(slow.0);
    if !run("tc", &format!("qdisc replace dev {} root tbf rate 8kbit burst 100 limit 300", slow.0)) {
        return println!("skipped: no tc, or a kernel without its token bucket filter");
    }
    let mut gripd = Gripd::start(config.path(), car.0);
    let traffic = Traffic::start(car.0, frames(simulated_drive()));
    gripd.wait_for_log("the send queue is full");
    std::thread::sleep(Duration::from_secs(1));
    assert!(gripd.is_running());
    assert!(run("tc", &format!("qdisc del dev {} root", slow.0)));
    candump.wait_for_more(300, "publishing once there is room");
    drop(traffic);
    let tally = gripd.end(SIGTERM);
    assert!(tally.unsent > 100 && tally.published >= 300, "{tally:?}");
    assert_eq!((tally.published + tally.unsent) % published_ids().len(), 0, "whole rounds");
}
