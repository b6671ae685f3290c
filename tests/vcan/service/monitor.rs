//! Watching a bus on which gripd runs.

use gripd::signals::e2e::next_counter;

use super::*;

/// How often a published message's counter did not count on from the one before.
fn counter_jumps(recorded: &[Frame], id: CanId) -> usize {
    counters(recorded, id).windows(2).filter(|pair| pair[1] != next_counter(pair[0])).count()
}

/// `gripd monitor --once`: its exit code, and what it printed.
fn monitor(interface: &str, arguments: &[&str]) -> (Option<i32>, String) {
    let mut command = Command::new(gripd());
    let car = demo_car();
    command.args(["-q", "monitor", "-i", interface, "-c"]).arg(car).args(arguments);
    let output = command.output().unwrap();
    (output.status.code(), String::from_utf8(output.stdout).unwrap())
}

/// GIVEN a configuration that names what the service learned WHEN the estimators run here THEN they go on from it, and the
/// file stays as it is.
#[test]
fn what_was_learned_is_taken_up_and_left_alone() {
    let Some(interface) = Interface::new("gs_learned") else { return };
    let folder = tempfile::tempdir_in("/dev/shm").unwrap();
    let state = folder.path().join("learned.toml");
    let car = edited_car(|text| format!("{text}\n[service]\nstate_file = \"{}\"\n", state.display()));
    let mut replay = Command::new(gripd());
    replay.args(["replay", "-q", "-c"]).arg(car.path()).arg(simulated_drive()).arg("--state").arg(&state);
    assert!(replay.status().unwrap().success());
    let watch = || {
        let mut monitor = Command::new(gripd());
        monitor.args(["monitor", "-i", interface.0, "--once=1", "--estimate", "-c"]).arg(car.path());
        let output = monitor.env_remove("RUST_LOG").output().unwrap();
        assert_eq!(output.status.code(), Some(0), "{output:?}");
        String::from_utf8(output.stderr).unwrap()
    };
    let traffic = Traffic::start(interface.0, frames(simulated_drive()));
    let saved = std::fs::read(&state).unwrap();
    let told = watch();
    assert!(told.contains("goes on from what"), "{told}");
    assert_eq!(std::fs::read(&state).unwrap(), saved);
    // One that is refused, neither.
    std::fs::write(&state, &saved[..saved.len() / 2]).unwrap();
    let told = watch();
    assert!(told.contains("left alone"), "{told}");
    assert_eq!(std::fs::read(&state).unwrap(), saved[..saved.len() / 2]);
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1);
    drop(traffic);
}

/// GIVEN a bus with a car WHEN it is watched with and without a gripd on it THEN the words are about what is there, and
/// nothing is sent.
#[test]
fn what_a_running_gripd_publishes_is_shown_and_nothing_is_sent() {
    let Some(interface) = Interface::new("gs_watch") else { return };
    let recorder = Recorder::start(interface.0);
    let gripd = Gripd::start(&demo_car(), interface.0);
    let traffic = Traffic::start(interface.0, frames(simulated_drive()));
    recorder.wait_for_more(300, "a second of published frames");
    let (code, text) = monitor(interface.0, &["--once=2"]);
    println!("{text}");
    assert_eq!(code, Some(0));
    for words in [
        "gs_watch: up",
        "as a gripd on this bus publishes them",
        "Published messages: ",
        "State and faults: running",
    ] {
        assert!(text.contains(words), "no `{words}`");
    }
    // Every message comes, and none was damaged or is stale.
    let messages: Vec<&str> = text.lines().filter(|line| line.trim_start().starts_with("GRIP_")).collect();
    assert_eq!(messages.len(), 7);
    assert!(
        messages.iter().all(|line| line.contains("crc 0 ctr ") && !line.contains("stale")),
        "{messages:?}"
    );
    let counted = messages.iter().map(|line| line.rsplit(' ').next().unwrap().parse().unwrap());
    let most_counted: usize = counted.max().unwrap();
    let first = text.lines().next().unwrap().to_owned();

    // Without it: said so; and estimated here if that is wanted, for nobody else to see.
    let tally = gripd.end(SIGTERM);
    let (code, text) = monitor(interface.0, &["--once=1"]);
    assert!(code == Some(0) && text.contains("no gripd publishes on this bus"), "{text}");
    let (code, text) = monitor(interface.0, &["--once=2", "--estimate"]);
    assert!(code == Some(0) && text.contains("nothing is sent") && text.contains("running"), "{text}");
    drop(traffic);
    let of_the_car = |frame: &Frame| (0x1A0..=0x1D0).contains(&frame.id.number());
    let all = recorder.frames();
    assert_eq!(all.iter().filter(|frame| is_published(frame)).count(), tally.published);
    // A guest that is busy makes gripd give rounds up, and it says so. The monitor counts no jump that is not on the bus.
    let jumps = published_ids().into_iter().map(|id| counter_jumps(&all, id)).max().unwrap();
    let given_up = tally.late + tally.unsent + tally.dropped;
    assert!(jumps == 0 || given_up > 0, "{jumps} jumps, {tally:?}");
    assert!(most_counted <= jumps || first.contains("frames lost"), "{most_counted} of {jumps}: {first}");
    assert!(all.iter().all(|frame| is_published(frame) || of_the_car(frame) || frame.id.number() == 0x7FF));

    // A bus that is down, and one that is not there.
    interface.set("down");
    let (code, text) = monitor(interface.0, &["--once=1"]);
    assert!(code == Some(1) && text.contains("the interface is down"), "{text}");
    let (code, text) = monitor("gs_nowhere", &["--once=1"]);
    assert!(code == Some(1) && text.contains("there is no such interface"), "{text}");
}
