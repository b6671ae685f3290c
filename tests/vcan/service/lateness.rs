//! How late the service answers: from the kernel's stamp of the frame that makes a round due to the kernel's stamp of
//! the round's first frame, beside a bare echo (one read, one write) in the same run.
//!
//! Every test run measures some seconds, and asserts nothing of how fast it is. The guide's table, in six minutes:
//!
//! ```text
//! CARGO_TARGET_X86_64_UNKNOWN_LINUX_GNU_RUNNER=$PWD/tests/vcan/run.sh VCAN_TIMEOUT=900 \
//!     cargo test --release --test vcan lateness::by_hand -- --ignored --nocapture --test-threads 1
//! ```

use std::process::Child;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::JoinHandle;

use nix::time::ClockId;
use nix::unistd::Pid;
use socketcan::{CanDataFrame, CanFilter, CanSocket, EmbeddedFrame, Id, Socket, SocketOptions, StandardId};

use super::log::Log;
use super::process::by_way_of;
use super::*;
use testing::setting::setting;

/// What the echo is asked on, and what it answers on.
const ASKED: u16 = 0x700;
const ANSWERED: u16 = 0x701;
/// Between two questions, as between two rounds.
const BETWEEN_QUESTIONS: Duration = Duration::from_millis(20);

/// The demo's drive, 20 s of it, its five frames (DRIVE comes twice) so often that it makes so many frames a second.
pub fn drive(frames_per_second: u32) -> Vec<Frame> {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR"));
    let period = format!("period_ms = {:?}", 5000.0 / f64::from(frames_per_second));
    let text = std::fs::read_to_string(project("config/scenarios/demo.toml")).unwrap();
    let text = text.replace("duration_s = 120.0", "duration_s = 20.0");
    let text = text.replace("period_ms = 10.0", &period).replace("period_ms = 20.0", &period);
    let [scenario, log] =
        ["toml", "log"].map(|ending| folder.join(format!("lateness_{frames_per_second}.{ending}")));
    std::fs::write(&scenario, text).unwrap();
    let mut simulate = Command::new(gripd());
    simulate.arg("simulate").arg(&scenario).arg("-o").arg(&log);
    assert!(simulate.status().unwrap().success());
    let frames = frames(&log);
    let rate = frames.len() as f64 / 20.0;
    assert!((rate / f64::from(frames_per_second) - 1.0).abs() < 0.01, "{rate} frames/s");
    frames
}

/// Sends a recording over and over, in its own time, and a question for the echo now and then.
pub struct Sender {
    stop: Arc<AtomicBool>,
    thread: JoinHandle<u64>,
}

impl Sender {
    pub fn start(interface: &'static str, recording: Vec<Frame>) -> Self {
        let stop = Arc::new(AtomicBool::new(false));
        let stopped = Arc::clone(&stop);
        let thread = std::thread::spawn(move || {
            let socket = CanSocket::open(interface).unwrap();
            socket.set_filter_drop_all().unwrap();
            let recording: Vec<(Duration, CanDataFrame)> = recording
                .iter()
                .map(|frame| {
                    let since = Duration::from_secs_f64((frame.time - recording[0].time).seconds());
                    let id = StandardId::new(frame.id.number() as u16).unwrap();
                    (since, CanDataFrame::new(id, frame.data()).unwrap())
                })
                .collect();
            let question = CanDataFrame::new(StandardId::new(ASKED).unwrap(), &[0; 8]).unwrap();
            let begun = Instant::now();
            let (mut sent, mut next, mut round, mut ask) = (0, 0, Duration::ZERO, Duration::ZERO);
            while !stopped.load(Ordering::Relaxed) {
                while round + recording[next].0 <= begun.elapsed() {
                    // A link that is down takes none; what it takes is counted.
                    sent += u64::from(socket.write_frame(&recording[next].1).is_ok());
                    next += 1;
                    if next == recording.len() {
                        round += recording[next - 1].0;
                        next = 0;
                    }
                }
                if ask <= begun.elapsed() {
                    let _ = socket.write_frame(&question);
                    ask = begun.elapsed() + BETWEEN_QUESTIONS;
                }
                std::thread::sleep(Duration::from_micros(500));
            }
            sent
        });
        Self { stop, thread }
    }

    /// Frames of the recording that the kernel took.
    pub fn stop(self) -> u64 {
        self.stop.store(true, Ordering::Relaxed);
        self.thread.join().unwrap()
    }
}

/// The echo, in a process of its own.
pub struct Echo(Child);

