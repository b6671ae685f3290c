//! Others on the bus: a car that sends, a candump that records.

use std::io::{BufRead, BufReader, Cursor};
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use gripd::Micros;
use gripd::can::candump::{Reader, Writer};
use gripd::can::{Event, Frame, SendError, SocketCan, SocketCanConfig};

use super::{data, is_published, wait_for};

/// Sends a recording's frames in their own time, over and over; survives everything that happens to
/// the interface.
pub struct Traffic {
    stop: Arc<AtomicBool>,
    thread: Option<JoinHandle<()>>,
}

impl Traffic {
    pub fn start(interface: &str, frames: Vec<Frame>) -> Self {
        let stop = Arc::new(AtomicBool::new(false));
        let stopped = Arc::clone(&stop);
        let config = SocketCanConfig { ids: Some(Vec::new()), ..config(interface) };
        let thread = std::thread::spawn(move || {
            let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build().unwrap();
            runtime.block_on(async {
                let mut bus = SocketCan::open(config).unwrap();
                for frame in Repeated::new(&frames) {
                    let until = tokio::time::sleep_until(frame.0.into());
                    tokio::pin!(until);
                    // Listening for news is what brings a lost interface back.
                    while !stopped.load(Ordering::Relaxed) {
                        tokio::select! {
                            () = &mut until => break,
                            _ = bus.recv() => {}
                        }
                    }
                    if stopped.load(Ordering::Relaxed) {
                        return;
                    }
                    let _ = bus.try_send(frame.1);
                }
            });
        });
        Self { stop, thread: Some(thread) }
    }
}

impl Drop for Traffic {
    fn drop(&mut self) {
        self.stop.store(true, Ordering::Relaxed);
        let _ = self.thread.take().map(JoinHandle::join);
    }
}

/// Frames and when to send them, without end.
struct Repeated<'a> {
    frames: &'a [Frame],
    next: usize,
    begun: Instant,
}

impl<'a> Repeated<'a> {
    fn new(frames: &'a [Frame]) -> Self {
        Self { frames, next: 0, begun: Instant::now() }
    }
}

impl<'a> Iterator for Repeated<'a> {
    type Item = (Instant, &'a Frame);

    fn next(&mut self) -> Option<Self::Item> {
        if self.next == self.frames.len() {
            *self = Self::new(self.frames);
        }
        let frame = &self.frames[self.next];
        self.next += 1;
        let since = (frame.time - self.frames[0].time).seconds();
        Some((self.begun + Duration::from_secs_f64(since), frame))
    }
}

fn config(interface: &str) -> SocketCanConfig {
    SocketCanConfig { fd: true, ..SocketCanConfig::new(interface.parse().unwrap()) }
}

/// Sends frames at once, as a node of its own, and waits for a place in a full queue.
pub fn send_all(interface: &str, frames: &[Frame]) {
    let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build().unwrap();
    runtime.block_on(async {
        let mut bus =
            SocketCan::open(SocketCanConfig { ids: Some(Vec::new()), ..config(interface) }).unwrap();
        assert_eq!(bus.recv().await, Event::Up);
        for frame in frames {
            while let Err(error) = bus.try_send(frame) {
                assert_eq!(error, SendError::Busy);
                tokio::time::sleep(Duration::from_millis(1)).await;
            }
        }
    });
}

/// Sends a recording's frames once, in their own time.
pub fn play(interface: &str, recording: &[Frame]) {
    let begun = Instant::now();
    for round in recording.chunks(4) {
        let since = (round[0].time - recording[0].time).seconds();
        std::thread::sleep(Duration::from_secs_f64(since).saturating_sub(begun.elapsed()));
        send_all(interface, round);
    }
}

/// Sends frames as fast as the interface takes them, over and over.
pub struct Flood {
    stop: Arc<AtomicBool>,
    thread: Option<JoinHandle<()>>,
}

impl Flood {
    pub fn start(interface: &'static str, frames: Vec<Frame>) -> Self {
        let stop = Arc::new(AtomicBool::new(false));
        let stopped = Arc::clone(&stop);
        let thread = std::thread::spawn(move || {
            for some in frames.chunks(1000).cycle() {
                if stopped.load(Ordering::Relaxed) {
                    return;
                }
                send_all(interface, some);
            }
        });
        Self { stop, thread: Some(thread) }
    }
}

impl Drop for Flood {
    fn drop(&mut self) {
        self.stop.store(true, Ordering::Relaxed);
        let _ = self.thread.take().map(JoinHandle::join);
    }
}

/// A running `candump -L` and what it has written.
pub struct Recorder {
    child: Child,
    lines: Arc<Mutex<String>>,
}

impl Recorder {
    /// Starts it and makes sure it listens, by frames with the identifier 7FF.
    #[track_caller]
    pub fn start(interface: &str) -> Self {
        // A large receive buffer: it must not be the recorder that loses frames.
        let mut child = Command::new("candump")
            .args(["-L", "-d", "-D", "-r", "4000000", interface])
            .stdout(Stdio::piped())
            .spawn()
            .expect("candump is needed: apt-get install can-utils");
        let mut output = BufReader::new(child.stdout.take().unwrap());
        let lines = Arc::new(Mutex::new(String::new()));
        let recorded = Arc::clone(&lines);
        std::thread::spawn(move || {
            let mut line = String::new();
            while output.read_line(&mut line).is_ok_and(|length| length > 0) {
                recorded.lock().unwrap().push_str(&line);
                line.clear();
            }
        });
        let recorder = Self { child, lines };
        wait_for("candump's first line", || {
            send_all(interface, &[data(0x7FF, &[])]);
            !recorder.lines.lock().unwrap().is_empty()
        });
        recorder
    }

