//! `gripd plot`: what is in the page, what it refuses, and the page in a real browser.

mod command;
mod page;

use std::fs;
use std::path::PathBuf;
use std::process::Output;
use std::sync::OnceLock;

use serde_json::Value;
use tempfile::TempDir;
use testing::program::{gripd, project};

use crate::interactive::{data, titled};

/// 30 s of the demo drive as candump text.
fn drive() -> &'static str {
    static TEXT: OnceLock<String> = OnceLock::new();
    TEXT.get_or_init(|| {
        let folder = TempDir::new().unwrap();
        let scenario = fs::read_to_string(project("config/scenarios/demo.toml")).unwrap();
        let path = folder.path().join("drive.toml");
        fs::write(&path, scenario.replace("duration_s = 120.0", "duration_s = 30.0")).unwrap();
        let output = gripd().arg("simulate").arg(path).args(["-o", "-"]).output().unwrap();
        String::from_utf8(output.stdout).unwrap()
    })
}

/// The same so many times, by a clock that is right, one after the other.
fn repeated(times: u32) -> String {
    let mut text = String::new();
    for round in 0..times {
        for line in drive().lines() {
            let (stamp, rest) = line.strip_prefix('(').unwrap().split_once(')').unwrap();
            let stamp = stamp.parse::<f64>().unwrap() + 1_760_000_000.0 + 30.0 * f64::from(round);
            text += &format!("({stamp:.6}){rest}\n");
        }
    }
    text
}

/// A folder with the drive in it, and plots there.
struct Place(TempDir);

impl Place {
    fn new() -> Self {
        let place = Self(TempDir::new().unwrap());
        place.write("drive.log", drive());
        place
    }

    fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    fn write(&self, name: &str, content: impl AsRef<[u8]>) {
        fs::write(self.path(name), content).unwrap();
    }

    /// `gripd plot` of the demo car with these arguments, in this folder.
    fn plot(&self, arguments: &str) -> Output {
        let mut command = gripd();
        command.current_dir(self.0.path()).args(["plot", "-c"]).arg(project("config/demo.toml"));
        command.args(arguments.split_whitespace()).output().unwrap()
    }

    /// The same into `page.html`; it must succeed. The page.
    #[track_caller]
    fn plotted(&self, arguments: &str) -> String {
        let output = self.plot(&format!("{arguments} --html page.html"));
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        fs::read_to_string(self.path("page.html")).unwrap()
    }
}
