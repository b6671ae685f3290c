//! `gripd monitor` as its users meet it: in a terminal, and as text.
//!
//! The terminal is a pseudo terminal made by script(1), which is a part of every Debian.

use std::fs;
use std::io::Write;
use std::num::NonZeroU16;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Output, Stdio};
use std::sync::OnceLock;
use std::time::{Duration, Instant};

use nix::sys::signal::{Signal, kill};
use nix::unistd::Pid;
use testing::program;

const GRIPD: &str = env!("CARGO_BIN_EXE_gripd");
const CAR: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/config/demo.toml");
/// Far more than any of it takes.
const PATIENCE: Duration = Duration::from_secs(60);

fn gripd(arguments: &[&str]) -> Output {
    program::gripd().args(arguments).output().unwrap()
}

/// 20 s of the demo drive.
fn drive() -> &'static Path {
    static MADE: OnceLock<PathBuf> = OnceLock::new();
    MADE.get_or_init(|| {
        let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("monitor");
        fs::create_dir_all(&folder).unwrap();
        let scenario =
            fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join("config/scenarios/demo.toml"));
        let (toml, log) = (folder.join("drive.toml"), folder.join("drive.log"));
        fs::write(&toml, scenario.unwrap().replace("duration_s = 120.0", "duration_s = 20.0")).unwrap();
        let status = Command::new(GRIPD).arg("simulate").arg(&toml).arg("-o").arg(&log).status();
        assert!(status.unwrap().success());
        log
    })
}

/// A program in a pseudo terminal of 80x24, its settings printed before and after.
struct Terminal {
    script: Child,
    /// All that was written on it, and how much of that is on the screen below.
    typescript: PathBuf,
    shown: usize,
    screen: vt100::Parser,
    /// What it is called, and the program's process.
    name: String,
    process: Pid,
    folder: tempfile::TempDir,
}

impl Terminal {
    /// `None`, with a printed message, where there is no script(1).
    fn start(arguments: &str) -> Option<Self> {
        let folder = tempfile::tempdir().unwrap();
        let path = |name: &str| folder.path().join(name).display().to_string();
        let line = format!(
            "stty rows 24 cols 80; stty -g > {}; tty > {}; sh -c 'echo $$ > {}; exec {GRIPD} monitor {arguments}'; \
             code=$?; stty -g > {}; echo $code > {}",
            path("before"),
            path("tty"),
            path("pid"),
            path("after"),
            path("code")
        );
        let script = Command::new("script")
            .args(["-qefc", &line, &path("typescript")])
            .env("TERM", "xterm-256color")
            .env_remove("RUST_LOG")
            .env_remove("NO_COLOR")
            .stdin(Stdio::piped())
            .stdout(Stdio::null())
            .spawn();
        let Ok(script) = script else {
            println!("skipped: there is no script(1) here");
            return None;
        };
        let (name, pid) = (read(folder.path(), "tty"), read(folder.path(), "pid"));
        Some(Self {
            script,
            typescript: folder.path().join("typescript"),
            shown: 0,
            screen: vt100::Parser::new(size(24), size(80), 0),
            name,
            process: Pid::from_raw(pid.parse().unwrap()),
            folder,
        })
    }

    fn written(&self) -> Vec<u8> {
        fs::read(&self.typescript).unwrap_or_default()
    }

    /// What is on it now.
    fn text(&mut self) -> String {
        let written = self.written();
        self.screen.process(&written[self.shown..]);
        self.shown = written.len();
        self.screen.screen().contents()
    }

    /// Is the screen still the program's?
    fn is_taken(&mut self) -> bool {
        self.text();
        self.screen.screen().alternate_screen() || self.screen.screen().hide_cursor()
    }

    #[track_caller]
    fn wait_for(&mut self, words: &[&str]) {
        let begun = Instant::now();
        loop {
            let text = self.text();
            if words.iter().all(|words| text.contains(words)) {
                return;
            }
            assert!(begun.elapsed() < PATIENCE, "waited in vain for {words:?}:\n{text}");
            std::thread::sleep(Duration::from_millis(20));
        }
    }

