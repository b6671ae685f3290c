//! Bad days of the bus, the disk and the process, with the time that it takes until all is well again: rows of the
//! guide's table.

use std::path::PathBuf;

use gripd::service::SavedState;
use gripd::{Config, Faults};
use nix::sys::signal::Signal::SIGKILL;

use super::*;

/// The faults that a status frame tells; none in any other frame.
pub fn told(frame: &Frame) -> Faults {
    let bits = |from: usize| u32::from(u16::from_le_bytes([frame.data()[from], frame.data()[from + 1]]));
    match frame.id.number() {
        0x6A5 => Faults::from_bits_retain(bits(5)),
        0x6A6 => Faults::from_bits_retain(bits(2) << 16),
        _ => Faults::empty(),
    }
}

/// Waits until something new is published, and a status without these faults; how long that took.
#[track_caller]
fn recovers(candump: &Recorder, since: Instant, known: usize, faults: Faults) -> Duration {
    wait_for("publishing without faults", || {
        let published = candump.published();
        let new = published.get(known..).unwrap_or_default();
        new.iter().rfind(|frame| frame.id.number() == 0x6A5).is_some_and(|f| !told(f).intersects(faults))
    });
    since.elapsed()
}

fn row(fault: &str, reaction: &str, took: impl IntoIterator<Item = Duration>) {
    let worst = took.into_iter().max().unwrap_or_default();
    println!("| {fault} | {reaction} | {:.2} s |", worst.as_secs_f64());
}

#[test]
fn a_link_that_goes_down() {
    let Some(interface) = Interface::new("gs_fdown") else { return };
    let candump = Recorder::start(interface.0);
    let gripd = Gripd::start(&demo_car(), interface.0);
    let _car = Traffic::start(interface.0, frames(simulated_drive()));
    candump.wait_for_more(60, "publishing");
    let took = (0..5).map(|_| {
        interface.set("down");
        std::thread::sleep(Duration::from_millis(300));
        let known = candump.published().len();
        interface.set("up");
        let took = recovers(&candump, Instant::now(), known, Faults::BUS_DOWN);
        let told = candump.published()[known..].iter().any(|frame| told(frame).contains(Faults::BUS_DOWN));
        assert!(told, "the first status afterwards tells of it");
        took
    });
    let took: Vec<Duration> = took.collect();
    row("link down, up", "BUS_DOWN; \"the input interface is down\"; silence", took);
    assert_eq!(gripd.log().matches("the input interface is down").count(), 5);
    gripd.end(SIGTERM);
}

#[test]
fn an_interface_that_is_removed_or_comes_late() {
    let Some(interface) = Interface::new("gs_fgone") else { return };
    interface.remove();
    let gripd = Gripd::start(&demo_car(), interface.0);
    gripd.wait_for_log("the input interface does not exist");
    let _car = Traffic::start(interface.0, frames(simulated_drive()));
    let again = || {
        let index = Interface::create(interface.0).then(|| interface.index()).unwrap();
        let created = Instant::now();
        let candump = Recorder::start(interface.0);
        let took = recovers(&candump, created, 0, Faults::BUS_DOWN);
        drop(candump);
        interface.remove();
        std::thread::sleep(Duration::from_millis(1500));
        (took, index)
    };
    let (late, first) = again();
    let (back, second) = again();
    assert_ne!(first, second);
    row("no such interface at the start", "\"does not exist; waiting for it\"; silence", [late]);
    row("interface removed, made again with another index", "BUS_DOWN; \"does not exist\"; silence", [back]);
    // Something to be dropped.
    assert!(Interface::create(interface.0));
    gripd.end(SIGTERM);
}

