//! One interface to a CAN bus, wherever it is.

use std::io;

use nix::errno::Errno;
use thiserror::Error;

use physics::Micros;

use super::{CanId, ErrorReport, Frame, InterfaceName, MemoryBus, SocketCan};

/// What comes from a bus: frames, and everything that can happen to it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Event {
    /// A frame was received.
    Frame(Frame),
    /// The controller reports an error.
    Error(ErrorReport),
    /// So many frames were lost since the last frame because we read too slowly.
    Dropped(u32),
    /// The interface is up. The first event of a bus is its state: this, [`Event::Down`] or [`Event::Gone`].
    Up,
    /// The interface is there, but down.
    Down,
    /// There is no such interface (any more, or yet); it is waited for.
    Gone,
}

/// What of a bus can be changed while it is open.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Reception {
    /// Identifiers to receive; `None`: all.
    pub ids: Option<Vec<CanId>>,
    /// May FD frames be sent?
    pub fd: bool,
    /// Receive buffer in bytes; `None`: as it is.
    pub receive_buffer: Option<usize>,
}

/// A bus that cannot be opened however long one waits.
#[derive(Debug, Error)]
pub enum OpenError {
    /// Linux allows no such name.
    #[error("`{0}` cannot be the name of an interface (1 to 15 characters, no space, `/` or `:`)")]
    BadName(String),
    /// The kernel knows no CAN.
    #[error("this kernel has no CAN support; try `modprobe can_raw`, or a kernel with CONFIG_CAN_RAW")]
    NoCanSupport,
    /// Not a CAN interface.
    #[error("{0} is not a CAN interface; `ip -details link show type can` (or vcan) lists those there are")]
    NotCan(InterfaceName),
    /// The kernel refuses something.
    #[error("{interface}: cannot {step}: {source}")]
    Refused {
        /// The interface.
        interface: InterfaceName,
        /// What was tried.
        step: &'static str,
        /// What the kernel says.
        source: io::Error,
    },
}

/// A frame that could not be sent. Nothing was queued; the caller decides whether to try again.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
pub enum SendError {
    /// The queue is full (`ENOBUFS`): the bus is overloaded, or no other node acknowledges.
    #[error(
        "the send queue is full: the bus is overloaded, or nothing acknowledges; \
         a longer queue: `ip link set {{interface}} txqueuelen 1000`"
    )]
    Busy,
    /// The interface is down.
    #[error("the interface is down")]
    Down,
    /// The interface does not exist.
    #[error("the interface does not exist")]
    Gone,
    /// An FD frame, but FD is off or the interface cannot.
    #[error(
        "FD frames cannot be sent here: `fd = true` is missing in [bus], or the interface is not FD (mtu 72)"
    )]
    NoFd,
    /// An error frame: controllers make these, programs do not send them.
    #[error("error frames cannot be sent")]
    ErrorFrame,
    /// Anything else the kernel refuses.
    #[error("the kernel refuses the frame: {0}")]
    Refused(Errno),
}

/// A CAN bus: a real (or virtual) one of the kernel, or one in memory.
///
/// Recordings are read with [`candump::Reader`](super::candump::Reader), not waited for.
#[derive(Debug)]
pub enum Bus {
    /// An interface of the kernel.
    SocketCan(Box<SocketCan>),
    /// A pipe within the process.
    Memory(MemoryBus),
}

impl Bus {
    /// The next thing that happens. Waits as long as nothing does; never fails.
    ///
    /// Cancel-safe: dropping the future loses nothing, so it can stand in `tokio::select!`.
    pub async fn recv(&mut self) -> Event {
        match self {
            Bus::SocketCan(socket) => socket.recv().await,
            Bus::Memory(memory) => memory.recv().await,
        }
    }

    /// Sends a frame (its time does not matter) or says at once why not.
    ///
    /// A frame sent here never comes back through [`Bus::recv`] of the same bus, while all others on
    /// the interface see it.
    ///
    /// # Errors
    /// If the frame was not taken; nothing is queued then.
    pub fn try_send(&mut self, frame: &Frame) -> Result<(), SendError> {
        match self {
            Bus::SocketCan(socket) => socket.try_send(frame),
            Bus::Memory(memory) => memory.try_send(frame),
        }
    }

    /// Lets go of an interface that has another name now: to be called before each round of frames that belong on the
    /// interface of that name and on no other.
    pub fn stay_with_the_name(&mut self) {
        if let Bus::SocketCan(socket) = self {
            socket.stay_with_the_name();
        }
    }

    /// How late it is on the clock that the frames of this bus are stamped by; `None` where there is no such clock
    /// (frames in memory keep the time that their sender gave them). Steps of the system's clock do not show.
    pub fn now(&self) -> Option<Micros> {
        match self {
            Bus::SocketCan(socket) => socket.now(),
            Bus::Memory(_) => None,
        }
    }

    /// Receives something else from now on. No frame is lost that was wanted before and still is; what was
    /// received and not yet read may be of what is not wanted any more. A bus in memory filters nothing.
    ///
    /// # Errors
    /// If the kernel refuses the filters; then everything is as before.
    pub fn retune(&mut self, reception: Reception) -> io::Result<()> {
        match self {
            Bus::SocketCan(socket) => socket.retune(reception),
            Bus::Memory(_) => Ok(()),
        }
    }
}

impl From<SocketCan> for Bus {
    fn from(socket: SocketCan) -> Self {
        Bus::SocketCan(Box::new(socket))
    }
}

impl From<MemoryBus> for Bus {
    fn from(memory: MemoryBus) -> Self {
        Bus::Memory(memory)
    }
}
