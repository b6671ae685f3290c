//! The SocketCAN bus on a real (virtual) interface, on good days and bad.
//!
//! Each test makes an interface of its own. Where that is not allowed they say so and pass;
//! `tests/vcan/run.sh` is cargo's runner for a place where it is.

mod link;
mod traffic;

use std::future::Future;
use std::io::{BufRead, BufReader};
use std::pin::pin;
use std::process::{Child, Command, Stdio};
use std::time::Duration;

use gripd::Micros;
use gripd::can::candump::Reader;
use gripd::can::{
    BusState, CanId, ErrorClass, Event, Frame, FrameKind, OpenError, SendError, SocketCan, SocketCanConfig,
};
use testing::vcan::{Interface, PATIENCE, must, run};
use tokio::time::{sleep, timeout};

/// The bus on an interface.
trait OnIt {
    fn config(&self) -> SocketCanConfig;

    /// One that has already said that it is up.
    async fn bus(&self) -> SocketCan;

    async fn bus_with(&self, config: SocketCanConfig) -> SocketCan;
}

impl OnIt for Interface {
    fn config(&self) -> SocketCanConfig {
        SocketCanConfig { fd: true, ..SocketCanConfig::new(self.0.parse().unwrap()) }
    }

    async fn bus(&self) -> SocketCan {
        self.bus_with(self.config()).await
    }

    async fn bus_with(&self, config: SocketCanConfig) -> SocketCan {
        let mut bus = SocketCan::open(config).unwrap();
        assert_eq!(next(&mut bus).await, Event::Up);
        bus
    }
}

async fn next(bus: &mut SocketCan) -> Event {
    timeout(PATIENCE, bus.recv()).await.expect("nothing came")
}

/// The next frame's kind, identifier and data; anything else is a failure.
async fn next_frame(bus: &mut SocketCan) -> Frame {
    match next(bus).await {
        Event::Frame(frame) => frame,
        event => panic!("{event:?} instead of a frame"),
    }
}

/// Sends, even if the queue is full for a while.
async fn send(bus: &mut SocketCan, frame: Frame) {
    while let Err(error) = bus.try_send(&frame) {
        assert_eq!(error, SendError::Busy);
        sleep(Duration::from_millis(1)).await;
    }
}

fn standard(number: u32) -> CanId {
    CanId::standard(number).unwrap()
}

fn extended(number: u32) -> CanId {
    CanId::extended(number).unwrap()
}

fn data(id: CanId, bytes: &[u8]) -> Frame {
    Frame::data_frame(Micros(0), id, bytes).unwrap()
}

fn fd(bytes: &[u8]) -> Frame {
    let kind = FrameKind::Fd { bit_rate_switch: true, error_state: false };
    Frame::new(Micros(0), standard(0x200), kind, bytes).unwrap()
}

/// The same but for the time.
fn same(received: &Frame, sent: &Frame) -> bool {
    let mut received = *received;
    received.time = sent.time;
    received == *sent
}