    fn press(&mut self, keys: &str) {
        self.script.stdin.as_mut().unwrap().write_all(keys.as_bytes()).unwrap();
    }

    fn resize(&mut self, rows: u16, columns: u16) {
        self.text();
        self.screen.screen_mut().set_size(size(rows), size(columns));
        let size = [rows, columns].map(|size| size.to_string());
        let stty = Command::new("stty").args(["-F", &self.name, "rows", &size[0], "cols", &size[1]]).status();
        assert!(stty.unwrap().success());
    }

    /// It must end by itself, and leave the terminal as it was.
    #[track_caller]
    fn ends_well(&mut self) {
        assert_eq!(read(self.folder.path(), "code"), "0");
        assert_eq!(read(self.folder.path(), "before"), read(self.folder.path(), "after"));
        // script(1) may still have the last of it to copy.
        let begun = Instant::now();
        while begun.elapsed() < PATIENCE && self.is_taken() {
            std::thread::sleep(Duration::from_millis(5));
        }
        let screen = self.screen.screen();
        assert!(!screen.alternate_screen() && !screen.hide_cursor());
        assert!(
            !screen.contents().contains("Friction"),
            "its picture is still there:\n{}",
            screen.contents()
        );
    }
}

fn size(cells: u16) -> NonZeroU16 {
    NonZeroU16::new(cells).unwrap()
}

/// A line that appears in a file.
#[track_caller]
fn read(folder: &Path, name: &str) -> String {
    let begun = Instant::now();
    loop {
        let text = fs::read_to_string(folder.join(name)).unwrap_or_default();
        if text.ends_with('\n') {
            return text.trim().to_owned();
        }
        assert!(begun.elapsed() < PATIENCE, "no {name}");
        std::thread::sleep(Duration::from_millis(5));
    }
}

impl Drop for Terminal {
    fn drop(&mut self) {
        let _ = self.script.kill();
        let _ = self.script.wait();
    }
}

#[test]
fn a_session_in_a_terminal() {
    let Some(mut terminal) = Terminal::start(&format!("-c {CAR} {} --speed 5", drive().display())) else {
        return;
    };
    terminal.wait_for(&["gripd monitor", "Friction", "Slip slope", "wheel RR", "q quit", "no faults"]);
    assert!(terminal.screen.screen().alternate_screen() && terminal.screen.screen().hide_cursor());
    terminal.wait_for(&["km/h", "running"]);
    let colored = |terminal: &Terminal| {
        let cell = |place: u16| terminal.screen.screen().cell(place / 80, place % 80);
        (0..24 * 80).filter_map(cell).filter(|cell| cell.fgcolor() != vt100::Color::Default).count()
    };
    assert!(colored(&terminal) > 50, "{} cells have a colour", colored(&terminal));
    terminal.press("?");
    terminal.wait_for(&["Nothing is sent", "not available"]);
    terminal.press("?p");
    terminal.wait_for(&["PAUSED"]);
    assert!(!terminal.text().contains("Nothing is sent"));
    // It stands still: the recording, too.
    let still = terminal.text();
    std::thread::sleep(Duration::from_millis(400));
    assert_eq!(terminal.text(), still);
    // Another size: it has room for more.
    assert!(!still.contains("Input messages"));
    terminal.resize(50, 150);
    terminal.wait_for(&["Input messages", "GRIP_STATUS", "q quit"]);
    terminal.press("p");
    terminal.wait_for(&["the recording is over"]);
    terminal.press("q");
    terminal.ends_well();
}

#[test]
fn a_signal_ends_it_as_well_as_a_key() {
    let start = || Terminal::start(&format!("-c {CAR} {}", drive().display()));
    for signal in [Signal::SIGTERM, Signal::SIGINT, Signal::SIGHUP] {
        let Some(mut terminal) = start() else { return };
        terminal.wait_for(&["q quit"]);
        kill(terminal.process, signal).unwrap();
        terminal.ends_well();
    }
    // In raw mode this is but a key.
    for key in ["\x03", "q", "\x1b"] {
        let Some(mut terminal) = start() else { return };
        terminal.wait_for(&["q quit"]);
        terminal.press(key);
        terminal.ends_well();
    }
}

