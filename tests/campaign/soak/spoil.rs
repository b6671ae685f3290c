//! Where faults come in: drawn from the list, each for five seconds or some times that.

use gripd::Micros;
use gripd::can::Frame;
use gripd::model::Reading;
use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use testing::dice::Dice;
use testing::fault::{Case, FROM, Fault, UNTIL, at, content, frame, sensor, timing};
use testing::frames;

/// Frames that go to the engine one after the other, and what is wrong with them.
pub struct Piece {
    pub frames: Vec<Frame>,
    /// By how much the clock that stamps them is behind the drive's.
    pub behind: Micros,
    /// What began last, in these frames or before them.
    pub blamed: &'static str,
    /// It is the window of a fault.
    pub is_fault: bool,
    /// Stamps are anything here: nothing can be told of what is right.
    pub is_chaos: bool,
    /// What happens before.
    pub event: Option<Event>,
}

impl Piece {
    fn good(frames: Vec<Frame>, blamed: &'static str) -> Self {
        Self { frames, behind: Micros(0), blamed, is_fault: false, is_chaos: false, event: None }
    }
}

/// What happens to the process and the bus.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Event {
    /// The same configuration is read anew.
    Reload,
    /// Killed, and started again from what was learned.
    Restart,
    /// The link goes down and comes up again.
    LinkDown,
    /// The kernel drops frames, every second one of the piece.
    Dropped,
}

const MIXED: &str = "anything at once (as tests/formats/fuzz does it)";
const NOTHING: &str = "nothing yet";

/// All that is known how to spoil.
pub struct List(Vec<Case>);

/// One fault, for one window.
#[derive(Clone, Copy, PartialEq)]
enum What {
    Listed(usize),
    Mixed,
    Event(Event),
}

/// Which faults when, in windows that do not overlap; s since the beginning of the stretch.
pub struct Plan(Vec<(f64, Vec<What>)>);

impl List {
    pub fn new() -> Self {
        let groups =
            [frame::cases(), content::cases(), sensor::cases(), sensor::slow_wheels(), timing::cases()];
        Self(groups.into_iter().flatten().collect())
    }

    /// Faults for so many seconds: after a pause one, for one to four windows, now and then two at once.
    pub fn plan(&self, seconds: f64, dice: &mut ChaCha8Rng) -> Plan {
        let mut plan = Vec::new();
        let mut time = dice.random_range(5.0..40.0);
        while time + 25.0 < seconds {
            let mut what = vec![self.draw(dice)];
            if dice.random_range(0..4) == 0 {
                // Last what leaves nothing as the list knows it.
                what.push(self.draw(dice));
                what.sort_by_key(|what| matches!(what, What::Mixed));
                what.dedup();
            }
            for _ in 0..[1, 1, 2, 4][dice.random_range(0..4)] {
                plan.push((time, what.clone()));
                time += UNTIL - FROM;
            }
            time += dice.random_range(10.0..50.0);
        }
        Plan(plan)
    }

    fn draw(&self, dice: &mut ChaCha8Rng) -> What {
        use Event::{Dropped, LinkDown, Reload, Restart};
        match dice.random_range(0..self.0.len() + 7) {
            listed if listed < self.0.len() => What::Listed(listed),
            other => match other - self.0.len() {
                0 => What::Event(Reload),
                1 => What::Event(Restart),
                2 => What::Event(LinkDown),
                3 => What::Event(Dropped),
                _ => What::Mixed,
            },
        }
    }

