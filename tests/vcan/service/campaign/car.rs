//! The car: sends its drive over and over, and can be told to do it wrongly.

use std::sync::{Arc, Mutex};

use gripd::can::{SocketCan, SocketCanConfig};
use gripd::signals::e2e;

use super::*;

/// What is wrong with a message.
#[derive(Clone, Copy, Debug)]
pub enum Wrong {
    /// It does not come.
    Missing,
    /// It comes twice.
    Twice,
    /// It is shorter.
    Short,
    /// A remote request comes in its place.
    Remote,
    /// All bits are set.
    Ones,
    /// It is always the same.
    Frozen,
    /// Its checksum is another one.
    Checksum,
    /// These two bytes have the other sign; a checksum is right.
    Reversed(usize),
}

/// What is wrong, and with which message; `None`: with all of them.
type Spoil = Option<(Option<u32>, Wrong)>;

pub struct Car {
    spoil: Arc<Mutex<Spoil>>,
    stop: Arc<Mutex<bool>>,
    thread: Option<std::thread::JoinHandle<()>>,
}

impl Car {
    pub const WHEELS: u32 = 0x1A0;
    pub const INERTIAL: u32 = 0x1B0;
    pub const STEERING: u32 = 0x1C0;
    pub const DRIVE: u32 = 0x1D0;

    pub fn start(interface: &str, drive: Vec<Frame>) -> Self {
        let (spoil, stop) = (Arc::new(Mutex::new(None)), Arc::new(Mutex::new(false)));
        let (spoiled, stopped) = (Arc::clone(&spoil), Arc::clone(&stop));
        let mut config = SocketCanConfig::new(interface.parse().unwrap());
        config.ids = Some(Vec::new());
        let thread = std::thread::spawn(move || {
            let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build().unwrap();
            runtime.block_on(async {
                let mut bus = SocketCan::open(config).unwrap();
                // The rolling counter goes on from one drive to the next.
                let mut counter = 0;
                let mut frozen = None;
                for round in 0.. {
                    let begun = Instant::now() - Duration::from_millis(u64::from(round > 0) * 10);
                    for frame in &drive {
                        let since = Duration::from_secs_f64((frame.time - drive[0].time).seconds());
                        let until = tokio::time::sleep_until((begun + since).into());
                        tokio::pin!(until);
                        // Listening for news is what brings a lost interface back.
                        while tokio::select! { () = &mut until => false, _ = bus.recv() => true } {}
                        if *stopped.lock().unwrap() {
                            return;
                        }
                        let counted = counted(frame, &mut counter);
                        let spoil = *spoiled.lock().unwrap();
                        for frame in spoiled_by(&counted, spoil, &mut frozen) {
                            let _ = bus.try_send(&frame);
                        }
                    }
                }
            });
        });
        Self { spoil, stop, thread: Some(thread) }
    }

    /// For so long.
    pub fn spoil(&self, id: Option<u32>, wrong: Wrong, lasts: Duration) {
        *self.spoil.lock().unwrap() = Some((id, wrong));
        std::thread::sleep(lasts);
        *self.spoil.lock().unwrap() = None;
    }
}

impl Drop for Car {
    fn drop(&mut self) {
        *self.stop.lock().unwrap() = true;
        let _ = self.thread.take().map(std::thread::JoinHandle::join);
    }
}

/// The frame with the next counter, where it has one.
fn counted(frame: &Frame, counter: &mut u8) -> Frame {
    if frame.id.number() != Car::INERTIAL {
        return *frame;
    }
    *counter = (*counter + 1) % 15;
    sealed(frame, |data| data[1] = data[1] & 0xF0 | *counter)
}

/// The frame with other bytes, and the checksum of these.
fn sealed(frame: &Frame, change: impl FnOnce(&mut [u8])) -> Frame {
    let mut data = frame.data().to_vec();
    change(&mut data);
    if frame.id.number() == Car::INERTIAL {
        data[0] = e2e::profile_1_crc(Car::INERTIAL as u16, &data, 0);
    }
    Frame::new(frame.time, frame.id, frame.kind, &data).unwrap()
}

fn spoiled_by(frame: &Frame, spoil: Spoil, frozen: &mut Option<Frame>) -> Vec<Frame> {
    let Some((id, wrong)) = spoil.filter(|(id, _)| id.is_none_or(|id| id == frame.id.number())) else {
        if spoil.is_none() {
            *frozen = None;
        }
        return vec![*frame];
    };
    let bytes = |data: &[u8]| vec![Frame::new(frame.time, frame.id, frame.kind, data).unwrap()];
    match wrong {
        Wrong::Missing => Vec::new(),
        Wrong::Twice => vec![*frame; 2],
        Wrong::Short => bytes(&frame.data()[..2]),
        Wrong::Remote => vec![Frame::remote(frame.time, frame.id, frame.length()).unwrap()],
        Wrong::Ones => bytes(&vec![0xFF; frame.length()]),
        Wrong::Frozen if id.is_some() => vec![*frozen.get_or_insert(*frame)],
        Wrong::Frozen => vec![*frame],
        Wrong::Checksum => {
            let mut data = frame.data().to_vec();
            data[0] ^= 0x55;
            bytes(&data)
        }
        Wrong::Reversed(place) => vec![sealed(frame, |data| {
            let value = i16::from_le_bytes([data[place], data[place + 1]]);
            data[place..place + 2].copy_from_slice(&value.saturating_neg().to_le_bytes());
        })],
    }
}