    /// What it has written so far.
    pub fn frames(&self) -> Vec<Frame> {
        let text = self.lines.lock().unwrap().clone();
        let mut reader = Reader::from_read(Box::new(Cursor::new(text)), "candump").unwrap();
        let frames = std::iter::from_fn(|| reader.next_frame().unwrap()).collect();
        assert_eq!((reader.stats().skipped_lines, reader.stats().dropped), (0, 0));
        frames
    }

    /// How many of them gripd publishes; without looking into them.
    pub fn published_count(&self) -> usize {
        self.lines.lock().unwrap().matches(" 6A0#").count()
    }

    /// Those of them that gripd publishes.
    pub fn published(&self) -> Vec<Frame> {
        self.frames().into_iter().filter(is_published).collect()
    }

    /// Waits until so many more frames were published than there are now.
    #[track_caller]
    pub fn wait_for_more(&self, count: usize, when: &str) {
        let before = self.published().len();
        wait_for(when, || self.published().len() >= before + count);
    }

    /// Ends it once nothing more comes from the car, and writes to a file what was on the bus until then.
    pub fn save(self, file: &Path) {
        let of_the_car = || self.frames().iter().filter(|frame| !is_published(frame)).count();
        let mut count = usize::MAX;
        wait_for("silence", || {
            std::thread::sleep(Duration::from_millis(300));
            let now = of_the_car();
            std::mem::replace(&mut count, now) == now
        });
        let all = self.frames();
        let mut writer = Writer::create(file, "car").unwrap();
        until_silence(&all).iter().for_each(|frame| writer.write(frame).unwrap());
        writer.finish().unwrap();
    }
}

/// What was on the bus until gripd takes it for silent, and goes on without input: of that no replay knows.
pub fn until_silence(all: &[Frame]) -> &[Frame] {
    let of_the_car = |frame: &Frame| !is_published(frame) && frame.id.number() < 0x6A0;
    let last = all.iter().rfind(|frame| of_the_car(frame)).map_or(Micros(0), |frame| frame.time);
    let end = all.iter().rposition(|frame| frame.time <= last + Micros::from_millis(150));
    &all[..end.map_or(0, |end| end + 1)]
}

impl Drop for Recorder {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}
