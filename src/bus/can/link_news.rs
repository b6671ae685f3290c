//! Word from the kernel that some network interface was changed: made, removed, renamed, set up or down.
//!
//! Only that there is news is taken from it, not what it says: whoever gets it looks the interface up anyway. So
//! nothing has to be parsed, and news that was lost in an overfull queue is news as well.

use std::os::fd::{AsRawFd, OwnedFd, RawFd};

use nix::errno::Errno;
use nix::libc;
use nix::sys::socket::{
    AddressFamily, MsgFlags, NetlinkAddr, SockFlag, SockProtocol, SockType, bind, recv, socket,
};
use tokio::io::Interest;
use tokio::io::unix::AsyncFd;

/// A socket of the kernel's group for links.
#[derive(Debug)]
pub(super) struct LinkNews(AsyncFd<Subscription>);

/// The socket itself, which stays the same as long as this lives.
#[derive(Debug)]
struct Subscription(OwnedFd);

impl AsRawFd for Subscription {
    fn as_raw_fd(&self) -> RawFd {
        self.0.as_raw_fd()
    }
}

impl LinkNews {
    /// Subscribes; `None` where the kernel does not allow it. Then a rename is found out when something is sent.
    pub(super) fn subscribe() -> Option<Self> {
        let subscription =
            open().inspect_err(|errno| tracing::debug!("no news of interfaces: {errno}")).ok()?;
        watch(subscription).inspect_err(|error| tracing::debug!("no news of interfaces: {error}")).ok()
    }

    /// Waits for news. Cancel-safe: news that was not waited for to its end is there the next time.
    pub(super) async fn next(&mut self) {
        loop {
            let Ok(mut ready) = self.0.readable().await else {
                // The runtime is shutting down.
                return std::future::pending().await;
            };
            let mut came = false;
            // All of it: one look answers it.
            let empty = loop {
                let mut message = [0; 8];
                match recv(ready.get_inner().as_raw_fd(), &mut message, MsgFlags::MSG_DONTWAIT) {
                    Ok(_) | Err(Errno::ENOBUFS) => came = true,
                    Err(Errno::EINTR) => {}
                    Err(errno) => break errno == Errno::EAGAIN,
                }
            };
            if empty {
                ready.clear_ready();
            }
            if came {
                return;
            }
            if !empty {
                // Nothing the kernel documents: there is no more to be heard here.
                return std::future::pending().await;
            }
        }
    }
}

fn open() -> Result<Subscription, Errno> {
    let flags = SockFlag::SOCK_NONBLOCK | SockFlag::SOCK_CLOEXEC;
    let socket = socket(AddressFamily::Netlink, SockType::Raw, flags, SockProtocol::NetlinkRoute)?;
    bind(socket.as_raw_fd(), &NetlinkAddr::new(0, libc::RTMGRP_LINK.cast_unsigned()))?;
    Ok(Subscription(socket))
}

#[allow(
    deprecated,
    reason = "its successor is an `unsafe fn`, because it cannot know that `as_raw_fd` always gives the same \
              open descriptor; that of `Subscription`, which owns its socket, does"
)]
fn watch(subscription: Subscription) -> std::io::Result<LinkNews> {
    AsyncFd::with_interest(subscription, Interest::READABLE).map(LinkNews)
}