    fn name(&self, what: What) -> &'static str {
        match what {
            What::Listed(listed) => self.0[listed].name,
            What::Mixed => MIXED,
            What::Event(Event::Reload) => "a reload",
            What::Event(Event::Restart) => "killed, and started again",
            What::Event(Event::LinkDown) => "the link goes down and up",
            What::Event(Event::Dropped) => "the kernel drops frames",
        }
    }

    /// What sensors say wrongly; `begin` is the stretch's.
    pub fn sensors(&self, plan: &Plan, begin: Micros, readings: &mut Vec<Reading>) {
        for (from, what) in &plan.0 {
            for spoil in what.iter().filter_map(|what| match what {
                What::Listed(listed) => match self.0[*listed].fault {
                    Fault::Sensors(spoil) => Some(spoil),
                    Fault::Frames(_) => None,
                },
                _ => None,
            }) {
                let (range, shift) = window(begin, *from, readings, |reading| reading.time);
                let mut some: Vec<Reading> = readings[range.clone()].to_vec();
                some.iter_mut().for_each(|reading| reading.time = reading.time + shift);
                spoil(&mut some);
                some.iter_mut().for_each(|reading| reading.time = reading.time - shift);
                readings.splice(range, some);
                readings.sort_by_key(|reading| reading.time);
            }
        }
    }

    /// The frames in pieces, spoiled where the plan has it.
    pub fn pieces(
        &self,
        plan: &Plan,
        begin: Micros,
        mut frames: Vec<Frame>,
        blamed: &mut &'static str,
        dice: &mut Dice,
    ) -> Vec<Piece> {
        let mut pieces = Vec::new();
        for (from, what) in &plan.0 {
            let (range, shift) = window(begin, *from, &frames, |frame| frame.time);
            let mut rest = frames.split_off(range.start);
            let after = rest.split_off(range.end - range.start);
            pieces.push(Piece::good(frames, blamed));
            *blamed = what.iter().map(|what| self.name(*what)).next_back().unwrap_or(NOTHING);
            pieces.push(self.spoiled(what, rest, shift, blamed, dice));
            frames = after;
        }
        pieces.push(Piece::good(frames, blamed));
        pieces
    }

    fn spoiled(
        &self,
        what: &[What],
        frames: Vec<Frame>,
        shift: Micros,
        blamed: &'static str,
        dice: &mut Dice,
    ) -> Piece {
        let first = frames.first().map(|frame| frame.time);
        let mut piece = Piece { is_fault: true, ..Piece::good(frames, blamed) };
        for what in what {
            match what {
                What::Listed(listed) => {
                    let Fault::Frames(spoil) = self.0[*listed].fault else { continue };
                    let there = piece.frames.iter().map(|f| at(f, f.time + shift)).collect();
                    piece.frames = spoil(there).iter().map(|f| at(f, f.time - shift)).collect();
                }
                What::Mixed => {
                    piece.is_chaos = true;
                    for _ in 0..1 << dice.below(8) {
                        frames::spoil(dice, &mut piece.frames);
                    }
                }
                What::Event(Event::LinkDown) => {
                    piece.frames.clear();
                    piece.event = Some(Event::LinkDown);
                }
                What::Event(Event::Dropped) => {
                    let mut number = 0;
                    piece.frames.retain(|_| {
                        number += 1;
                        number % 2 == 0
                    });
                    piece.event = Some(Event::Dropped);
                }
                What::Event(event) => piece.event = Some(*event),
            }
        }
        let behind = first.zip(piece.frames.first()).map_or(0.0, |(was, is)| (was - is.time).seconds());
        // Clocks are set back by whole seconds; frames are some milliseconds apart.
        piece.behind = Micros::from_millis(1000 * behind.round() as i64);
        piece
    }
}

/// Those of a fault's window, and how far they are from the times at which the list has it.
fn window<T>(
    begin: Micros,
    from: f64,
    all: &[T],
    time: impl Fn(&T) -> Micros,
) -> (std::ops::Range<usize>, Micros) {
    let from = begin + Micros((from * 1e6) as i64);
    let until = from + Micros(((UNTIL - FROM) * 1e6) as i64);
    let range = all.partition_point(|item| time(item) < from)..all.partition_point(|item| time(item) < until);
    (range, Micros((FROM * 1e6) as i64) - from)
}
