//! Where what is watched comes from: a live bus, or a recording.

use std::time::{SystemTime, UNIX_EPOCH};

use super::Playback;
use crate::can::{
    Bus, CanId, ErrorReport, Event, Frame, InterfaceName, OpenError, SocketCan, SocketCanConfig,
};
use crate::config::Config;
use physics::Micros;

/// State of an interface.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Link {
    /// Frames can come.
    Up,
    /// It is there, but down.
    Down,
    /// There is none of this name; it is waited for.
    Gone,
}

/// Something that happened.
#[derive(Clone, Debug, PartialEq)]
pub enum Happening {
    /// A frame came.
    Frame(Frame),
    /// The input interface came, went, or went down.
    Link(Link),
    /// The controller reports an error.
    Error(ErrorReport),
    /// So many frames were lost because we read too slowly.
    Dropped(u32),
    /// The recording is over.
    Over,
    /// The recording broke off, and why.
    Failed(String),
}

/// Frames, from wherever they come.
pub enum Source {
    /// From a bus.
    Live(Listener),
    /// From a recording.
    Recording(Box<Playback>),
}

impl Source {
    /// The next thing that happens. Cancel-safe. After [`Happening::Over`] and [`Happening::Failed`] nothing more.
    pub async fn next(&mut self) -> Happening {
        // However much comes: others of this thread have their turn, too.
        tokio::task::consume_budget().await;
        match self {
            Self::Live(listener) => listener.next().await,
            Self::Recording(playback) => playback.next().await,
        }
    }

    /// How late it is, in the frames' own time; `None` before the first frame of a recording.
    pub fn now(&self) -> Option<Micros> {
        match self {
            Self::Live(listener) => listener.input.now().or_else(|| {
                let since = SystemTime::now().duration_since(UNIX_EPOCH).ok()?;
                Some(Micros(i64::try_from(since.as_micros()).ok()?))
            }),
            Self::Recording(playback) => playback.now(),
        }
    }
}

/// Sockets that are only listened to: what could send is behind this, and not called.
pub struct Listener {
    input: Bus,
    /// Where gripd publishes, if that is another interface.
    published: Option<Bus>,
}

impl Listener {
    /// Listens to the interface for these identifiers, and to the one that is published on. They need not exist yet.
    ///
    /// Must be called within a tokio runtime that has I/O and time enabled.
    ///
    /// # Errors
    /// If a name cannot be one, the kernel has no CAN, or it refuses.
    pub fn open(config: &Config, interface: Option<&str>, ids: &[CanId]) -> Result<Self, OpenError> {
        let name = interface.unwrap_or(&config.bus.interface);
        let open = |name: &str| -> Result<Bus, OpenError> {
            let interface: InterfaceName = name.parse()?;
            let receive_buffer = Some(config.bus.receive_buffer_bytes).filter(|bytes| *bytes > 0);
            let ids = Some(ids.to_vec());
            // FD frames are received in any case; this is about sending them.
            Ok(SocketCan::open(SocketCanConfig { interface, ids, fd: false, receive_buffer })?.into())
        };
        let published = config.publish.interface.as_deref().filter(|other| *other != name);
        Ok(Self { input: open(name)?, published: published.map(open).transpose()? })
    }

    /// Listens to a bus that is there already.
    pub fn of(input: Bus) -> Self {
        Self { input, published: None }
    }

    async fn next(&mut self) -> Happening {
        loop {
            let published = async {
                match &mut self.published {
                    Some(bus) => bus.recv().await,
                    None => std::future::pending().await,
                }
            };
            tokio::select! {
                event = self.input.recv() => return match event {
                    Event::Frame(frame) => Happening::Frame(frame),
                    Event::Error(error) => Happening::Error(error),
                    Event::Dropped(count) => Happening::Dropped(count),
                    Event::Up => Happening::Link(Link::Up),
                    Event::Down => Happening::Link(Link::Down),
                    Event::Gone => Happening::Link(Link::Gone),
                },
                // That nothing comes from there is seen in the frames that are missing.
                event = published => if let Event::Frame(frame) = event {
                    return Happening::Frame(frame);
                },
            }
        }
    }
}
