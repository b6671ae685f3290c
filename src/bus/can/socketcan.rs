//! A CAN interface of the kernel, on good days and bad: it may be down, vanish, and come back.
//!
//! What the kernel does, and what follows from it:
//! - *Down*: one read gets `ENETDOWN`, then what was queued before, then silence; once up again the same
//!   socket works. So while down, the interface is asked from time to time; a frame does not say "up",
//!   for it may be one of the queue.
//! - *Removed*: one read gets `ENODEV`; the socket is dead for good, even when an interface of the same
//!   name is created again. So it is closed, and the name looked up until it is back.
//! - Both wake a waiting reader by an error condition only, not by readability: we wait for both.
//! - *The clock is set*: the kernel's stamps jump; what is given out does not ([`SteadyClock`]).
//! - A send can get (and thereby clear) the error that was meant for the reader: it tells the reader.
//! - *Renamed*: the socket stays with the interface, whatever it is called then, and the name may be another
//!   interface's at once. It is the name that was asked for (two adapters may come up the other way round), so the
//!   name's index is compared whenever the kernel has news of its links, and before each round that is sent.

use std::io;
use std::time::Duration;

use nix::errno::Errno;
use tokio::io::Interest;
use tokio::io::unix::AsyncFd;
use tokio::task::coop;
use tokio::time::{Instant, sleep_until};

use physics::Micros;

use super::clock::SteadyClock;
use super::link_news::LinkNews;
use super::raw_socket::{Buffers, RawSocket, Received};
use super::{CanId, ErrorReport, Event, Frame, FrameKind, InterfaceName, OpenError, Reception, SendError};

/// While down: how often to look whether the interface is up.
const LOOK_WHILE_DOWN: Duration = Duration::from_millis(100);
/// While gone: the first and the longest pause between looking for the interface; doubles in between.
const FIRST_PAUSE: Duration = Duration::from_millis(50);
const LONGEST_PAUSE: Duration = Duration::from_secs(1);

/// `CAN_MTU`: longest message of an interface without FD.
const CLASSIC_MTU: u32 = 16;

/// What is wanted of an interface.
#[derive(Clone, Debug)]
pub struct SocketCanConfig {
    /// Its name. It need not exist yet.
    pub interface: InterfaceName,
    /// Identifiers to receive, filtered by the kernel; `None`: all. Remote requests with these
    /// identifiers come too, and error frames always.
    pub ids: Option<Vec<CanId>>,
    /// May FD frames be sent? They are received in any case.
    pub fd: bool,
    /// Receive buffer in bytes; `None`: the system's default (about 200 KiB, some 270 frames).
    pub receive_buffer: Option<usize>,
}

impl SocketCanConfig {
    /// All identifiers, no FD, and a buffer for about a second of a full bus.
    pub fn new(interface: InterfaceName) -> Self {
        Self { interface, ids: None, fd: false, receive_buffer: Some(4 << 20) }
    }
}

/// An interface that is received from and sent to, through one socket.
///
/// One socket for both is what keeps own frames from coming back: the kernel shows a sent frame to
/// every socket on the interface (so candump sees it) except the one it was sent from. A second socket
/// of this process on the same interface would see it.
#[derive(Debug)]
pub struct SocketCan {
    config: SocketCanConfig,
    /// `None` while the interface is gone.
    socket: Option<AsyncFd<RawSocket>>,
    /// The interface that the socket is bound to.
    index: u32,
    /// `None` where the kernel does not tell.
    news: Option<LinkNews>,
    buffers: Buffers,
    clock: SteadyClock,
    /// State of the interface as far as we know, and as far as the caller knows.
    link: Link,
    told: Option<Link>,
    /// A frame that came with word of losses, to be delivered after it.
    held: Option<Frame>,
    /// Drop counter of the socket at the last message.
    drops: u32,
    pause: Duration,
    /// Why the interface could not be opened last.
    complaint: Option<String>,
    /// When to look for an interface that is down or gone. A point in time and not a pause begun anew by
    /// each `recv`: where another branch of a `select!` keeps winning, that pause would never end.
    next_look: Instant,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Link {
    Up,
    Down,
    Gone,
}

impl SocketCan {
    /// Opens an interface, or begins to wait for one that is not there.
    ///
    /// Must be called within a tokio runtime that has I/O and time enabled.
    ///
    /// # Errors
    /// If the kernel has no CAN, the interface is of another kind, or the kernel refuses.
    pub fn open(config: SocketCanConfig) -> Result<Self, OpenError> {
        RawSocket::check_support(config.interface)?;
        let mut bus = Self {
            config,
            socket: None,
            index: 0,
            news: LinkNews::subscribe(),
            buffers: Buffers::new(),
            clock: SteadyClock::start(),
            link: Link::Gone,
            told: None,
            held: None,
            drops: 0,
            pause: FIRST_PAUSE,
            complaint: None,
            next_look: Instant::now(),
        };
        bus.connect()?;
        Ok(bus)
    }