/// The value behind a word of a snapshot.
#[track_caller]
fn value(text: &str, line: &str, place: usize) -> f64 {
    let found = text.lines().find_map(|candidate| candidate.trim_start().strip_prefix(line));
    let word = found.and_then(|rest| rest.split_whitespace().nth(place));
    word.unwrap_or_else(|| panic!("no `{line}` in\n{text}")).replace('−', "-").parse().unwrap()
}

#[test]
fn one_snapshot_is_what_a_replay_ends_with() {
    let log = drive().to_str().unwrap();
    let output = gripd(&["monitor", "-c", CAR, log, "--once"]);
    let text = String::from_utf8(output.stdout).unwrap();
    assert!(output.status.success(), "{text}");
    assert!(!text.contains('\x1b'), "{text}");
    let replayed = gripd(&["replay", "-q", "-c", CAR, log, "--estimates", "-"]);
    let table = String::from_utf8(replayed.stdout).unwrap();
    let header: Vec<&str> = table.lines().next().unwrap().split(',').collect();
    let last: Vec<&str> = table.lines().last().unwrap().split(',').collect();
    let estimate = |name: &str| -> f64 {
        last[header.iter().position(|column| *column == name).unwrap()].parse().unwrap()
    };
    // The last samples of a recording are made at its end; the last round is some tens of milliseconds older.
    for (line, place, name, factor, near) in [
        ("FL", 0, "slope_fl", 1.0, 0.5),
        ("front", 0, "cornering_front", 1.0, 0.1),
        ("speed", 0, "speed", 3.6, 1.0),
        ("in use", 0, "mu_used", 1.0, 0.05),
        ("sideslip", 0, "sideslip", 57.3, 0.2),
    ] {
        let (shown, expected) = (value(&text, line, place), factor * estimate(name));
        assert!((shown - expected).abs() <= near, "{line}: {shown} beside {expected}\n{text}");
    }
    for words in ["no faults", "running", "WHEELS", "crc 0 ctr 0", "nothing is sent"] {
        assert!(text.contains(words), "no `{words}` in\n{text}");
    }
    let half = gripd(&["monitor", "-c", CAR, log, "--once=10"]);
    let half = String::from_utf8(half.stdout).unwrap();
    assert!(half.contains("00:00:09") && text.contains("00:00:19"), "{half}");
}

#[test]
fn where_there_is_no_terminal_it_says_what_to_do() {
    let log = drive().to_str().unwrap();
    for (arguments, code, expected) in [
        (&["-c", CAR, log][..], 2, "--once"),
        (&["-c", CAR, log, "--once=-1"], 2, "positive"),
        (&["-c", CAR, log, "--speed", "0", "--once"], 2, "--speed 0"),
        (&["-c", CAR, log, "-i", "vcan0", "--once"], 2, "cannot be used with"),
        (&["-c", CAR, "-i", "a/b", "--once"], 2, "a/b"),
        (&["-c", "none.toml", log, "--once"], 2, "none.toml"),
        (&["-c", CAR, "none.log", "--once"], 1, "none.log"),
        (&["-c", CAR, CAR, "--once"], 1, "demo.toml"),
    ] {
        let output = gripd(&[&["monitor"], arguments].concat());
        let said = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(code), "{arguments:?}: {said}");
        assert!(said.contains(expected), "{arguments:?}: {said}");
    }
    // Frames, but of another car.
    let folder = tempfile::tempdir().unwrap();
    let other = folder.path().join("other.log");
    fs::write(&other, "(1.0) can0 123#00\n(1.1) can0 123#00\n").unwrap();
    let output = gripd(&["monitor", "-c", CAR, other.to_str().unwrap(), "--once"]);
    assert_eq!(output.status.code(), Some(1));
    assert!(String::from_utf8_lossy(&output.stderr).contains("is it this car's bus?"));
    assert!(String::from_utf8_lossy(&output.stdout).contains("never"));
}
