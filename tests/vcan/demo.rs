//! `gripd demo` on vcan0. Where there is none the tests say so and pass; `tests/vcan/run.sh` is cargo's
//! runner for a place where there is one.

use std::fs;
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::sync::{LazyLock, Mutex};

/// The tests share one interface.
static VCAN0: Mutex<()> = Mutex::new(());

fn there_is_vcan0() -> bool {
    let there = nix::net::if_::if_nametoindex("vcan0").is_ok();
    assert!(there || std::env::var_os("GRIPD_REQUIRE_VCAN").is_none(), "there is no vcan0");
    if !there {
        println!("skipped: no vcan0 here; run with tests/vcan/run.sh as cargo's runner");
    }
    there
}

/// Standard output and page.
fn demo(folder: &Path, arguments: &[&str]) -> (String, String) {
    let output =
        Command::new(env!("CARGO_BIN_EXE_gripd")).arg("demo").args(arguments).current_dir(folder).output();
    let output = output.unwrap();
    let said = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{said}");
    let on = if arguments.contains(&"--memory") { "a bus in memory" } else { "on vcan0" };
    assert!(said.contains(on) && said.contains(" 0 frames lost"), "{said}");
    let page = fs::read_to_string(folder.join("gripd-demo.html")).unwrap();
    (String::from_utf8(output.stdout).unwrap(), page)
}

/// What the same car is told of on a bus in memory.
static MEMORY: LazyLock<(String, String)> =
    LazyLock::new(|| demo(tempfile::tempdir().unwrap().path(), &["--memory"]));

/// A program that runs beside the demo.
struct Beside(Child);

impl Beside {
    fn start(program: &str, arguments: &[&str], output: Stdio) -> Self {
        Self(Command::new(program).args(arguments).stdout(output).spawn().expect(program))
    }
}

impl Drop for Beside {
    fn drop(&mut self) {
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

#[test]
fn the_same_is_found_as_in_memory_and_others_see_both_directions() {
    let _alone = VCAN0.lock().unwrap();
    if !there_is_vcan0() {
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let heard = folder.path().join("heard.log");
    let candump = Beside::start("candump", &["-L", "vcan0"], fs::File::create(&heard).unwrap().into());
    std::thread::sleep(std::time::Duration::from_millis(300));
    let vcan = demo(folder.path(), &[]);
    drop(candump);
    assert_eq!(vcan.0, MEMORY.0);
    assert!(vcan.1 == MEMORY.1, "the pages differ");
    let heard = fs::read_to_string(heard).unwrap();
    for id in ["1A0#", "1B0#", "1C0#", "1D0#", "6A0#", "6A5#"] {
        assert!(heard.contains(id), "candump has not seen {id}");
    }
}

#[test]
fn traffic_of_others_with_the_same_identifiers_changes_nothing() {
    let _alone = VCAN0.lock().unwrap();
    if !there_is_vcan0() {
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let other = Beside::start("cangen", &["vcan0", "-I", "1A0", "-L", "8", "-g", "1"], Stdio::null());
    let vcan = demo(folder.path(), &["--interface", "vcan0"]);
    drop(other);
    assert!(vcan == *MEMORY, "the traffic of others was taken for the car's");
}