    /// The interface's name.
    pub fn interface(&self) -> InterfaceName {
        self.config.interface
    }

    /// Bytes the kernel really gives to the receive queue (it counts its own overhead, and doubles what
    /// was asked for); `None` while the interface is gone.
    pub fn receive_buffer(&self) -> Option<usize> {
        self.socket.as_ref().and_then(|socket| socket.get_ref().receive_buffer())
    }

    /// As [`Bus::now`](super::Bus::now).
    pub fn now(&self) -> Option<Micros> {
        self.clock.now()
    }

    /// As [`Bus::retune`](super::Bus::retune).
    ///
    /// # Errors
    /// If the kernel refuses the filters.
    pub fn retune(&mut self, reception: Reception) -> io::Result<()> {
        let Reception { ids, fd, receive_buffer } = reception;
        if let Some(socket) = &self.socket {
            socket.get_ref().retune(ids.as_deref(), receive_buffer)?;
        }
        self.config = SocketCanConfig { ids, fd, receive_buffer, ..self.config };
        Ok(())
    }

    /// As [`Bus::recv`](super::Bus::recv): cancel-safe, never fails, allocates nothing while all is well.
    pub async fn recv(&mut self) -> Event {
        loop {
            if self.told != Some(self.link) {
                self.told = Some(self.link);
                return match self.link {
                    Link::Up => Event::Up,
                    Link::Down => Event::Down,
                    Link::Gone => Event::Gone,
                };
            }
            if let Some(frame) = self.held.take() {
                return event_of(frame);
            }
            let Some(socket) = &self.socket else {
                self.wait_for_interface().await;
                continue;
            };
            let is_up = self.link == Link::Up;
            let received = tokio::select! {
                biased;
                // First: what else is there to be read may be another bus's.
                () = next(&mut self.news) => {
                    self.stay_with_the_name();
                    continue;
                }
                received = receive(socket, &mut self.buffers) => received,
                () = sleep_until(self.next_look), if !is_up => {
                    self.look_again();
                    continue;
                }
            };
            match received {
                Ok(received) => {
                    if let Some(event) = self.accept(received) {
                        return event;
                    }
                }
                Err(errno) => self.lost(errno),
            }
        }
    }

    /// As [`Bus::try_send`](super::Bus::try_send).
    ///
    /// # Errors
    /// If the kernel did not take the frame.
    pub fn try_send(&mut self, frame: &Frame) -> Result<(), SendError> {
        match frame.kind {
            FrameKind::Error => return Err(SendError::ErrorFrame),
            FrameKind::Fd { .. } if !self.config.fd => return Err(SendError::NoFd),
            _ => {}
        }
        let Some(socket) = &self.socket else { return Err(SendError::Gone) };
        socket.get_ref().send(frame).map_err(|errno| match errno {
            Errno::ENOBUFS | Errno::EAGAIN | Errno::ENOMEM | Errno::EINTR => SendError::Busy,
            Errno::ENETDOWN => {
                self.lost(errno);
                SendError::Down
            }
            Errno::ENXIO | Errno::ENODEV => {
                self.lost(errno);
                SendError::Gone
            }
            // What the kernel says to a frame that is longer than the interface's MTU.
            Errno::EINVAL | Errno::EMSGSIZE if frame.is_fd() => SendError::NoFd,
            errno => SendError::Refused(errno),
        })
    }

    /// News, if any, of one message from the kernel: losses first, for they came before the frame.
    fn accept(&mut self, received: Received) -> Option<Event> {
        // The counter stands in every message after the first loss, and wraps.
        let lost = received.drops.map_or(0, |drops| {
            let lost = drops.wrapping_sub(self.drops);
            self.drops = drops;
            lost
        });
        let frame = received.frame.map(|mut frame| {
            frame.time = self.clock.steady(frame.time);
            frame
        });
        if lost == 0 {
            return frame.map(event_of);
        }
        self.held = frame;
        Some(Event::Dropped(lost))
    }

    /// The interface reported an error.
    fn lost(&mut self, errno: Errno) {
        match errno {
            Errno::ENETDOWN => self.down(),
            Errno::ENODEV | Errno::ENXIO => self.disconnect(),
            _ => {
                // Nothing the kernel documents. Start afresh, with the usual pauses.
                tracing::warn!(interface = %self.config.interface, %errno, "CAN socket failed; reopening it");
                self.disconnect();
            }
        }
    }

    /// A sender may find this out many times: only the first counts, lest the look be put off again.
    fn down(&mut self) {
        if self.link != Link::Down {
            self.link = Link::Down;
            self.next_look = Instant::now() + LOOK_WHILE_DOWN;
        }
    }

