//! Other users and other processes: their links, and the state that they have.

use std::fs::{self, Permissions};
use std::os::unix::fs::PermissionsExt;

use super::*;

/// GIVEN a folder for all with a link of somebody else's WHEN root replays to it THEN it is refused where the kernel
/// refuses a shell, and the target stays as it is.
#[test]
fn a_result_does_not_go_through_another_users_link() {
    let is_guest = fs::read_to_string("/proc/cpuinfo").is_ok_and(|info| info.contains("User Mode Linux"));
    if !is_guest || fs::write("/proc/sys/fs/protected_symlinks", "1").is_err() {
        return println!("skipped: the kernel's rules are changed in a guest only");
    }
    // The guest's own file system.
    let folder = tempfile::tempdir_in("/dev/shm").unwrap();
    let (all, own) = (folder.path().join("all"), folder.path().join("own"));
    for (folder, mode) in [(folder.path(), 0o755), (&all, 0o1777), (&own, 0o700)] {
        let _ = fs::create_dir(folder);
        fs::set_permissions(folder, Permissions::from_mode(mode)).unwrap();
    }
    let (target, link) = (own.join("secret"), all.join("link"));
    fs::write(&target, "mine").unwrap();
    fs::set_permissions(&target, Permissions::from_mode(0o600)).unwrap();
    std::os::unix::fs::symlink(&target, &link).unwrap();
    std::os::unix::fs::lchown(&link, Some(12_345), Some(12_345)).unwrap();
    let shell = fs::OpenOptions::new().write(true).open(&link);
    assert_eq!(
        shell.unwrap_err().kind(),
        std::io::ErrorKind::PermissionDenied,
        "the kernel has no such rule"
    );
    for results in [["-o"], ["--state"]] {
        let mut replay = Command::new(gripd());
        replay.args(["replay", "-q", "-c"]).arg(demo_car()).arg(simulated_drive()).args(results).arg(&link);
        let output = replay.output().unwrap();
        let said = String::from_utf8_lossy(&output.stderr);
        assert!(!output.status.success() && said.contains("Permission denied"), "{results:?}: {said}");
        assert_eq!(fs::read_to_string(&target).unwrap(), "mine");
        assert_eq!(fs::metadata(&target).unwrap().permissions().mode() & 0o777, 0o600);
    }
}

/// GIVEN new tires WHEN the running service is told so THEN it forgets, and its file does, too.
#[test]
fn a_running_service_forgets() {
    let Some(interface) = Interface::new("gs_forget") else { return };
    let folder = tempfile::tempdir_in("/dev/shm").unwrap();
    let state = folder.path().join("learned.toml");
    let config = edited_car(|text| {
        format!("{text}\n[service]\nstate_file = \"{}\"\nstate_every_s = 1\n", state.display())
    });
    let gripd = Gripd::start(config.path(), interface.0);
    let candump = Recorder::start(interface.0);
    {
        let _car = Traffic::start(interface.0, frames(simulated_drive()));
        wait_for("its state", || state.exists());
        candump.wait_for_more(70, "publishing");
    }
    gripd.signal(nix::sys::signal::Signal::SIGUSR1);
    gripd.wait_for_log("forgets what it learned: [Tires, Radii, Offsets]");
    wait_for("a file without it, or none", || {
        fs::read_to_string(&state).map_or(true, |text| !text.contains("[slip_slope."))
    });
    let _car = Traffic::start(interface.0, frames(simulated_drive()));
    gripd.signal(nix::sys::signal::Signal::SIGUSR2);
    gripd.wait_for_log("forgets what it learned: [Tires, Radii]");
    candump.wait_for_more(70, "publishing afterwards");
    gripd.end(SIGTERM);
}

/// GIVEN a configuration that has become a pipe THEN a reload is refused and told, and the next good one is taken.
#[test]
fn a_reload_of_a_pipe() {
    let Some(interface) = Interface::new("gs_fifo") else { return };
    let folder = tempfile::tempdir_in("/dev/shm").unwrap();
    let car = edited_car(|text| text);
    let config = folder.path().join("car.toml");
    fs::copy(car.path(), &config).unwrap();
    let candump = Recorder::start(interface.0);
    let gripd = Gripd::start(&config, interface.0);
    let _car = Traffic::start(interface.0, frames(simulated_drive()));
    candump.wait_for_more(70, "publishing");
    fs::remove_file(&config).unwrap();
    assert!(run("mkfifo", config.to_str().unwrap()));
    gripd.signal(SIGHUP);
    gripd.wait_for_log("the new configuration is refused");
    assert!(gripd.log().contains("not an ordinary file"), "{}", gripd.log());
    wait_for("CONFIG", || {
        candump.published().iter().any(|frame| super::faults::told(frame).contains(gripd::Faults::CONFIG))
    });
    fs::remove_file(&config).unwrap();
    fs::copy(car.path(), &config).unwrap();
    gripd.signal(SIGHUP);
    gripd.wait_for_log("the new configuration is in use");
    gripd.end(SIGTERM);
}

/// GIVEN a second service with the same state file THEN it says so, and leaves the file to the first.
#[test]
fn a_state_file_that_another_one_has() {
    let (Some(one), Some(two)) = (Interface::new("gs_st0"), Interface::new("gs_st1")) else { return };
    let folder = tempfile::tempdir_in("/dev/shm").unwrap();
    let state = folder.path().join("learned.toml");
    let config = edited_car(|text| {
        format!("{text}\n[service]\nstate_file = \"{}\"\nstate_every_s = 1\n", state.display())
    });
    let first = Gripd::start(config.path(), one.0);
    let second = Gripd::start(config.path(), two.0);
    second.wait_for_log("another gripd has this file");
    assert!(!first.log().contains("another gripd"));
    {
        let _car = Traffic::start(two.0, frames(simulated_drive()));
        std::thread::sleep(Duration::from_secs(5));
    }
    second.end(SIGTERM);
    assert!(!state.exists(), "it is the first one's");
    let _car = Traffic::start(one.0, frames(simulated_drive()));
    wait_for("its state", || state.exists());
    assert_eq!(fs::metadata(&state).unwrap().permissions().mode() & 0o777, 0o600);
    first.end(SIGTERM);
    let third = Gripd::start(config.path(), one.0);
    third.wait_for_log("goes on from what");
    third.end(SIGTERM);
}
