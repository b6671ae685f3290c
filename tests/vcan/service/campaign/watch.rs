//! Listens to both buses and compares: of which moment is what is published?

use std::collections::VecDeque;
use std::sync::{Arc, Mutex, MutexGuard};

use gripd::can::{Event, SocketCan, SocketCanConfig};
use testing::heard::{bits, is_not_available};

use super::*;

/// What was found so far.
#[derive(Default)]
struct Found {
    rounds: usize,
    compared: usize,
    /// While the bus had no gaps, and at all.
    oldest: [Micros; 2],
    burst: f64,
    problems: Vec<String>,
    /// Until then nothing is compared: the speed on the bus is none.
    not_before: Option<Instant>,
}

pub struct Watch {
    found: Arc<Mutex<Found>>,
}

/// A speed on the bus, and when it came.
type Speed = (Micros, f64);

impl Watch {
    /// Speeds are published in steps of 0.05 m/s, and those of the wheels are a little rough, m/s. At 3 m/s² that is an
    /// uncertainty of 50 ms.
    const SAME: f64 = 0.15;
    /// A round is due 20 to 30 ms after its sample, may be 100 ms late, and its speed is told to 50 ms.
    const OLDEST: Micros = Micros::from_millis(180);
    /// The time-out of speeds, and a little.
    const LONG_GAP: Micros = Micros::from_millis(250);
    /// Two cycles of the message with the speeds.
    const NO_GAP: Micros = Micros::from_millis(25);
    const LATELY: Micros = Micros::from_millis(1000);
    /// What is older is not looked for.
    const REMEMBERED: Micros = Micros::from_millis(6000);
    /// So long an input's frame may take until it is read here.
    const LATE: Micros = Micros::from_millis(300);
    /// Rounds at once: two by the service's own rule, and what the guest's only processor holds up between two programs.
    /// (Old rounds that are sent in addition come by the dozen.)
    const BURST: f64 = 4.0;

    pub fn start(input: &str, output: &str) -> Self {
        let found = Arc::new(Mutex::new(Found::default()));
        let watch = Self { found: Arc::clone(&found) };
        let of = |name: &str, ids: &[u32]| {
            let ids = ids.iter().map(|id| CanId::standard(*id).unwrap()).collect();
            SocketCanConfig { ids: Some(ids), ..SocketCanConfig::new(name.parse().unwrap()) }
        };
        let (input, output) = (of(input, &[Car::WHEELS]), of(output, &[0x6A0, 0x6A4]));
        // Until the end of the process: it has nothing to give back.
        std::thread::spawn(move || {
            let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build().unwrap();
            runtime.block_on(listen(input, output, &found));
        });
        watch
    }

    fn found(&self) -> MutexGuard<'_, Found> {
        self.found.lock().unwrap()
    }

    /// What is published is not compared while this lasts, nor for two seconds after it.
    pub fn without_comparing(&self, work: impl FnOnce()) {
        self.found().not_before = Some(Instant::now() + Duration::from_secs(3600));
        work();
        self.found().not_before = Some(Instant::now() + Duration::from_secs(2));
    }

    pub fn rounds(&self) -> usize {
        self.found().rounds
    }

    pub fn compared(&self) -> usize {
        self.found().compared
    }

    /// While the bus had no gaps, and at all.
    pub fn oldest_ms(&self) -> [f64; 2] {
        self.found().oldest.map(|age| 1e3 * age.seconds())
    }

    /// The most rounds at once, those that their cycle gives taken off.
    pub fn burst(&self) -> f64 {
        self.found().burst
    }

    pub fn problems(&self) -> Vec<String> {
        self.found().problems.clone()
    }

    #[track_caller]
    pub fn wait_for_rounds(&self, count: usize) {
        let before = self.rounds();
        wait_for("rounds", || self.rounds() >= before + count);
    }
}

async fn listen(input: SocketCanConfig, output: SocketCanConfig, found: &Mutex<Found>) {
    let (mut input, mut output) = (SocketCan::open(input).unwrap(), SocketCan::open(output).unwrap());
    let mut speeds = VecDeque::<Speed>::new();
    let mut published = VecDeque::<(Speed, bool)>::new();
    let (mut level, mut last) = (0.0_f64, Micros(0));
    loop {
        tokio::select! {
            event = input.recv() => if let Event::Frame(frame) = event
                && let Some(speed) = of_wheels(&frame)
            {
                speeds.push_back((frame.time, speed));
                while speeds.front().is_some_and(|(time, _)| frame.time - *time > Watch::REMEMBERED) {
                    speeds.pop_front();
                }
            },
            event = output.recv() => match event {
                // A stranger's is all zeros.
                Event::Frame(frame) if frame.id.number() == 0x6A0 && frame.data() != [0; 8] => {
                    let mut found = found.lock().unwrap();
                    found.rounds += 1;
                    level = (level - (frame.time - last).seconds().max(0.0) * 50.0).max(0.0) + 1.0;
                    last = frame.time;
                    found.burst = found.burst.max(level);
                    if level > Watch::BURST {
                        found.problems.push(format!("{}: a burst of {level:.1} rounds", frame.time));
                        level = 0.0;
                    }
                }
                Event::Frame(frame) if frame.id.number() == 0x6A4 && !is_not_available(&frame, "Speed") => {
                    let is_compared = found.lock().unwrap().not_before.is_none_or(|time| Instant::now() > time);
                    published.push_back(((frame.time, 0.05 * bits(&frame, "Speed") as f64), is_compared));
                }
                _ => {}
            },
        }
        // Once all that came before it is here for certain.
        let newest = speeds.back().map_or(Micros(0), |(time, _)| *time);
        while let Some(((time, speed), is_compared)) = published.front().copied()
            && newest - time > Watch::LATE
        {
            published.pop_front();
            if is_compared {
                compare((time, speed), &speeds, &mut found.lock().unwrap());
            }
        }
    }
}

/// Of the wheels that roll freely, m/s.
fn of_wheels(frame: &Frame) -> Option<f64> {
    let data: [u8; 8] = frame.data().try_into().ok()?;
    let wheel = |place: usize| f64::from(u16::from_le_bytes([data[place], data[place + 1]])) / 360.0;
    Some(0.5 * (wheel(4) + wheel(6)))
}

/// The latest moment before it at which the bus had this speed. Where the bus has gaps, a value holds until its time-out:
/// it may be older by that; and behind a long one it is not compared.
fn compare((time, speed): Speed, speeds: &VecDeque<Speed>, found: &mut Found) {
    let lately = speeds.iter().map(|(at, _)| *at).filter(|at| time - *at < Watch::LATELY);
    let gaps = lately.clone().zip(lately.skip(1)).map(|(at, next)| next - at);
    let gap = gaps.max().unwrap_or(Watch::LATELY);
    if gap > Watch::LONG_GAP {
        return;
    }
    let same = |(at, of_bus): &&Speed| *at <= time && (of_bus - speed).abs() < Watch::SAME;
    found.compared += 1;
    let Some((at, _)) = speeds.iter().rev().find(same) else {
        return found
            .problems
            .push(format!("{time}: {speed:.2} m/s, which the bus did not have for seconds"));
    };
    let age = time - *at;
    let [without_gaps, at_all] = &mut found.oldest;
    *at_all = age.max(*at_all);
    if gap < Watch::NO_GAP {
        *without_gaps = age.max(*without_gaps);
    }
    if age > Watch::OLDEST + gap {
        found.problems.push(format!("{time}: {speed:.2} m/s is {:.0} ms old", 1e3 * age.seconds()));
    }
}
