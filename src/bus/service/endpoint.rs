//! Where [`Health`] can be read: a Unix socket or a loopback port that speaks just enough HTTP.
//!
//! A thread of its own answers one reader after the other. It shares nothing with the loop but numbers, so a reader
//! can be as slow as it likes.

use std::io::{self, Read, Write};
use std::net::TcpListener;
use std::os::fd::AsFd;
use std::os::unix::fs::FileTypeExt;
use std::os::unix::net::{UnixListener, UnixStream};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::thread;
use std::time::{Duration, Instant};

use nix::sys::socket::setsockopt;
use nix::sys::socket::sockopt::{ReceiveTimeout, SendTimeout};
use nix::sys::time::{TimeVal, TimeValLike};

use super::Health;
use crate::config::Address;

/// An endpoint at work, until the process ends; its socket's name is taken away when this is dropped.
#[derive(Debug)]
pub struct Endpoint {
    name: Option<PathBuf>,
}

impl Endpoint {
    /// So long a reader may take with its question and with the answer.
    const PATIENCE: Duration = Duration::from_secs(1);

    /// Opens it.
    ///
    /// # Errors
    /// If the address is taken or must not be used.
    pub fn start(address: &Address, health: Arc<Health>) -> io::Result<Self> {
        let thread = thread::Builder::new().name("metrics".into());
        match address {
            Address::Unix(path) => {
                remove_abandoned(path)?;
                let listener = UnixListener::bind(path)?;
                thread.spawn(move || answer_all(listener.incoming(), &health))?;
                Ok(Self { name: Some(path.clone()) })
            }
            Address::Loopback(address) => {
                let listener = TcpListener::bind(address)?;
                thread.spawn(move || answer_all(listener.incoming(), &health))?;
                Ok(Self { name: None })
            }
        }
    }
}

impl Drop for Endpoint {
    fn drop(&mut self) {
        if let Some(name) = &self.name {
            let _ = std::fs::remove_file(name);
        }
    }
}

/// A socket that a killed process left; not one that still answers, and nothing that is no socket.
fn remove_abandoned(path: &Path) -> io::Result<()> {
    let is_socket = std::fs::symlink_metadata(path).is_ok_and(|there| there.file_type().is_socket());
    if is_socket && UnixStream::connect(path).is_err() { std::fs::remove_file(path) } else { Ok(()) }
}

fn answer_all<S: Read + Write + AsFd>(readers: impl Iterator<Item = io::Result<S>>, health: &Health) {
    for reader in readers {
        let answered = reader.and_then(|mut stream| {
            limit(&stream)?;
            answer(&mut stream, health)
        });
        if let Err(error) = answered {
            tracing::debug!("a reader of the metrics got no answer: {error}");
            // Out of descriptors, it would be asked again at once.
            thread::sleep(Duration::from_millis(10));
        }
    }
}

/// Nobody holds up the others by reading or writing slowly.
fn limit(stream: &impl AsFd) -> io::Result<()> {
    let patience = TimeVal::microseconds(Endpoint::PATIENCE.as_micros() as i64);
    setsockopt(stream, ReceiveTimeout, &patience)?;
    Ok(setsockopt(stream, SendTimeout, &patience)?)
}

fn answer(stream: &mut (impl Read + Write), health: &Health) -> io::Result<()> {
    let deadline = Instant::now() + Endpoint::PATIENCE;
    let mut question = [0; 2048];
    let mut length = 0;
    while !question[..length].windows(4).any(|end| end == b"\r\n\r\n") {
        let count = stream.read(&mut question[length..])?;
        if count == 0 || Instant::now() > deadline {
            return Err(io::ErrorKind::InvalidData.into());
        }
        length += count;
    }
    let (status, body) = match question.get(..12) {
        Some(b"GET /metrics") => ("200 OK", health.to_string()),
        _ => ("404 Not Found", "only GET /metrics\n".to_owned()),
    };
    let kind = "text/plain; version=0.0.4; charset=utf-8";
    write!(
        stream,
        "HTTP/1.1 {status}\r\nContent-Type: {kind}\r\nContent-Length: {}\r\nConnection: close\r\n\r\n{body}",
        body.len()
    )?;
    stream.flush()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ask(path: &Path, question: &str) -> String {
        let mut stream = UnixStream::connect(path).unwrap();
        stream.write_all(question.as_bytes()).unwrap();
        let mut answer = String::new();
        stream.read_to_string(&mut answer).unwrap();
        answer
    }

    #[test]
    fn what_can_be_reached_from_outside_is_refused() {
        let address = |text: &str| Address::try_from(text.to_owned());
        assert!(matches!(address("127.0.0.1:9100"), Ok(Address::Loopback(_))));
        assert!(matches!(address("[::1]:9100"), Ok(Address::Loopback(_))));
        assert!(matches!(address("/run/gripd/metrics"), Ok(Address::Unix(_))));
        assert!(
            address("0.0.0.0:9100").is_err() && address("192.168.1.2:1").is_err() && address("").is_err()
        );
    }

    #[test]
    fn it_answers_whoever_asks_and_survives_those_who_do_not() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("metrics");
        let health = Arc::new(Health::default());
        health.set_input_up(true);
        let endpoint = Endpoint::start(&Address::Unix(path.clone()), Arc::clone(&health)).unwrap();
        // One that says nothing, one that goes away, one that talks without end.
        let _silent = UnixStream::connect(&path).unwrap();
        drop(UnixStream::connect(&path).unwrap());
        let mut endless = UnixStream::connect(&path).unwrap();
        endless.write_all(&[b'x'; 4000]).unwrap();
        let answer = ask(&path, "GET /metrics HTTP/1.1\r\nHost: x\r\n\r\n");
        assert!(answer.starts_with("HTTP/1.1 200 OK\r\n"), "{answer}");
        assert!(answer.contains("\ngripd_input_up 1\n"), "{answer}");
        assert!(answer.contains("\ngripd_faults_total{fault=\"bus_down\"} 0\n"), "{answer}");
        assert!(ask(&path, "POST / HTTP/1.1\r\n\r\n").starts_with("HTTP/1.1 404"));
        assert!(Endpoint::start(&Address::Unix(path.clone()), health).is_err(), "it is taken");
        drop(endpoint);
        assert!(!path.exists());
    }

    #[test]
    fn a_socket_that_nobody_answers_is_taken_over_and_a_file_is_not() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("metrics");
        drop(UnixListener::bind(&path).unwrap());
        assert!(path.exists());
        let endpoint = Endpoint::start(&Address::Unix(path.clone()), Arc::default()).unwrap();
        drop(endpoint);
        std::fs::write(&path, "mine").unwrap();
        assert!(Endpoint::start(&Address::Unix(path.clone()), Arc::default()).is_err());
        assert_eq!(std::fs::read_to_string(&path).unwrap(), "mine");
    }
}