    /// Lets go of an interface that has another name now. The one that has ours is looked for like one that was
    /// made anew.
    pub fn stay_with_the_name(&mut self) {
        if self.socket.is_some() && !self.config.interface.is_still(self.index) {
            self.disconnect();
        }
    }

    fn disconnect(&mut self) {
        self.socket = None;
        self.held = None;
        self.link = Link::Gone;
        self.drops = 0;
        self.pause = FIRST_PAUSE;
        self.next_look = Instant::now() + FIRST_PAUSE;
    }

    /// The link was down: is it up, and still the one of that name? That it is gone, the socket itself would have
    /// told.
    fn look_again(&mut self) {
        self.next_look = Instant::now() + LOOK_WHILE_DOWN;
        match self.config.interface.look_up() {
            Some(state) if state.index == self.index => {
                if state.is_up {
                    self.link = Link::Up;
                }
            }
            _ => self.disconnect(),
        }
    }

    /// One pause, then one look for an interface that is gone.
    async fn wait_for_interface(&mut self) {
        sleep_until(self.next_look).await;
        self.pause = (self.pause * 2).min(LONGEST_PAUSE);
        self.next_look = Instant::now() + self.pause;
        let error = self.connect().err().map(|error| error.to_string());
        // There is nothing else to do than to try again; that is said once.
        if let Some(error) = error.as_ref().filter(|_| error != self.complaint) {
            tracing::warn!(error, "the CAN interface cannot be opened yet");
        }
        self.complaint = error;
    }

    /// Opens the socket if the interface is there.
    fn connect(&mut self) -> Result<(), OpenError> {
        let interface = self.config.interface;
        let Some(state) = interface.look_up().filter(|state| state.index != 0) else { return Ok(()) };
        if !state.is_can {
            return Err(OpenError::NotCan(interface));
        }
        let ids = self.config.ids.as_deref();
        let raw = match RawSocket::open(interface, state.index, ids, self.config.receive_buffer) {
            // Removed at this very moment.
            Err(OpenError::Refused { source, .. }) if is_gone(&source) => return Ok(()),
            result => result?,
        };
        // Renamed between the look and the binding.
        if !interface.is_still(state.index) {
            return Ok(());
        }
        let socket = watch(raw).map_err(|source| OpenError::Refused {
            interface,
            step: "watch the socket in this runtime",
            source,
        })?;
        if self.config.fd && interface.mtu(state.index) == Some(CLASSIC_MTU) {
            tracing::warn!(
                "`fd = true` in [bus], but {interface} carries no FD frames (mtu 16): `ip link set {interface} mtu 72` \
                 where it is virtual, else `ip link set {interface} type can dbitrate … fd on` while it is down"
            );
        }
        self.socket = Some(socket);
        self.index = state.index;
        self.link = if state.is_up { Link::Up } else { Link::Down };
        self.pause = FIRST_PAUSE;
        Ok(())
    }
}

async fn next(news: &mut Option<LinkNews>) {
    match news {
        Some(news) => news.next().await,
        None => std::future::pending().await,
    }
}

/// Readability and errors: of a link that goes down or vanishes, only the error wakes us.
#[allow(
    deprecated,
    reason = "its successor is an `unsafe fn`, because it cannot know that `as_raw_fd` always gives the same \
              open descriptor; that of `RawSocket`, which owns its socket, does"
)]
fn watch(socket: RawSocket) -> io::Result<AsyncFd<RawSocket>> {
    AsyncFd::with_interest(socket, Interest::READABLE | Interest::ERROR)
}

/// Waits for one message. Cancel-safe: between taking it and returning nothing is awaited.
async fn receive(socket: &AsyncFd<RawSocket>, buffers: &mut Buffers) -> Result<Received, Errno> {
    loop {
        // A bus that is never silent must not starve the runtime's other tasks.
        coop::consume_budget().await;
        let Ok(mut ready) = socket.ready(Interest::READABLE | Interest::ERROR).await else {
            // The runtime is shutting down.
            return std::future::pending().await;
        };
        let result = ready.try_io(|socket| match socket.get_ref().receive(buffers) {
            Err(Errno::EAGAIN) => Err(io::ErrorKind::WouldBlock.into()),
            result => Ok(result),
        });
        match result {
            Ok(Ok(Err(Errno::EINTR))) => {}
            Ok(Ok(result)) => return result,
            // Not ready after all; `try_io` has taken note of that.
            Ok(Err(_)) | Err(_) => {}
        }
    }
}

fn event_of(frame: Frame) -> Event {
    ErrorReport::from_frame(&frame).map_or(Event::Frame(frame), Event::Error)
}

fn is_gone(error: &io::Error) -> bool {
    [Errno::ENODEV, Errno::ENXIO].iter().any(|errno| error.raw_os_error() == Some(*errno as i32))
}
