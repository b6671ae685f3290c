//! A raw CAN socket of the kernel: options, one receive, one send. Knows nothing of waiting.

use std::io::{self, IoSliceMut};
use std::os::fd::{AsFd, AsRawFd, RawFd};
use std::time::{SystemTime, UNIX_EPOCH};

use ::socketcan::{CanAddr, CanFdSocket, Socket as _, SocketOptions as _};
use nix::errno::Errno;
use nix::libc;
use nix::sys::socket::{
    AddressFamily, ControlMessageOwned, MsgFlags, SockFlag, SockProtocol, SockType, recvmsg, send,
    setsockopt, socket, sockopt,
};
use nix::sys::time::TimeSpec;

use super::wire::{self, EXTENDED};
use super::{CanId, Frame, InterfaceName, OpenError};
use physics::Micros;

/// More filters than the kernel takes on one socket (`CAN_RAW_FILTER_MAX`).
const MOST_FILTERS: usize = 512;

/// An open, bound, non-blocking socket.
#[derive(Debug)]
pub(super) struct RawSocket(CanFdSocket);

/// What [`RawSocket::receive`] needs; made once, so that receiving does not allocate.
#[derive(Debug)]
pub(super) struct Buffers {
    frame: [u8; wire::FD],
    control: Vec<u8>,
}

impl Buffers {
    pub(super) fn new() -> Self {
        Self { frame: [0; wire::FD], control: nix::cmsg_space!(TimeSpec, u32) }
    }
}

/// One message from the kernel.
#[derive(Debug)]
pub(super) struct Received {
    /// The frame; `None` if it was not one that a bus can carry.
    pub frame: Option<Frame>,
    /// How many frames the kernel has dropped since the socket was opened, where it says so.
    pub drops: Option<u32>,
}

impl RawSocket {
    /// Opens and binds a socket. Options are set before binding, so nothing unwanted is ever queued.
    pub(super) fn open(
        interface: InterfaceName,
        index: u32,
        ids: Option<&[CanId]>,
        receive_buffer: Option<usize>,
    ) -> Result<Self, OpenError> {
        let refused = |step| move |source: io::Error| OpenError::Refused { interface, step, source };
        let socket = create().map_err(|errno| match errno {
            Errno::EAFNOSUPPORT | Errno::EPROTONOSUPPORT => OpenError::NoCanSupport,
            _ => refused("open a CAN socket")(errno.into()),
        })?;
        socket
            .set_socket_option_int(libc::SOL_CAN_RAW, libc::CAN_RAW_FD_FRAMES, 1)
            .map_err(refused("receive FD frames"))?;
        set_filters(&socket, ids).map_err(refused("set the receive filters"))?;
        socket.set_error_filter_accept_all().map_err(refused("listen to error frames"))?;
        setsockopt(&socket, sockopt::ReceiveTimestampns, &true)
            .map_err(|errno| refused("switch receive time stamps on")(errno.into()))?;
        setsockopt(&socket, sockopt::RxqOvfl, &1)
            .map_err(|errno| refused("count dropped frames")(errno.into()))?;
        set_receive_buffer(&socket, receive_buffer);
        match socket.as_raw_socket().bind(&CanAddr::new(index).into()) {
            Ok(()) => Ok(Self(socket)),
            Err(error) => Err(refused("bind to the interface")(error)),
        }
    }

    /// The kernel can do CAN at all.
    pub(super) fn check_support(interface: InterfaceName) -> Result<(), OpenError> {
        match create() {
            Ok(_) => Ok(()),
            Err(Errno::EAFNOSUPPORT | Errno::EPROTONOSUPPORT) => Err(OpenError::NoCanSupport),
            Err(errno) => {
                Err(OpenError::Refused { interface, step: "open a CAN socket", source: errno.into() })
            }
        }
    }

    /// Other filters and another buffer on the open socket. The kernel sets up the new filters before it
    /// takes the old ones away, and leaves the queue alone: nothing is lost that both let through.
    pub(super) fn retune(&self, ids: Option<&[CanId]>, receive_buffer: Option<usize>) -> io::Result<()> {
        set_filters(&self.0, ids)?;
        set_receive_buffer(&self.0, receive_buffer);
        Ok(())
    }

