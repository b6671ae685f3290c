//! A link that drives the simulated car through a bus, as fast as the service can take it.
//!
//! It has both ends of the bus: the car's and the service's. Each frame of the car really travels; only
//! its time of arrival is replaced by the simulated one. So a drive of minutes takes seconds, and what
//! is found does not depend on the machine's speed.

use std::path::Path;
use std::rc::Rc;
use std::time::{Duration, Instant};

use nix::ifaddrs::getifaddrs;
use nix::net::if_::InterfaceFlags;
use tokio::sync::Notify;

use super::drive::Drive;
use crate::cli::Failure;
use bus::can::candump::Writer;
use bus::can::{Bus, CanId, Event, Frame, InterfaceName, SendError, SocketCan, SocketCanConfig, memory_pair};
use bus::service::Link;

/// The interface that is used without asking, if it is there.
pub const USUAL: &str = "vcan0";

/// Both ends of one bus.
pub struct Ends {
    car: Bus,
    service: Bus,
}

impl Ends {
    /// Within the process.
    pub fn in_memory() -> Self {
        // The car listens to nobody: what the service sends is seen by its observer.
        let (car, service) = memory_pair(64);
        Self { car: car.into(), service: service.into() }
    }

    /// Two sockets on one interface.
    pub fn on_interface(name: &str, ids: &[CanId]) -> Result<Self, Failure> {
        let interface: InterfaceName = name.parse().map_err(Failure::usage)?;
        if is_real(name) {
            return Err(Failure::usage(format_args!(
                "{name} is a real CAN controller, and others may take the simulated drive for a car; \
                 make a virtual one: ip link add dev vcan0 type vcan && ip link set vcan0 up"
            )));
        }
        if !is_up(name) {
            return Err(Failure::usage(format_args!(
                "there is no interface {name} that is up; `ip link set {name} up`, or use --memory"
            )));
        }
        let open = |ids| {
            let config = SocketCanConfig { ids: Some(ids), ..SocketCanConfig::new(interface) };
            SocketCan::open(config).map(Bus::from).map_err(Failure::work)
        };
        Ok(Self { car: open(Vec::new())?, service: open(ids.to_vec())? })
    }
}

/// Is there an interface of this name, and is it up?
pub fn is_up(name: &str) -> bool {
    getifaddrs().is_ok_and(|mut interfaces| {
        interfaces.any(|i| i.interface_name == name && i.flags.contains(InterfaceFlags::IFF_UP))
    })
}

/// Does a device drive it? Virtual interfaces have none. (/sys may be of another network namespace;
/// what it does not know is taken for virtual, as it must have been made there by hand.)
pub fn is_real(name: &str) -> bool {
    Path::new("/sys/class/net").join(name).join("device").exists()
}

/// The service's link to the simulated car.
pub struct SimulatedTimeLink {
    ends: Ends,
    drive: Drive,
    /// To be sent by the car; sent, but not yet seen by the service. Kept here, so that receiving can
    /// be cancelled.
    leaving: Option<Frame>,
    travelling: Option<Frame>,
    log: Option<Writer>,
    lost: u64,
    lost_in_a_row: u32,
    failure: Option<Failure>,
    over: Rc<Notify>,
}

impl SimulatedTimeLink {
    /// A frame that has not arrived by then is lost. On a virtual bus they arrive at once.
    const PATIENCE: Duration = Duration::from_millis(500);
    /// So many lost frames in a row are no bus any more.
    const TOO_MANY: u32 = 10;

    /// The recording, if one is wanted, gets what travels in both directions.
    pub fn new(ends: Ends, drive: Drive, log: Option<Writer>) -> Self {
        Self {
            ends,
            drive,
            leaving: None,
            travelling: None,
            log,
            lost: 0,
            lost_in_a_row: 0,
            failure: None,
            over: Rc::new(Notify::new()),
        }
    }

    /// Completes when the drive is over.
    pub fn over(&self) -> impl Future<Output = ()> + use<> {
        let over = Rc::clone(&self.over);
        async move { over.notified().await }
    }

    /// The drive, and how many frames the bus lost.
    pub fn finish(self) -> Result<(Drive, u64), Failure> {
        if let Some(failure) = self.failure {
            return Err(failure);
        }
        if let Some(log) = self.log {
            log.finish().map_err(Failure::work)?;
        }
        Ok((self.drive, self.lost))
    }

    fn stop(&mut self, failure: Option<Failure>) {
        self.failure = self.failure.take().or(failure);
        self.over.notify_one();
    }

    fn record(&mut self, frame: &Frame) {
        if let Some(log) = &mut self.log
            && let Err(error) = log.write(frame)
        {
            self.stop(Some(Failure::work(error)));
        }
    }

    /// Sends the car's next frame. Safe to cancel. False if there is none any more.
    async fn send_next(&mut self) -> bool {
        let begun = Instant::now();
        loop {
            let Some(frame) = self.leaving.take().or_else(|| self.drive.next_frame()) else {
                self.stop(None);
                return false;
            };
            match self.ends.car.try_send(&frame) {
                Ok(()) => {
                    self.travelling = Some(frame);
                    self.record(&frame);
                    return true;
                }
                Err(SendError::Busy) if begun.elapsed() < Self::PATIENCE => {
                    self.leaving = Some(frame);
                    tokio::time::sleep(Duration::from_millis(1)).await;
                }
                Err(error) => {
                    self.stop(Some(Failure::work(format_args!("the simulated car cannot send: {error}"))));
                    return false;
                }
            }
        }
    }

    /// Waits until the travelling frame arrives. Frames of others with the same identifiers are not the
    /// car's and left out.
    async fn arrival(&mut self, frame: Frame) -> Event {
        let until = tokio::time::Instant::now() + Self::PATIENCE;
        loop {
            match tokio::time::timeout_at(until, self.ends.service.recv()).await {
                Ok(Event::Frame(came)) if came.id == frame.id && came.data() == frame.data() => {
                    self.travelling = None;
                    self.lost_in_a_row = 0;
                    return Event::Frame(frame);
                }
                Ok(Event::Frame(_)) => {}
                Ok(event) => return event,
                Err(_) => {
                    self.travelling = None;
                    self.lost += 1;
                    self.lost_in_a_row += 1;
                    if self.lost_in_a_row == Self::TOO_MANY {
                        self.stop(Some(Failure::work("the bus no longer carries the car's frames")));
                    }
                    return Event::Dropped(1);
                }
            }
        }
    }
}

impl Link for &mut SimulatedTimeLink {
    async fn recv(&mut self) -> Event {
        if self.travelling.is_none() && !self.send_next().await {
            return std::future::pending().await;
        }
        match self.travelling {
            Some(frame) => self.arrival(frame).await,
            None => std::future::pending().await,
        }
    }

    fn try_send(&mut self, frame: &Frame) -> Result<(), SendError> {
        self.ends.service.try_send(frame)?;
        self.record(frame);
        Ok(())
    }
}
