//! What the loop hears and speaks on.

use std::future::Future;
use std::io;

use super::Fresh;
use super::run::{input_reception, output_reception};
use crate::can::{Bus, Event, Frame, Reception, SendError};
use physics::Micros;

/// Something that frames come from and go to: a bus, or a stand-in with the same manners.
pub trait Link {
    /// The next thing that happens. Cancel-safe.
    fn recv(&mut self) -> impl Future<Output = Event>;
    /// Sends without waiting.
    ///
    /// # Errors
    /// If the frame could not be taken; it is then gone.
    fn try_send(&mut self, frame: &Frame) -> Result<(), SendError>;
    /// Before a round: is it still the bus that it should be?
    fn stay_with_the_name(&mut self) {}
    /// How late it is on the clock that its frames are stamped by; `None` if it has none. Only of a link with a clock
    /// can a round be too late, and only such a one has receivers that wait.
    fn now(&self) -> Option<Micros> {
        None
    }
    /// Receives something else from now on; one that hands on everything has nothing to do.
    ///
    /// # Errors
    /// If that cannot be; then everything is as before.
    fn retune(&mut self, _reception: Reception) -> io::Result<()> {
        Ok(())
    }
}

impl Link for Bus {
    fn recv(&mut self) -> impl Future<Output = Event> {
        Bus::recv(self)
    }

    fn try_send(&mut self, frame: &Frame) -> Result<(), SendError> {
        Bus::try_send(self, frame)
    }

    fn stay_with_the_name(&mut self) {
        Bus::stay_with_the_name(self);
    }

    fn now(&self) -> Option<Micros> {
        Bus::now(self)
    }

    fn retune(&mut self, reception: Reception) -> io::Result<()> {
        Bus::retune(self, reception)
    }
}

/// The next thing that happens on a link, if there is one.
pub(super) async fn next<L: Link>(link: &mut Option<L>) -> Event {
    match link {
        Some(link) => link.recv().await,
        None => std::future::pending().await,
    }
}

/// Filters and buffers of what the new configuration needs, before it takes over.
pub(super) fn retune<L: Link>(fresh: &Fresh, input: &mut L, output: Option<&mut L>) -> Result<(), String> {
    let refused = |error| format!("the kernel does not take the receive filters: {error}");
    let publishes = output.is_none();
    input.retune(input_reception(&fresh.config, &fresh.engine, publishes)).map_err(refused)?;
    let own = output_reception(&fresh.config, &fresh.engine);
    output.map_or(Ok(()), |output| output.retune(own)).map_err(refused)
}