/// What wakes the echo.
#[derive(Clone, Copy, PartialEq)]
pub enum Wakes {
    /// Its question only: the kernel filters.
    Question,
    /// Every frame of the bus, as those that are needed wake the service.
    Everything,
}

impl Echo {
    pub fn start(interface: &str, wakes: Wakes, by: &[&str]) -> Self {
        let wakes = if wakes == Wakes::Question { "question" } else { "everything" };
        Self(process::again(by, "service::lateness::child::bare_echo", &[interface, wakes]))
    }
}

impl Drop for Echo {
    fn drop(&mut self) {
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

/// How late, in µs.
#[derive(Default)]
pub struct Lateness(Vec<i64>);

impl Lateness {
    pub fn count(&self) -> usize {
        self.0.len()
    }

    /// One row of the table.
    pub fn row(&mut self, name: &str) -> String {
        self.0.sort_unstable();
        let last = self.0.len() - 1;
        let at = |share: f64| self.0[(share * last as f64).round() as usize] as f64 / 1000.0;
        let [p50, p99, p999, most] = [0.5, 0.99, 0.999, 1.0].map(at);
        format!("| {name} | {} | {p50:.2} | {p99:.2} | {p999:.2} | {most:.1} |", self.0.len())
    }
}

/// What a recorded bus tells.
#[derive(Default)]
pub struct Heard {
    /// First frames of rounds; the last ones; answers of the echo.
    pub first: Lateness,
    pub last: Lateness,
    pub echo: Lateness,
    pub published: u64,
    missing: u64,
}

/// Compares what was published with a replay of the same bus: every payload must be the same, and what is missing is
/// what the service says that it could not send. Where links flap, status frames tell of it, and no recording does. A replay stamps what it publishes with the frame that made it due.
pub fn heard(log: &Path, config: &Path, unsent: u64, links_flap: bool) -> Heard {
    let replayed = log.with_extension("replayed.log");
    let mut replay = Command::new(gripd());
    replay.args(["replay", "-q", "-c"]).arg(config).arg(log).arg("-o").arg(&replayed);
    assert!(replay.status().unwrap().success());
    let mut again = Reader::open(&replayed).unwrap();
    let all = frames(log);
    let mut heard = Heard::default();
    let mut asked = None;
    // With a counter that is right, at least.
    let is_status = |frame: &Frame| links_flap && (0x6A5..=0x6A6).contains(&frame.id.number());
    let known = |frame: &Frame| if is_status(frame) { frame.data()[1] & 15 } else { 0 };
    let same = |live: &Frame, due: &Frame| {
        live.id == due.id && known(live) == known(due) && (is_status(live) || live.data() == due.data())
    };
    for &frame in traffic::until_silence(&all) {
        match frame.id.number() {
            number if number == u32::from(ASKED) => asked = Some(frame.time),
            number if number == u32::from(ANSWERED) => {
                heard.echo.0.extend(asked.take().map(|asked| (frame.time - asked).0));
            }
            number if is_published(&frame) => {
                let mut due = again.next_frame().unwrap().expect("a replay publishes as much");
                while !same(&frame, &due) {
                    heard.missing += 1;
                    assert!(heard.missing <= unsent, "{}: {frame:?}, not {due:?}", heard.published);
                    due = again.next_frame().unwrap().expect("a replay publishes as much");
                }
                let late = (frame.time - due.time).0;
                heard.published += 1;
                match number {
                    0x6A0 => heard.first.0.push(late),
                    0x6A5 => heard.last.0.push(late),
                    _ => {}
                }
            }
            _ => {}
        }
    }
    while again.next_frame().unwrap().is_some() {
        heard.missing += 1;
    }
    assert_eq!(heard.missing, unsent, "a replay publishes more");
    heard
}

/// Seconds of the processor and resident kibibytes of a process.
pub fn used_by(pid: u32) -> (f64, u64) {
    // Not from /proc, where ticks are counted: what begins with a tick hardly ever meets one.
    let clock = ClockId::pid_cpu_clock_id(Pid::from_raw(pid.cast_signed())).unwrap();
    let time = clock.now().unwrap();
    let status = std::fs::read_to_string(format!("/proc/{pid}/status")).unwrap();
    let resident = status.lines().find_map(|line| line.strip_prefix("VmRSS:")).unwrap();
    let resident = resident.split_whitespace().next().unwrap().parse().unwrap();
    (time.tv_sec() as f64 + 1e-9 * time.tv_nsec() as f64, resident)
}

/// How programs are scheduled: as `systemd/gripd.service` has it, or as `systemd/realtime.conf` does.
const AS_SHIPPED: &[&str] = &["nice", "-n", "-10"];
const REAL_TIME: &[&str] = &["chrt", "-f", "10"];

fn measure(interface: &Interface, frames_per_second: u32, seconds: u64, by: &[&str], wakes: Wakes) {
    let recording = drive(frames_per_second);
    let log = Log::start(interface.0);
    let gripd = Gripd::spawn_by(by_way_of(by, process::gripd()), &demo_car(), interface.0, &[]);
    let echo = Echo::start(interface.0, wakes, by);
    gripd.wait_for_log("the input interface is up");
    let sender = Sender::start(interface.0, recording);
    std::thread::sleep(Duration::from_secs(1));
    let [of_gripd, of_echo] = [gripd.id(), echo.0.id()].map(used_by);
    std::thread::sleep(Duration::from_secs(seconds));
    let [now, now_echo] = [gripd.id(), echo.0.id()].map(used_by);
    let sent = sender.stop();
    let file = log.end();
    let tally = gripd.end(SIGTERM);
    let mut heard = heard(&file, &demo_car(), (tally.unsent + tally.late) as u64, tally.late > 0);
    assert_eq!((tally.received + tally.dropped) as u64, sent, "{tally:?}");
    assert!(tally.published as u64 > heard.published && tally.unsent == 0, "{tally:?}");
    assert!(heard.first.count() as u64 > 20 * seconds && heard.echo.count() as u64 > 20 * seconds);
    let scheduled = by.join(" ");
    println!(
        "| {frames_per_second} frames/s {scheduled} | count | p50 | p99 | p99.9 | most, ms |\n|---|---|---|---|---|---|"
    );
    println!("{}", heard.first.row("first frame of a round"));
    println!("{}", heard.last.row("last frame of a round"));
    let name = if wakes == Wakes::Question { "bare echo" } else { "echo that every frame wakes" };
    println!("{}", heard.echo.row(name));
    let share = |before: f64, after: f64| 100.0 * (after - before) / seconds as f64;
    println!(
        "CPU {:.1} % and {:.1} MB for the daemon, {:.1} % for the echo (50 frames/s); {} of {sent} frames dropped",
        share(of_gripd.0, now.0),
        now.1 as f64 / 1024.0,
        share(of_echo.0, now_echo.0),
        tally.dropped
    );
}

#[test]
fn the_service_answers_as_its_replay_does_beside_an_echo() {
    let Some(interface) = Interface::new("gs_late") else { return };
    measure(&interface, 500, 4, AS_SHIPPED, Wakes::Question);
}

/// For people, by name: no run of all tests has the time.
mod by_hand {
    use super::*;

    #[test]
    #[ignore = "by hand: minutes"]
    fn lateness_at_500_and_2000_frames_a_second() {
        let Some(interface) = Interface::new("gs_later") else { return };
        let load = std::fs::read_to_string("/proc/loadavg").unwrap();
        println!("load average in the guest: {load}");
        let seconds = setting("GRIPD_LATENESS_S", 60);
        for (by, frames_per_second, wakes) in [
            (AS_SHIPPED, 500, Wakes::Question),
            (AS_SHIPPED, 2000, Wakes::Question),
            (AS_SHIPPED, 2000, Wakes::Everything),
            (REAL_TIME, 500, Wakes::Question),
            // Where every frame is waited for by somebody more urgent, the sender gets no further than this.
            (REAL_TIME, 1000, Wakes::Question),
        ] {
            measure(&interface, frames_per_second, seconds, by, wakes);
        }
    }
}

/// What tests start, in a process of its own.
mod child {
    use super::*;

    #[test]
    #[ignore = "child: started by the tests of lateness"]
    fn bare_echo() {
        let Some([interface, wakes]) = process::asked() else { return };
        let socket = CanSocket::open(&interface).unwrap();
        if wakes == "question" {
            socket.set_filters(&[CanFilter::new(ASKED.into(), 0x7FF)]).unwrap();
        }
        let [asked, answered] = [ASKED, ANSWERED].map(|id| Id::from(StandardId::new(id).unwrap()));
        loop {
            // Nothing but errors while the link is down.
            let Ok(question) = socket.read_frame() else { continue };
            if question.id() == asked {
                let _ = socket.write_frame(&CanDataFrame::new(answered, question.data()).unwrap());
            }
        }
    }
}