    /// Takes one message, without waiting.
    pub(super) fn receive(&self, buffers: &mut Buffers) -> Result<Received, Errno> {
        let mut parts = [IoSliceMut::new(&mut buffers.frame)];
        let message =
            recvmsg::<()>(self.as_raw_fd(), &mut parts, Some(&mut buffers.control), MsgFlags::MSG_DONTWAIT)?;
        let (mut time, mut drops) = (None, None);
        for control in message.cmsgs()? {
            match control {
                ControlMessageOwned::ScmTimestampns(stamp) => time = Some(micros(stamp)),
                ControlMessageOwned::RxqOvfl(count) => drops = Some(count),
                _ => {}
            }
        }
        let size = message.bytes;
        let frame = buffers.frame.get(..size).and_then(|b| wire::decode(b, time.unwrap_or_else(now)));
        Ok(Received { frame, drops })
    }

    /// Hands one frame to the kernel, without waiting.
    pub(super) fn send(&self, frame: &Frame) -> Result<(), Errno> {
        let (bytes, size) = wire::encode(frame);
        send(self.as_raw_fd(), &bytes[..size], MsgFlags::MSG_DONTWAIT).map(|_| ())
    }

    /// Bytes the kernel really gives to the receive queue.
    pub(super) fn receive_buffer(&self) -> Option<usize> {
        nix::sys::socket::getsockopt(&self.0.as_fd(), sockopt::RcvBuf).ok()
    }
}

impl AsRawFd for RawSocket {
    fn as_raw_fd(&self) -> RawFd {
        self.0.as_raw_fd()
    }
}

fn create() -> Result<CanFdSocket, Errno> {
    let flags = SockFlag::SOCK_NONBLOCK | SockFlag::SOCK_CLOEXEC;
    socket(AddressFamily::Can, SockType::Raw, flags, SockProtocol::CanRaw).map(CanFdSocket::from)
}

/// Beyond net.core.rmem_max only with CAP_NET_ADMIN; else as much as is allowed. A smaller buffer is no
/// reason to fail: lost frames are counted.
fn set_receive_buffer(socket: &CanFdSocket, bytes: Option<usize>) {
    if let Some(bytes) = bytes
        && setsockopt(socket, sockopt::RcvBufForce, &bytes).is_err()
    {
        let _ = setsockopt(socket, sockopt::RcvBuf, &bytes);
    }
}

/// Lets exactly these identifiers through, data frames and remote requests alike: a request where
/// data are expected is a fault that is to be seen. `None`: everything.
fn set_filters(socket: &CanFdSocket, ids: Option<&[CanId]>) -> io::Result<()> {
    match ids {
        // Too many for the kernel: better everything than not all of them.
        Some(ids) if ids.len() <= MOST_FILTERS => {
            let filters: Vec<(u32, u32)> = ids.iter().map(|id| filter(*id)).collect();
            if filters.is_empty() { socket.set_filter_drop_all() } else { socket.set_filters(&filters) }
        }
        _ => socket.set_filter_accept_all(),
    }
}

/// Identifier and mask. The mask holds the mark of an extended identifier, so that a standard and an
/// extended one of the same number are told apart, but not the mark of a remote request.
fn filter(id: CanId) -> (u32, u32) {
    let number = if id.is_extended() { CanId::MAX_EXTENDED } else { CanId::MAX_STANDARD };
    (wire::kernel_id(id), number | EXTENDED)
}

/// Cut to whole microseconds, not rounded: so does candump, and live and recorded time must agree.
fn micros(stamp: TimeSpec) -> Micros {
    let seconds = i128::from(stamp.tv_sec()) * i128::from(Micros::PER_SECOND);
    Micros((seconds + i128::from(stamp.tv_nsec()) / 1000) as i64)
}

/// Only for a kernel that does not stamp, which there is none of: what it would have done.
#[cold]
fn now() -> Micros {
    let since = SystemTime::now().duration_since(UNIX_EPOCH).unwrap_or_default();
    Micros(i64::try_from(since.as_micros()).unwrap_or(i64::MAX))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn filters_keep_standard_and_extended_apart_but_let_requests_through() {
        let passes = |filter: (u32, u32), id: u32| id & filter.1 == filter.0 & filter.1;
        let standard = filter(CanId::standard(0x123).unwrap());
        let extended = filter(CanId::extended(0x123).unwrap());
        assert!(passes(standard, 0x123) && passes(standard, 0x123 | wire::REMOTE));
        assert!(!passes(standard, 0x123 | EXTENDED) && !passes(standard, 0x124));
        assert!(passes(extended, 0x123 | EXTENDED) && !passes(extended, 0x123));
        assert!(!passes(extended, 0x10123 | EXTENDED));
    }

    #[test]
    fn stamps_are_cut_not_rounded() {
        assert_eq!(micros(TimeSpec::new(1_760_000_000, 584_999)), Micros(1_760_000_000_000_584));
    }
}