#[test]
fn a_controller_that_reports_errors() {
    let Some(interface) = Interface::new("gs_ferr") else { return };
    let candump = Recorder::start(interface.0);
    let gripd = Gripd::start(&demo_car(), interface.0);
    let _car = Traffic::start(interface.0, frames(simulated_drive()));
    candump.wait_for_more(60, "publishing");
    for (name, frame, said) in [
        ("bus off", "20000040#0000000000000000", "bus off"),
        ("no acknowledgement", "20000024#0010000000000000", "no acknowledgement"),
    ] {
        let known = candump.published().len();
        assert!(run("cansend", &format!("{} {frame}", interface.0)));
        let sent = Instant::now();
        gripd.wait_for_log(said);
        wait_for("the fault bit", || {
            candump.published()[known..].iter().any(|frame| told(frame).contains(Faults::BUS_ERROR))
        });
        let took = recovers(&candump, sent, candump.published().len(), Faults::BUS_ERROR);
        row(name, &format!("BUS_ERROR; \"{said}\"; goes on"), [took]);
    }
    gripd.end(SIGTERM);
}

#[test]
fn a_bus_that_takes_no_frames() {
    let Some(interface) = Interface::new("gs_ffull") else { return };
    let candump = Recorder::start(interface.0);
    let gripd = Gripd::start(&demo_car(), interface.0);
    let _car = Traffic::start(interface.0, frames(simulated_drive()));
    candump.wait_for_more(60, "publishing");
    if !run("tc", &format!("qdisc replace dev {} root tbf rate 8kbit burst 100 limit 300", interface.0)) {
        return println!("skipped: no tc, or a kernel without its token bucket filter");
    }
    gripd.wait_for_log("the send queue is full");
    let known = candump.published().len();
    assert!(run("tc", &format!("qdisc del dev {} root", interface.0)));
    let took = recovers(&candump, Instant::now(), known, Faults::BUS_ERROR);
    row("send queue full (ENOBUFS)", "BUS_ERROR; \"the send queue is full\"; dropped, counted", [took]);
    assert!(gripd.end(SIGTERM).unsent > 0);
}

/// The demo's car with its state in a file of this folder, written after each second of driving.
fn keeping(folder: &Path) -> (tempfile::NamedTempFile, PathBuf) {
    let file = folder.join("learned.toml");
    let service = format!("\n[service]\nstate_file = \"{}\"\nstate_every_s = 1\n", file.display());
    (edited_car(|text| text + &service), file)
}

#[test]
fn a_disk_that_is_full() {
    let Some(interface) = Interface::new("gs_fdisk") else { return };
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().display();
    if !run("mount", &format!("-t tmpfs -o size=16k none {path}")) {
        return println!("skipped: no small file system can be mounted here");
    }
    let (car, file) = keeping(folder.path());
    let ballast = folder.path().join("ballast");
    let full = std::fs::write(&ballast, vec![0; 1 << 16]).is_err();
    let candump = Recorder::start(interface.0);
    let gripd = Gripd::start(car.path(), interface.0);
    let _car = Traffic::start(interface.0, frames(simulated_drive()));
    gripd.wait_for_log("what is learned cannot be saved");
    candump.wait_for_more(60, "publishing without a disk");
    let nothing = !file.exists();
    std::fs::remove_file(&ballast).unwrap();
    let freed = Instant::now();
    gripd.wait_for_log("what is learned is saved again");
    let took = freed.elapsed();
    let complaints = gripd.log().matches("cannot be saved").count();
    gripd.end(SIGTERM);
    let config = Config::load(car.path()).unwrap();
    let saved = SavedState::new(&file, &config).load();
    assert!(run("umount", &path.to_string()));
    assert!(full && nothing && saved.unwrap().is_some());
    assert_eq!(complaints, 1);
    row("disk full", "\"what is learned cannot be saved\", once; goes on", [took]);
}

