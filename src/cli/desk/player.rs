//! Plays frames onto a bus, or just in their own time.

use std::time::{Duration, Instant};

use tokio::runtime::Runtime;
use tokio::time::timeout;

use super::Failure;
use bus::Config;
use bus::can::{Event, Frame, InterfaceName, SendError, SocketCan, SocketCanConfig};
use physics::Micros;

/// Waits for each frame's time, and sends it if there is an interface.
pub struct Player {
    speed: Option<f64>,
    start: Option<(Instant, Micros)>,
    bus: Option<LiveBus>,
    refused: u64,
}

/// However a replay ends, it says what the bus did not take.
impl Drop for Player {
    fn drop(&mut self) {
        if self.refused > 0 {
            tracing::warn!("{} frames were not sent", self.refused);
        }
    }
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
    #[inline]
    pub fn play(&mut self, frame: &Frame) {
        if let Some(speed) = self.speed {
            self.wait_for(frame.time, speed);
        }
        self.send(frame);
    }

    /// Sends a frame now. Frames that a real bus does not take from a program are left out.
    #[inline]
    pub fn send(&mut self, frame: &Frame) {
        if let Some(bus) = &mut self.bus
            && let Err(error) = bus.send(frame, Self::PATIENCE)
        {
            self.refuse(&error);
        }
    }

    fn refuse(&mut self, error: &SendError) {
        self.refused += 1;
        if self.refused.is_power_of_two() {
            tracing::warn!("{error} ({} frames not sent so far)", self.refused);
        }
    }

    fn wait_for(&mut self, time: Micros, speed: f64) {
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
    /// Longest look for an interface that was lost on the way.
    const LOOK: Duration = Duration::from_millis(1);

    fn open(name: &str, fd: bool) -> Result<Self, Failure> {
        let runtime =
            tokio::runtime::Builder::new_current_thread().enable_all().build().map_err(Failure::work)?;
        let interface: InterfaceName = name.parse().map_err(Failure::usage)?;
        let guard = runtime.enter();
        // Nothing is to be received here: an empty list of identifiers filters everything out.
        let config = SocketCanConfig { fd, ids: Some(Vec::new()), ..SocketCanConfig::new(interface) };
        let mut socket = SocketCan::open(config).map_err(Failure::work)?;
        drop(guard);
        // The service would wait for it; who plays a recording wants to know at once.
        match runtime.block_on(socket.recv()) {
            Event::Gone => Err(Failure::work(format_args!("there is no interface {name}"))),
            Event::Down => {
                Err(Failure::work(format_args!("{name} is down; bring it up: `ip link set {name} up`")))
            }
            _ => Ok(Self { runtime, socket }),
        }
    }

    fn send(&mut self, frame: &Frame, patience: Duration) -> Result<(), SendError> {
        let begun = Instant::now();
        let Self { runtime, socket } = self;
        loop {
            match socket.try_send(frame) {
                Ok(()) | Err(SendError::ErrorFrame) => return Ok(()),
                Err(SendError::Busy) if begun.elapsed() < patience => {
                    std::thread::sleep(Duration::from_micros(200));
                }
                Err(error) => {
                    if matches!(error, SendError::Down | SendError::Gone) {
                        // It notices only here that the interface is back.
                        let _ = runtime.block_on(async { timeout(Self::LOOK, socket.recv()).await });
                    }
                    return Err(error);
                }
            }
        }
    }
}
