//! Virtual CAN interfaces for tests, and programs that work on them.

use std::process::{Command, Stdio};
use std::time::Duration;

/// Nothing here takes a second on an idle machine; the guest may be far from idle.
pub const PATIENCE: Duration = Duration::from_secs(30);

/// Runs a program; true if it succeeded.
pub fn run(program: &str, arguments: &str) -> bool {
    let status = Command::new(program).args(arguments.split_whitespace()).stderr(Stdio::null()).status();
    status.is_ok_and(|status| status.success())
}

#[track_caller]
pub fn must(program: &str, arguments: &str) {
    assert!(run(program, arguments), "{program} {arguments}");
}

/// A virtual interface that lives as long as this.
pub struct Interface(pub &'static str);

impl Interface {
    /// Makes it; `None`, with a printed message, where that is not allowed.
    pub fn new(name: &'static str) -> Option<Self> {
        if Self::create(name) {
            return Some(Self(name));
        }
        let required = std::env::var_os("GRIPD_REQUIRE_VCAN").is_some();
        assert!(!required, "cannot make the virtual CAN interface {name}");
        println!("skipped: no virtual CAN here; run with tests/vcan/run.sh as cargo's runner");
        None
    }

    pub fn create(name: &str) -> bool {
        run("ip", &format!("link add dev {name} type vcan")) && run("ip", &format!("link set {name} up"))
    }

    pub fn set(&self, what: &str) {
        must("ip", &format!("link set {} {what}", self.0));
    }

    pub fn remove(&self) {
        must("ip", &format!("link del {}", self.0));
    }

    pub fn index(&self) -> u32 {
        // Not from /sys, which may belong to another network namespace.
        nix::net::if_::if_nametoindex(self.0).expect("the interface is there")
    }
}

impl Drop for Interface {
    fn drop(&mut self) {
        run("ip", &format!("link del {}", self.0));
    }
}
