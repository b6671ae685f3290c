//! Plays frames onto a bus, or just in their own time.

use std::time::{Duration, Instant};

use tokio::runtime::Runtime;

use super::Failure;
use crate::can::{Frame, InterfaceName, SendError, SocketCan, SocketCanConfig};
use crate::{Config, Micros};

/// Waits for each frame's time, and sends it if there is an interface.
pub struct Player {
    speed: Option<f64>,
    start: Option<(Instant, Micros)>,
    bus: Option<LiveBus>,
    refused: u64,
}

struct LiveBus {
    runtime: Runtime,
    socket: SocketCan,
}

impl Player {
    /// Longest a full send queue is waited for before a frame is given up.
    const PATIENCE: Duration = Duration::from_millis(200);
    /// A gap or a step of the recording's clock is played as at most this, s.
    const LONGEST_PAUSE: f64 = 5.0;

    /// At `speed` times real time if given; onto `interface`, in real time unless told otherwise.
    pub fn new(speed: Option<f64>, interface: Option<&str>, config: &Config) -> Result<Self, Failure> {
        let bus = interface.map(|name| LiveBus::open(name, config.bus.fd)).transpose()?;
        let speed = if bus.is_some() { Some(speed.unwrap_or(1.0)) } else { speed };
        Ok(Self { speed, start: None, bus, refused: 0 })
    }

    /// A frame of the recording.
    pub fn play(&mut self, frame: &Frame) {
        self.wait_for(frame.time);
        self.send(frame);
    }

    /// Sends a frame now. Frames that a real bus does not take from a program are left out.
    pub fn send(&mut self, frame: &Frame) {
        let Some(bus) = &mut self.bus else { return };
        let begun = Instant::now();
        let _guard = bus.runtime.enter();
        loop {
            match bus.socket.try_send(frame) {
                Ok(()) | Err(SendError::ErrorFrame) => return,
                Err(SendError::Busy) if begun.elapsed() < Self::PATIENCE => {
                    std::thread::sleep(Duration::from_micros(200));
                }
                Err(error) => {
                    self.refused += 1;
                    if self.refused.is_power_of_two() {
                        tracing::warn!("{error} ({} frames not sent so far)", self.refused);
                    }
                    return;
                }
            }
        }
    }

    fn wait_for(&mut self, time: Micros) {
        let Some(speed) = self.speed else { return };
        let now = Instant::now();
        let (begun, first) = *self.start.get_or_insert((now, time));
        let due = (time - first).seconds() / speed;
        let ahead = due - (now - begun).as_secs_f64();
        if (0.0..=Self::LONGEST_PAUSE).contains(&ahead) {
            std::thread::sleep(Duration::from_secs_f64(ahead));
        } else if !(-Self::LONGEST_PAUSE..=0.0).contains(&ahead) {
            self.start = Some((now, time));
        }
    }
}

impl LiveBus {
    fn open(name: &str, fd: bool) -> Result<Self, Failure> {
        let runtime =
            tokio::runtime::Builder::new_current_thread().enable_all().build().map_err(Failure::work)?;
        let interface: InterfaceName = name.parse().map_err(Failure::usage)?;
        let guard = runtime.enter();
        // Nothing is to be received here: an empty list of identifiers filters everything out.
        let config = SocketCanConfig { fd, ids: Some(Vec::new()), ..SocketCanConfig::new(interface) };
        let socket = SocketCan::open(config).map_err(Failure::work)?;
        drop(guard);
        Ok(Self { runtime, socket })
    }
}