/// GIVEN nothing at all can be written, its own folder least of all, THEN it says so once, publishes, and ends as ever.
#[test]
fn a_root_that_is_read_only() {
    let Some(interface) = Interface::new("gs_froot") else { return };
    if !run("unshare", "-m mount -o remount,bind,ro /") {
        return println!("skipped: no root of one's own can be made read-only here");
    }
    let folder = tempfile::tempdir_in(env!("CARGO_TARGET_TMPDIR")).unwrap();
    let (car, file) = keeping(folder.path());
    // From before, to be read and not to be damaged.
    let before = {
        let candump = Recorder::start(interface.0);
        let gripd = Gripd::start(car.path(), interface.0);
        let _car = Traffic::start(interface.0, frames(simulated_drive()));
        candump.wait_for_more(300, "publishing");
        gripd.end(SIGTERM);
        std::fs::read(&file).unwrap()
    };
    let mut read_only = Command::new("unshare");
    // Wherever the folder is: on the root or on a disk of its own.
    let script = "mount -o remount,bind,ro / && mount --bind \"$0\" \"$0\" && mount -o remount,bind,ro \"$0\" && \
                  ! touch \"$0/x\" 2>/dev/null && exec \"$@\"";
    read_only.args(["-m", "sh", "-c", script]).arg(folder.path()).arg(process::gripd());
    let candump = Recorder::start(interface.0);
    let begun = Instant::now();
    let gripd = Gripd::spawn_by(read_only, car.path(), interface.0, &[]);
    gripd.wait_for_notification("READY=1");
    let _car = Traffic::start(interface.0, frames(simulated_drive()));
    let took = recovers(&candump, begun, 0, Faults::all() - Faults::INCONSISTENT);
    gripd.wait_for_log("what is learned cannot be saved");
    candump.wait_for_more(600, "publishing without a disk");
    let complaints = gripd.log().matches("cannot be saved").count();
    let log = gripd.log();
    assert_eq!(complaints, 1, "{log}");
    gripd.end(SIGTERM);
    assert_eq!(std::fs::read(&file).unwrap(), before);
    row("read-only root", "\"what is learned cannot be saved\", once; goes on", [took]);
}

/// GIVEN a sensor that turns the other way THEN the log says who contradicts whom, and why the motion is not believed.
#[test]
fn sensors_that_contradict_each_other() {
    let Some(interface) = Interface::new("gs_fcontra") else { return };
    let car = edited_car(|text| {
        text.replace(
            "yaw_rate = { signal = \"INERTIAL.YawRate\",",
            "yaw_rate = { signal = \"INERTIAL.YawRate\", gain = -1.0,",
        )
    });
    let gripd = Gripd::start(car.path(), interface.0);
    let _car = Traffic::start(interface.0, frames(simulated_drive()));
    gripd.wait_for_log("sensors contradict each other: yaw_rate and ");
    gripd.wait_for_log("move against each other (correlation -");
    gripd.wait_for_log("the motion is not believed at the moment: ");
    let log = gripd.log();
    let said = log.matches("contradict each other").count() + log.matches("not believed").count();
    assert!(said < 12, "it is said too often: {log}");
    log.lines()
        .filter(|line| line.contains("contradict") || line.contains("believed"))
        .for_each(|l| println!("{l}"));
    gripd.end(SIGTERM);
}

/// GIVEN it writes all the time WHEN it is killed at any moment THEN the file is whole, and the next start goes on.
#[test]
#[ignore = "long: 21 s"]
fn killed_and_ended_while_it_writes() {
    let Some(interface) = Interface::new("gs_fkill") else { return };
    let folder = tempfile::tempdir().unwrap();
    let (car, file) = keeping(folder.path());
    let config = Config::load(car.path()).unwrap();
    let state = SavedState::new(&file, &config);
    let candump = Recorder::start(interface.0);
    let _car = Traffic::start(interface.0, frames(simulated_drive()));
    let (mut took, mut driven) = (Vec::new(), 0.0);
    for round in 0..8 {
        let known = candump.published().len();
        let begun = Instant::now();
        let mut gripd = Gripd::start(car.path(), interface.0);
        took.push(recovers(&candump, begun, known, Faults::all() - Faults::INCONSISTENT));
        std::thread::sleep(Duration::from_millis(1000 + 150 * round));
        if round % 2 == 0 {
            gripd.signal(SIGKILL);
            gripd.ends();
        } else {
            gripd.end(SIGTERM);
        }
        let saved = state.load().unwrap().map_or(0.0, |learned| learned.driving_s);
        assert!(saved >= driven, "round {round}: {saved} after {driven} s");
        driven = saved;
    }
    assert!(driven > 4.0, "{driven}");
    assert!(!state.aside().exists());
    row("killed (-9), started again", "the file is the one before or whole; goes on from it", took);
}
