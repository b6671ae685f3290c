//! `gripd view`: what it answers, what it refuses, and the page in a real browser.

pub mod browser;
mod http;
mod page;

use std::fs;
use std::io::{BufRead, BufReader, Read, Write};
use std::net::{SocketAddr, TcpStream};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::sync::OnceLock;
use std::time::{Duration, Instant};

use nix::sys::signal::{Signal, kill};
use nix::unistd::Pid;

const GRIPD: &str = env!("CARGO_BIN_EXE_gripd");
const CAR: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/config/demo.toml");
/// Far more than any of it takes.
const PATIENCE: Duration = Duration::from_secs(60);

/// 30 s of the demo drive.
fn drive() -> &'static Path {
    static MADE: OnceLock<PathBuf> = OnceLock::new();
    MADE.get_or_init(|| {
        let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("view");
        fs::create_dir_all(&folder).unwrap();
        let scenario = Path::new(env!("CARGO_MANIFEST_DIR")).join("config/scenarios/demo.toml");
        let scenario = fs::read_to_string(scenario).unwrap();
        let (toml, log) = (folder.join("drive.toml"), folder.join("drive.log"));
        fs::write(&toml, scenario.replace("duration_s = 120.0", "duration_s = 30.0")).unwrap();
        let status = Command::new(GRIPD).arg("simulate").arg(&toml).arg("-o").arg(&log).status();
        assert!(status.unwrap().success());
        log
    })
}

/// A page that is served, until this is dropped.
struct Server {
    process: Child,
    address: SocketAddr,
}

impl Server {
    /// The drive, so many times as fast.
    fn start(speed: &str) -> Self {
        let mut process = Command::new(GRIPD)
            .args(["-q", "view", "-c", CAR, "--listen", "127.0.0.1:0", "--speed", speed])
            .arg(drive())
            .env_remove("RUST_LOG")
            .stdout(Stdio::piped())
            .spawn()
            .unwrap();
        let mut line = String::new();
        BufReader::new(process.stdout.take().unwrap()).read_line(&mut line).unwrap();
        let address = line.trim().strip_prefix("http://").and_then(|rest| rest.strip_suffix('/'));
        let address = address.unwrap_or_else(|| panic!("`{line}`")).parse().unwrap();
        Self { process, address }
    }

    fn url(&self) -> String {
        format!("http://{}/", self.address)
    }

    fn signal(&self, signal: Signal) {
        kill(Pid::from_raw(self.process.id().cast_signed()), signal).unwrap();
    }

    fn connect(&self) -> TcpStream {
        let stream = TcpStream::connect(self.address).unwrap();
        stream.set_read_timeout(Some(PATIENCE)).unwrap();
        stream
    }

    /// The answer to a request, to its end.
    fn ask(&self, request: &str) -> String {
        let mut stream = self.connect();
        stream.write_all(request.as_bytes()).unwrap();
        let mut answer = String::new();
        stream.read_to_string(&mut answer).unwrap();
        answer
    }

    fn get(&self, path: &str) -> String {
        self.ask(&format!("GET {path} HTTP/1.1\r\nHost: {}\r\nConnection: close\r\n\r\n", self.address))
    }

    /// Events as a browser gets them.
    fn events(&self) -> Events {
        let mut stream = self.connect();
        write!(stream, "GET /events HTTP/1.1\r\nHost: {}\r\n\r\n", self.address).unwrap();
        Events(BufReader::new(stream))
    }
}

impl Drop for Server {
    fn drop(&mut self) {
        let _ = self.process.kill();
        let _ = self.process.wait();
    }
}

/// A stream of events.
struct Events(BufReader<TcpStream>);

impl Events {
    /// The next one: its name and what it says.
    fn next(&mut self) -> (String, serde_json::Value) {
        let mut name = String::new();
        loop {
            let mut line = String::new();
            assert!(self.0.read_line(&mut line).unwrap() > 0, "the stream ended");
            if let Some(event) = line.strip_prefix("event: ") {
                name = event.trim().to_owned();
            } else if let Some(data) = line.strip_prefix("data: ") {
                return (name, serde_json::from_str(data).unwrap());
            }
        }
    }
}
