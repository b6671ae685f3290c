//! A running `gripd run`, with what it says on stderr and what it tells systemd.

use std::io::{BufRead, BufReader};
use std::os::unix::net::UnixDatagram;
use std::path::Path;
use std::process::{Child, Command, ExitStatus, Stdio};
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};

use nix::sys::signal::{Signal, kill};
use nix::unistd::Pid;

use super::wait_for;
use testing::vcan::PATIENCE;

/// Directly: a program that does it takes longer to start in the guest than gripd to end.
#[track_caller]
pub fn send_signal(child: &Child, signal: Signal) {
    kill(Pid::from_raw(child.id().cast_signed()), signal).unwrap();
}

/// The program.
pub fn gripd() -> &'static str {
    env!("CARGO_BIN_EXE_gripd")
}

/// What a test that is a process of its own is asked, a line each.
const WORDS: &str = "GRIPD_TEST_WORDS";

/// This program again, for one of its ignored tests, in a process of its own; `by` starts it otherwise scheduled.
pub fn again(by: &[&str], test: &str, words: &[&str]) -> Child {
    let myself = std::env::current_exe().unwrap();
    let mut program = by_way_of(by, myself);
    program.args([test, "--exact", "--ignored", "--nocapture"]).env(WORDS, words.join("\n"));
    program.stdout(Stdio::null()).spawn().unwrap()
}

/// What [`again`] was given; none where a person starts such a test.
pub fn asked<const COUNT: usize>() -> Option<[String; COUNT]> {
    let words = std::env::var(WORDS).ok()?;
    Some(words.lines().map(str::to_owned).collect::<Vec<_>>().try_into().unwrap())
}

/// A program, started by another one and its arguments (`nice`, `chrt`), or directly.
pub fn by_way_of(by: &[&str], program: impl AsRef<std::ffi::OsStr>) -> Command {
    let Some((first, rest)) = by.split_first() else { return Command::new(program) };
    let mut command = Command::new(first);
    command.args(rest).arg(program);
    command
}

/// Killed when dropped.
pub struct Gripd {
    child: Child,
    log: Arc<Mutex<Vec<String>>>,
    /// What came on the socket that systemd would listen on.
    notifications: Arc<Mutex<Vec<(Instant, String)>>>,
    _folder: tempfile::TempDir,
}

/// What it counted.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Tally {
    pub received: usize,
    pub published: usize,
    pub unsent: usize,
    pub late: usize,
    pub foreign: usize,
    pub dropped: usize,
}

impl Gripd {
    /// Starts it and waits until it says that it is ready.
    #[track_caller]
    pub fn start(config: &Path, interface: &str) -> Self {
        let gripd = Self::spawn(config, interface, &[]);
        gripd.wait_for_notification("READY=1");
        gripd
    }

    pub fn spawn(config: &Path, interface: &str, environment: &[(&str, &str)]) -> Self {
        Self::spawn_by(Command::new(gripd()), config, interface, environment)
    }

    /// By a program that becomes it.
    pub fn spawn_by(
        mut program: Command,
        config: &Path,
        interface: &str,
        environment: &[(&str, &str)],
    ) -> Self {
        // In memory: in the guest, not every file system can hold a socket.
        let folder = tempfile::tempdir_in("/dev/shm").unwrap();
        let path = folder.path().join("notify");
        let socket = UnixDatagram::bind(&path).unwrap();
        let notifications = Arc::new(Mutex::new(Vec::new()));
        let told = Arc::clone(&notifications);
        std::thread::spawn(move || {
            let mut buffer = [0; 1024];
            while let Ok(length) = socket.recv(&mut buffer) {
                let text = String::from_utf8_lossy(&buffer[..length]).into_owned();
                let mut told = told.lock().unwrap();
                told.extend(text.lines().map(|line| (Instant::now(), line.to_owned())));
            }
        });
        let mut child = program
            .args(["run", "-i", interface, "-c"])
            .arg(config)
            .env("NOTIFY_SOCKET", &path)
            .env_remove("WATCHDOG_USEC")
            .env_remove("RUST_LOG")
            .envs(environment.iter().copied())
            .stdout(Stdio::null())
            .stderr(Stdio::piped())
            .spawn()
            .unwrap();
        let log = Arc::new(Mutex::new(Vec::new()));
        let lines = BufReader::new(child.stderr.take().unwrap()).lines();
        let said = Arc::clone(&log);
        std::thread::spawn(move || {
            for line in lines.map_while(Result::ok) {
                said.lock().unwrap().push(line);
            }
        });
        Self { child, log, notifications, _folder: folder }
    }

    #[track_caller]
    pub fn signal(&self, signal: Signal) {
        send_signal(&self.child, signal);
    }

    /// Its process.
    pub fn id(&self) -> u32 {
        self.child.id()
    }

    /// Everything it has said on stderr.
    pub fn log(&self) -> String {
        self.log.lock().unwrap().join("\n")
    }

    #[track_caller]
    pub fn wait_for_log(&self, text: &str) {
        self.wait_longer_for_log(text, PATIENCE);
    }

    #[track_caller]
    pub fn wait_longer_for_log(&self, text: &str, patience: Duration) {
        let begun = Instant::now();
        while !self.log().contains(text) {
            assert!(begun.elapsed() < patience, "`{text}` was not said:\n{}", self.log());
            std::thread::sleep(Duration::from_millis(10));
        }
    }

    /// Everything it has told systemd, with the time.
    pub fn notifications(&self) -> Vec<(Instant, String)> {
        self.notifications.lock().unwrap().clone()
    }

    pub fn was_told(&self, text: &str) -> bool {
        self.notifications().iter().any(|(_, told)| told == text)
    }

    #[track_caller]
    pub fn wait_for_notification(&self, text: &str) {
        wait_for(text, || self.was_told(text));
    }

    pub fn is_running(&mut self) -> bool {
        self.child.try_wait().unwrap().is_none()
    }

    /// Waits for its end.
    #[track_caller]
    pub fn ends(&mut self) -> ExitStatus {
        wait_for("its end", || !self.is_running());
        self.child.wait().unwrap()
    }

    /// Sends the signal; it must end well within a second. Its own counts.
    #[track_caller]
    pub fn end(mut self, signal: Signal) -> Tally {
        let begun = Instant::now();
        self.signal(signal);
        let status = self.ends();
        let took = begun.elapsed();
        assert!(status.success(), "{status}:\n{}", self.log());
        assert!(took < Duration::from_secs(1), "{signal} took {took:?}");
        self.wait_for_log("frames so far");
        wait_for("STOPPING=1", || self.was_told("STOPPING=1"));
        self.tally()
    }

    fn tally(&self) -> Tally {
        let log = self.log();
        let line = log.lines().rev().find(|line| line.contains("frames so far")).unwrap();
        let count = |name: &str| {
            let (_, rest) = line.split_once(&format!("{name}=")).unwrap();
            rest.split(' ').next().unwrap().parse().unwrap()
        };
        Tally {
            received: count("received"),
            published: count("published"),
            unsent: count("unsent"),
            late: count("late"),
            foreign: count("foreign"),
            dropped: count("dropped"),
        }
    }
}

impl Drop for Gripd {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}
